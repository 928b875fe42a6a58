"""Board poses by the methods for cameras that J V-A weighs: Perspective-n-Point, through OpenCV.

A station that measures both angles of a point is a pinhole camera: with its optical axis along
station x the image of (x, y, z) is (-y/x, -z/x) = (-tan azimuth, -tan elevation). EPnP [Lepetit
et al. 2009] and SQPnP [Terzakis & Lourakis 2020] take boards with depth, IPPE [Collins & Bartoli
2014] flat ones. OpenCV's EPnP has no case for flat boards: on one of 24 x 16 cm at 3 m it is off by
tens of degrees, so it is refused there.

OpenCV is not among the project's requirements: `make peers` installs it.
"""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.board import FEWEST_DIODES

METHODS = ("auto", "epnp", "ippe", "sqpnp")
FLAT = 1e-3  # thickness of a flat board over its width
CAMERA = np.array([[0.0, -1, 0], [0, 0, -1], [1, 0, 0]])  # station axes -> camera axes


def opencv_is_missing() -> str:
    """One line where OpenCV is not installed, else nothing."""
    if find_spec("cv2") is not None:
        return ""
    return "pnp needs OpenCV, which is not installed; to install it type: make peers"


def angle_cost(R: np.ndarray, t: np.ndarray, directions: np.ndarray, board: np.ndarray) -> float:
    """K_1 of J Eq. 4 with ideal optics: sum of squared angle errors in rad^2, NaN left out.

    A pose behind the station has cost inf: its laser never turns there.
    """
    p = board @ R.T + t
    if (p[np.isfinite(directions).all(axis=1), 0] <= 0).any():
        return float("inf")
    predicted = np.arctan2(p[:, 1:], p[:, :1])
    return float(np.nansum((predicted - directions) ** 2))


def is_flat(board: np.ndarray) -> bool:
    """Whether all points (n, 3) lie in one plane."""
    spread = np.linalg.svd(board - board.mean(axis=0), compute_uv=False)
    return bool(spread[2] < FLAT * spread[0])


def both_poses(
    directions: np.ndarray, board: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The two poses IPPE finds for a flat board, the one of lower cost first.

    They are mirror images at the line of sight; a cost ratio near 1 means that the angles do not
    decide which is right. Arguments as in `board_poses`; R (n, 2, 3, 3), t (n, 2, 3), cost (n, 2).
    """
    if not is_flat(board):
        raise Refusal("ippe: the board is not flat; expected all diodes in one plane, or sqpnp")
    return _solve_all(directions, board, "ippe", 2)


def board_poses(
    directions: np.ndarray, board: np.ndarray, method: str = "auto"
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pose of the board in the station's frame for each of n measurements.

    directions (n, d, 2): ideal azimuth and elevation in rad, NaN where unseen; board (d, 3) in m.
    method: `epnp`, `sqpnp` (boards with depth), `ippe` (flat boards; of its two poses the one of
    lower cost), `auto` (ippe for a flat board, else epnp).

    Returns R (n, 3, 3), t (n, 3) in m, and cost (n,), the sum of squared angle errors in rad^2; NaN
    where fewer than four diodes are seen or none of the solutions lies before the station.
    """
    if method not in METHODS:
        raise Refusal(f"pnp: method is {method!r}; expected one of {', '.join(METHODS)}")
    flat = is_flat(board)
    chosen = ("ippe" if flat else "epnp") if method == "auto" else method
    if chosen == "ippe":
        R, t, cost = both_poses(directions, board)
    elif flat and chosen == "epnp":
        raise Refusal("epnp: the board is flat, where this method fails; expected ippe or auto")
    else:
        R, t, cost = _solve_all(directions, board, chosen, 1)
    return R[:, 0], t[:, 0], cost[:, 0]


def _solve_all(
    directions: np.ndarray, board: np.ndarray, method: str, n_kept: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The `n_kept` solutions of lowest cost for every measurement."""
    n = len(directions)
    R, t = np.full((n, n_kept, 3, 3), np.nan), np.full((n, n_kept, 3), np.nan)
    cost = np.full((n, n_kept), np.nan)
    # IPPE wants its plane as z = 0 and every method conditions best about the centroid.
    centre = board.mean(axis=0)
    axes = np.linalg.svd(board - centre)[2]
    axes[2] = np.cross(axes[0], axes[1])
    local = (board - centre) @ axes.T
    if method == "ippe":
        local[:, 2] = 0.0
    for i, measured in enumerate(directions):
        seen = np.isfinite(measured).all(axis=1)
        if seen.sum() < FEWEST_DIODES:
            continue
        own = np.where(seen[:, None], measured, np.nan)
        found = []
        for R_local, t_local in _solve(local[seen], -np.tan(measured[seen]), method):
            Ri = R_local @ axes
            ti = t_local - Ri @ centre
            found.append((angle_cost(Ri, ti, own, board), Ri, ti))
        found = sorted((f for f in found if np.isfinite(f[0])), key=lambda f: f[0])
        for k, (c, Ri, ti) in enumerate(found[:n_kept]):
            cost[i, k], R[i, k], t[i, k] = c, Ri, ti
    return R, t, cost


def _solve(
    points: np.ndarray, image: np.ndarray, method: str
) -> list[tuple[np.ndarray, np.ndarray]]:
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
    found = [
        (CAMERA.T @ rotation.exp(np.ravel(turn)), CAMERA.T @ np.ravel(shift))
        for turn, shift in zip(turns, shifts, strict=True)
    ]
    return [(R, t) for R, t in found if np.isfinite(R).all() and np.isfinite(t).all()]
