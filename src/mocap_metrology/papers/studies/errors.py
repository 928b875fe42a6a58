"""Errors of every method on one simulated recording, between the optical frames of the stations."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.calibrate.jansen import CalibrationSettings, calibrate
from mocap_metrology.lighthouse.calibrate.pnp import opencv_is_missing
from mocap_metrology.lighthouse.calibrate.stages import INTERPOLATIONS, PEERS, Calibration
from mocap_metrology.lighthouse.calibrate.superpose import at_times, kabsch
from mocap_metrology.lighthouse.records import Factory
from mocap_metrology.papers.studies.cases import Drawn

STAGES = {"batch": ("final",)} | dict.fromkeys(PEERS, ("kabsch",))
BOTH = ("kabsch", "final")
WEIGHTED, UNWEIGHTED = "weighted", "unweighted"


@dataclass(frozen=True)
class Approach:
    """One way to calibrate, by some estimators. variant: its name in tables; lasers: `real`
    places are named, are a `common` centre, or their depths are `estimated` (by batch)."""

    estimators: tuple[str, ...]
    variant: str = ""
    reconstruction: str = "full-interpolation"
    interpolation: str = "cubic"
    lasers: str = "common"
    unweighted: bool = False

    def available(self) -> Approach:
        """Without `pnp` where OpenCV is not installed."""
        missing = ("pnp",) if opencv_is_missing() else ()
        return replace(self, estimators=tuple(e for e in self.estimators if e not in missing))


@dataclass(frozen=True)
class Error:
    """Error of the pose of the slave by a method: mm and deg, infinite where there is no pose, and
    the reason; mirrored: share of board poses in the other minimum (NaN: unknown)."""

    estimator: str
    stage: str
    variant: str
    error_mm: float = math.inf
    error_deg: float = math.inf
    mirrored: float = math.nan
    why: str = ""


def errors_of(approach: Approach, drawn: Drawn) -> list[Error]:
    """Errors of each estimator and stage of an approach."""
    estimated = approach.lasers == "estimated"
    settings = CalibrationSettings(
        estimators=approach.estimators,
        optics=("factory",) if estimated else ("ideal",),
        reconstruction=approach.reconstruction,
        lm_interpolation=approach.interpolation,
        lasers_m=drawn.lasers_m if approach.lasers == "real" else None,
    )
    factories = (Factory(), Factory()) if estimated else (None, None)
    why = ""
    try:
        calibration = calibrate(drawn.hits, drawn.board, factories, settings)
    except Refusal as refusal:
        calibration, why = Calibration(), str(refusal)
    why = why or "; ".join(calibration.why) or "no pose"
    errors = []
    for estimator in approach.estimators:
        for stage in STAGES.get(estimator, BOTH):
            kind = estimator, stage
            pose = next((e for e in calibration.estimates if (e.estimator, e.stage) == kind), None)
            name = *kind, approach.variant
            if pose is None or not np.isfinite(pose.t_m).all():
                errors.append(Error(*name, why=why))
                continue
            size = _sizes(pose.R, pose.t_m, pose.frame, drawn)
            errors.append(Error(*name, *size, mirrored=pose.mirrored_share))
    return errors + (_unweighted(approach, calibration, drawn) if approach.unweighted else [])


def _unweighted(approach: Approach, calibration: Calibration, drawn: Drawn) -> list[Error]:
    """Stage `kabsch` of the same paths with equal weights."""
    errors = []
    for estimator in approach.estimators:
        paths = calibration.paths.get((estimator, "ideal"))
        if estimator == "batch":
            continue
        if paths is None:
            errors.append(Error(estimator, "kabsch", UNWEIGHTED, why="no paths"))
            continue
        master, slave = paths
        order = INTERPOLATIONS[approach.interpolation] if estimator == "paper-lm" else 1
        then, inside = at_times(slave, master.time_s, order)
        R, t_m = kabsch(then.t_m, master.take(inside).t_m)
        errors.append(Error(estimator, "kabsch", UNWEIGHTED, *_sizes(R, t_m, "optical", drawn)))
    return errors


def _sizes(R: Floats, t_m: Floats, frame: str, drawn: Drawn) -> tuple[float, float]:
    """Lengths of the errors of position (mm) and rotation (deg)."""
    if frame == "housing":
        master, slave = drawn.origins_m
        t_m = t_m + R @ slave - master
    turn = np.linalg.norm(rotation.error(R, drawn.R))
    return 1e3 * float(np.linalg.norm(t_m - drawn.t_optical_m)), math.degrees(turn)
