"""Least squares for sums of curves: non-negative amplitudes, searched time constants and frequency.

Curves are (k,) vectors of a whitened problem: power laws of one shape each, Gauss-Markov terms of
a shape by log T_c, a sinusoid of a shape by log f_0. For given shapes the best amplitudes are a
convex problem (non-negative least squares, Lawson & Hanson 1974), so only shapes are searched:
variable projection [Golub & Pereyra 1973, with Kaufman's 1975 Jacobian]. Starts come from the
data: amplitudes of a whole grid of time constants are convex too, and where they end up positive
are the terms; then terms are removed and inserted one at a time. No random numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from mocap_metrology.common.types import Floats

STEPS, ROUGH_STEPS, NEWTON_STEPS = 60, 25, 8
ROUGH, FINE = 1e-5, 1e-11  # change of the cost that ends Gauss-Newton and Newton steps
DICTIONARY_STRIDE = 4  # every fourth time constant of the table is an atom of the first fit


# Powers 0 to 3 of the place in an interval, times this: weights of the values at its ends and of
# the derivatives there, in lengths of the interval; and the derivatives of these weights
HERMITE = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [-3, 3, -2, -1], [2, -2, 1, 1]], float)
HERMITE_SLOPE = np.array([[0, 0, 1, 0], [-6, 6, -4, -2], [6, -6, 3, 3], [0, 0, 0, 0]], float)


def hermite_nodes(log_T: np.ndarray, table: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """(g - 1, 4, k) values at both ends of every interval and derivatives by log_T there times its
    length."""
    step = log_T[1] - log_T[0]
    return np.stack([table[:-1], table[1:], step * slope[:-1], step * slope[1:]], axis=1)


@dataclass(frozen=True)
class Problem:
    """target: (k,); fixed: (k, a) power laws; log_T: (g,) rising by equal steps, table: (g, k)
    Gauss-Markov curves there, nodes: see `hermite_nodes`; line: (k, f) curves at log
    f_0 (f,), of which log_f: (2,) is the range."""

    target: np.ndarray
    fixed: np.ndarray
    log_T: np.ndarray
    table: np.ndarray
    nodes: np.ndarray
    line: Callable[[np.ndarray], np.ndarray]
    log_f: tuple[float, float]

    def correlated(self, log_T: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(k, t) curves at log_T (t,) and their derivatives: cubic Hermite interpolation."""
        step = self.log_T[1] - self.log_T[0]
        place = (log_T - self.log_T[0]) / step
        i = np.minimum(np.maximum(place.astype(int), 0), self.log_T.size - 2)
        powers = (place - i)[:, None] ** np.arange(4.0)
        weights = np.stack([powers @ HERMITE, powers @ HERMITE_SLOPE / step], axis=1)
        values = weights @ self.nodes[i]
        return values[:, 0].T, values[:, 1].T

    def tone(self, log_f: float) -> tuple[np.ndarray, np.ndarray]:
        """Curve of the sinusoid and its derivative by log f_0."""
        h = 1e-6
        below, at, above = self.line(np.array([log_f - h, log_f, log_f + h])).T
        return at, (above - below) / (2 * h)


@dataclass(frozen=True)
class Fit:
    """log_T: (terms,) rising; log_f: of the sinusoid or None; amplitudes: of the power laws, the
    terms and the sinusoid, in that order, >= 0; cost: sum of squared residuals (k,). curves: (k,
    a + s), slopes: (k, s) derivatives of the s that have a shape."""

    log_T: np.ndarray
    log_f: float | None
    amplitudes: np.ndarray
    residual: np.ndarray
    curves: np.ndarray
    slopes: np.ndarray
    converged: bool = True

    @property
    def cost(self) -> float:
        """Sum of squares."""
        return float(self.residual @ self.residual)

    @property
    def shapes(self) -> np.ndarray:
        """What is searched: log_T and, last, log_f."""
        return self.log_T if self.log_f is None else np.append(self.log_T, self.log_f)

    @property
    def shaped(self) -> np.ndarray:
        """Amplitudes of the curves that have a shape."""
        return self.amplitudes[self.amplitudes.size - self.slopes.shape[1] :]


