"""J section IV: which way of completing measurements is the most accurate?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.calibrate.jansen import CalibrationSettings, calibrate
from mocap_metrology.lighthouse.calibrate.reconstruction import METHODS
from mocap_metrology.lighthouse.records import Hits


@dataclass(frozen=True)
class Comparison:
    """Lengths of the errors of one recording by one way, in mm and deg, at stage `final`."""

    way: str
    error_mm: float
    error_deg: float


def reconstruction_errors(
    hits: Hits, board: np.ndarray, true_rotation: np.ndarray, true_position_m: np.ndarray
) -> list[Comparison]:
    """Pose of the slave by each of J's three ways, linear interpolation and ideal optics, against
    the truth R (3, 3), t (3,) in m. By `paper-lm`, which finds the minimum of J's cost: his simplex
    would add its own error. A way that is refused is left out."""
    found = []
    for way in METHODS:
        settings = CalibrationSettings(
            estimators=("paper-lm",),
            optics=("ideal",),
            reconstruction=way,
            lm_interpolation="linear",
        )
        try:
            estimates = calibrate(hits, board, (None, None), settings).estimates
        except Refusal:
            continue
        last = next(e for e in estimates if e.stage in ("final", "static"))
        offset = 1000 * (last.t_m - true_position_m)
        turn = np.degrees(rotation.log(last.R @ true_rotation.T))
        lengths = float(np.linalg.norm(offset)), float(np.linalg.norm(turn))
        found.append(Comparison(way, *lengths))
    return found
