"""Levenberg-Marquardt on K_1 and K_2 (J Eq. 4 and 6), with analytic derivatives.

The step is a shift of the position and a left rotation vector, so no angle has a singular point:
p(d) = Exp(w) R b + t + s for the board's pose, p(d) = R^T Exp(-w) (q - t - s) for the station's.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.common.linear import solve
from mocap_metrology.lighthouse.fit.simplex import STATION
from mocap_metrology.lighthouse.rotor import angle_gradient, turned

N = 6  # unknowns of a pose
ITERATIONS = 40  # at most
SINGULAR = 1e-14  # what is left of a diagonal element, over it


class PoseProblem(NamedTuple):
    """Whose pose is unknown, BOARD or STATION; points (n, 3) in m with both angles, measured (n, 2)
    in rad; rotors of the station."""

    unknown: int
    points: np.ndarray
    measured: np.ndarray
    rotors: np.ndarray


@njit
def turn(w: np.ndarray, R: np.ndarray) -> np.ndarray:
    """Exp(w) R for a rotation vector w (Rodrigues)."""
    angle = math.sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
    if angle < 1e-8:
        s, c = 1.0, 0.5
    else:
        s, c = math.sin(angle) / angle, (1.0 - math.cos(angle)) / (angle * angle)
    rest = math.cos(angle)
    out = np.empty((3, 3))
    for j in range(3):
        x, y, z = R[0, j], R[1, j], R[2, j]
        along = c * (w[0] * x + w[1] * y + w[2] * z)
        out[0, j] = rest * x + s * (w[1] * z - w[2] * y) + along * w[0]
        out[1, j] = rest * y + s * (w[2] * x - w[0] * z) + along * w[1]
        out[2, j] = rest * z + s * (w[0] * y - w[1] * x) + along * w[2]
    return out


@njit
def normal_equations(
    R: np.ndarray, t: np.ndarray, problem: PoseProblem, H: np.ndarray, g: np.ndarray
) -> float:
    """H = J^T J (6, 6) and g = J^T (C - M) (6,) of a pose, by position in m and left rotation
    vector in rad, written in place; returns the cost."""
    unknown, points, measured, rotors = problem
    H[:], g[:] = 0.0, 0.0
    row, none = np.empty(N), np.empty(0)
    total = 0.0
    for i in range(points.shape[0]):
        a, b, c = points[i, 0], points[i, 1], points[i, 2]
        if unknown == STATION:
            a, b, c = a - t[0], b - t[1], c - t[2]
            qx, qy, qz = turned(R.T, a, b, c)
        else:
            a, b, c = turned(R, a, b, c)
            qx, qy, qz = a + t[0], b + t[1], c + t[2]
        for axis in range(2):
            theta, dx, dy, dz = angle_gradient(axis, qx, qy, qz, rotors[axis], none)
            e = theta - measured[i, axis]
            if unknown == STATION:  # derivatives by the arm (a, b, c) in master axes, negated
                dx, dy, dz = turned(R, -dx, -dy, -dz)
            row[0], row[1], row[2] = dx, dy, dz
            row[3], row[4], row[5] = b * dz - c * dy, c * dx - a * dz, a * dy - b * dx
            total += e * e
            for j in range(N):
                g[j] += row[j] * e
                for k in range(j + 1):
                    H[j, k] += row[j] * row[k]
    for j in range(N):
        for k in range(j):
            H[k, j] = H[j, k]
    return total


@njit
def damped_step(H: np.ndarray, g: np.ndarray, damping: float) -> np.ndarray:
    """-(H + damping diag H)^-1 g, (6,); NaN where H is singular."""
    damped, x = H.copy(), -g
    for i in range(N):
        damped[i, i] *= 1.0 + damping
    solve(damped, x, 0.0, SINGULAR, np.nan)
    return x


@njit
def minimise(
    R: np.ndarray, t: np.ndarray, problem: PoseProblem
) -> tuple[np.ndarray, np.ndarray, float, bool]:
    """Local minimum of K_1 or K_2 from (R, t): R, t, cost in rad^2, and whether it converged: a
    step below 1e-10 (m, rad) or a gain below 1e-10 of the cost."""
    H, g = np.empty((N, N)), np.empty(N)
    H2, g2 = np.empty((N, N)), np.empty(N)
    f = normal_equations(R, t, problem, H, g)
    damping = 1e-3
    for _ in range(ITERATIONS):
        d = damped_step(H, g, damping)
        if not math.isfinite(d[0]):
            damping = max(10.0 * damping, 1e-6)
            if damping > 1e10:
                return R, t, f, False
            continue
        R2, t2 = turn(d[3:], R), t + d[:3]
        f2 = normal_equations(R2, t2, problem, H2, g2)
        largest = np.abs(d).max()
        if f2 <= f:
            gained = f - f2
            R, t, f = R2, t2, f2
            H, H2 = H2, H
            g, g2 = g2, g
            damping *= 0.1
            if largest < 1e-10 or gained <= 1e-10 * f:
                return R, t, f, True
        else:
            if largest < 1e-10 or f2 - f <= 1e-12 * f:
                return R, t, f, True
            damping = max(10.0 * damping, 1e-6)
            if damping > 1e10:
                return R, t, f, False
    return R, t, f, False
