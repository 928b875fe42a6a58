"""Board poses from ranges by root finding, the geometric method that J V-A weighs.

Islam et al. 2016 and Kleinschmidt et al. 2017: both lasers are assumed in the station's middle, so
the angles of diode i give its direction d_i, |d_i| = 1, and its range r_i is unknown. For each pair
of diodes at the known distance D_ij the law of cosines gives

    r_i^2 + r_j^2 - 2 r_i r_j cos(d_i, d_j) = D_ij^2,

solved for the ranges by Newton's method. Then r_i d_i are the diodes' places and Kabsch's algorithm
gives the board's pose. Here all pairs are used at once, in least squares (Gauss-Newton, damped), as
32 diodes give 496 equations for 32 ranges. A flat board fits nearly as well mirrored at the line of
sight, so both are tried and the pose that fits the angles better is chosen.
"""

from __future__ import annotations

import math

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.common.linear import solve
from mocap_metrology.lighthouse.board import FEWEST_DIODES
from mocap_metrology.lighthouse.calibrate.pnp import angle_cost
from mocap_metrology.lighthouse.calibrate.superpose import kabsch

ITERATIONS = 50  # at most
CONVERGED = 1e-10  # largest step of a range over the range
LEAST_PIVOT = 1e-30  # m^2: of equations that are all zero
LARGEST_COST = 1.0  # rad^2: such a root is no pose


def board_poses(
    directions: np.ndarray, board: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pose of the board in the station's frame for each of n measurements.

    directions (n, d, 2): ideal azimuth and elevation in rad, NaN where unseen; board (d, 3) in m.
    Returns R (n, 3, 3), t (n, 3) in m, and cost (n,), the sum of squared angle errors in rad^2; NaN
    where fewer than four diodes are seen or no root is found.
    """
    n = len(directions)
    R, t, cost = np.full((n, 3, 3), np.nan), np.full((n, 3), np.nan), np.full(n, np.nan)
    squared = ((board[:, None] - board[None]) ** 2).sum(axis=-1)
    for i, measured in enumerate(np.asarray(directions, dtype=np.float64)):
        seen = np.isfinite(measured).all(axis=1)
        if seen.sum() < FEWEST_DIODES:
            continue
        rays = np.column_stack([np.ones(seen.sum()), np.tan(measured[seen])])
        rays /= np.linalg.norm(rays, axis=1, keepdims=True)
        own, wanted = board[seen], np.ascontiguousarray(squared[np.ix_(seen, seen)])
        for start in first_ranges(rays, own):
            ranges = solve_ranges(rays, wanted, start)
            if not (ranges > 0).all():
                continue
            Ri, ti = kabsch(own, ranges[:, None] * rays)
            ci = angle_cost(Ri, ti, measured[seen], own)
            if ci < LARGEST_COST and not ci >= cost[i]:
                R[i], t[i], cost[i] = Ri, ti, ci
    return R, t, cost


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
    k = rays.shape[0]
    c = rays @ rays.T
    r, damping = start.copy(), 1e-3
    H, g = np.empty((k, k)), np.empty(k)
    f = _normal_equations(r, c, squared, H, g)
    H2, g2 = np.empty((k, k)), np.empty(k)
    for _ in range(ITERATIONS):
        step = _step(H, g, damping)
        f2 = _normal_equations(r + step, c, squared, H2, g2)
        small = np.abs(step).max() < CONVERGED * np.abs(r).max()
        if f2 <= f:
            small = small or f - f2 <= 1e-12 * f
            r, f = r + step, f2
            H, H2 = H2, H
            g, g2 = g2, g
            damping *= 0.1
        else:
            damping = max(10.0 * damping, 1e-8)
        if small or damping > 1e8:
            break
    return r


@njit
def _normal_equations(
    r: np.ndarray, c: np.ndarray, squared: np.ndarray, H: np.ndarray, g: np.ndarray
) -> float:
    """H = J^T J and g = J^T f of all pairs, written in place; returns the sum of squares, m^4."""
    H[:], g[:] = 0.0, 0.0
    total = 0.0
    for i in range(r.size):
        for j in range(i):
            # |r_i d_i - r_j d_j|^2 without the loss of digits of r_i^2 + r_j^2 - ...
            f = (r[i] - r[j]) ** 2 + 2.0 * r[i] * r[j] * (1.0 - c[i, j]) - squared[i, j]
            a, b = 2.0 * (r[i] - r[j] * c[i, j]), 2.0 * (r[j] - r[i] * c[i, j])
            H[i, i] += a * a
            H[j, j] += b * b
            H[i, j] += a * b
            g[i] += a * f
            g[j] += b * f
            total += f * f
    return total


@njit
def _step(H: np.ndarray, g: np.ndarray, damping: float) -> np.ndarray:
    """-(H + damping diag H)^-1 g; only the lower half of H is read."""
    damped, x = H.copy(), -g
    trace = 0.0
    for i in range(g.size):
        trace += H[i, i]
    for i in range(g.size):
        damped[i, i] = H[i, i] * (1.0 + damping) + 1e-14 * trace
    solve(damped, x, LEAST_PIVOT, 0.0, LEAST_PIVOT)
    return x
