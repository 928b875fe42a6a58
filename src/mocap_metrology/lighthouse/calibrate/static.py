"""Slave pose from a board that lies still: no path for Kabsch, one board pose for each station.

R = R_m R_s^T and t = t_m - R t_s, with (R_m, t_m) and (R_s, t_s) the pose of the same board in the
frames of master and slave.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy import ndimage
from scipy.special import fdtrc, ndtri

from mocap_metrology.common.hampel import MAD_TO_SIGMA
from mocap_metrology.lighthouse.board import FEWEST_DIODES
from mocap_metrology.lighthouse.calibrate.weighted_station import board_equations
from mocap_metrology.lighthouse.fit.board_pose import by_levenberg_marquardt
from mocap_metrology.lighthouse.records import ROLES, Hits, Measurements, Path
from mocap_metrology.lighthouse.rotation import cross, log, mean
from mocap_metrology.lighthouse.rotor import angles

STILL_M = 0.005  # spread of the board's position (one standard deviation) below which it is still
STILL_RAD = np.radians(0.3)
STRETCH, MOVED, PART = 15, 4.0, 0.1  # poses; how many times as far; of the stretches
CONSTANT = 1.5  # spread of angles over that from hit to hit; of a board at rest 1.1
STRETCHES = 50  # of the time, each of which may show that it moved
FEWEST_LEFT = 5  # diodes; with four, nearly any pose fits
BY_CHANCE = 0.01  # probability that a diode is left out of a measurement without a bad one
NO_NOISE = 1e-14  # rad^2: angles computed, not measured
FEWEST_HITS = 10  # of a diode in one axis, so that its median means something


@dataclass(frozen=True)
class StaticPose:
    """Slave pose R, t (m); covariance (6, 6) in m and rad; residual in rad; angles used; the lower
    of both stations' ratios of mirrored to taken K_1 (near 1: which is right is a guess); diodes
    left out, of master and slave; the board's pose in the master's frame, m."""

    R: np.ndarray
    t_m: np.ndarray
    covariance: np.ndarray
    residual_rms_rad: float
    n_angles: int
    ambiguity: float
    left_out: tuple[tuple[int, ...], tuple[int, ...]]
    board_R: np.ndarray
    board_t_m: np.ndarray

    @property
    def open_mirror(self) -> bool:
        """Whether the ratio of both K_1 is one that noise makes of equal ones."""
        freedom = max(self.n_angles / 2 - 6, 1)
        return bool(fdtrc(freedom, freedom, self.ambiguity) > BY_CHANCE)

    @property
    def notes(self) -> list[str]:
        """On the mirrored pose, and on diodes that were left out."""
        mirror = "no mirrored pose"
        if np.isfinite(self.ambiguity):
            mirror = f"K_1 of the mirrored pose is {self.ambiguity:.3g} times that of the pose used"
        return [mirror] + [
            f"diode {', '.join(map(str, out))} excluded from the {role}'s: the others contradict it"
            for role, out in zip(ROLES, self.left_out, strict=True)
            if out
        ]


def is_still(path: Path) -> bool:
    """Whether the board is at rest: robust spread of its position below `STILL_M`,
    and of its rotation about the mean below `STILL_RAD` beyond what the noise of a pose makes; and
    less than `PART` of the stretches of `STRETCH` poses are farther away, which else is a board
    that moved for a part of the time."""
    off = path.t_m - np.median(path.t_m, axis=0)
    spread = MAD_TO_SIGMA * np.linalg.norm(np.median(np.abs(off), axis=0))
    if spread >= STILL_M:
        return False
    whole = off[: len(off) // STRETCH * STRETCH].reshape(-1, STRETCH, 3)
    noise = np.median(np.abs(np.diff(off, axis=0)), axis=0) if len(off) > 1 else np.zeros(3)
    far = np.linalg.norm(np.median(whole, axis=1), axis=1)
    limit = MOVED * (STILL_M + spread + np.linalg.norm(noise))
    if np.count_nonzero(far > limit) > PART * len(whole):
        return False
    turns = log(path.R @ mean(path.R).T)
    noise = np.median(np.abs(np.diff(turns, axis=0)), axis=0) / np.sqrt(2)
    turned = np.median(np.abs(turns), axis=0)
    limit = STILL_RAD + 2 * MAD_TO_SIGMA * np.linalg.norm(noise)
    return bool(MAD_TO_SIGMA * np.linalg.norm(turned) < limit)


def is_constant(hits: Hits, n_diodes: int) -> bool:
    """Whether the angles of most diodes spread no more than from hit to hit, but for a `PART` of
    all, and are far off in no stretch of the time: so they do on a board at rest, be it so small or
    far away that its single poses scatter."""
    series = (2 * hits.station.astype(np.int64) + hits.axis) * n_diodes + hits.diode
    times = []
    for one in np.unique(series):
        angle = hits.angle_rad[series == one]
        if angle.size >= FEWEST_HITS:
            step = MAD_TO_SIGMA * np.median(np.abs(np.diff(angle))) / np.sqrt(2)
            off = angle - np.median(angle)
            spread = np.quantile(np.abs(off), 1 - PART) / ndtri(1 - PART / 2)
            stretches = np.array_split(off, min(angle.size // FEWEST_HITS, STRETCHES))
            moved = max(abs(np.median(stretch)) for stretch in stretches)
            times.append(max(spread / CONSTANT, moved / MOVED) / max(step, NO_NOISE))
    return bool(times) and float(np.median(times)) < 1


def median_angles(hits: Hits, station: int, n_diodes: int) -> Measurements:
    """One measurement: the median of each diode's angle in each axis over the recording."""
    hits = hits.take(hits.station == station)
    key, n = 2 * hits.diode.astype(np.int64) + hits.axis, 2 * n_diodes
    count, middle = np.bincount(key, minlength=n), np.full(n, np.nan)
    seen = np.flatnonzero(count >= FEWEST_HITS)
    middle[seen] = ndimage.median(hits.angle_rad, key, seen) if seen.size else np.nan
    angles = middle.reshape(1, n_diodes, 2)
    angles[~np.isfinite(angles).all(axis=2)] = np.nan
    return Measurements(np.array([np.mean(hits.time_s)]) if len(hits) else np.zeros(1), angles)