def amplitudes(curves: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Non-negative least squares; columns are scaled first, as their units differ by powers."""
    from scipy.optimize import nnls

    if not curves.shape[1]:
        return np.empty(0)
    norm = np.sqrt(np.einsum("ij,ij->j", curves, curves))
    norm = np.where(norm > 0, norm, 1.0)
    return nnls(curves / norm, target, maxiter=50 * curves.shape[1])[0] / norm


def solved(problem: Problem, log_T: np.ndarray, log_f: float | None = None) -> Fit:
    """The fit with these shapes."""
    curves, slopes = problem.correlated(np.asarray(log_T, float))
    if log_f is not None:
        tone = problem.tone(log_f)
        curves, slopes = np.column_stack([curves, tone[0]]), np.column_stack([slopes, tone[1]])
    curves = np.hstack([problem.fixed, curves])
    found = amplitudes(curves, problem.target)
    residual = problem.target - curves @ found
    return Fit(np.asarray(log_T, float), log_f, found, residual, curves, slopes)


def polish(
    problem: Problem, log_T: np.ndarray, log_f: float | None = None, rough: bool = False
) -> Fit:
    """Local minimum over the shapes, within the table and the range of frequencies: damped
    Gauss-Newton steps (Levenberg-Marquardt), then, unless `rough`, Newton steps. Terms of amplitude
    0 are left out of the result."""
    low = np.append(np.full(len(log_T), problem.log_T[0]), problem.log_f[0])
    high = np.append(np.full(len(log_T), problem.log_T[-1]), problem.log_f[1])
    fit = solved(problem, np.clip(log_T, low[:-1], high[:-1]), log_f)
    bounds = low[: fit.shapes.size], high[: fit.shapes.size]
    damping, converged = 1e-3, not fit.shapes.size
    for _ in range(0 if converged else ROUGH_STEPS if rough else STEPS):
        trial = _moved(problem, fit, _step(fit, damping, *bounds), *bounds)
        gain = fit.cost - trial.cost
        fit, damping = (trial, damping / 5) if gain > 0 else (fit, damping * 4)
        if abs(gain) < ROUGH * (1 + fit.cost) or damping > 1e9:
            converged = True
            break
    for _ in range(0 if rough or not fit.shapes.size else NEWTON_STEPS):
        step = _newton(problem, fit, *bounds)
        trial = _moved(problem, fit, step, *bounds)
        gain = fit.cost - trial.cost
        fit = trial if gain > 0 else fit
        if gain < FINE * (1 + fit.cost):
            converged = converged or bool(np.max(np.abs(step)) < 1e-3)
            break
    return _pruned(replace(fit, converged=converged))


def _newton(problem: Problem, fit: Fit, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Newton step from differences of the gradient: where residuals are large (long tau scatter
    by their own size), Gauss-Newton steps overshoot and creep."""
    gradient = fit.shaped * (fit.slopes.T @ fit.residual)
    free = np.flatnonzero((fit.shaped > 0) & (fit.shapes > low) & (fit.shapes < high))
    step = np.zeros(gradient.size)
    if not free.size:
        return step
    rows = []
    for i in free:
        beside = _moved(problem, fit, np.eye(gradient.size)[i] * 1e-5, -np.inf, np.inf)
        rows.append(gradient - beside.shaped * (beside.slopes.T @ beside.residual))
    curvature = np.stack(rows)[:, free] / 1e-5
    values, vectors = np.linalg.eigh((curvature + curvature.T) / 2)
    along = vectors.T @ gradient[free]
    uphill = values <= 1e-9 * values[-1]  # no minimum that way: no step
    step[free] = vectors @ np.where(uphill, 0.0, along / np.where(uphill, 1.0, values))
    return np.minimum(np.maximum(step, -1.0), 1.0)


def _moved(
    problem: Problem, fit: Fit, step: np.ndarray, low: np.ndarray | float, high: np.ndarray | float
) -> Fit:
    shapes = np.minimum(np.maximum(fit.shapes + step, low), high)
    return solved(problem, shapes[: fit.log_T.size], None if fit.log_f is None else shapes[-1])


def _step(fit: Fit, damping: float, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    shapes, own = fit.shapes, fit.shaped
    jacobian = projected(fit.slopes * own, fit.curves[:, fit.amplitudes > 0])
    gradient = jacobian.T @ fit.residual
    # A shape on its bound that would leave it stays out of the step, one without amplitude too
    free = (own > 0) & ~((shapes <= low) & (gradient < 0)) & ~((shapes >= high) & (gradient > 0))
    step = np.zeros(shapes.size)
    if free.any():
        normal = jacobian[:, free].T @ jacobian[:, free]
        scale = np.diag(normal)
        normal = normal + np.diag(damping * scale + 1e-12 * scale.max() + 1e-300)
        step[free] = np.linalg.solve(normal, gradient[free])
    return np.minimum(np.maximum(step, -1.0), 1.0)


def projected(vectors: Floats, onto_complement_of: np.ndarray) -> Floats:
    """Columns less what the other columns explain."""
    if not onto_complement_of.shape[1]:
        return vectors
    norm = np.linalg.norm(onto_complement_of, axis=0)
    basis, _ = np.linalg.qr(onto_complement_of / np.where(norm > 0, norm, 1.0))
    return vectors - basis @ (basis.T @ vectors)


def _pruned(fit: Fit) -> Fit:
    """Without empty terms, by rising log_T."""
    size = fit.log_T.size
    first = fit.amplitudes.size - fit.slopes.shape[1]
    order = np.argsort(fit.log_T)
    order = order[fit.amplitudes[first + order] > 0]
    shaped = np.append(order, np.arange(size, fit.slopes.shape[1]))
    every = np.append(np.arange(first), first + shaped)
    return replace(
        fit,
        log_T=fit.log_T[order],
        amplitudes=fit.amplitudes[every],
        curves=fit.curves[:, every],
        slopes=fit.slopes[:, shaped],
    )


def dictionary(problem: Problem, log_f: float | None = None) -> Fit:
    """The convex fit: a term at every atom of a grid of time constants."""
    return _pruned(solved(problem, problem.log_T[::DICTIONARY_STRIDE], log_f))


def merged(problem: Problem, fit: Fit) -> np.ndarray:
    """Time constants of a `dictionary` fit, neighbouring atoms merged to their mean by amplitude
    times length of curve (two neighbours stand for one term between them)."""
    if not fit.log_T.size:
        return fit.log_T
    first = problem.fixed.shape[1]
    at = np.rint((fit.log_T - problem.log_T[0]) / (problem.log_T[1] - problem.log_T[0])).astype(int)
    weight = fit.amplitudes[first : first + at.size] * np.linalg.norm(problem.table[at], axis=1)
    groups = np.cumsum(np.concatenate([[0], np.diff(at) > DICTIONARY_STRIDE]))
    return np.bincount(groups, weight * fit.log_T) / np.bincount(groups, weight)


def path(problem: Problem, most: int, log_f: float | None = None) -> list[Fit]:
    """The best fits found with at most 0, 1, ..., `most` terms.

    From the merged dictionary down: the term that is missed least goes, the others are polished.
    Then up: a term is put in where it gains most. The better of both ways stands.
    """
    best: dict[int, Fit] = {}
    fit = polish(problem, merged(problem, dictionary(problem, log_f)), log_f, rough=True)
    while True:
        size = fit.log_T.size
        if size <= most and (size not in best or fit.cost < best[size].cost):
            best[size] = fit
        if size == 0:
            break
        fit = _without_one(problem, fit)
    for size in range(1, most + 1):
        below = best[size - 1]
        for log_T in best_insertions(problem, below):
            trial = polish(problem, np.append(below.log_T, log_T), below.log_f, rough=True)
            if size not in best or trial.cost < best[size].cost:
                best[size] = trial
        if size not in best or below.cost <= best[size].cost:
            best[size] = below
    return [best[size] for size in range(most + 1)]


def _without_one(problem: Problem, fit: Fit) -> Fit:
    rest = [np.delete(fit.log_T, i) for i in range(fit.log_T.size)]
    costs = [solved(problem, log_T, fit.log_f).cost for log_T in rest]
    first, *others = np.argsort(costs)
    close = [i for i in others[:1] if costs[i] - fit.cost < 3 * (costs[first] - fit.cost) + 1]
    tried = [polish(problem, rest[i], fit.log_f, rough=True) for i in (first, *close)]
    return min(tried, key=lambda f: f.cost)


def gains(fit: Fit, columns: np.ndarray) -> np.ndarray:
    """(g,) how much each of the columns (k, g), of positive amplitude, would lower the cost with
    the shapes as they are."""
    new = projected(columns, fit.curves[:, fit.amplitudes > 0])
    power = np.einsum("ij,ij->j", new, new)
    floor = 1e-10 * np.einsum("ij,ij->j", columns, columns)
    along = np.maximum(fit.residual @ new, 0.0)
    return np.where(power > floor, along**2 / np.maximum(power, floor + 1e-300), 0.0)


def peaks(values: np.ndarray, count: int) -> np.ndarray:
    """Places of the highest local maxima above 0, highest first."""
    padded = np.concatenate([[-1.0], values, [-1.0]])
    high = (values > padded[:-2]) & (values >= padded[2:]) & (values > 0)
    at = np.flatnonzero(high)
    return at[np.argsort(-values[at], kind="stable")][:count]


def best_insertions(problem: Problem, fit: Fit, count: int = 2) -> np.ndarray:
    """log T_c where one more term would gain most; empty where none gains 0.01, a tenth of a
    standard error."""
    gained = gains(fit, problem.table.T)
    at = peaks(gained, count)
    return problem.log_T[at[gained[at] > max(0.01, 0.2 * gained.max())]]


def with_line(problem: Problem, fit: Fit, log_f: np.ndarray, columns: np.ndarray) -> Fit | None:
    """The fit plus a sinusoid, or None where none gains; its frequency from a scan of log_f (g,),
    whose curves are columns (k, g), then polished from up to three peaks."""
    bare = fit if fit.log_f is None else solved(problem, fit.log_T)
    gained = gains(bare, columns)
    at = [i for i in peaks(gained, 3) if gained[i] > 0.5 * gained.max()]
    tried = [polish(problem, bare.log_T, float(log_f[i]), rough=True) for i in at]
    return min(tried, key=lambda f: f.cost, default=None)
