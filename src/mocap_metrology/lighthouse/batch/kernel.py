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
from mocap_metrology.lighthouse.rotor import GENERATION, angle_gradient

POSE = 6  # unknowns of a control point, and of a station: position, rotation vector
SPAN = 5 * POSE  # of a sweep: the control points of two neighbouring intervals
LOCAL = 28  # most global unknowns of one hit
ROOM = 45  # of the work of one hit
HELD = 0.5  # of the factor of t: where the places of a board's file hold
INDEX2 = 1.5**2  # of refraction, of the cover of a diode


Rows = tuple[np.ndarray, int, int, int]


class Light(NamedTuple):
    """What the kernels need of hits (n,): station, axis, diode and first control point (n, 4);
    weights of four control points (n, 4); reference rotation (n, 3, 3)."""

    who: np.ndarray
    basis: np.ndarray
    turned: np.ndarray


class Equations(NamedTuple):
    """Normal equations of K control points and G other unknowns: lower diagonals (SPAN, 6 K);
    (6 K, G); (G, G); gradients (6 K,) and (G,)."""

    band: np.ndarray
    cross: np.ndarray
    inner: np.ndarray
    g: np.ndarray
    g_inner: np.ndarray

    @classmethod
    def zeros(cls, K: int, G: int) -> Equations:
        """Empty equations of K coordinates of control points and G global unknowns."""
        shapes = (SPAN, K), (K, G), (G, G), (K,), (G,)
        return cls(*(np.zeros(shape) for shape in shapes))


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
def right_jacobian(v: np.ndarray, J: np.ndarray) -> None:
    """J with Exp(v + d) = Exp(v) Exp(J d) to first order in d."""
    a2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2]
    if a2 < 1e-8:
        b, c = 0.5 - a2 / 24, 1 / 6 - a2 / 120
    else:
        a = math.sqrt(a2)
        b, c = (1 - math.cos(a)) / a2, (a - math.sin(a)) / (a2 * a)
    for i in range(3):
        for j in range(3):
            J[i, j] = c * v[i] * v[j]
        J[i, i] += 1 - c * a2
    J[0, 1] += b * v[2]
    J[0, 2] -= b * v[1]
    J[1, 0] -= b * v[2]
    J[1, 2] += b * v[0]
    J[2, 0] += b * v[1]
    J[2, 1] -= b * v[0]


@njit
def right_jacobians(v: np.ndarray) -> np.ndarray:
    """Those of rotation vectors (n, 3), (n, 3, 3)."""
    out = np.empty((len(v), 3, 3))
    for m in range(len(v)):
        right_jacobian(v[m], out[m])
    return out


@njit(inline="always")
def rotated(v: np.ndarray, q: np.ndarray, out: np.ndarray) -> None:
    """out = Exp(v) q (Rodrigues)."""
    a2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2]
    if a2 < 1e-8:
        s, c = 1 - a2 / 6, 0.5 - a2 / 24
    else:
        a = math.sqrt(a2)
        s, c = math.sin(a) / a, (1 - math.cos(a)) / a2
    k0, k1, k2 = v[1] * q[2] - v[2] * q[1], v[2] * q[0] - v[0] * q[2], v[0] * q[1] - v[1] * q[0]
    out[0] = q[0] + s * k0 + c * (v[1] * k2 - v[2] * k1)
    out[1] = q[1] + s * k1 + c * (v[2] * k0 - v[0] * k2)
    out[2] = q[2] + s * k2 + c * (v[0] * k1 - v[1] * k0)


