"""Pose of the board in a station's frame, for every measurement (J V-A, Eq. 3 and 4)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.fit.levenberg_marquardt import PoseProblem, minimise
from mocap_metrology.lighthouse.fit.simplex import (
    BOARD,
    MATLAB,
    SimplexData,
    SimplexSettings,
    cost,
    evaluate,
    nelder_mead,
    seen_at,
    trig_of,
)
from mocap_metrology.lighthouse.records import Measurements, Path
from mocap_metrology.lighthouse.rotor import rotor_parameters, turned

START_M = 3.0
NARROW = 0.2  # of the board's own width, to its second side
SOLID_DIODES, SOLID_DEPTH = 6, 0.2  # a board at least so deep has no mirrored pose
SAME_TRACE = 1.0 + 2.0 * math.cos(math.radians(1.0))  # of R R2^T: less than 1 deg apart
MIRRORED_RAD = math.radians(8.0)  # a pose further off than this is in the other minimum


def well_posed(measurements: Measurements, board: np.ndarray) -> Measurements:
    """The measurements whose diodes span a surface: seen along one line, a pose is open."""
    seen = measurements.seen.astype(float)
    total = np.maximum(seen.sum(axis=1), 1)
    offset = (board - (seen @ board / total[:, None])[:, None]) * seen[:, :, None]
    spread = np.linalg.eigvalsh(np.einsum("ndi,ndj->nij", offset, offset) / total[:, None, None])
    board_spread = np.linalg.eigvalsh(np.cov(board.T, bias=True))
    wide = spread[:, 1] >= NARROW**2 * board_spread[1]
    return measurements.take(wide)


def upright(x: np.ndarray) -> np.ndarray:
    """Rotations (n, 3, 3) whose first columns are the directions x (n, 3), whose second ones are
    horizontal."""
    x = x / np.linalg.norm(x, axis=1)[:, None]
    y = np.cross([0.0, 0.0, 1.0], x)
    y /= np.linalg.norm(y, axis=1)[:, None]
    return np.stack([x, y, np.cross(x, y)], axis=2)


def _frames(board: np.ndarray) -> np.ndarray:
    """Ways a board may lie in its own frame: as J's, x towards the station, or with its principal
    plane there, either face, four quarter turns; (9, 3, 3)."""
    axes = np.linalg.svd(board - board.mean(axis=0), full_matrices=False)[2][::-1].copy()
    axes[0] = np.cross(axes[1], axes[2])
    quarter, half = rotation.from_angles(np.pi / 2, 0, 0), np.diag([-1.0, 1, -1])
    turns = [np.linalg.matrix_power(quarter, k) for k in range(4)]
    return np.array([np.eye(3), *(q @ f @ axes for q in turns for f in (np.eye(3), half))])


def first_guesses(
    measurements: Measurements, board: np.ndarray, distance_m: float
) -> tuple[np.ndarray, np.ndarray]:
    """P_0 of J: in the direction of the mean angles, at a distance, facing the station.

    J's board faces along one known axis of its frame, here x. For a board in another frame the
    face and quarter turn are taken that fit some of the measurements best by K_1. Returns
    R (n, 3, 3), t (n, 3) in metres.
    """
    azimuth, elevation = np.nanmean(measurements.angles_rad, axis=1).T
    d = np.column_stack([np.ones(len(azimuth)), np.tan(azimuth), np.tan(elevation)])
    t = distance_m * d / np.linalg.norm(d, axis=1)[:, None]
    back = upright(-d)  # the x axis of J's board, at the station
    ideal, frames = rotor_parameters(), _frames(board)
    costs = np.zeros(len(frames))
    for i in range(0, len(measurements), max(len(measurements) // 8, 1)):
        known = measurements.seen[i]
        seen = seen_at(BOARD, board[known], measurements.angles_rad[i, known], ideal)
        costs += [
            evaluate(np.r_[t[i], rotation.to_angles(back[i] @ frame)], seen) for frame in frames
        ]
    best = 0 if costs[0] <= 2 * costs.min() else int(np.argmin(costs))
    return back @ frames[best], t


@njit
def _search_all(
    starts: np.ndarray,
    warm: bool,
    seen: np.ndarray,
    board: np.ndarray,
    angles: np.ndarray,
    trig: np.ndarray,
    rotors: np.ndarray,
    end: SimplexSettings,
) -> tuple[np.ndarray, np.ndarray]:
    """Nelder-Mead for every measurement; `warm` starts each from the pose before."""
    n = seen.shape[0]
    poses, epsilon = np.empty((n, 6)), np.empty(n)
    for i in range(n):
        diodes = np.flatnonzero(seen[i])
        points, m = board[diodes].T.copy(), angles[i][diodes].T.copy()
        cs = trig[:, i][:, diodes].copy()
        x0, data = starts[i], SimplexData(BOARD, points, m, cs, rotors)
        if warm and i > 0:  # unless the search before was lost
            R, room = np.empty((3, 3)), np.empty((4, diodes.size))
            if cost(poses[i - 1], data, R, room) < cost(x0, data, R, room):
                x0 = poses[i - 1]
        poses[i], epsilon[i], _ = nelder_mead(x0, data, end)
    return poses, epsilon


def by_nelder_mead(
    measurements: Measurements,
    board: np.ndarray,
    rotors: np.ndarray,
    settings: SimplexSettings = MATLAB,
    warm: bool = False,
    distance_m: float = START_M,
) -> Path:
    """J Eq. 3: the pose of least K_1 for each measurement, by the simplex algorithm, from
    `first_guesses`, or with `warm` from the pose found before it."""
    angles, seen = measurements.angles_rad, measurements.seen
    R, t = first_guesses(measurements, board, distance_m)
    starts = np.column_stack([t, rotation.to_angles(R)])
    trig = trig_of(np.moveaxis(angles, 2, 0))
    points = np.ascontiguousarray(board)
    poses, epsilon = _search_all(starts, warm, seen, points, angles, trig, rotors, settings)
    R = rotation.from_angles(*poses[:, 3:].T)
    unknown = np.full(len(measurements), np.nan)
    return Path(measurements.time_s, R, poses[:, :3], epsilon, 2 * seen.sum(axis=1), unknown)


@njit
def _mirrored(
    R: np.ndarray, t: np.ndarray, centre: np.ndarray, normal: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The other pose in which a flat board looks nearly the same: normal mirrored at the ray.

    R' = (I - 2 d d^T) R (I - 2 n n^T) with d the ray to the board's centre, which stays in place.
    """
    c = np.array(turned(R, centre[0], centre[1], centre[2])) + t
    across = np.eye(3) - 2.0 * np.outer(c, c) / np.sum(c * c)
    R2 = across @ R @ (np.eye(3) - 2.0 * np.outer(normal, normal))
    return R2, c - R2 @ centre


