"""One step of a joint estimate: linearise, integrate the sweeps' offsets out, solve.

The normal matrix is a band (the trajectory, half width 30) with a border (all else):

    [A  C ] [x]     [g]
    [C' B ] [y] = - [h],   S = B - C' A^-1 C,  y = -S^-1 (h - C' A^-1 g),  x = -A^-1 (g + C y).

The inverse of the Schur complement S is the covariance of y. Recordings that share stations and
board have an S and h each, which are simply added.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import linalg, optimize

from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.batch import kernel
from mocap_metrology.lighthouse.batch.kernel import POSE, SPAN, Equations
from mocap_metrology.lighthouse.batch.problem import Layout, State
from mocap_metrology.lighthouse.batch.trajectory import KNOT_S, Trajectory
from mocap_metrology.lighthouse.batch.view import (
    LEAST_RAD,
    Noise,
    View,
    selected_inverse,
    without_offsets,
)

# Of the second difference of control points 50 ms apart: 20 m/s^2 and 400 rad/s^2. They are to
# count only where a board is not seen, as they make every turn smaller: a bias of the stations
# where single poses are uncertain by degrees, as those of a small board.
BEND = np.r_[np.full(3, 0.05), np.full(3, 1.0)]
FACTORS = (1e-3, 0.03, 0.06, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
NOT_RULED_OUT = 4.0  # of -2 log likelihood: two standard deviations
WRONG = 0.5  # of the weight of a sweep: below it is farther off than five standard deviations
NOISE_ROUNDS = 2  # of its estimate beside other data
RATIOS = (0.05, 20.0)  # of common to independent noise that are told from none and from only


@dataclass(frozen=True)
class Sums:
    """Normal equations with V = I, what sweeps have in sum, and w e^2 in all; and those of other
    data."""

    hits: Equations
    begin: np.ndarray
    of_sweep: np.ndarray
    of_sweep_inner: np.ndarray
    weight: np.ndarray  # sum(w) of each sweep
    held: np.ndarray  # weight of what is known of its offset
    residual: np.ndarray  # sum(w e) of each sweep
    square: float
    n_hits: int
    more: Equations | None


def linearised(
    seen: View,
    trajectory: Trajectory,
    state: State,
    residual: np.ndarray,
    weight: np.ndarray,
    of: Layout,
    more: Equations | None = None,
    held: np.ndarray | None = None,
) -> Sums:
    """Sums over all hits; more: equations of other data; held: of `Weights`, 1 without it."""
    first, control, m = seen.sweeps.first, trajectory.control, seen.sweeps.first.size - 1
    equations = Equations.zeros(control.size, of.size)
    by_sweep = np.zeros((m, SPAN)), np.zeros((m, of.size))
    at = seen.light, first, residual, weight, control, state, of.rows
    kernel.accumulate(*at, equations, *by_sweep)
    low, held = first[:-1], np.ones(m) if held is None else held
    total, off = np.add.reduceat(weight, low), np.add.reduceat(weight * residual, low)
    of_all = float(weight @ residual**2), residual.size
    return Sums(equations, seen.begin, *by_sweep, total, held, off, *of_all, more)


@dataclass(frozen=True)
class Reduced:
    """A recording without its trajectory: S and h, both without priors, and the way back."""

    S: np.ndarray
    h: np.ndarray
    factor: np.ndarray  # of A
    A_C: np.ndarray
    A_g: np.ndarray

    def trajectory_step(self, step: np.ndarray) -> np.ndarray:
        """Step of the path's knots that belongs to a step of all other unknowns."""
        return -(self.A_g + self.A_C @ step)


def _bend(trajectory: Trajectory, noise: float) -> tuple[np.ndarray, np.ndarray]:
    """Band and gradient of the second differences, in units of the variance of a hit."""
    flat = trajectory.control
    band = np.zeros((SPAN, flat.size), order="F")
    if trajectory.still:
        band[0, POSE:] = 1.0  # control points that are not used
        return band, np.zeros(flat.size)
    weight = (noise / (BEND * (trajectory.knot_s / KNOT_S) ** 2)) ** 2
    second = flat[:-2] - 2 * flat[1:-1] + flat[2:]
    g, n = np.zeros_like(flat), len(flat)
    for i, a in enumerate((1.0, -2.0, 1.0)):
        g[i : n - 2 + i] += a * second * weight
        for j, b in enumerate((1.0, -2.0, 1.0)):
            if j <= i:
                rows = (POSE * np.arange(j, n - 2 + j)[:, None] + np.arange(POSE)).ravel()
                band[POSE * (i - j), rows] += np.tile(a * b * weight, n - 2)
    band[0] += 1e-12 * band[0].max()
    return band, g.ravel()


