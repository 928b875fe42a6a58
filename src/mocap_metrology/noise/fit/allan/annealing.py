"""Estimators `annealing-ant-colony` and `annealing-ant-colony-plain`: the fit of Skurowski &
Pawlyta 2019 (S 3.4, Eq. 13), with descents and without.

Least squares on the relative residuals of the Allan variances, by multi-start simulated annealing
and then ant colony optimisation for continuous coordinates, ACO_R [Socha & Dorigo, Eur. J. Oper.
Res. 185 (2008) 1155-1173], whose archive is filled by jittering round the annealing's result
(`jittered`) where the original draws it at random.

What the first adds to S: every trial of the annealing first descends a few steps of
Levenberg-Marquardt ("Monte Carlo minimisation", Li & Scheraga, PNAS 84, 1987), so it hops between
valleys and not between points of a 15-dimensional slope, and the results of the starts and of the
colony descend to their minima. Measured on series L of the twin of T40, 10 cameras
(four Gauss-Markov terms and a sinusoid): of ten plain annealing starts of 1,800 trials with one
descent at the end, none reached the best valley; of ten of 90 descended trials, all did. So the
colony has nothing left to find: it lowers the cost by less than one part in 10^9.

The second has no descent anywhere, as S, whose metaheuristics only ever compare costs, and many
more trials instead (`AnnealingSettings.plain`). S does not print its number.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.fit.allan.relative import Misfit, SearchRange, misfit
from mocap_metrology.noise.fit.estimates import (
    PLAIN_ESTIMATOR,
    S_ESTIMATOR,
    Coefficient,
    Components,
    Estimate,
)
from mocap_metrology.noise.model.components import Form, NoiseModel

LOOSE = 0.05  # what can move by more at hardly more cost is named in the note
POLISH = 300  # steps of the last descent: a few dozen do, but in a flat valley


@dataclass(frozen=True)
class Colony:
    """Settings of ACO_R, named as in the paper.

    archive: solutions kept, k. ants: new solutions an iteration, m. q: how far down the archive
    guides are drawn from, as a share of k (small: the best only). xi: width of a kernel over the
    mean distance of its guide to the archive (larger: slower, and less easily trapped).
    """

    archive: int = 50
    ants: int = 10
    q: float = 0.1
    xi: float = 0.85
    iterations: int = 100

    def __post_init__(self) -> None:
        whole = self.archive >= 2 and self.ants >= 1 and self.iterations >= 0
        if not (whole and self.q > 0 and self.xi > 0):
            raise Refusal(
                f"{self}, expected archive >= 2, ants >= 1, iterations >= 0, q > 0, xi > 0"
            )


@dataclass(frozen=True)
class Found:
    """Best point (d,) and its cost; history: (iterations + 1,) best cost so far."""

    x: np.ndarray
    cost: float
    history: np.ndarray


def jittered(
    centre: np.ndarray,
    n: int,
    width: float | np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    rng: np.random.Generator,
) -> np.ndarray:
    """(n, d) points: `centre` (d,) itself, then normal deviates about it of standard deviation
    `width` (a number or (d,)), moved into the bounds."""
    points = centre + width * rng.normal(size=(n, centre.size))
    points[0] = centre
    return np.clip(points, lower, upper)


def colony(
    costs: Callable[[np.ndarray], np.ndarray],
    archive: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    settings: Colony,
    rng: np.random.Generator,
) -> Found:
    """Minimise from a filled archive (k, d); `costs` takes (n, d) points and returns (n,).

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
    history = [values[0]]
    for _ in range(settings.iterations):
        guides = archive[np.searchsorted(edges[:-1], rng.random(settings.ants), side="right")]
        spread = np.abs(archive[None] - guides[:, None]).sum(axis=1) * (settings.xi / (k - 1))
        ants = np.clip(guides + spread * rng.normal(size=guides.shape), lower, upper)
        pool = np.concatenate([values, costs(ants)])
        order = np.argsort(pool, kind="stable")[:k]
        archive, values = np.concatenate([archive, ants])[order], pool[order]
        history.append(values[0])
    return Found(archive[0].copy(), float(values[0]), np.array(history))


