"""Estimators `levenberg-marquardt` and `slopes`: what S's own is compared with.

The first is ordinary least squares on Allan variances (S Figure 6): every variance counts by its
size, so the few largest decide, and what is seen in small ones only, at the other taus, is left to
chance. The second, which everyone knows, reads N, B and K off the Allan deviation (S 3.4): on
log-log axes white noise has slope -1/2, flicker 0, random walk +1/2 [IEEE Std 952]:

    AVAR = N^2 / tau + (2 ln 2 / pi) B^2 + K^2 tau / 3

and h_0 = 2 N^2, h_-1 = B^2 / pi, h_-2 = K^2 / (2 pi^2) in one-sided spectra.
"""

from __future__ import annotations

import math

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.fit.allan.annealing import AGREEMENT, NO_MISFIT
from mocap_metrology.noise.fit.allan.relative import checked, misfit
from mocap_metrology.noise.fit.estimates import Coefficient, Components, Estimate
from mocap_metrology.noise.model.components import Form
from mocap_metrology.settings import Annealing

STARTS, STEPS = 10, 300  # random points, and steps of the descent from each at most
# alpha: slope of the deviation, AVAR at tau = 1 s of h = 1
SEGMENTS = {-2: (0.5, 2 * math.pi**2 / 3), -1: (0.0, 2 * math.log(2)), 0: (-0.5, 0.5)}
TOLERANCE = 0.1  # of a slope
DECADES = 0.5  # of tau in a segment
LONGEST_SHARE = 0.3  # of the longest tau: beyond, too few differences are averaged for a slope


def levenberg_marquardt(
    m: np.ndarray,
    avar: np.ndarray,
    frame_rate_hz: float,
    components: Components,
    seed: int,
    form: Form = "continuous",
    search: Annealing | None = None,
    duration: float | None = None,
) -> Estimate:
    """argmin sum_k (avar_k - model_k)^2 over `components`; m, avar, duration: as of
    `relative.misfit`.

    Levenberg-Marquardt in logarithms of the coefficients, within the range `search` (at every tau),
    from ten random points, of which the best result is given. The cost is the sum of squares over
    that of the variances, times their number, so that it has no unit and 1 a point is a model of
    nothing. Standard errors and intervals are NaN. status: `at_bound`, or `not_converged` where no
    two starts ended at one cost.
    """
    every_tau = (search or Annealing()).model_copy(update={"longest_tau_share": 1.0})
    problem = misfit(m, avar, frame_rate_hz, components, form, "equal", every_tau, duration)
    rng = np.random.default_rng(seed)
    ends = [
        problem.polished(rng.uniform(problem.lower, problem.upper), STEPS) for _ in range(STARTS)
    ]
    x, cost = min(ends, key=lambda end: end[1])
    equal = sum(c <= cost + AGREEMENT * cost + NO_MISFIT * problem.m.size for _, c in ends)
    at_bound, otherwise = problem.at_bound(x), "ok" if equal >= 2 else "not_converged"
    coefficients = tuple(
        Coefficient(name, value, status="at_bound" if at_bound[name] else otherwise)
        for name, value in problem.model(x).coefficients().items()
    )
    note = f"{equal} of {STARTS} starts reached the cost of the result"
    return Estimate("levenberg-marquardt", form, coefficients, cost, note)


def slopes(m: np.ndarray, avar: np.ndarray, frame_rate_hz: float) -> Estimate:
    """h_-2, h_-1 and h_0 from Allan variances avar (k,) in mm^2 at tau = m tau0 (s).

    Lines are fitted to log ADEV over every window of half a decade of tau, and over either half of
    it (three points at least each), up to 0.3 of the longest tau. Where all three slopes are within
    0.1 of the noise's, the segment is that noise's (a valley, level on the average, is none); of
    several, the one closest in slope, of equal ones the first. Its coefficient is the mean over the
    segment with the slope held at -1/2, 0 or +1/2; `not_detected` where no segment has the slope.

    Only what dominates somewhere is seen, whatever else there is adds to it, and the flanks of a
    Gauss-Markov bump pass for white noise and random walk: that is this method. No errors. cost:
    sum of squares of log10 ADEV about the lines.
    """
    m, avar = checked(m, avar, frame_rate_hz)
    used = m <= LONGEST_SHARE * m[-1:]
    log_tau, log_adev = np.log10(m[used] * (1 / frame_rate_hz)), 0.5 * np.log10(avar[used])
    windows = _windows(log_tau)
    if not windows:
        raise Refusal(
            f"{log_tau.size} Allan variances up to {LONGEST_SHARE:g} of the longest tau, expected "
            f"more, over at least {DECADES:g} decades of tau"
        )
    fitted = np.array([_slopes(log_tau[w], log_adev[w]) for w in windows])
    coefficients, cost = [], 0.0
    for alpha, (slope, unit) in SEGMENTS.items():
        distance = np.round(np.abs(fitted - slope), 9)  # so that equal slopes are equal
        fits = np.all(distance <= TOLERANCE, axis=1)
        if not fits.any():
            coefficients.append(Coefficient.limit(f"h_{alpha}"))
            continue
        best = windows[np.argmin(np.where(fits, distance[:, 0], np.inf))]
        level = log_adev[best] - slope * log_tau[best]
        cost += float(np.sum((level - level.mean()) ** 2))
        coefficients.append(Coefficient(f"h_{alpha}", float(10 ** (2 * level.mean()) / unit)))
    return Estimate("slopes", "continuous", tuple(coefficients), cost)


def _windows(log_tau: np.ndarray) -> list[slice]:
    """Every run of at least five points that spans `DECADES`, as short as can be."""
    ends = np.searchsorted(log_tau, log_tau + DECADES - 1e-9)
    pairs = [(i, max(int(end) + 1, i + 5)) for i, end in enumerate(ends)]
    return [slice(i, end) for i, end in pairs if end <= log_tau.size]


def _slopes(x: np.ndarray, y: np.ndarray) -> list[float]:
    """Slope of all of it, of the first half and of the second; the middle point is in both."""
    middle, slopes = x.size // 2, []
    for part in (slice(None), slice(middle + 1), slice(middle, None)):
        off = x[part] - x[part].mean()
        slopes.append(float(off @ y[part] / (off @ off)))
    return slopes