def known_of(
    trajectory: Trajectory, more: Equations | None, noise: float
) -> tuple[np.ndarray, np.ndarray]:
    """Band and gradient of all that is known of a trajectory beside hits, in units of the variance
    of a hit."""
    band, g = _bend(trajectory, noise)
    if more is not None:
        band += noise**2 * more.band
        g += noise**2 * more.g
    return band, g


def reduced(
    sums: Sums, trajectory: Trajectory, noise: Noise, damping: Floats | float = 0.0
) -> Reduced:
    """The trajectory eliminated, damping (6 K,) times the diagonal added; raises LinAlgError where
    it is not determined."""
    variance, hits = noise.hit**2, sums.hits
    band, g = known_of(trajectory, sums.more, noise.hit)
    band, g = hits.band + band, hits.g + g
    # np.copy keeps the order of columns, the method of arrays does not
    cross, inner, h = map(np.copy, (hits.cross, hits.inner, hits.g_inner))
    if sums.more is not None:
        cross += variance * sums.more.cross
        inner += variance * sums.more.inner
        h += variance * sums.more.g_inner
    ratio = (noise.sweep / noise.hit) ** 2 / sums.held
    factor = ratio / (1 + ratio * sums.weight)
    of_sweeps = sums.begin, factor, sums.of_sweep, sums.of_sweep_inner, sums.residual
    without_offsets(*of_sweeps, Equations(band, cross, inner, g, h))
    band[0] *= 1 + damping
    L = linalg.cholesky_banded(band, overwrite_ab=True, lower=True, check_finite=False)
    both = linalg.cho_solve_banded(
        (L, True), np.column_stack([cross, g]), overwrite_b=True, check_finite=False
    )
    A_C, A_g = both[:, :-1], both[:, -1]
    S = (inner - cross.T @ A_C) / variance
    return Reduced((S + S.T) / 2, (h - cross.T @ A_g) / variance, L, A_C, A_g)


def by_bends(part: Reduced, trajectory: Trajectory, noise: Noise) -> Floats:
    """C' A^-1 g with g of the second differences alone: by how much less than the hits alone
    these, and hits, pull at the global unknowns (`batch.bias`)."""
    return part.A_C.T @ _bend(trajectory, noise.hit)[1] / noise.hit**2


def bend_cost(trajectory: Trajectory) -> float:
    """Sum of the squared second differences over their variances."""
    _, g = _bend(trajectory, 1.0)
    return 0.0 if trajectory.still else float(g @ trajectory.control.ravel())


def solved(M: np.ndarray, y: np.ndarray) -> Floats:
    """M^-1 y of a positive definite M, in units in which its diagonal is 1: those of the unknowns
    differ by many orders of magnitude. Raises LinAlgError for another M."""
    if not (np.diag(M) > 0).all():
        raise np.linalg.LinAlgError("an unknown of no or negative information")
    scale = 1 / np.sqrt(np.diag(M))
    x: Floats = linalg.solve(M * np.outer(scale, scale), (y.T * scale).T, assume_a="pos")
    return (x.T * scale).T


def covariance_of(
    S: np.ndarray, working: np.ndarray, believed: np.ndarray, pull: np.ndarray | None = None
) -> np.ndarray:
    """Covariance of y estimated with prior standard deviations `working` where `believed` are true:
    with L = diag(1 / working^2) and M = S + L,

        M^-1 (S + L diag(believed^2) L) M^-1,

    which is M^-1 where both are the same, and where working is 0 that of Schmidt (1966) for
    quantities that are considered, not estimated. pull: in place of the first S.
    """
    known = 1 / working**2
    inside = np.where(np.isfinite(believed), believed, 0.0) * known
    M = solved(S + np.diag(known), np.eye(known.size))
    covariance = M @ ((S if pull is None else pull) + np.diag(inside**2)) @ M.T
    return (covariance + covariance.T) / 2  # apart by rounding, where little is determined


