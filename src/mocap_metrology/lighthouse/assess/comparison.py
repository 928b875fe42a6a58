"""Whether a station has moved since an earlier calibration.

Errors of the board and of the stations' optics are the same in both calibrations. They make most of
a covariance and little of a difference: with the pose's sensitivities G_1, G_2 to errors of
variances V and with the covariances N_1, N_2 of what both recordings do not share,

    cov(p_2 - p_1) = N_1 + N_2 + (G_1 - G_2) V (G_1 - G_2)'.

N is as much larger as parts of the recording differ by more than N explains. The variants of the
rotor model that neither recording excludes add their part in the same way.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.types import Record, Row
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.assess import pose_file
from mocap_metrology.lighthouse.assess.reference import check_same_ids, station_id
from mocap_metrology.lighthouse.calibrate.superpose import BLOCKS
from mocap_metrology.lighthouse.records import ROLES

# Probability of so large a difference by chance, by the basis of the covariance.
SIGNIFICANT = {"difference": 0.01, "sum": 1e-3}
SMALLEST_MM, SMALLEST_DEG = 2.0, 0.05  # differences below do not matter, however significant
TOLERANCE_MM, TOLERANCE_DEG = 5.0, 0.2  # beyond, an earlier pose is not confirmed
LARGE_MM, LARGE_DEG = 20.0, 0.5  # where a covariance is missing
SOUND_M2 = 16.0  # largest squared distance between parts that 1 sound recording in 20 exceeds
POINTS = 12  # 2^12 normal vectors: quantiles within 1 % of a standard deviation


@dataclass(frozen=True)
class Comparison:
    """New pose against the earlier one.

    t_new - t_old in mm and the rotation vector of R_new R_old^T in deg, in master axes; chi2 of six
    degrees of freedom and its probability by chance, NaN without both covariances; moved; basis: of
    the covariance of the difference: `difference` without errors that both share, `sum` of both
    covariances, `none`; lower_95, upper_95: of the lengths in mm and deg, NaN without a covariance;
    other: (estimator, stage, optics) of the earlier pose where they are others; note: on ids that
    could not be compared.
    """

    difference_mm: np.ndarray
    difference_deg: np.ndarray
    chi2: float
    p_value: float
    moved: bool
    basis: str = "none"
    lower_95: tuple[float, float] = (math.nan, math.nan)
    upper_95: tuple[float, float] = (math.nan, math.nan)
    other: tuple[str, str, str] | None = None
    note: str = ""

    @property
    def shift(self) -> tuple[float, float]:
        """Lengths of both differences, mm and deg."""
        mm, deg = self.difference_mm, self.difference_deg
        return float(np.linalg.norm(mm)), float(np.linalg.norm(deg))

    @property
    def valid(self) -> bool:
        """Whether the earlier pose still holds: not moved, and within the tolerance."""
        mm, deg = self.shift
        return not self.moved and mm <= TOLERANCE_MM and deg <= TOLERANCE_DEG

    def as_dict(self) -> Row:
        row: Row = dict(zip(("shift_mm", "shift_deg"), self.shift, strict=True))
        for name in ("lower_95", "upper_95"):
            row[name] = dict(zip(("mm", "deg"), getattr(self, name), strict=True))
        row["tolerance"] = {"mm": TOLERANCE_MM, "deg": TOLERANCE_DEG}
        row |= {name: getattr(self, name) for name in ("valid", "moved")}
        names = ("difference_mm", "difference_deg")
        row |= {name: getattr(self, name).tolist() for name in names}
        return row | {name: getattr(self, name) for name in ("chi2", "p_value", "basis")}


def compare_with_earlier(
    pose_new: pose_file.PoseFile, pose_old: pose_file.PoseFile, one_board: bool = True
) -> Comparison:
    """Compare two pose.json contents of the same two stations.

    The estimate chosen in the new one is held against the same (estimator, stage, optics) of the
    old one, else against the one chosen there. one_board: whether boards of equal diodes are one
    board, so that their errors cancel.

    Raises `Refusal` for other stations, swapped roles, poses of other origins, or a file without a
    pose.
    """
    note = check_same_ids(ids_of(pose_old), ids_of(pose_new), "the earlier pose", "the recording")
    new = pose_file.chosen_pose(pose_new)
    old = pose_file.chosen_pose(pose_old)
    if new is None or old is None:
        which = "the new" if new is None else "the earlier"
        raise Refusal(f"check_against: {which} calibration has no pose; expected one in both")
    same = [p for p in pose_old["poses"] if pose_file.kind_of(p) == pose_file.kind_of(new)]
    old = same[0] if same else old
    frames = [pose.get("frame", "optical") for pose in (old, new)]
    if frames[0] != frames[1]:
        raise Refusal(
            f"check_against: the earlier pose is of frame {frames[0]}, the new one of {frames[1]};"
            " expected one lasers_mm in both"
        )
    (R, t), (R_old, t_old) = pose_file.matrix_and_metres(new), pose_file.matrix_and_metres(old)
    off = np.r_[1e3 * (t - t_old), np.degrees(rotation.error(R, R_old))]
    basis, covariance = _covariance(new, old, one_board)
    if basis == "difference" and new["optics"] == "factory":
        step, spread = _by_variants(pose_new, pose_old)
        off, covariance = off - step, covariance + spread
    chi2, p = _significance(off, covariance, basis)
    mm, deg = off[:3], off[3:]
    distance, angle = float(np.linalg.norm(mm)), float(np.linalg.norm(deg))
    if math.isnan(p):
        moved = distance > LARGE_MM or angle > LARGE_DEG
        ends = [(math.nan, math.nan)] * 2
    else:
        moved = p < SIGNIFICANT[basis] and (distance > SMALLEST_MM or angle > SMALLEST_DEG)
        parts = slice(0, 3), slice(3, 6)
        ends = [length_interval(off[k], covariance[k, k]) for k in parts]
    lower, upper = zip(*ends, strict=True)
    other = None if same else pose_file.kind_of(old)
    return Comparison(mm, deg, chi2, p, moved, basis, lower, upper, other, note)


def ids_of(document: pose_file.PoseFile) -> tuple[int | None, int | None]:
    """Identifiers of master and slave; None where the file names none."""
    master, slave = (station_id(document["stations"][role], role) for role in ROLES)
    return master, slave


def _covariance(
    new: pose_file.PoseEntry, old: pose_file.PoseEntry, one_board: bool
) -> tuple[str, np.ndarray]:
    """Basis and covariance (6, 6) of the difference; NaN where one has none."""
    noise = new.get("covariance_noise"), old.get("covariance_noise")
    first, second = new.get("shared_errors"), old.get("shared_errors")
    same = new["optics"] == old["optics"]
    if same and first is not None and second is not None and None not in noise:
        scaled = [
            np.array(one) * _scale(entry) for one, entry in zip(noise, (new, old), strict=True)
        ]
        return "difference", scaled[0] + scaled[1] + _left_of_shared(first, second, one_board)
    whole = new.get("covariance"), old.get("covariance")
    if None in whole:
        return "none", np.full((6, 6), np.nan)
    return "sum", np.sum(np.array(whole, dtype=np.float64), axis=0)


def _scale(entry: pose_file.PoseEntry) -> float:
    """Factor of the noise by which parts of one recording differ from each other, at least 1: what
    else depends on the path of the board, such as rotors that obey another model."""
    m2 = (entry.get("halves") or {}).get("m2")
    return max(1.0, m2 / SOUND_M2) if isinstance(m2, (int, float)) else 1.0


def _left_of_shared(first: Record, second: Record, one_board: bool) -> np.ndarray:
    """What errors of board and stations make of the difference, (6, 6): each group cancels where
    both recordings have it alike, with the smaller of both standard deviations; of two boards both
    errors count."""
    total = np.zeros((6, 6))
    one_board &= first["digest"] == second["digest"]
    for group in ("stations", "board"):
        sd, sd_2 = (np.array(one[group]["sd"], dtype=np.float64) for one in (first, second))
        effect, effect_2 = (np.reshape(one[group]["effect"], (-1, 6)) for one in (first, second))
        if sd.shape != sd_2.shape or (group == "board" and not one_board):
            total += effect.T @ effect + effect_2.T @ effect_2
        else:
            least = np.minimum(sd, sd_2)[:, None]
            apart = effect * (least / sd[:, None]) - effect_2 * (least / sd_2[:, None])
            total += apart.T @ apart
    return total


def _by_variants(new: pose_file.PoseFile, old: pose_file.PoseFile) -> tuple[np.ndarray, np.ndarray]:
    """Difference that another variant of the rotor model makes, and the covariance of variants
    left open, of which each would move both poses alike but for the path of the board."""
    both = [
        {one["variant"]: one for one in document.get("variants", [])} for document in (new, old)
    ]
    taken = [next((k for k, one in of.items() if one["chosen"]), None) for of in both]
    if None in taken or taken[1] not in both[0]:
        return np.zeros(6), np.zeros((6, 6))
    step = _pose_steps(both[0][taken[0]], both[0][taken[1]])
    left = [{k for k, one in of.items() if one["standing"] != "worse"} for of in both]
    rows = [
        _pose_steps(both[0][k], both[0][taken[1]]) - _pose_steps(both[1][k], both[1][taken[1]])
        for k in both[0]
        if k != taken[1] and k in left[0] & left[1]
    ]
    off = np.reshape(rows, (-1, 6))
    return step, off.T @ off / (len(off) + 1)


def _pose_steps(one: Record, other: Record) -> np.ndarray:
    (R, mm), (R_other, mm_other) = (
        (np.array(way["rotation_matrix"]), np.array(way["translation_mm"])) for way in (one, other)
    )
    return np.r_[mm - mm_other, np.degrees(rotation.error(R, R_other))]


def _significance(
    difference: np.ndarray, covariance: np.ndarray, basis: str
) -> tuple[float, float]:
    """T^2 = d^T C^-1 d and the probability of more, NaN without a covariance.

    Of basis `difference` T^2 has a chi-squared distribution of six degrees of freedom. The
    covariances of the other estimators come from BLOCKS blocks of each recording, so T^2 of basis
    `sum` is Hotelling's, with nu = 2 (BLOCKS - 1): T^2 (nu - 5) / (6 nu) is F distributed
    (6, nu - 5).
    """
    from scipy.special import chdtrc, fdtrc

    if not np.isfinite(covariance).all() or np.linalg.eigvalsh(covariance)[0] <= 0:
        return math.nan, math.nan
    chi2 = float(difference @ np.linalg.solve(covariance, difference))
    if basis == "difference":
        return chi2, float(chdtrc(6, chi2))
    nu = 2 * (BLOCKS - 1)
    return chi2, float(fdtrc(6, nu - 5, chi2 * (nu - 5) / (6 * nu)))


def length_interval(vector: np.ndarray, covariance: np.ndarray) -> tuple[float, float]:
    """95 % interval of the true length |v| where v + e is measured, e normal with a covariance.

    A measured length is larger than the true one on average. So the lower end is the true length s,
    along the measured direction, with which the measured length would be exceeded with probability
    2.5 %; 0 where s = 0 exceeds it more often. The upper end is the quantile
    97.5 % of the length of the measured vector with as much noise again: 1.96
    standard deviations above a length far from 0, and conservative near 0, where it stays above the
    measured one. Quantiles are of a Sobol sequence of normal vectors.
    """
    from scipy.optimize import brentq
    from scipy.stats import norm, qmc

    n, size = len(vector), float(np.linalg.norm(vector))
    uniform = qmc.Sobol(n, scramble=False).random_base2(POINTS) + 0.5 ** (POINTS + 1)
    variances, axes = np.linalg.eigh(covariance)
    error = norm.ppf(uniform) * np.sqrt(np.maximum(variances, 0)) @ axes.T
    direction = vector / size if size > 0 else axes[:, -1]

    def reached(s: float) -> float:
        lengths = np.linalg.norm(s * direction + error, axis=1)
        return float(np.quantile(lengths, 0.975))

    lower = 0.0
    if reached(0.0) < size:
        lower = float(brentq(lambda s: reached(s) - size, 0.0, size))
    return lower, reached(size)
