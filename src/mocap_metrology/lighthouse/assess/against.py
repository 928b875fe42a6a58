"""Has a station moved since an earlier calibration?"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.assess.identity import check_same_ids, station_id
from mocap_metrology.lighthouse.assess.pose_file import chosen_pose, matrix_and_metres
from mocap_metrology.lighthouse.calibrate.superpose import BLOCKS
from mocap_metrology.lighthouse.records import ROLES

SIGNIFICANT = 1e-3  # probability of so large a difference by chance
SMALLEST_MM, SMALLEST_DEG = 2.0, 0.05  # differences below do not matter, however significant
LARGE_MM, LARGE_DEG = 20.0, 0.5  # where a covariance is missing


@dataclass(frozen=True)
class Comparison:
    """New pose against the earlier one.

    t_new - t_old in mm and the rotation vector of R_new R_old^T in deg, in master axes; chi2 of six
    degrees of freedom and its probability by chance, NaN without both covariances; moved; a
    sentence.
    """

    difference_mm: np.ndarray
    difference_deg: np.ndarray
    chi2: float
    p_value: float
    moved: bool
    sentence: str


def compare_with_earlier(pose_new: Mapping[str, Any], pose_old: Mapping[str, Any]) -> Comparison:
    """Compare two pose.json contents of the same two stations.

    The estimate chosen in the new one is held against the same (estimator, stage, optics) of the
    old one, else against the one chosen there, and the sentence says so.

    Raises `Refusal` for other stations, swapped roles, or a file without a pose.
    """
    note = check_same_ids(_ids(pose_old), _ids(pose_new), "the earlier pose", "the recording")
    new = chosen_pose(pose_new)
    old = chosen_pose(pose_old)
    if new is None or old is None:
        which = "the new" if new is None else "the earlier"
        raise Refusal(f"check_against: {which} calibration has no pose; expected one in both")
    same = [p for p in pose_old["poses"] if _kind(p) == _kind(new)]
    old = same[0] if same else old
    if not same:
        note = f"{note} Compared with another estimate ({', '.join(_kind(old))}).".strip()
    (R, t), (R_old, t_old) = matrix_and_metres(new), matrix_and_metres(old)
    mm, deg = 1e3 * (t - t_old), np.degrees(rotation.error(R, R_old))
    chi2, p = _significance(np.r_[mm, deg], new.get("covariance"), old.get("covariance"))
    distance, angle = float(np.linalg.norm(mm)), float(np.linalg.norm(deg))
    if math.isnan(p):
        moved = distance > LARGE_MM or angle > LARGE_DEG
        how = f"no covariance; taken as moved beyond {LARGE_MM:g} mm or {LARGE_DEG:g}°"
    else:
        moved = p < SIGNIFICANT and (distance > SMALLEST_MM or angle > SMALLEST_DEG)
        how = f"by chance with probability {p:.2g}"
    said = "A station has moved" if moved else "No sign that a station moved"
    sentence = f"{said}: {distance:.3g} mm and {angle:.2g}° from the earlier pose ({how}). {note}"
    return Comparison(mm, deg, chi2, p, moved, sentence.strip())


def _kind(entry: Mapping[str, Any]) -> tuple[str, str, str]:
    return entry["estimator"], entry["stage"], entry["optics"]


def _ids(given: Mapping[str, Any]) -> tuple[int | None, int | None]:
    master, slave = (station_id(given["stations"][role], role) for role in ROLES)
    return master, slave


def _significance(
    difference: np.ndarray, first: list | None, second: list | None
) -> tuple[float, float]:
    """T^2 = d^T (C_1 + C_2)^-1 d and the probability of more, NaN without both covariances.

    The covariances are estimates from BLOCKS blocks of each recording, so T^2 is Hotelling's, with
    nu = 2 (BLOCKS - 1) degrees of freedom: T^2 (nu - 5) / (6 nu) is F distributed (6, nu - 5).
    """
    if first is None or second is None:
        return math.nan, math.nan
    from scipy.stats import f as distribution

    total = np.array(first, dtype=np.float64) + np.array(second, dtype=np.float64)
    if not np.isfinite(total).all() or np.linalg.eigvalsh(total)[0] <= 0:
        return math.nan, math.nan
    chi2 = float(difference @ np.linalg.solve(total, difference))
    nu = 2 * (BLOCKS - 1)
    return chi2, float(distribution.sf(chi2 * (nu - 5) / (6 * nu), 6, nu - 5))