def static_pose(
    measurements: list[Measurements], board: np.ndarray, rotors: list[np.ndarray]
) -> StaticPose | None:
    """Slave pose from one measurement of each station; None where one sees too few diodes.

    Diodes that the others contradict are left out, see `without_bad`.

    The noise is estimated from the residuals, so an error of optics or of the board counts as
    noise; the covariance of each board pose, sigma^2 (J^T J)^-1, is carried through both formulas.
    """
    if any(m.seen.sum() < FEWEST_DIODES for m in measurements):
        return None
    cleaned = [without_bad(m, board, r) for m, r in zip(measurements, rotors, strict=True)]
    measurements = [measured for measured, _ in cleaned]
    paths = [by_levenberg_marquardt(m, board, r) for m, r in zip(measurements, rotors, strict=True)]
    master, slave = paths
    R = master.R[0] @ slave.R[0].T
    t = master.t_m[0] - R @ slave.t_m[0]
    covariance = np.zeros((6, 6))
    # d(R) = w_m - R w_s; d(t) = d(t_m) - R d(t_s) + (R t_s) x (w_m - R w_s)
    arm = cross(R @ slave.t_m[0])
    jacobians = (
        np.block([[np.eye(3), arm], [np.zeros((3, 3)), np.eye(3)]]),
        np.block([[-R, -arm @ R], [np.zeros((3, 3)), -R]]),
    )
    for path, measured, rotor, jacobian in zip(paths, measurements, rotors, jacobians, strict=True):
        covariance += jacobian @ _covariance(path, measured, board, rotor) @ jacobian.T
    n_angles = int(master.n_angles[0] + slave.n_angles[0])
    rms = float(np.sqrt((master.epsilon[0] + slave.epsilon[0]) / n_angles))
    ambiguity = float(min(master.ambiguity[0], slave.ambiguity[0]))
    left_out, placed = (cleaned[0][1], cleaned[1][1]), (master.R[0], master.t_m[0])
    return StaticPose(R, t, covariance, rms, n_angles, ambiguity, left_out, *placed)


def without_bad(
    measured: Measurements, board: np.ndarray, rotors: np.ndarray
) -> tuple[Measurements, tuple[int, ...]]:
    """One measurement without the diodes, at most a quarter of them, that decide it against all
    others; and which. Of one diode in its wrong place, or seen at a grazing angle, K_1 makes a pose
    that fits none.

    One diode or two go if K_1 falls by more than chance: F = (fall / 2k) / (rest / (2(n - k) - 6))
    exceeds what one in 100 measurements without a bad diode would, among all choices of k from n.
    """
    out: list[int] = []
    for _ in range(max(int(measured.seen.sum()) // 4, 1)):
        seen = np.flatnonzero(measured.seen[0])
        cost = _cost(measured.angles_rad, board, rotors)[0]
        most = max((seen.size + len(out)) // 4, 1) - len(out)
        for k in range(1, min(2, most, seen.size - FEWEST_LEFT) + 1):
            choices = list(combinations(seen.tolist(), k))
            trial = np.repeat(measured.angles_rad, len(choices), axis=0)
            trial[np.arange(len(choices))[:, None], np.array(choices)] = np.nan
            rest = _cost(trial, board, rotors)
            best = int(np.argmin(rest))
            freedom = 2 * (seen.size - k) - 6
            ratio = (cost - rest[best]) / (2 * k) / max(rest[best] / freedom, NO_NOISE)
            if fdtrc(2 * k, freedom, ratio) * len(choices) < BY_CHANCE:
                out += choices[best]
                measured = Measurements(measured.time_s, trial[best : best + 1])
                break
        else:
            break
    return measured, tuple(sorted(out))


def _cost(angles: np.ndarray, board: np.ndarray, rotors: np.ndarray) -> np.ndarray:
    measured = Measurements(np.arange(len(angles), dtype=float), angles)
    return by_levenberg_marquardt(measured, board, rotors).epsilon


def residuals_by_diode(
    measurements: list[Measurements], board: np.ndarray, rotors: list[np.ndarray]
) -> np.ndarray:
    """Mean square residual in rad^2 of each diode that a station sees, master's first."""
    squares = []
    for measured, rotor in zip(measurements, rotors, strict=True):
        path, seen = by_levenberg_marquardt(measured, board, rotor), measured.seen[0]
        points = np.ascontiguousarray(board[seen] @ path.R[0].T + path.t_m[0])
        squares.append(((angles(points, rotor) - measured.angles_rad[0, seen]) ** 2).mean(axis=1))
    return np.concatenate(squares)


def _covariance(
    path: Path, measured: Measurements, board: np.ndarray, rotors: np.ndarray
) -> np.ndarray:
    """sigma^2 (J^T J)^-1 of a board pose, sigma^2 = K_1 / (angles - 6); m and rad."""
    (H,), *_ = board_equations(path.R, path.t_m, measured.angles_rad, board, rotors)
    return path.epsilon[0] / max(int(path.n_angles[0]) - 6, 1) * np.linalg.inv(H)