class _Starts(NamedTuple):
    """Poses at which the searches for n poses begin: R (n, 3, 3), t (n, 3); centre (n, 3) and
    normal (n, 3) of the diodes seen, in the board's frame."""

    R: np.ndarray
    t: np.ndarray
    centre: np.ndarray
    normal: np.ndarray


def _affine_starts(measurements: Measurements, board: np.ndarray) -> _Starts:
    """Poses from the board's images under weak perspective.

    In a camera that looks at the board's middle, image = (row of R) . (b - centre) / range, so an
    affine fit of the image on the board's coordinates gives two rows. Of a flat board their
    component along the normal follows from |row| = 1 up to its sign, which the mirror test settles.
    """
    seen = measurements.seen.astype(float)
    ray = np.ones((*seen.shape, 3))
    ray[:, :, 1:] = np.tan(np.nan_to_num(measurements.angles_rad))
    total = seen.sum(axis=1)
    view = upright(np.einsum("nd,ndi->ni", seen, ray)).transpose(0, 2, 1)
    seen_by = np.einsum("nij,ndj->ndi", view, ray)
    image = seen_by[:, :, 1:] / seen_by[:, :, :1]
    centre = seen @ board / total[:, None]
    offset = (board - centre[:, None]) * seen[:, :, None]
    size, vectors = np.linalg.eigh(np.einsum("ndi,ndj->nij", offset, offset))
    axes = vectors.transpose(0, 2, 1)[:, ::-1].copy()  # rows, the normal last
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])
    F = np.zeros((len(measurements), 3, 2))
    solid = (total >= SOLID_DIODES) & (size[:, 0] > SOLID_DEPTH**2 * size[:, 2])
    for which, k in ((solid, 3), (~solid, 2)):
        F[which, :k] = _affine_fit(offset[which], axes[which, :k], image[which], seen[which])
    scale, rows = _rows(F, solid)
    R = view.transpose(0, 2, 1) @ rows @ axes
    t = view[:, 0] / scale[:, None] - np.einsum("nij,nj->ni", R, centre)
    return _Starts(R, t, centre, axes[:, 2].copy())


def _affine_fit(
    offset: np.ndarray, axes: np.ndarray, image: np.ndarray, seen: np.ndarray
) -> np.ndarray:
    """What a step along each of k axes moves in the image, (n, k, 2), by least squares; 0 along an
    axis across which there is no diode."""
    along = np.einsum("ndi,nki->ndk", offset, axes)
    A = np.concatenate([along, np.ones_like(along[:, :, :1])], axis=2) * seen[:, :, None]
    At = A.transpose(0, 2, 1)
    try:
        return np.linalg.solve(At @ A, At @ image)[:, :-1]
    except np.linalg.LinAlgError:  # of one that sees diodes on a line
        return (np.linalg.pinv(At @ A, hermitian=True) @ (At @ image))[:, :-1]


