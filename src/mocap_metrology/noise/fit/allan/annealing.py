"""Estimators `annealing-ant-colony` and `annealing-ant-colony-plain`: the fit of Skurowski &
Pawlyta 2019 (S 3.4, Eq. 13), with descents and without.

Least squares on the relative residuals of the Allan variances, by multi-start simulated annealing
and then ant colony optimisation for continuous coordinates, ACO_R [Socha & Dorigo, Eur. J. Oper.
Res. 185 (2008) 1155-1173], whose archive is filled by jittering round the annealing's result where
the original draws it at random.

What the first adds to S: every trial of the annealing first descends a few steps of
Levenberg-Marquardt ("Monte Carlo minimisation", Li & Scheraga, PNAS 84, 1987), so it hops between
valleys and not between points of a 15-dimensional slope, and the results of the starts and of the
colony descend to their minima. Measured on series L of the twin of T40, 10 cameras
(four Gauss-Markov terms and a sinusoid): of ten plain annealing starts of 1,800 trials with one
descent at the end, none reached the best valley; of ten of 90 descended trials, all did. So the
colony has nothing left to find: it lowers the cost by less than one part in 10^9.

The second has no descent anywhere, as S, whose metaheuristics only ever compare costs, and many
more trials instead (`without_descents`). S does not print its number.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from mocap_metrology.noise.fit.allan.relative import Misfit, misfit
from mocap_metrology.noise.fit.estimates import (
    PLAIN_ESTIMATOR,
    S_ESTIMATOR,
    Coefficient,
    Components,
    Estimate,
)
from mocap_metrology.noise.model.components import Form, NoiseModel
from mocap_metrology.settings import Annealing

LOOSE = 0.05  # what can move by more at hardly more cost is named in the note
POLISH = 300  # steps of the last descent: a few dozen do, but in a flat valley
AGREEMENT = 1e-3  # relative difference of cost up to which two fits are equally good
NO_MISFIT = 1e-8  # of the square of a relative residual: 1e-4 is beyond any recording


def without_descents(settings: Annealing) -> Annealing:
    """The settings without descents, and with the budget that this needs."""
    budget = {
        "iterations": settings.plain_iterations,
        "colony_iterations": settings.plain_colony_iterations,
    }
    return settings.model_copy(update={"descent": 0, **budget})


def colony(
    costs: Callable[[np.ndarray], np.ndarray],
    archive: np.ndarray,
    bounds: tuple[np.ndarray, np.ndarray],
    settings: Annealing,
    rng: np.random.Generator,
) -> tuple[np.ndarray, float]:
    """Best point (d,) and its cost, by ACO_R from a filled archive (k, d); `costs` takes (n, d)
    points and returns (n,). q, xi, ants, colony_iterations: of the settings.

    An ant draws a guide l of the archive, sorted by cost, with weight
    exp(-(l - 1)^2 / (2 q^2 k^2)) (Eq. 12), then every coordinate i from a normal distribution
    about the guide's, of standard deviation xi sum_e |s_e^i - s_l^i| / (k - 1) (Eq. 16); the best
    k of archive and ants stay. Coordinates are drawn as they are, without the rotation of the
    paper's section 3.2; what leaves the bounds is moved onto them.
    """
    k = archive.shape[0]
    values = costs(archive)
    order = np.argsort(values, kind="stable")
    archive, values = archive[order], values[order]
    weights = np.exp(-(np.arange(k) ** 2) / (2 * (settings.q * k) ** 2))
    edges = np.cumsum(weights / weights.sum())
    for _ in range(settings.colony_iterations):
        guides = archive[np.searchsorted(edges[:-1], rng.random(settings.ants), side="right")]
        spread = np.abs(archive[None] - guides[:, None]).sum(axis=1) * (settings.xi / (k - 1))
        ants = np.clip(guides + spread * rng.normal(size=guides.shape), *bounds)
        pool = np.concatenate([values, costs(ants)])
        order = np.argsort(pool, kind="stable")[:k]
        archive, values = np.concatenate([archive, ants])[order], pool[order]
    return archive[0].copy(), float(values[0])


@dataclass(frozen=True)
class AnnealingRun:
    """The estimate; the model each annealing start ended in, in order.

    colony_gain: cost of the best start over that of the colony's best point, at least 1."""

    estimate: Estimate
    starts: tuple[NoiseModel, ...]
    colony_gain: float


