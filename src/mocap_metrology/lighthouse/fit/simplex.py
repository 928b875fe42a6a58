"""K_1 and K_2 of J, compiled, and their minimum by the simplex of Nelder and Mead as MATLAB's
fminsearch uses it (J V-A, Eq. 3 and 5).

Both sum (C - M)^2 over diodes and axes: how far predicted angles are from measured ones. In K_1
(J Eq. 4) the unknown is the board's pose and the points are its diodes; in K_2 (J Eq. 6) the
unknown is the station's pose and the points are diodes of all measurements in the master's frame.
A pose is x = (x, y, z, alpha, beta, gamma) in m and rad.

J names the algorithm and neither its settings nor its program; the defaults here are those of
fminsearch: the first simplex is the start and, for each unknown, the start with 5 % more of it
(0.00025 where it is zero); reflection 1, expansion 2, contraction 1/2, shrinking 1/2; the end is
where the simplex is below TolX in every coordinate and below TolFun in cost, or after 200
evaluations an unknown. scipy's `Nelder-Mead` makes the same steps; a test compares both.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.lighthouse.rotor import IMPERFECT, X, Y, angle_gradient, turned

BOARD, STATION = 0, 1  # whose pose is unknown
N = 6  # unknowns of a pose


class SimplexData(NamedTuple):
    """Whose pose is unknown; points (3, n) in m: diodes in the board's frame (BOARD) or in the
    master's (STATION); measured (2, n) rad, azimuth and elevation; trig (4, n): cos and sin of
    both; rotors (2, 13)."""

    unknown: int
    points: np.ndarray
    measured: np.ndarray
    trig: np.ndarray
    rotors: np.ndarray


class SimplexSettings(NamedTuple):
    """Limits at which a search ends: TolX in m and rad, TolFun in rad^2, evaluations of the
    cost."""

    tol_x: float = 1e-4
    tol_fun: float = 1e-4
    evaluations: int = 200 * N


MATLAB = SimplexSettings()
TIGHT = SimplexSettings(tol_x=1e-6, tol_fun=1e-14, evaluations=1000 * N)


@njit
def matrix(x: np.ndarray, R: np.ndarray) -> None:
    """R = Rz(gamma) Ry(beta) Rx(alpha) of the angles x[3:6], written to R (3, 3)."""
    ca, cb, cg = math.cos(x[3]), math.cos(x[4]), math.cos(x[5])
    sa, sb, sg = math.sin(x[3]), math.sin(x[4]), math.sin(x[5])
    R[0, 0], R[0, 1], R[0, 2] = cg * cb, cg * sb * sa - sg * ca, cg * sb * ca + sg * sa
    R[1, 0], R[1, 1], R[1, 2] = sg * cb, sg * sb * sa + cg * ca, sg * sb * ca - cg * sa
    R[2, 0], R[2, 1], R[2, 2] = -sb, cb * sa, cb * ca


@njit
def _turns(room: np.ndarray, axis: int, data: SimplexData) -> float:
    """Sum of squares of atan2(side, ahead) about a laser, less the measured angle m.

    Points are in room[:3], room[3] is written over. Differences are in (-pi, pi], and need no
    arctangent where they are small: with q = (s cos m - a sin m) / (a cos m + s sin m), the tangent
    of the difference, below 0.1 the series of atan q, cut after q^13, is exact to 1e-16. Loops
    without a branch, so that several elements are computed at a time.
    """
    measured, trig, laser = data.measured, data.trig, data.rotors[axis]
    side_0, ahead_0 = laser[Y + axis], laser[X]
    n, k, c = measured.shape[1], 1 + axis, 2 * axis
    for i in range(n):
        s, a = room[k, i] - side_0, room[0, i] - ahead_0
        room[3, i] = (s * trig[c, i] - a * trig[c + 1, i]) / (a * trig[c, i] + s * trig[c + 1, i])
    far = 0
    for i in range(n):
        under = (room[0, i] - ahead_0) * trig[c, i] + (room[k, i] - side_0) * trig[c + 1, i]
        far += 0 if (abs(room[3, i]) < 0.1) & (under > 0.0) else 1
    if far > 0:
        for i in range(n):
            e = math.atan2(room[k, i] - side_0, room[0, i] - ahead_0) - measured[axis, i]
            room[3, i] = e - 2.0 * math.pi * math.floor(0.5 + e / (2.0 * math.pi))
    else:
        for i in range(n):
            q = room[3, i]
            s = q * q
            series = 1 / 5 - s * (1 / 7 - s * (1 / 9 - s * (1 / 11 - s / 13)))
            room[3, i] = q * (1.0 - s * (1 / 3 - s * series))
    return _sum_of_squares(room)


@njit
def _sum_of_squares(room: np.ndarray) -> float:
    """Sum of squares of room[3], in four parts, of which a processor adds several at a time."""
    a, b, c, d = 0.0, 0.0, 0.0, 0.0
    n = room.shape[1]
    whole = n - n % 4
    for i in range(0, whole, 4):
        a += room[3, i] * room[3, i]
        b += room[3, i + 1] * room[3, i + 1]
        c += room[3, i + 2] * room[3, i + 2]
        d += room[3, i + 3] * room[3, i + 3]
    for i in range(whole, n):
        a += room[3, i] * room[3, i]
    return (a + b) + (c + d)


@njit
def cost(x: np.ndarray, data: SimplexData, R: np.ndarray, room: np.ndarray) -> float:
    """K_1 or K_2 in rad^2; R (3, 3) and room (4, n) to work in."""
    rotors, points = data.rotors, data.points
    matrix(x, R)
    if data.unknown == STATION:  # p = R^T (w - t)
        R = R.T
        tx, ty, tz = turned(R, -x[0], -x[1], -x[2])
    else:
        tx, ty, tz = x[0], x[1], x[2]
    for k, t in ((0, tx), (1, ty), (2, tz)):  # R p + t, into room[:3]
        rx, ry, rz = R[k, 0], R[k, 1], R[k, 2]
        for i in range(points.shape[1]):
            room[k, i] = rx * points[0, i] + ry * points[1, i] + rz * points[2, i] + t
    total = 0.0
    if rotors[0, IMPERFECT] == 0.0 and rotors[1, IMPERFECT] == 0.0:
        for axis in range(2):
            total += _turns(room, axis, data)
        return total
    none = np.empty(0)
    for i in range(points.shape[1]):
        a, b, c = room[0, i], room[1, i], room[2, i]
        for axis in range(2):
            angle = angle_gradient(axis, a, b, c, rotors[axis], none)[0]
            e = angle - data.measured[axis, i]
            total += e * e
    return total


def trig_of(measured: np.ndarray) -> np.ndarray:
    """cos and sin of both angles, (4, ...), of angles (2, ...) in rad."""
    return np.stack([f(m) for m in np.asarray(measured) for f in (np.cos, np.sin)])


def seen_at(
    unknown: int, points: np.ndarray, measured: np.ndarray, rotors: np.ndarray
) -> SimplexData:
    """What a search needs of points (n, 3) and measured angles (n, 2)."""
    angles = np.ascontiguousarray(np.transpose(measured), dtype=np.float64)
    places = np.ascontiguousarray(np.transpose(points), dtype=np.float64)
    return SimplexData(unknown, places, angles, trig_of(angles), rotors)


def evaluate(x: np.ndarray, data: SimplexData) -> float:
    """The cost that `nelder_mead` minimises, at one point."""
    return cost(np.asarray(x, float), data, np.empty((3, 3)), np.empty((4, data.points.shape[1])))


@njit
def _sort(simplex: np.ndarray, f: np.ndarray) -> None:
    """Insertion sort by cost; equal costs retain their order."""
    for i in range(1, N + 1):
        j = i
        while j > 0 and f[j - 1] > f[j]:
            f[j - 1], f[j] = f[j], f[j - 1]
            for k in range(N):
                simplex[j - 1, k], simplex[j, k] = simplex[j, k], simplex[j - 1, k]
            j -= 1


@njit
def _on_line(middle: np.ndarray, simplex: np.ndarray, share: float, x: np.ndarray) -> None:
    """x = middle + share (middle - worst point)."""
    for j in range(N):
        x[j] = (1.0 + share) * middle[j] - share * simplex[N, j]


@njit
def _is_small(simplex: np.ndarray, f: np.ndarray, end: SimplexSettings) -> bool:
    for i in range(1, N + 1):
        if abs(f[i] - f[0]) > end.tol_fun:
            return False
        for j in range(N):
            if abs(simplex[i, j] - simplex[0, j]) > end.tol_x:
                return False
    return True


@njit
def nelder_mead(
    x0: np.ndarray, data: SimplexData, end: SimplexSettings
) -> tuple[np.ndarray, float, int]:
    """Minimise K_1 or K_2 (see `cost`) from x0: the pose (6,), its cost in rad^2, evaluations."""
    R, room = np.empty((3, 3)), np.empty((4, data.points.shape[1]))
    simplex, f = np.empty((N + 1, N)), np.empty(N + 1)
    middle, x, y = np.empty(N), np.empty(N), np.empty(N)
    for i in range(N + 1):
        simplex[i] = x0
        if i > 0:
            simplex[i, i - 1] = 1.05 * x0[i - 1] if x0[i - 1] != 0.0 else 0.00025
        f[i] = cost(simplex[i], data, R, room)
    used = N + 1
    _sort(simplex, f)
    while used < end.evaluations and not _is_small(simplex, f, end):
        for j in range(N):
            total = 0.0
            for i in range(N):
                total += simplex[i, j]
            middle[j] = total / N
        _on_line(middle, simplex, 1.0, x)
        fx = cost(x, data, R, room)
        used += 1
        if f[0] <= fx < f[N - 1]:
            simplex[N], f[N] = x, fx
        elif fx < f[0]:
            _on_line(middle, simplex, 2.0, y)
            fy = cost(y, data, R, room)
            used += 1
            if fy < fx:
                simplex[N], f[N] = y, fy
            else:
                simplex[N], f[N] = x, fx
        else:
            _on_line(middle, simplex, 0.5 if fx < f[N] else -0.5, y)
            fy = cost(y, data, R, room)
            used += 1
            if (fx < f[N] and fy <= fx) or (fx >= f[N] and fy < f[N]):
                simplex[N], f[N] = y, fy
            else:
                for i in range(1, N + 1):
                    simplex[i] = simplex[0] + 0.5 * (simplex[i] - simplex[0])
                    f[i] = cost(simplex[i], data, R, room)
                used += N
        _sort(simplex, f)
    return simplex[0].copy(), f[0], used