@dataclass(frozen=True)
class AnnealingSettings:
    """Every choice of the fit.

    starts: annealing runs, each from a random point (10 in S Figure 6). iterations: of one run,
    each 2 d trials for d coefficients. temperature: at its start. descent: steps down a trial is
    taken; 0: no descent at all, at the end neither. archive, ants, q, xi, colony_iterations: see
    `colony.Colony`. jitter: standard deviation, in natural logarithms, of the archive round the
    annealing's result. plain_iterations, plain_colony_iterations: those of `plain`. negligible,
    largest, shortest_frames, longest_share, lowest_hz, longest_tau_share: see
    `relative.SearchRange`. agreement: relative difference of cost up to which two fits are equally
    good.
    """

    starts: int = 10
    iterations: int = 3
    temperature: float = 5230.0
    descent: int = 20
    archive: int = 50
    ants: int = 10
    q: float = 0.1
    xi: float = 0.85
    colony_iterations: int = 100
    jitter: float = 0.1
    plain_iterations: int = 1000
    plain_colony_iterations: int = 2000
    negligible: float = 1e-5
    largest: float = 1.5
    shortest_frames: float = 2.0
    longest_share: float = 0.1
    lowest_hz: float = 0.01
    longest_tau_share: float = 0.03
    agreement: float = 1e-3

    def __post_init__(self) -> None:
        whole = self.starts >= 1 and self.iterations >= 1 and self.descent >= 0
        if not (whole and 0.01 < self.temperature <= 5e4 and self.jitter > 0 < self.agreement):
            raise Refusal(
                f"{self}, expected starts >= 1, iterations >= 1, descent >= 0, temperature in "
                "(0.01, 50000], jitter > 0, agreement > 0"
            )
        if not (self.plain_iterations >= 1 and self.plain_colony_iterations >= 0):
            raise Refusal(f"{self}, expected plain_iterations >= 1, plain_colony_iterations >= 0")
        _ = self.colony, self.range

    @property
    def plain(self) -> AnnealingSettings:
        """The same without descents, and with the budget that this needs."""
        iterations = {
            "iterations": self.plain_iterations,
            "colony_iterations": self.plain_colony_iterations,
        }
        return replace(self, descent=0, **iterations)

    @property
    def colony(self) -> Colony:
        """Those of the second stage."""
        return Colony(self.archive, self.ants, self.q, self.xi, self.colony_iterations)

    @property
    def range(self) -> SearchRange:
        """Where the coefficients are looked for."""
        return SearchRange(
            self.negligible,
            self.largest,
            self.shortest_frames,
            self.longest_share,
            self.lowest_hz,
            self.longest_tau_share,
        )

    @property
    def every_tau(self) -> SearchRange:
        """The same range for ordinary least squares, which long tau are to decide."""
        return replace(self.range, longest_tau_share=1.0)


@dataclass(frozen=True)
class AnnealingRun:
    """The estimate; the model each annealing start ended in, in order, and its cost (Eq. 13).

    colony_gain: cost of the best start over that of the colony's best point, at least 1."""

    estimate: Estimate
    starts: tuple[NoiseModel, ...]
    starts_cost: tuple[float, ...]
    colony_gain: float


def annealing_run(
    m: np.ndarray,
    avar: np.ndarray,
    frame_rate_hz: float,
    components: Components,
    settings: AnnealingSettings,
    seed: int,
    form: Form = "continuous",
    duration: float | None = None,
) -> AnnealingRun:
    """argmin sum_k ((avar_k - model_k) / avar_k)^2 (S Eq. 13) over `components`.

    duration: of the recording in s, for the ranges of T_c and f_0; by default three times the
    longest tau. Standard errors and intervals are NaN: S gives none. The same `seed` gives the
    same numbers. status: `at_bound` (an amplitude there is absent, with its T_c or f_0);
    `not_converged` where the colony still found a better valley than the best start, where no
    other start reached that cost, or, coefficient by coefficient, where starts of equal cost
    differ by more than 1 %.
    """
    problem = misfit(m, avar, frame_rate_hz, components, form, "relative", settings.range, duration)
    steps = POLISH if settings.descent else 0
    seeds = np.random.SeedSequence(seed).spawn(settings.starts + 1)
    points, costs = [], []
    for one in seeds[1:]:
        x, cost = problem.polished(_anneal(problem, settings, np.random.default_rng(one)), steps)
        points.append(x)
        costs.append(cost)
    best = int(np.argmin(costs))
    rng = np.random.default_rng(seeds[0])
    archive = jittered(
        points[best], settings.archive, settings.jitter, problem.lower, problem.upper, rng
    )
    found = colony(problem.costs, archive, problem.lower, problem.upper, settings.colony, rng)
    x, cost = problem.polished(found.x, steps)
    # A misfit of 1e-4 of the variances at every tau is beyond any recording
    least = settings.agreement * cost + 1e-8 * problem.m.size
    equal = [p for p, c in zip(points, costs, strict=True) if c <= cost + least]
    gain = costs[best] / found.cost if found.cost > 0 else 1.0
    estimate = _estimate(problem, x, cost, equal, settings)
    if not settings.descent:
        said = f"the colony lowered the cost of the best start {gain:.4g} times; {estimate.note}"
        estimate = replace(estimate, note=said)
    return AnnealingRun(estimate, tuple(map(problem.model, points)), tuple(costs), gain)


def _anneal(problem: Misfit, settings: AnnealingSettings, rng: np.random.Generator) -> np.ndarray:
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
    problem: Misfit,
    x: np.ndarray,
    cost: float,
    equal: list[np.ndarray],
    settings: AnnealingSettings,
) -> Estimate:
    model = problem.model(x)
    values = model.coefficients()
    at_bound = problem.at_bound(x)
    others = [problem.model(p).coefficients() for p in equal]
    lonely = len(equal) < min(2, settings.starts)
    coefficients = []
    for name, value in values.items():
        differs = any(abs(o[name] - value) > 0.01 * value for o in others)
        status = "at_bound" if at_bound[name] else "not_converged" if lonely or differs else "ok"
        coefficients.append(Coefficient(name, value, status=status))
    note = f"{len(equal)} of {settings.starts} starts reached the cost of the result"
    freedom = problem.freedom(x, settings.agreement * cost)
    loose = [f"{name} by {share:.0%}" for name, share in freedom.items() if share > LOOSE]
    if loose:
        note += f"; at a cost {settings.agreement:.1%} higher, it could change {', '.join(loose)}"
    name = S_ESTIMATOR if settings.descent else PLAIN_ESTIMATOR
    return Estimate(name, problem.form, tuple(coefficients), cost, note)
