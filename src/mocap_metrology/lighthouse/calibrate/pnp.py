"""Board poses by the methods for cameras that J V-A weighs: Perspective-n-Point, through OpenCV.

A station that measures both angles of a point is a pinhole camera: with its optical axis along
station x the image of (x, y, z) is (-y/x, -z/x) = (-tan azimuth, -tan elevation). EPnP [Lepetit
et al. 2009] and SQPnP [Terzakis & Lourakis 2020] take boards with depth, IPPE [Collins & Bartoli
2014] flat ones. OpenCV's EPnP has no case for flat boards: on one of 24 x 16 cm at 3 m it is off by
tens of degrees, so it is refused there.

OpenCV is not among the project's requirements: `make peers` installs it.

The geometric method that J V-A weighs too is root finding on ranges [Islam et al. 2016,
Kleinschmidt et al. 2017]: both lasers are assumed in the station's middle, so the angles of diode
i give its direction d_i, |d_i| = 1, and its range r_i is unknown. For each pair of diodes at the
known distance D_ij the law of cosines gives

    r_i^2 + r_j^2 - 2 r_i r_j cos(d_i, d_j) = D_ij^2,

solved for the ranges by Newton's method. Then r_i d_i are the diodes' places and Kabsch's algorithm
gives the board's pose. Here all pairs are used at once, in least squares (Gauss-Newton, damped), as
32 diodes give 496 equations for 32 ranges. A flat board fits nearly as well mirrored at the line of
sight, so both are tried and the pose that fits the angles better is chosen.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from importlib.util import find_spec

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.linear import solve
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.board import FEWEST_DIODES
from mocap_metrology.lighthouse.calibrate.superpose import kabsch

METHODS = ("auto", "epnp", "ippe", "sqpnp")
FLAT = 1e-3  # thickness of a flat board over its width
CAMERA = np.array([[0.0, -1, 0], [0, 0, -1], [1, 0, 0]])  # station axes -> camera axes
ITERATIONS = 50  # at most
CONVERGED = 1e-10  # largest step of a range over the range
LEAST_PIVOT = 1e-30  # m^2: of equations that are all zero
LEAST_GAIN = 1e-12  # of the sum of squares
LARGEST_DAMPING, RIDGE = 1e8, 1e-14  # of the diagonal, of its sum
LARGEST_COST = 1.0  # rad^2: with more it is no pose

Pose = tuple[np.ndarray, np.ndarray]


def opencv_is_missing() -> str:
    """One line where OpenCV is not installed, else nothing."""
    if find_spec("cv2") is not None:
        return ""
    return "pnp needs OpenCV, which is not installed; to install it type: make peers"


def is_flat(board: np.ndarray) -> bool:
    """Whether all points (n, 3) lie in one plane."""
    spread = np.linalg.svd(board - board.mean(axis=0), compute_uv=False)
    return bool(spread[2] < FLAT * spread[0])


def board_poses(
    directions: np.ndarray, board: np.ndarray, method: str = "auto"
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pose of the board in the station's frame for each of n measurements, as `_best_poses`.

    directions (n, d, 2): ideal azimuth and elevation in rad, NaN where unseen; board (d, 3) in m.
    method: `epnp`, `sqpnp` (boards with depth), `ippe` (flat boards; it finds two poses, mirror
    images at the line of sight), `auto` (ippe for a flat board, else epnp).
    """
    if method not in METHODS:
        raise Refusal(f"pnp: method is {method!r}; expected one of {', '.join(METHODS)}")
    flat = is_flat(board)
    chosen = ("ippe" if flat else "epnp") if method == "auto" else method
    if chosen == "ippe" and not flat:
        raise Refusal("ippe: the board is not flat; expected all diodes in one plane, or sqpnp")
    if flat and chosen == "epnp":
        raise Refusal("epnp: the board is flat, where this method fails; expected ippe or auto")
    # IPPE wants its plane as z = 0 and every method conditions best about the centroid.
    centre = board.mean(axis=0)
    axes = np.linalg.svd(board - centre)[2]
    axes[2] = np.cross(axes[0], axes[1])

    def poses_of(points: np.ndarray, angles: np.ndarray) -> Iterator[Pose]:
        local = (points - centre) @ axes.T
        if chosen == "ippe":
            local[:, 2] = 0.0
        for R, t in _solve(local, -np.tan(angles), chosen):
            yield R @ axes, t - R @ axes @ centre

    return _best_poses(directions, board, poses_of)