@njit(inline="always")
def _hit(
    h: int, seen: Light, control: np.ndarray, of: Values, row: np.ndarray, work: np.ndarray, at: int
) -> float:
    """Predicted angle; derivative by the board's pose at the time, in row[:6]; work[3:6] is that
    by the diode's place, work[6:9] by the master's coordinates, work[9:12] the diode from the
    station, work[12:15] in the station's frame, work[30:36] those by the intrinsics if `at` is no
    less than 0, work[36] the factor of t, work[37:43] the normal in the master's frame and the
    diode under its cover, work[43] the sign of the shift, work[44] the derivative by depth."""
    who, basis, normals, cover = seen.who, seen.basis, of.normals, of.cover
    t, rotors = of.t_m, of.rotors
    s, axis, d, k = who[h, 0], who[h, 1], who[h, 2], who[h, 3]
    p0 = p1 = p2 = 0.0
    v = work[15:18]
    v[:] = 0.0
    for i in range(4):
        b, c = basis[h, i], control[k + i]
        p0 += b * c[0]
        p1 += b * c[1]
        p2 += b * c[2]
        v[0] += b * c[3]
        v[1] += b * c[4]
        v[2] += b * c[5]
    q, a, F, S = of.board[d], work[0:3], seen.turned[h], of.R[s]
    rotated(v, q, a)
    far, x = work[9:12], work[12:15]
    far[0] = p0 - t[s, 0] + F[0, 0] * a[0] + F[0, 1] * a[1] + F[0, 2] * a[2]
    far[1] = p1 - t[s, 1] + F[1, 0] * a[0] + F[1, 1] * a[1] + F[1, 2] * a[2]
    far[2] = p2 - t[s, 2] + F[2, 0] * a[0] + F[2, 1] * a[1] + F[2, 2] * a[2]
    if normals.shape[0] > 0:
        m, under = work[37:40], work[40:43]
        rotated(v, normals[d], a)
        along = 0.0
        for i in range(3):
            m[i] = F[i, 0] * a[0] + F[i, 1] * a[1] + F[i, 2] * a[2]
            along -= m[i] * far[i]
        along /= math.sqrt(far[0] * far[0] + far[1] * far[1] + far[2] * far[2])
        side = 1.0 if along > 0.0 else -1.0  # that of a flat board which the light comes from
        along = min(side * along, 1.0)
        work[36], work[43] = 1.0 - along / math.sqrt(INDEX2 - 1.0 + along * along), side
        shift = side * (cover[0] + cover[1] * work[36])
        for i in range(3):
            far[i] += shift * m[i]
            under[i] = q[i] + shift * normals[d, i]
        q = under
    for i in range(3):
        x[i] = S[0, i] * far[0] + S[1, i] * far[1] + S[2, i] * far[2]
    by = work[30:36] if at >= 0 else work[:0]
    theta, gx, gy, gz = angle_gradient(axis, x[0], x[1], x[2], rotors[s, axis], by)
    work[44] = gx
    D, e = work[6:9], work[3:6]
    for i in range(3):
        D[i] = S[i, 0] * gx + S[i, 1] * gy + S[i, 2] * gz
        row[i] = D[i]
    for i in range(3):
        a[i] = F[0, i] * D[0] + F[1, i] * D[1] + F[2, i] * D[2]
    work[18], work[19], work[20] = -v[0], -v[1], -v[2]
    rotated(work[18:21], a, e)
    J = work[21:30].reshape(3, 3)
    right_jacobian(v, J)
    m0, m1, m2 = q[1] * e[2] - q[2] * e[1], q[2] * e[0] - q[0] * e[2], q[0] * e[1] - q[1] * e[0]
    for i in range(3):
        row[3 + i] = m0 * J[0, i] + m1 * J[1, i] + m2 * J[2, i]
    return theta


