"""Hits as a trajectory sees them: residuals, and what each hit counts for; kernels of whole sweeps,
and covariances out of the factor of a banded matrix.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.lighthouse.batch import kernel
from mocap_metrology.lighthouse.batch.kernel import POSE, SPAN, Equations
from mocap_metrology.lighthouse.batch.problem import State, Sweeps
from mocap_metrology.lighthouse.batch.trajectory import Trajectory

LIMIT = 3.5  # of |z|, beyond which a hit loses weight: of good hits 1 in 2000
LEAST_RAD = 1e-6  # noise of a hit, at least; rounding to ticks of 48 MHz alone is 2.3 urad


@njit
def without_offsets(
    begin: np.ndarray,
    factor: np.ndarray,
    sums: np.ndarray,
    sums_inner: np.ndarray,
    sum_residual: np.ndarray,
    of_all: Equations,
) -> None:
    """Subtract from the sums what the offset of each sweep can explain: factor (sweeps,) times the
    outer products of its sums; begin (sweeps,): its first control point."""
    band, cross, inner, g, g_inner = of_all
    G = g_inner.size
    used = np.empty(G, np.int64)  # those that a sweep depends on
    for m in range(begin.size):
        f, of = factor[m], POSE * begin[m]
        if f == 0.0:
            continue
        n = 0
        for j in range(G):
            if sums_inner[m, j] != 0.0:
                used[n] = j
                n += 1
        near = sums[m, : min(SPAN, g.size - of)]
        for i in range(near.size):  # of slices the processor subtracts several numbers at once
            column, part, x = band[: near.size - i, of + i], near[i:], f * near[i]
            for j in range(column.size):
                column[j] -= x * part[j]
            g[of + i] -= x * sum_residual[m]
        for k in range(n):
            i = used[k]
            x = f * sums_inner[m, i]
            column = cross[of : of + near.size, i]
            for j in range(column.size):
                column[j] -= x * near[j]
            for j in range(n):
                inner[i, used[j]] -= x * sums_inner[m, used[j]]
            g_inner[i] -= x * sum_residual[m]


class Noise(NamedTuple):
    """Standard deviations in rad: of a hit alone, and of the offset that a sweep's hits share."""

    hit: float
    sweep: float


class Weights(NamedTuple):
    """Weight of each hit; offset in rad, the weight of what is known of it, and robust cost of
    each sweep."""

    hit: np.ndarray
    offset: np.ndarray
    held: np.ndarray
    cost: np.ndarray


@njit
def _robust(first: np.ndarray, residual: np.ndarray, noise: Noise, share: np.ndarray) -> Weights:
    sigma, common = noise
    n = first.size - 1
    robust = Weights(np.empty(residual.size), np.empty(n), np.empty(n), np.empty(n))
    weight = robust.hit
    for m in range(n):
        low, high = first[m], first[m + 1]
        b, v = 0.0, 1.0
        if common > 0:
            b = float(np.median(residual[low:high]))
            v = _weight(b / common)
            b /= 1 + v * (sigma / common) ** 2 / np.sum(share[low:high])
        for _ in range(4 if common > 0 else 1):
            v = _weight(b / common) if common > 0 else 1.0
            up, down = 0.0, v * (sigma / common) ** 2 if common > 0 else 1.0
            for h in range(low, high):
                weight[h] = share[h] * _weight((residual[h] - b) / sigma)
                up += weight[h] * residual[h]
                down += weight[h]
            if common > 0:
                b = up / down
        robust.offset[m], robust.held[m] = b, v
        total = _loss(b / common) if common > 0 else 0.0
        for h in range(low, high):
            total += share[h] * _loss((residual[h] - b) / sigma)
        robust.cost[m] = total
    return robust


@njit(inline="always")
def _weight(z: float) -> float:
    return 1.0 if abs(z) <= LIMIT else (LIMIT / z) ** 2


@njit(inline="always")
def _loss(z: float) -> float:
    z = abs(z)
    return z * z if z <= LIMIT else LIMIT * LIMIT * (1 + 2 * math.log(z / LIMIT))