def _best_poses(
    directions: np.ndarray,
    board: np.ndarray,
    poses_of: Callable[[np.ndarray, np.ndarray], Iterable[Pose]],
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """R (n, 3, 3), t (n, 3) in m, and K_1 of J Eq. 4 with ideal optics (n,) in rad^2, of the least
    K_1 among the poses found from the diodes seen and their angles; NaN where fewer than four are
    seen, or none of the poses lies before the station, whose laser turns nowhere else."""
    n = len(directions)
    R, t, cost = np.full((n, 3, 3), np.nan), np.full((n, 3), np.nan), np.full(n, np.nan)
    for i, measured in enumerate(directions):
        seen = np.isfinite(measured).all(axis=1)
        if seen.sum() < FEWEST_DIODES:
            continue
        for turn, shift in poses_of(board[seen], measured[seen]):
            p = board[seen] @ turn.T + shift
            off = np.arctan2(p[:, 1:], p[:, :1]) - measured[seen]
            K_1 = float(np.sum(off**2)) if (p[:, 0] > 0).all() else np.inf
            if K_1 < LARGEST_COST and not cost[i] <= K_1:
                R[i], t[i], cost[i] = turn, shift, K_1
    return R, t, cost


def _solve(points: np.ndarray, image: np.ndarray, method: str) -> list[Pose]:
    """Poses of points (k, 3) seen at image (k, 2) by the camera, in station axes."""
    if why := opencv_is_missing():
        raise ModuleNotFoundError(why)
    import cv2

    flag = {"epnp": cv2.SOLVEPNP_EPNP, "ippe": cv2.SOLVEPNP_IPPE, "sqpnp": cv2.SOLVEPNP_SQPNP}
    try:
        _, turns, shifts, _ = cv2.solvePnPGeneric(
            np.ascontiguousarray(points),
            np.ascontiguousarray(image[:, None]),
            np.eye(3),
            None,
            flags=flag[method],
        )
    except cv2.error:  # a degenerate view: no pose
        return []
    poses = [
        (CAMERA.T @ rotation.exp(np.ravel(turn)), CAMERA.T @ np.ravel(shift))
        for turn, shift in zip(turns, shifts, strict=True)
    ]
    return [(R, t) for R, t in poses if np.isfinite(R).all() and np.isfinite(t).all()]


def geometric_poses(
    directions: np.ndarray, board: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Board poses as `board_poses` by root finding; NaN also where no root is found."""

    def poses_of(points: np.ndarray, angles: np.ndarray) -> Iterator[Pose]:
        rays = np.column_stack([np.ones(len(angles)), np.tan(angles)])
        rays /= np.linalg.norm(rays, axis=1, keepdims=True)
        squared = ((points[:, None] - points) ** 2).sum(axis=-1)
        for start in first_ranges(rays, points):
            ranges = solve_ranges(rays, squared, start)
            if (ranges > 0).all():
                yield kabsch(points, ranges[:, None] * rays)

    return _best_poses(directions, board, poses_of)


def first_ranges(rays: np.ndarray, board: np.ndarray) -> list[np.ndarray]:
    """Two starts for the ranges, in m, from small angles: the image of the board is a scaled view.

    The offsets of the rays from their mean are an affine map A of the board's own plane; its
    larger singular value is 1 / range, as no length looks longer than it is. The smaller is
    shortened by the cosine of the tilt, whose sign is open: one start for each.
    """
    middle = rays.mean(axis=0)
    middle /= np.linalg.norm(middle)
    across = np.linalg.svd(middle[None])[2][1:]
    image = (rays @ across.T) / (rays @ middle)[:, None]
    centred = board - board.mean(axis=0)
    plane = centred @ np.linalg.svd(centred, full_matrices=False)[2][:2].T
    A = np.linalg.lstsq(np.column_stack([plane, np.ones(len(plane))]), image, rcond=None)[0][:2]
    U, s, _ = np.linalg.svd(A)
    tilt = math.sqrt(max(1.0 - (s[1] / s[0]) ** 2, 0.01))  # never the saddle between both
    depth = tilt * (plane @ U[:, 1])
    distance = (1.0 / s[0] + np.array([1.0, -1.0])[:, None] * depth) / (rays @ middle)
    return list(distance)


@njit
def solve_ranges(rays: np.ndarray, squared: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Ranges (k,) in m that least-squares solve r_i^2 + r_j^2 - 2 r_i r_j c_ij = D_ij^2.

    rays (k, 3) unit vectors, squared (k, k) the D_ij^2 in m^2, start (k,). Newton's step
    (J^T J + damping) dr = -J^T f, damping lowered as long as the sum of squares falls.
    """
    c, r, damping = rays @ rays.T, start, 1e-3
    f = _misfit(r, c, squared)
    for _ in range(ITERATIONS):
        J = 2 * (r[:, None] - r * c)  # of f_ij by r_i, every pair in both orders
        H = J * J.T
        H += np.diag((1 + damping) * np.sum(J**2, axis=1) + RIDGE * np.sum(J**2))
        step = -np.sum(J * f, axis=1)
        solve(H, step, LEAST_PIVOT, 0.0, LEAST_PIVOT)
        then = _misfit(r + step, c, squared)
        small, gain = np.abs(step).max() < CONVERGED * np.abs(r).max(), np.sum(f**2 - then**2)
        if gain >= 0:
            small = small or gain <= LEAST_GAIN * np.sum(f**2)
            r, f, damping = r + step, then, 0.1 * damping
        else:
            damping = max(10.0 * damping, 1e-8)
        if small or damping > LARGEST_DAMPING:
            break
    return r


@njit
def _misfit(r: np.ndarray, c: np.ndarray, squared: np.ndarray) -> np.ndarray:
    """(k, k) of all pairs, m^2: |r_i d_i - r_j d_j|^2 without the loss of digits of r_i^2 + ..."""
    return np.square(r[:, None] - r) + 2 * np.outer(r, r) * (1 - c) - squared
