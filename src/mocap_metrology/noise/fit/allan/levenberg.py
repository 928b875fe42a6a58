"""Estimator `levenberg-marquardt`: ordinary least squares on Allan variances.

Skurowski & Pawlyta 2019 show it beside theirs (S Figure 6): every variance counts by its size, so
the few largest decide, and what is seen in small ones only, at the other taus, is left to chance.
"""

from __future__ import annotations

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.fit.allan.relative import SearchRange, misfit
from mocap_metrology.noise.fit.estimates import Coefficient, Components, Estimate
from mocap_metrology.noise.model.components import Form

NAME = "levenberg-marquardt"
STEPS = 300
AGREEMENT = 1e-3


def levenberg_marquardt(
    m: np.ndarray,
    avar: np.ndarray,
    tau0: float,
    components: Components,
    seed: int,
    form: Form = "continuous",
    starts: int = 10,
    within: SearchRange | None = None,
    duration: float | None = None,
) -> Estimate:
    """argmin sum_k (avar_k - model_k)^2 over `components`, avar (k,) in mm^2 at tau = m tau0 (s).

    Levenberg-Marquardt in logarithms of the coefficients, inside the bounds `within`, from
    `starts` random points, of which the best result is given. duration: as in
    `annealing.annealing_run`. The cost is the sum of squares over that of the variances, times
    their number, so that it has no unit and 1 a point is a model of nothing. Standard errors and
    intervals are NaN. status: `at_bound`, or `not_converged` where no two starts ended at one cost.
    """
    if starts < 1:
        raise Refusal(f"levenberg-marquardt: {starts} starts, expected at least 1")
    problem = misfit(m, avar, tau0, components, form, "equal", within, duration)
    rng = np.random.default_rng(seed)
    ends = [
        problem.polished(rng.uniform(problem.lower, problem.upper), STEPS) for _ in range(starts)
    ]
    x, cost = min(ends, key=lambda end: end[1])
    least = AGREEMENT * cost + 1e-8 * problem.m.size
    equal = sum(c <= cost + least for _, c in ends)
    at_bound = problem.at_bound(x)
    otherwise = "ok" if equal >= min(2, starts) else "not_converged"
    coefficients = tuple(
        Coefficient(name, value, status="at_bound" if at_bound[name] else otherwise)
        for name, value in problem.model(x).coefficients().items()
    )
    note = f"{equal} of {starts} starts reached the cost of the result"
    return Estimate(NAME, form, coefficients, cost, note)