@njit
def selected_inverse(L: np.ndarray) -> np.ndarray:
    """The band of A^-1 from that of the Cholesky factor of A (Takahashi, Fagan & Chin 1973).

    L (w + 1, n): lower diagonals, L[d, j] = L_{j+d, j}; returned likewise. With A^-1 = Z,
    Z_ij = (delta_ij / L_jj - sum_{k > j} L_kj Z_ik) / L_jj for i >= j, columns from the last on.
    """
    w, n = L.shape[0] - 1, L.shape[1]
    Z = np.zeros_like(L)
    for j in range(n - 1, -1, -1):
        most = min(w, n - 1 - j)
        for d in range(most, -1, -1):
            i, total = j + d, 1.0 / L[0, j] if d == 0 else 0.0
            for e in range(1, most + 1):
                k = j + e
                total -= L[e, j] * Z[abs(i - k), min(i, k)]
            Z[d, j] = total / L[0, j]
    return Z


@njit
def pose_blocks(Z: np.ndarray, first: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Blocks (n, 6, 6) of the covariance of sum_i weights_i x_{first + i}."""
    out = np.zeros((first.size, POSE, POSE))
    for m in range(first.size):
        for i in range(4):
            for j in range(4):
                w = weights[m, i] * weights[m, j]
                for a in range(POSE):
                    for b in range(POSE):
                        r, c = POSE * (first[m] + i) + a, POSE * (first[m] + j) + b
                        out[m, a, b] += w * Z[abs(r - c), min(r, c)]
    return out


@dataclass(frozen=True)
class View:
    """Hits with what the trajectory's knots fix about them: first control point and weights of
    each, and the reference rotation at its time."""

    sweeps: Sweeps
    who: np.ndarray
    basis: np.ndarray
    turned: np.ndarray

    @property
    def light(self) -> kernel.Light:
        return kernel.Light(self.who, self.basis, self.turned)

    @property
    def begin(self) -> np.ndarray:
        """First control point of each sweep."""
        return np.minimum.reduceat(self.who[:, 3], self.sweeps.first[:-1])


def sweeps_of(seen: View, chosen: np.ndarray) -> View:
    """The hits of chosen sweeps, a mask of all sweeps."""
    hit = chosen[seen.sweeps.sweep]
    first = np.append(0, np.cumsum(np.diff(seen.sweeps.first)[chosen]))
    part = Sweeps(seen.sweeps.hits.take(hit), first)
    return View(part, seen.who[hit], seen.basis[hit], seen.turned[hit])


def stretch(seen: View, trajectory: Trajectory) -> tuple[View, Trajectory]:
    """Likewise through the control points alone that the hits touch: the others go straight on at
    no cost."""
    low, high = seen.who[:, 3].min(), seen.who[:, 3].max() + 4
    part = replace(trajectory, control=trajectory.control[low:high])
    return replace(seen, who=seen.who - np.array([0, 0, 0, low])), part


def view(sweeps: Sweeps, trajectory: Trajectory) -> View:
    """Hits with the basis functions and reference rotations of the path at their times."""
    hits = sweeps.hits
    first, basis = trajectory.basis(hits.time_s)
    who = np.column_stack([hits.station, hits.axis, hits.diode, first]).astype(np.int64)
    return View(sweeps, who, basis, np.ascontiguousarray(trajectory.reference(hits.time_s)))


def residuals(seen: View, trajectory: Trajectory, state: State) -> np.ndarray:
    """Predicted less measured angle of each hit in rad."""
    return kernel.predicted(seen.light, trajectory.control, state) - seen.sweeps.hits.angle_rad


def weights(
    seen: View, residual: np.ndarray, noise: Noise, share: np.ndarray | None = None
) -> Weights:
    """Weights of hits by their residuals; share: that of each hit as `recording.shares`, 1 without
    it.

    With z = (e - offset) / sigma, a hit costs z^2 up to |z| = `LIMIT` and LIMIT^2 (1 + 2 ln(|z| /
    LIMIT)) beyond, an offset the same of z = offset / common; the weight is 1 up to the limit,
    (LIMIT / z)^2 beyond. Cost and weight of a hit are times its share. So a sweep that is wrong as
    a whole has an offset of its own, and determines nothing but differences of its hits. The offset
    is the minimum for these weights, found by repetition from the median.
    """
    share = np.ones(residual.size) if share is None else share
    return _robust(seen.sweeps.first, residual, noise, share)