def supported(
    S: np.ndarray, h: np.ndarray, values: np.ndarray, working: np.ndarray, group: np.ndarray
) -> tuple[float, float]:
    """How large a group of unknowns is as a whole, by the recording: the factors of its standard
    deviation of greatest restricted likelihood, and the largest that it does not contradict.

    own: which unknowns the group is; with L(f) the information of the priors, the group's standard
    deviations times f, and h_0 = h - S values at values 0,

        -2 log L = log det(S + L) - log det L - h_0' (S + L)^-1 h_0,

    which the largest factor raises by `NOT_RULED_OUT`; both are interpolated between `FACTORS`.
    """
    at_zero = h - S @ values
    costs = []
    for factor in FACTORS:
        known = 1 / np.where(group, factor * working, working) ** 2
        L = linalg.cholesky(S + np.diag(known), lower=True)
        x = linalg.solve_triangular(L, at_zero, lower=True)
        size = 2 * np.log(np.diag(L)).sum() - np.log(known[group]).sum()
        costs.append(float(size - x @ x))
    best = int(np.argmin(costs))
    fine = np.linspace(0, len(FACTORS) - 1, 20 * len(FACTORS))
    curve = np.interp(fine, np.arange(len(FACTORS)), costs)
    within = fine[curve <= costs[best] + NOT_RULED_OUT]
    factors = np.interp([_lowest(costs, best), within.max()], np.arange(len(FACTORS)), FACTORS)
    return float(factors[0]), float(factors[1])


def _lowest(values: list[float], at: int) -> float:
    """Where the parabola through the least of equidistant values and its neighbours is lowest."""
    if not 0 < at < len(values) - 1:
        return float(at)
    below, here, above = values[at - 1 : at + 2]
    bend = below - 2 * here + above
    return at + 0.5 * (below - above) / bend if bend > 0 else float(at)


def estimated_noise(sums: Sums, trajectory: Trajectory, start: Noise) -> Noise:
    """Standard deviations of the greatest restricted likelihood (Patterson & Thompson 1971).

    For a ratio r = (sweep / hit)^2 of the variances, with A and g of the trajectory alone,

        Q = sum(w e^2) - sum_m r / (1 + r W_m) (sum_m w e)^2 - g' A^-1 g,
        -2 log L = (n - p) log Q + sum_m log(1 + r W_m) + log det A,   hit^2 = Q / (n - p),

    p unknowns of the trajectory, less what other data determine of them; those of the border are
    few beside it and count as known. r of a sweep is divided by its weight in `Sums.held`; as much
    of its offset as this leaves open counts as an unknown. The offset of a sweep that lost most of
    its weight is one more unknown, with r infinite and no term in the second sum: by the limited
    loss of `view.weights` alone a few wrong sweeps make the noise of all larger. The ratio
    is found by bounded search; 0 is tried, too.
    """
    if sums.more is None:
        return _estimated_noise(sums, trajectory, start, 0.0)
    for _ in range(NOISE_ROUNDS):
        Z = selected_inverse(reduced(sums, trajectory, start).factor)
        both = (Z * sums.more.band).sum(axis=1)  # of trace(A^-1 A_more): so many unknowns
        by_more = start.hit**2 * float(2 * both.sum() - both[0])
        start = _estimated_noise(sums, trajectory, start, by_more)
    return start


def _estimated_noise(sums: Sums, trajectory: Trajectory, start: Noise, by_more: float) -> Noise:
    bend, bend_g = known_of(trajectory, sums.more, start.hit)
    p = int((sums.hits.band[0] > 0).sum())
    wrong = sums.held < WRONG
    free = max(sums.n_hits - p + by_more - float(np.sum(np.where(wrong, 1, 1 - sums.held))), 1)
    nothing, none = np.zeros((sums.begin.size, 0)), Equations.zeros(sums.hits.g.size, 0)

    def at(ratio: float) -> tuple[float, float]:
        band, g = sums.hits.band + bend, sums.hits.g + bend_g
        relative = ratio / sums.held
        factor = np.where(wrong, 1 / sums.weight, relative / (1 + relative * sums.weight))
        of_sweeps = sums.begin, factor, sums.of_sweep, nothing, sums.residual
        without_offsets(*of_sweeps, none._replace(band=band, g=g))
        L = linalg.cholesky_banded(band, overwrite_ab=True, lower=True, check_finite=False)
        x = linalg.cho_solve_banded((L, True), g, check_finite=False)
        Q = sums.square - float(factor @ sums.residual**2) - float(g @ x)
        Q = max(Q, free * LEAST_RAD**2)
        log_det = 2 * float(np.log(L[0]).sum())
        rest = float(np.log1p((relative * sums.weight)[~wrong]).sum())
        return free * np.log(Q) + rest + log_det, Q / free

    low, high = 2 * np.log(RATIOS)
    best = optimize.minimize_scalar(
        lambda x: at(np.exp(x))[0], bounds=(low, high), method="bounded", options={"xatol": 0.05}
    )
    ratio = float(np.exp(best.x))
    ratio = min((0.0, ratio), key=lambda r: at(r)[0])
    hit = float(np.sqrt(at(ratio)[1]))
    return Noise(hit, hit * float(np.sqrt(ratio)))
