"""K_1 and K_2 of J, compiled: how far predicted angles are from measured ones.

Both sum (C - M)^2 over diodes and axes. In K_1 (J Eq. 4) the unknown is the board's pose and the
points are its diodes; in K_2 (J Eq. 6) the unknown is the station's pose and the points are diodes
of all measurements in the master's frame. A pose is x = (x, y, z, alpha, beta, gamma) in m and rad.
"""

from __future__ import annotations

import math

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.lighthouse.rotor import IMPERFECT, X, Y, Z, angle

BOARD, STATION = 0, 1  # whose pose is unknown


@njit
def matrix(x: np.ndarray, R: np.ndarray) -> None:
    """R = Rz(gamma) Ry(beta) Rx(alpha) of the angles x[3:6], written to R (3, 3)."""
    ca, cb, cg = math.cos(x[3]), math.cos(x[4]), math.cos(x[5])
    sa, sb, sg = math.sin(x[3]), math.sin(x[4]), math.sin(x[5])
    R[0, 0], R[0, 1], R[0, 2] = cg * cb, cg * sb * sa - sg * ca, cg * sb * ca + sg * sa
    R[1, 0], R[1, 1], R[1, 2] = sg * cb, sg * sb * sa + cg * ca, sg * sb * ca - cg * sa
    R[2, 0], R[2, 1], R[2, 2] = -sb, cb * sa, cb * ca


@njit(inline="always")
def _turn(b: float, a: float, cos_m: float, sin_m: float) -> float:
    """atan2(b, a) minus the measured angle, without an arctangent where the two are near.

    tan of the difference is q = (b cos m - a sin m) / (a cos m + b sin m); below 0.04 the series of
    atan q, cut after q^11, is exact to 1e-19.
    """
    over, under = b * cos_m - a * sin_m, a * cos_m + b * sin_m
    q = over / under
    if under > 0.0 and abs(q) < 0.04:
        s = q * q
        return q * (1.0 - s * (1 / 3 - s * (1 / 5 - s * (1 / 7 - s * (1 / 9 - s / 11)))))
    return math.atan2(over, under)


@njit
def cost(
    x: np.ndarray,
    unknown: int,
    points: np.ndarray,
    measured: np.ndarray,
    trig: np.ndarray,
    rotors: np.ndarray,
    R: np.ndarray,
) -> float:
    """K_1 or K_2 in rad^2.

    points (n, 3): diodes in the board's frame (BOARD) or in the master's (STATION); measured (n, 2)
    rad, and trig (n, 4): cos and sin of both; rotors (2, 10); R (3, 3) is room to work in.
    """
    matrix(x, R)
    if unknown == STATION:  # p = R^T (w - t)
        R[0, 1], R[1, 0] = R[1, 0], R[0, 1]
        R[0, 2], R[2, 0] = R[2, 0], R[0, 2]
        R[1, 2], R[2, 1] = R[2, 1], R[1, 2]
        tx = -(R[0, 0] * x[0] + R[0, 1] * x[1] + R[0, 2] * x[2])
        ty = -(R[1, 0] * x[0] + R[1, 1] * x[1] + R[1, 2] * x[2])
        tz = -(R[2, 0] * x[0] + R[2, 1] * x[1] + R[2, 2] * x[2])
    else:
        tx, ty, tz = x[0], x[1], x[2]
    total = 0.0
    ideal = rotors[0, IMPERFECT] == 0.0 and rotors[1, IMPERFECT] == 0.0
    for i in range(points.shape[0]):
        a, b, c = points[i, 0], points[i, 1], points[i, 2]
        px = R[0, 0] * a + R[0, 1] * b + R[0, 2] * c + tx
        py = R[1, 0] * a + R[1, 1] * b + R[1, 2] * c + ty
        pz = R[2, 0] * a + R[2, 1] * b + R[2, 2] * c + tz
        if ideal:
            e0 = _turn(py - rotors[0, Y], px - rotors[0, X], trig[i, 0], trig[i, 1])
            e1 = _turn(pz - rotors[1, Z], px - rotors[1, X], trig[i, 2], trig[i, 3])
        else:
            e0 = angle(0, px, py, pz, rotors[0]) - measured[i, 0]
            e1 = angle(1, px, py, pz, rotors[1]) - measured[i, 1]
        total += e0 * e0 + e1 * e1
    return total


def trig_of(measured: np.ndarray) -> np.ndarray:
    """cos and sin of azimuth, cos and sin of elevation, (n, 4)."""
    m = np.asarray(measured)
    return np.column_stack([np.cos(m[:, 0]), np.sin(m[:, 0]), np.cos(m[:, 1]), np.sin(m[:, 1])])


def evaluate(
    x: np.ndarray, unknown: int, points: np.ndarray, measured: np.ndarray, rotors: np.ndarray
) -> float:
    """K_1 (unknown BOARD) or K_2 (STATION) at a pose, see `cost`."""
    x, points = np.asarray(x, dtype=np.float64), np.ascontiguousarray(points)
    measured = np.ascontiguousarray(measured)
    return cost(x, unknown, points, measured, trig_of(measured), rotors, np.empty((3, 3)))
