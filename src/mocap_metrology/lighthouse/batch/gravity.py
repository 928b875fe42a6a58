"""Gravity in a joint estimate: its magnitude, and the way up that stations transmit.

With g the gravity in the master's frame, u = -g / |g| the way up, and R the rotation of a station,

    (|g| - 9.81) / 0.03,   (R' u - up) / 1.5 deg.

Real stations were wrong by 1 to 2.5 deg, so this helps only where the pose is known no better.
"""

from __future__ import annotations

import numpy as np

from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.batch.problem import GRAVITY_M_S2, Layout, State

MAGNITUDE_SD = 0.03  # m/s^2: between equator and pole, and by altitude
UP_SD = np.radians(1.5)  # of the accelerometer of a station


def first_gravity(state: State, ups: np.ndarray) -> Floats:
    """Gravity (3,) in m/s^2 by the stations' ways up (stations, 3), NaN where unknown."""
    up = np.nansum(np.einsum("sij,sj->si", state.R, ups), axis=0)
    return -GRAVITY_M_S2 * up / np.linalg.norm(up)


def gravity_equations(
    state: State, of: Layout, ups: np.ndarray | None
) -> tuple[Floats, Floats, float]:
    """Normal matrix, gradient and sum of squares of what is known of gravity."""
    S, h, cost = np.zeros((of.size, of.size)), np.zeros(of.size), 0.0
    if of.gravity < 0:
        return S, h, cost
    down = of.gravity + np.arange(3)
    size = np.linalg.norm(state.gravity)
    u = -state.gravity / size
    rows = [((size - GRAVITY_M_S2) / MAGNITUDE_SD, down, -u / MAGNITUDE_SD)]
    for station, up in enumerate(() if ups is None else ups):
        if not np.isfinite(up).all():
            continue
        R, pose = state.R[station], int(of.columns[station, 0, 0])
        by_g = R.T @ (np.outer(u, u) - np.eye(3)) / size
        by_turn = R.T @ np.cross(np.eye(3), u)  # [u]
        at = np.r_[down, pose + 3 + np.arange(3)] if pose >= 0 else down
        D = np.hstack([by_g, by_turn])[:, : at.size] / UP_SD
        rows += zip((R.T @ u - up) / UP_SD, [at] * 3, D, strict=True)
    for e, at, d in rows:
        S[np.ix_(at, at)] += np.outer(d, d)
        h[at] += e * d
        cost += float(e * e)
    return S, h, cost