@njit(inline="always")
def _globals(
    h: int, seen: Light, of: Values, rows: Rows, work: np.ndarray, at: np.ndarray, value: np.ndarray
) -> int:
    """Which global unknowns the angle depends on, and its derivatives; returns how many.

    rows: columns (stations, 2, 9), first column of the station's pose, of its laser depth, then of
    each axis' offset, tilt, curve and both parts of gibbous, and of ogee; that of the scale, of the
    diodes' places and of the cover; -1 where known.
    """
    columns, scale, places, cover = rows
    board, normals = of.board, of.normals
    s, axis, d = seen.who[h, 0], seen.who[h, 1], seen.who[h, 2]
    column, D, far, e, n = columns[s, axis], work[6:9], work[9:12], work[3:6], 0
    if column[0] >= 0:
        for i in range(3):
            at[n], value[n] = column[0] + i, -D[i]
            j, k = (i + 1) % 3, (i + 2) % 3
            at[n + 3], value[n + 3] = column[0] + 3 + i, D[j] * far[k] - D[k] * far[j]
            n += 1
        n += 3
    if column[1] >= 0:
        at[n], value[n] = column[1], (0.5 if axis == 1 else -0.5) * work[44]
        n += 1
    if column[2] >= 0:
        at[n], value[n] = column[2], 1.0
        n += 1
    if column[3] >= 0:
        for i in range(6 if of.rotors[s, axis, GENERATION] == 2.0 else 4):
            at[n], value[n] = column[3 + i], work[30 + i]
            n += 1
    if scale >= 0:
        at[n] = scale
        value[n] = e[0] * board[d, 0] + e[1] * board[d, 1] + e[2] * board[d, 2]
        n += 1
    if places >= 0:
        for i in range(3):
            at[n], value[n] = places + 3 * d + i, e[i]
            n += 1
    if cover >= 0:
        across = e[0] * normals[d, 0] + e[1] * normals[d, 1] + e[2] * normals[d, 2]
        across *= work[43]
        at[n], value[n] = cover, across
        at[n + 1], value[n + 1] = cover + 1, across * (work[36] - HELD)
        n += 2
    return n


@njit
def predicted(seen: Light, control: np.ndarray, of: Values) -> np.ndarray:
    """Angle (rad) that the model gives for each hit, the offset of its rotor included."""
    row, work, out = np.empty(POSE), np.empty(ROOM), np.empty(seen.who.shape[0])
    for h in range(out.size):
        theta = _hit(h, seen, control, of, row, work, -1)
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
    All are zero before.
    """
    who, basis, inner, g_inner = seen.who, seen.basis, total.inner, total.g_inner
    row, work = np.empty(POSE), np.empty(ROOM)
    at, value = np.empty(LOCAL, np.int64), np.empty(LOCAL)
    block = np.zeros((4 * POSE, 4 * POSE)), np.zeros((4 * POSE, g_inner.size)), np.zeros(4 * POSE)
    wide = np.empty(4 * POSE)
    at_knot = -1
    for m in range(first.size - 1):
        begin = who[first[m], 3]
        for h in range(first[m], first[m + 1]):
            begin = min(begin, who[h, 3])
        for h in range(first[m], first[m + 1]):
            k = who[h, 3]
            if k != at_knot:
                _flush(at_knot, block, total)
                at_knot = k
            _hit(h, seen, control, of, row, work, rows[0][who[h, 0], who[h, 1], 3])
            n = _globals(h, seen, of, rows, work, at, value)
            w = weight[h]
            we, shift = w * residual[h], POSE * (k - begin)
            for i in range(4):
                for a in range(POSE):
                    wide[POSE * i + a] = basis[h, i] * row[a]
            for i in range(4 * POSE):
                wx = w * wide[i]
                sums[m, shift + i] += wx
                block[2][i] += we * wide[i]
                for j in range(i + 1):
                    block[0][i, j] += wx * wide[j]
                for j in range(n):
                    block[1][i, at[j]] += wx * value[j]
            for i in range(n):
                sums_inner[m, at[i]] += w * value[i]
                g_inner[at[i]] += we * value[i]
                for j in range(n):
                    inner[at[i], at[j]] += w * value[i] * value[j]
    _flush(at_knot, block, total)


@njit
def _flush(knot: int, block: tuple[np.ndarray, np.ndarray, np.ndarray], total: Equations) -> None:
    """Move the sums over hits of one interval, which fit in the cache, to those of all."""
    if knot < 0:
        return
    of, band, cross, g = POSE * knot, total.band, total.cross, total.g
    for i in range(4 * POSE):
        for j in range(i + 1):
            band[i - j, of + j] += block[0][i, j]
        for j in range(cross.shape[1]):
            cross[of + i, j] += block[1][i, j]
        g[of + i] += block[2][i]
    block[0][:], block[1][:], block[2][:] = 0.0, 0.0, 0.0