def _rows(F: np.ndarray, solid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """1/range (n,) and the rotation (n, 3, 3) whose last two rows are nearest to F / scale."""
    square = (F**2).sum(axis=(1, 2))
    det = F[:, 0, 0] * F[:, 1, 1] - F[:, 0, 1] * F[:, 1, 0]
    # The larger singular value of a flat board's F: no length looks longer than it is.
    largest = np.sqrt(square / 2 + np.sqrt(np.maximum(square**2 / 4 - det**2, 0)))
    scale = np.where(solid, np.sqrt(square / 2), largest)
    rows = np.empty((len(F), 3, 3))
    rows[:, 1:] = (F / scale[:, None, None]).transpose(0, 2, 1)
    depth = np.sqrt(np.maximum(1 - (rows[:, 1:, :2] ** 2).sum(axis=2), 0))
    # The rows are at right angles.
    depth[:, 1] *= -np.sign((rows[:, 1, :2] * rows[:, 2, :2]).sum(axis=1))
    rows[:, 1:, 2] = np.where(solid[:, None], rows[:, 1:, 2], depth)
    rows[:, 1] /= np.linalg.norm(rows[:, 1], axis=1)[:, None]
    rows[:, 2] -= (rows[:, 1] * rows[:, 2]).sum(axis=1)[:, None] * rows[:, 1]
    rows[:, 2] /= np.linalg.norm(rows[:, 2], axis=1)[:, None]
    rows[:, 0] = np.cross(rows[:, 1], rows[:, 2])
    return scale, rows


@njit
def _minimise_all(
    seen: np.ndarray,
    board: np.ndarray,
    angles: np.ndarray,
    rotors: np.ndarray,
    start: _Starts,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Levenberg-Marquardt and the mirror test for every measurement."""
    n, d = seen.shape
    Rs, ts, centre, normal = start
    Rs_found, ts_found = np.empty((2, n, 3, 3)), np.empty((2, n, 3))
    epsilon, ambiguity = np.empty((2, n)), np.empty(n)
    points, m = np.empty((d, 3)), np.empty((d, 2))
    for i in range(n):
        k = 0
        for j in range(d):
            if seen[i, j]:
                points[k], m[k] = board[j], angles[i, j]
                k += 1
        problem = PoseProblem(BOARD, points[:k], m[:k], rotors)
        R, t, f, _ = minimise(Rs[i], ts[i], problem)
        R2, t2 = _mirrored(R, t, centre[i], normal[i])
        R2, t2, f2, _ = minimise(R2, t2, problem)
        trace = 0.0
        for j in range(3):
            for k in range(3):
                trace += R[j, k] * R2[j, k]
        ambiguity[i] = max(f, f2) / min(f, f2) if trace < SAME_TRACE else np.inf
        best = 1 if f2 < f else 0
        Rs_found[best, i], ts_found[best, i], epsilon[best, i] = R, t, f
        Rs_found[1 - best, i], ts_found[1 - best, i], epsilon[1 - best, i] = R2, t2, f2
    return Rs_found, ts_found, epsilon, ambiguity


def both_minima(
    measurements: Measurements, board: np.ndarray, rotors: np.ndarray
) -> tuple[Path, Path]:
    """J Eq. 3 by Levenberg-Marquardt: the minimum of lower K_1, and the other one.

    A nearly flat board looks nearly the same with its normal mirrored at the line of sight. The
    search starts from the weak-perspective pose of each measurement, and again from the mirrored
    one; where both end in one pose, the paths share it and `ambiguity` is infinite.
    """
    seen, start = measurements.seen, _affine_starts(measurements, board)
    points, angles = np.ascontiguousarray(board), measurements.angles_rad
    R, t, epsilon, ambiguity = _minimise_all(seen, points, angles, rotors, start)
    count = 2 * seen.sum(axis=1)
    first, second = (
        Path(measurements.time_s, R[k], t[k], epsilon[k], count, ambiguity) for k in (0, 1)
    )
    return first, second


def by_levenberg_marquardt(
    measurements: Measurements, board: np.ndarray, rotors: np.ndarray
) -> Path:
    """J Eq. 3 by Levenberg-Marquardt: of both minima that of lower K_1, see `both_minima`."""
    return both_minima(measurements, board, rotors)[0]


def angle_between(path: Path, other: Path) -> np.ndarray:
    """Angle in rad between the rotations of two paths."""
    trace = np.einsum("nij,nij->n", path.R, other.R)
    return np.arccos(np.clip((trace - 1) / 2, -1, 1))