def annealing_run(
    m: np.ndarray,
    avar: np.ndarray,
    frame_rate_hz: float,
    components: Components,
    settings: Annealing,
    seed: int,
    form: Form = "continuous",
    duration: float | None = None,
) -> AnnealingRun:
    """argmin sum_k ((avar_k - model_k) / avar_k)^2 (S Eq. 13) over `components`.

    m, avar, duration: as of `relative.misfit`. Standard errors and intervals are NaN: S gives none.
    The same `seed` gives the same numbers. status: `at_bound` (an amplitude there is absent, with
    its T_c or f_0); `not_converged` where the colony still found a better valley than the best
    start, where no other start reached that cost, or, coefficient by coefficient, where starts of
    equal cost differ by more than 1 %.
    """
    problem = misfit(m, avar, frame_rate_hz, components, form, "relative", settings, duration)
    bounds = problem.lower, problem.upper
    steps = POLISH if settings.descent else 0
    first, *seeds = np.random.SeedSequence(seed).spawn(settings.starts + 1)
    ends = [
        problem.polished(_anneal(problem, settings, np.random.default_rng(one)), steps)
        for one in seeds
    ]
    best, best_cost = min(ends, key=lambda end: end[1])
    rng = np.random.default_rng(first)
    archive = best + settings.jitter * rng.normal(size=(settings.archive, best.size))
    archive[0] = best
    x, colony_cost = colony(problem.costs, np.clip(archive, *bounds), bounds, settings, rng)
    gain = best_cost / colony_cost if colony_cost > 0 else 1.0
    x, cost = problem.polished(x, steps)
    least = AGREEMENT * cost + NO_MISFIT * problem.m.size
    equal = [problem.model(point) for point, c in ends if c <= cost + least]
    estimate = _estimate(problem, x, cost, equal, settings)
    if not settings.descent:
        note = f"the colony lowered the cost of the best start {gain:.4g} times; {estimate.note}"
        estimate = replace(estimate, note=note)
    return AnnealingRun(estimate, tuple(problem.model(point) for point, _ in ends), gain)


def _anneal(problem: Misfit, settings: Annealing, rng: np.random.Generator) -> np.ndarray:
    """One start: scipy's dual annealing over the valleys of the cost."""
    from scipy.optimize import dual_annealing

    best = problem.lower, np.inf

    def trial(x: np.ndarray) -> float:
        nonlocal best
        bottom, cost = problem.polished(x, settings.descent)
        if cost < best[1]:
            best = bottom, cost
        return cost

    dual_annealing(
        trial,
        list(zip(problem.lower, problem.upper, strict=True)),
        maxiter=settings.iterations,
        initial_temp=settings.temperature,
        no_local_search=True,
        rng=rng,
    )
    return best[0]


def _estimate(
    problem: Misfit, x: np.ndarray, cost: float, equal: list[NoiseModel], settings: Annealing
) -> Estimate:
    """equal: models of the starts that reached the cost."""
    at_bound, others = problem.at_bound(x), [model.coefficients() for model in equal]
    lonely = len(equal) < min(2, settings.starts)
    coefficients = []
    for name, value in problem.model(x).coefficients().items():
        differs = any(abs(o[name] - value) > 0.01 * value for o in others)
        status = "at_bound" if at_bound[name] else "not_converged" if lonely or differs else "ok"
        coefficients.append(Coefficient(name, value, status=status))
    note = f"{len(equal)} of {settings.starts} starts reached the cost of the result"
    freedom = problem.freedom(x, AGREEMENT * cost)
    loose = [f"{name} by {share:.0%}" for name, share in freedom.items() if share > LOOSE]
    if loose:
        note += f"; at a cost {AGREEMENT:.1%} higher, it could change {', '.join(loose)}"
    name = S_ESTIMATOR if settings.descent else PLAIN_ESTIMATOR
    return Estimate(name, problem.form, tuple(coefficients), cost, note)
