"""Sums over hits of the normal equations of a joint estimate.

A hit on diode d at time t has the residual e = C(R_s^T (p(t) + R(t) q_d - t_s)) + z - theta, with
p and R from the cubic B-spline of `trajectory`, z the offset of the station's axis. Its derivative
touches the four control points about t and some of the global unknowns. Where the normals n_d of
the diodes are known, light of incidence i reaches a diode under a cover, of the refractive index
1.5, as if it were at q_d + n_d (a + t (1 - cos i / sqrt(1.5^2 - sin^2 i))); a + t / 2, the shift
at 50 deg, and t are unknowns, and what a turn of the board changes of the shift is not in the
derivative. Hits of a sweep share one more error, an offset of variance sigma_c^2 that is
integrated out: with weights w,

    V^-1 = diag(w) / sigma^2 - k w w^T / sigma^4,  k = 1 / (1 / sigma_c^2 + sum(w) / sigma^2),

so the sums below are those of V = I, and of each sweep sum(w J) and sum(w e) besides: any sigma and
sigma_c can be put in later.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.rotation import cross
from mocap_metrology.lighthouse.rotor import GENERATION, angle_gradient

POSE = 6  # unknowns of a control point, and of a station: position, rotation vector
SPAN = 5 * POSE  # of a sweep: the control points of two neighbouring intervals
NEAR = 4 * POSE  # of the control points of one hit
MOST = NEAR + 19  # of those, its other unknowns but its diode's place, its residual and 1
HELD = 0.5  # of the factor of t: where the places of a board's file hold
SMALL_RAD = 1e-4  # of a rotation vector: its functions hardly change below
INDEX2 = 1.5**2  # of refraction, of the cover of a diode
# Of the work of one hit: derivatives by the diode's place in the board's frame, by the master's
# coordinates, by depth and by the intrinsics; the diode from the station; rotation vector and the
# functions of its length; the diode under its cover, the sign of the shift and the factor of t
PLACE, ALL, DEPTH, BY, FAR, TURN, UNDER, SIDE, LEAN = 0, 3, 6, 7, 13, 16, 22, 25, 26
ROOM = 27


Rows = tuple[np.ndarray, int, int, int]


class Light(NamedTuple):
    """What the kernels need of hits (n,): station, axis, diode and first control point (n, 4);
    weights of four control points (n, 4); reference rotation (n, 3, 3)."""

    who: np.ndarray
    basis: np.ndarray
    turned: np.ndarray


class Equations(NamedTuple):
    """Normal equations of K control points and G other unknowns: lower diagonals (SPAN, 6 K);
    (6 K, G); (G, G); gradients (6 K,) and (G,). The first two are in column order, in which LAPACK
    works and sums over neighbours are contiguous."""

    band: np.ndarray
    cross: np.ndarray
    inner: np.ndarray
    g: np.ndarray
    g_inner: np.ndarray

    @classmethod
    def zeros(cls, K: int, G: int) -> Equations:
        """Empty equations of K coordinates of control points and G global unknowns."""
        shapes = (SPAN, K), (K, G), (G, G), (K,), (G,)
        return cls(*(np.zeros(shape, order="F") for shape in shapes))


class Values(NamedTuple):
    """Values of all unknowns but the trajectory.

    R (stations, 3, 3), t_m (stations, 3): into the master's frame; rotors (stations, 2, 13) as
    `rotor_parameters`; offsets (stations, 2) in rad; board (n, 3) in m; gravity (3,) in m/s^2, of
    the master's frame; values (unknowns,): steps from where the priors are centred; normals (n, 3)
    of the diodes, (0, 3) where no cover is taken into account; cover (2,): a and t in m.
    """

    R: np.ndarray
    t_m: np.ndarray
    rotors: np.ndarray
    offsets: np.ndarray
    board: np.ndarray
    gravity: np.ndarray
    values: np.ndarray
    normals: np.ndarray
    cover: np.ndarray


@njit(inline="always")
def of_turn(a2: float) -> tuple[float, float, float]:
    """sin(a) / a, (1 - cos a) / a^2 and (a - sin a) / a^3 of the square of an angle."""
    if a2 < 1e-8:
        return 1 - a2 / 6, 0.5 - a2 / 24, 1 / 6 - a2 / 120
    a = math.sqrt(a2)
    sine = math.sin(a)
    return sine / a, (1 - math.cos(a)) / a2, (a - sine) / (a2 * a)


@njit(inline="always")
def rotated(
    v0: float, v1: float, v2: float, s: float, c: float, q0: float, q1: float, q2: float
) -> tuple[float, float, float]:
    """Exp(v) q (Rodrigues); s, c: the first of `of_turn`."""
    k0, k1, k2 = v1 * q2 - v2 * q1, v2 * q0 - v0 * q2, v0 * q1 - v1 * q0
    return (
        q0 + s * k0 + c * (v1 * k2 - v2 * k1),
        q1 + s * k1 + c * (v2 * k0 - v0 * k2),
        q2 + s * k2 + c * (v0 * k1 - v1 * k0),
    )


def right_jacobians(v: np.ndarray) -> Floats:
    """J (n, 3, 3) with Exp(v + d) = Exp(v) Exp(J d) to first order in d, of vectors (n, 3):
    1 - (1 - cos a) / a^2 [v] + (a - sin a) / a^3 [v]^2, for a the length of v."""
    X: Floats = cross(v)
    a = np.maximum(np.linalg.norm(v, axis=1), SMALL_RAD)[:, None, None]
    return np.eye(3) - (1 - np.cos(a)) / a**2 * X + (a - np.sin(a)) / a**3 * (X @ X)


@njit(inline="always")
def _angle(
    h: int, seen: Light, control: np.ndarray, of: Values, work: np.ndarray, by: np.ndarray
) -> float:
    """Predicted angle, and the part of the work that it needs; by: room for derivatives by the
    intrinsics, or empty."""
    basis, F, R, t, board, normals = seen.basis, seen.turned, of.R, of.t_m, of.board, of.normals
    s, axis, d, k = seen.who[h, 0], seen.who[h, 1], seen.who[h, 2], seen.who[h, 3]
    p0 = p1 = p2 = v0 = v1 = v2 = 0.0
    for i in range(4):
        b = basis[h, i]
        p0 += b * control[k + i, 0]
        p1 += b * control[k + i, 1]
        p2 += b * control[k + i, 2]
        v0 += b * control[k + i, 3]
        v1 += b * control[k + i, 4]
        v2 += b * control[k + i, 5]
    sine, cosine, third = of_turn(v0 * v0 + v1 * v1 + v2 * v2)
    q0, q1, q2 = board[d, 0], board[d, 1], board[d, 2]
    a0, a1, a2 = rotated(v0, v1, v2, sine, cosine, q0, q1, q2)
    f0 = p0 - t[s, 0] + F[h, 0, 0] * a0 + F[h, 0, 1] * a1 + F[h, 0, 2] * a2
    f1 = p1 - t[s, 1] + F[h, 1, 0] * a0 + F[h, 1, 1] * a1 + F[h, 1, 2] * a2
    f2 = p2 - t[s, 2] + F[h, 2, 0] * a0 + F[h, 2, 1] * a1 + F[h, 2, 2] * a2
    if normals.shape[0] > 0:
        n0, n1, n2 = normals[d, 0], normals[d, 1], normals[d, 2]
        a0, a1, a2 = rotated(v0, v1, v2, sine, cosine, n0, n1, n2)
        m0 = F[h, 0, 0] * a0 + F[h, 0, 1] * a1 + F[h, 0, 2] * a2
        m1 = F[h, 1, 0] * a0 + F[h, 1, 1] * a1 + F[h, 1, 2] * a2
        m2 = F[h, 2, 0] * a0 + F[h, 2, 1] * a1 + F[h, 2, 2] * a2
        along = -(m0 * f0 + m1 * f1 + m2 * f2) / math.sqrt(f0 * f0 + f1 * f1 + f2 * f2)
        side = 1.0 if along > 0.0 else -1.0  # that of a flat board which the light comes from
        along = min(side * along, 1.0)
        lean = 1.0 - along / math.sqrt(INDEX2 - 1.0 + along * along)
        shift = side * (of.cover[0] + of.cover[1] * lean)
        f0, f1, f2 = f0 + shift * m0, f1 + shift * m1, f2 + shift * m2
        q0, q1, q2 = q0 + shift * n0, q1 + shift * n1, q2 + shift * n2
        work[SIDE], work[LEAN] = side, lean
    x = R[s, 0, 0] * f0 + R[s, 1, 0] * f1 + R[s, 2, 0] * f2
    y = R[s, 0, 1] * f0 + R[s, 1, 1] * f1 + R[s, 2, 1] * f2
    z = R[s, 0, 2] * f0 + R[s, 1, 2] * f1 + R[s, 2, 2] * f2
    theta, gx, gy, gz = angle_gradient(axis, x, y, z, of.rotors[s, axis], by)
    for i in range(3):
        work[ALL + i] = R[s, i, 0] * gx + R[s, i, 1] * gy + R[s, i, 2] * gz
    work[DEPTH] = gx
    work[FAR], work[FAR + 1], work[FAR + 2] = f0, f1, f2
    work[TURN], work[TURN + 1], work[TURN + 2] = v0, v1, v2
    work[TURN + 3], work[TURN + 4], work[TURN + 5] = sine, cosine, third
    work[UNDER], work[UNDER + 1], work[UNDER + 2] = q0, q1, q2
    return theta


@njit(inline="always")
def _by_pose(h: int, seen: Light, work: np.ndarray, row: np.ndarray) -> None:
    """Derivative by the board's pose at the time of a hit, row (6,), and by the diode's place. With
    m = q x e, that by the rotation vector v is (1 - c |v|^2) m + c (m v) v + b v x m, b and c the
    last of `of_turn`."""
    F, D0, D1, D2 = seen.turned, work[ALL], work[ALL + 1], work[ALL + 2]
    a0 = F[h, 0, 0] * D0 + F[h, 1, 0] * D1 + F[h, 2, 0] * D2
    a1 = F[h, 0, 1] * D0 + F[h, 1, 1] * D1 + F[h, 2, 1] * D2
    a2 = F[h, 0, 2] * D0 + F[h, 1, 2] * D1 + F[h, 2, 2] * D2
    v0, v1, v2 = work[TURN], work[TURN + 1], work[TURN + 2]
    s, b, c = work[TURN + 3], work[TURN + 4], work[TURN + 5]
    e0, e1, e2 = rotated(-v0, -v1, -v2, s, b, a0, a1, a2)
    q0, q1, q2 = work[UNDER], work[UNDER + 1], work[UNDER + 2]
    m0, m1, m2 = q1 * e2 - q2 * e1, q2 * e0 - q0 * e2, q0 * e1 - q1 * e0
    whole = 1 - c * (v0 * v0 + v1 * v1 + v2 * v2)
    along = c * (m0 * v0 + m1 * v1 + m2 * v2)
    row[0], row[1], row[2] = D0, D1, D2
    row[3] = whole * m0 + along * v0 + b * (v1 * m2 - v2 * m1)
    row[4] = whole * m1 + along * v1 + b * (v2 * m0 - v0 * m2)
    row[5] = whole * m2 + along * v2 + b * (v0 * m1 - v1 * m0)
    work[PLACE], work[PLACE + 1], work[PLACE + 2] = e0, e1, e2


@njit(inline="always")
def _globals(
    h: int, seen: Light, of: Values, rows: Rows, work: np.ndarray, at: np.ndarray, value: np.ndarray
) -> int:
    """Which global unknowns but its diode's place the angle depends on, and its derivatives, from
    `NEAR` on; returns where they end. Of all hits of a station and axis they are the same.

    rows: columns (stations, 2, 9), first column of the station's pose, of its laser depth, then of
    each axis' offset, tilt, curve and both parts of gibbous, and of ogee; that of the scale, of the
    diodes' places and of the cover; -1 where known.
    """
    columns, scale, _, cover = rows
    board, normals, n = of.board, of.normals, NEAR
    s, axis, d = seen.who[h, 0], seen.who[h, 1], seen.who[h, 2]
    first = columns[s, axis, 0]
    if first >= 0:
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            turn = work[ALL + j] * work[FAR + k] - work[ALL + k] * work[FAR + j]
            at[n], value[n] = first + i, -work[ALL + i]
            at[n + 3], value[n + 3] = first + 3 + i, turn
            n += 1
        n += 3
    if columns[s, axis, 1] >= 0:
        at[n], value[n] = columns[s, axis, 1], (0.5 if axis == 1 else -0.5) * work[DEPTH]
        n += 1
    if columns[s, axis, 2] >= 0:
        at[n], value[n] = columns[s, axis, 2], 1.0
        n += 1
    if columns[s, axis, 3] >= 0:
        for i in range(6 if of.rotors[s, axis, GENERATION] == 2.0 else 4):
            at[n], value[n] = columns[s, axis, 3 + i], work[BY + i]
            n += 1
    if scale >= 0:
        at[n], value[n] = scale, 0.0
        for i in range(3):
            value[n] += work[PLACE + i] * board[d, i]
        n += 1
    if cover >= 0:
        across = 0.0
        for i in range(3):
            across += work[SIDE] * work[PLACE + i] * normals[d, i]
        at[n], value[n] = cover, across
        at[n + 1], value[n + 1] = cover + 1, across * (work[LEAN] - HELD)
        n += 2
    return n


@njit
def predicted(seen: Light, control: np.ndarray, of: Values) -> np.ndarray:
    """Angle (rad) that the model gives for each hit, the offset of its rotor included."""
    work, out, none = np.empty(ROOM), np.empty(seen.who.shape[0]), np.empty(0)
    for h in range(out.size):
        theta = _angle(h, seen, control, of, work, none)
        out[h] = theta + of.offsets[seen.who[h, 0], seen.who[h, 1]]
    return out


@njit
def accumulate(
    seen: Light,
    first: np.ndarray,
    residual: np.ndarray,
    weight: np.ndarray,
    control: np.ndarray,
    of: Values,
    rows: Rows,
    total: Equations,
    sums: np.ndarray,
    sums_inner: np.ndarray,
) -> None:
    """Add up w J J^T and w J e over the hits, with V = I.

    first (sweeps + 1,): hits of each sweep; rows: as of `_globals`; of each sweep sum(w J) in sums
    (sweeps, SPAN), from the first control point of its first hit on, and sums_inner (sweeps, G).
    All are zero before. Hits of a sweep in one interval share their unknowns: w z z^T of z = (J, e,
    1) is summed up in one small matrix first, which fits in the cache.
    """
    who, basis, places = seen.who, seen.basis, rows[2]
    row, work, z = np.empty(POSE), np.empty(ROOM), np.empty(MOST)
    by, none, at = work[BY : BY + 6], work[:0], np.empty(MOST, np.int64)
    M = np.zeros((MOST, MOST))
    for m in range(first.size - 1):
        begin, end = who[first[m], 3], first[m + 1]
        for h in range(first[m], end):
            begin = min(begin, who[h, 3])
        wants = rows[0][who[first[m], 0], who[first[m], 1], 3] >= 0
        for h in range(first[m], end):
            k, w = who[h, 3], weight[h]
            _angle(h, seen, control, of, work, by if wants else none)
            _by_pose(h, seen, work, row)
            n = _globals(h, seen, of, rows, work, at, z)
            z[n], z[n + 1] = residual[h], 1.0
            for i in range(4):
                for a in range(POSE):
                    z[POSE * i + a] = basis[h, i] * row[a]
            for i in range(n + 2):
                x = w * z[i]
                for j in range(i + 1):
                    M[i, j] += x * z[j]
            if places >= 0:
                column = places + 3 * who[h, 2]
                _add_place(column, POSE * k, w, n, at, z, work, total)
                for i in range(3):
                    sums_inner[m, column + i] += w * work[PLACE + i]
            if h + 1 == end or who[h + 1, 3] != k:
                _add(POSE * k, n, at, M, total)
                for i in range(NEAR):
                    sums[m, POSE * (k - begin) + i] += M[n + 1, i]
                for i in range(NEAR, n):
                    sums_inner[m, at[i]] += M[n + 1, i]
                M[: n + 2] = 0.0
    inner = total.inner
    for i in range(len(inner)):  # what is on one side of the diagonal alone
        for j in range(i):
            inner[i, j] = inner[j, i] = inner[i, j] + inner[j, i]


@njit
def _add(k: int, n: int, at: np.ndarray, M: np.ndarray, total: Equations) -> None:
    """Add the sums over some hits to those of all; k: first row of their control points."""
    band, cross, inner, g, g_inner = total
    for j in range(NEAR):  # of slices the processor adds several numbers at once
        column, part = band[: NEAR - j, k + j], M[j:NEAR, j]
        for i in range(column.size):
            column[i] += part[i]
        g[k + j] += M[n, j]
    for i in range(NEAR, n):
        column, part = cross[k : k + NEAR, at[i]], M[i, :NEAR]
        for j in range(column.size):
            column[j] += part[j]
        for j in range(NEAR, i + 1):
            inner[at[i], at[j]] += M[i, j]
        g_inner[at[i]] += M[n, i]


@njit
def _add_place(
    column: int,
    k: int,
    w: float,
    n: int,
    at: np.ndarray,
    z: np.ndarray,
    work: np.ndarray,
    total: Equations,
) -> None:
    """Add what a hit says about its diode's place, from `column` on."""
    _, cross, inner, _, g_inner = total
    for i in range(3):
        x = w * work[PLACE + i]
        along = cross[k : k + NEAR, column + i]
        for j in range(along.size):
            along[j] += x * z[j]
        for j in range(NEAR, n):
            inner[column + i, at[j]] += x * z[j]
        for j in range(i + 1):
            inner[column + i, column + j] += x * work[PLACE + j]
        g_inner[column + i] += x * z[n]
