"""Noise coefficients from Allan variances, weighted by their full covariance (generalised least
squares), with the noise model of frames that are points, or averages over the frame period.

Overlapping Allan variances at neighbouring tau are almost copies of each other, so the fit that
counts each as new data says too much, and the fit that weighs them by relative residuals (S Eq. 13)
misses the information in differences between neighbours. Here C = Cov[AVAR_a, AVAR_b] of the fitted
model (`avar_covariance`) weighs them: minimised is r^T C^-1 r, r = observed - model. With all
integers m up to ten and sixteen a decade beyond, (J^T C^-1 J)^-1, J over all coefficients, is then
the Cramer-Rao bound to 2 %, ridge included: no information is left in the series.

The model inside C comes from a first fit with weights edf / 2 on relative residuals, and C is then
held fixed within a fit, so that long tau, which scatter by their own size, do not drag the model
down to the lowest of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypedDict

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.fit.allan import separable
from mocap_metrology.noise.fit.allan.separable import Fit, Problem
from mocap_metrology.noise.fit.allan.weighted_report import Found, coefficients
from mocap_metrology.noise.fit.allan.whitening import (
    Curves,
    Whitened,
    model_curve,
    unit_curves,
    whitened,
    whitened_by,
    whitening_matrix,
)
from mocap_metrology.noise.fit.estimates import Components, Estimate
from mocap_metrology.noise.model.components import (
    ALPHAS,
    Component,
    Form,
    GaussMarkov,
    NoiseModel,
    PowerLaw,
    Sinusoid,
)


class Settings(TypedDict, total=False):
    """criterion: `bic` or `aicc`; max_gauss_markov: most terms, and sinusoid: whether one, is tried
    when the components are not given; ridge: share of its own variance by which each Allan variance
    is doubted beyond C (0.01 costs 1-3 % of standard error, and a curve that no model fits exactly
    is then not fitted to the fifth digit); passes: how often C is renewed from the fit."""

    criterion: str
    max_gauss_markov: int
    sinusoid: bool
    ridge: float
    passes: int


SETTINGS: Settings = {
    "criterion": "bic",
    "max_gauss_markov": 4,
    "sinusoid": True,
    "ridge": 0.01,
    "passes": 2,
}
AT_BOUND_PAYS = 6.0  # 95 % of chi-squared with the two degrees of freedom of a term
NOTICED = 0.05  # share of the Allan variance from which a component changes its covariance


def weighted(
    m: np.ndarray,
    avar: np.ndarray,
    edf: np.ndarray,
    n: int,
    frame_rate_hz: float,
    components: Components | None = None,
    settings: Settings | None = None,
    form: Form = "sampled",
) -> Estimate:
    """Coefficients of one series of n samples from its overlapping Allan variances.

    m: (k,) averaging factors; avar: (k,) mm^2; edf: (k,) degrees of freedom, which lower the
    weights where they are fewer than n samples without gaps would have. `components`: what is
    fitted; None: chosen by the criterion from all power laws, 0 to 4 Gauss-Markov terms and a
    sinusoid. `settings`: see SETTINGS. `form`: of the frames (`model`). The same data give
    the same numbers; there is no start to choose. Refuses arrays of unequal length, values that
    are not positive numbers, and fewer variances than coefficients.
    """
    options = _options(settings)
    m, avar, edf = _checked(m, avar, edf, n, frame_rate_hz, components)
    curves = unit_curves(m.tobytes(), int(n), float(frame_rate_hz), form)
    alphas = ALPHAS if components is None else tuple(sorted(components.alphas))
    white = _pilot(curves, avar, edf, alphas, options)
    if components is None:
        alphas, fit = _chosen(white, curves, options)
    else:
        fit = _known(white, curves, components)
    for _ in range(options["passes"]):
        model = _model(alphas, fit, form)
        if not model.broadband:
            break
        white = whitened(curves, avar, edf, model, alphas, options["ridge"])
        fit = separable.polish(white.problem, fit.log_T, fit.log_f)
    if components is None:
        most = options["max_gauss_markov"]
        components = Components(ALPHAS, min(fit.log_T.size + 1, most), options["sinusoid"])
    power = dict(zip(ALPHAS, (white.matrix @ curves.power).T, strict=True))
    tones = white.matrix @ curves.tones
    again = _again(white, curves, edf, _model(alphas, fit, form), options["ridge"])
    found = Found(
        alphas,
        fit,
        power,
        curves.log_T,
        white.problem.table,
        curves.log_f,
        tones,
        again,
        _ceiling(curves, avar, edf),
    )
    parts, note = coefficients(found, components)
    return Estimate("weighted", form, parts, fit.cost, note)


def _again(
    white: Whitened,
    curves: Curves,
    edf: np.ndarray,
    model: NoiseModel,
    ridge: float,
) -> Callable[[Component], np.ndarray | None]:
    """See `Found.again`."""
    base, back = model_curve(curves, model), np.linalg.inv(white.matrix)

    def again(component: Component) -> np.ndarray | None:
        if np.all(model_curve(curves, NoiseModel((component,))) <= NOTICED * base):
            return None
        joined = replace(model, components=(*model.components, component))
        return whitening_matrix(curves, edf, joined, ridge) @ back

    return again


def _ceiling(curves: Curves, avar: np.ndarray, edf: np.ndarray) -> Callable[[Component], float]:
    """See `Found.ceiling`: edf * estimate / truth is chi-squared with edf degrees."""

    def ceiling(unit: Component) -> float:
        from scipy.special import chdtri

        with np.errstate(divide="ignore"):
            top = avar * edf / chdtri(edf, 0.99) / model_curve(curves, NoiseModel((unit,)))
        return float(np.min(top))

    return ceiling


def _pilot(
    curves: Curves,
    avar: np.ndarray,
    edf: np.ndarray,
    alphas: tuple[int, ...],
    options: Settings,
) -> Whitened:
    """The problem with the covariance of a model of as many terms as the data like: first without
    correlations and relative to the data, then twice with the covariance of the fit before."""
    white = whitened_by(np.diag(np.sqrt(edf / 2) / avar), curves, avar, alphas, avar)
    for _ in range(2):
        model = _model(alphas, separable.dictionary(white.problem), curves.form)
        white = whitened(curves, avar, edf, model, alphas, options["ridge"])
    return white


def _model(alphas: tuple[int, ...], fit: Fit, form: Form) -> NoiseModel:
    a, size = fit.amplitudes, len(alphas)
    parts: list[Component] = [
        PowerLaw(alpha, float(h)) for alpha, h in zip(alphas, a, strict=False) if h > 0
    ]
    terms = zip(a[size:], fit.log_T, strict=False)
    parts += [GaussMarkov(float(np.sqrt(p)), float(np.exp(x))) for p, x in terms]
    if fit.log_f is not None and a[-1] > 0:
        parts.append(Sinusoid(float(np.sqrt(a[-1])), float(np.exp(fit.log_f))))
    return NoiseModel(tuple(parts), form)


def _only(problem: Problem, alphas: tuple[int, ...]) -> Problem:
    """A problem with all power laws, reduced to some."""
    return replace(problem, fixed=problem.fixed[:, [ALPHAS.index(alpha) for alpha in alphas]])


def _known(white: Whitened, curves: Curves, components: Components) -> Fit:
    problem, most = white.problem, components.gauss_markov
    fit = _resolved(problem, separable.path(problem, most))
    if not components.sinusoid:
        return fit
    # The terms may have replaced the line: they are searched again beside it, and it once more
    tones = white.matrix @ curves.tones
    first = separable.with_line(problem, fit, curves.log_f, tones)
    if first is None:
        return fit
    fit = _resolved(problem, separable.path(problem, most, first.log_f))
    again = separable.with_line(problem, fit, curves.log_f, tones)
    return min((f for f in (fit, first, again) if f is not None), key=lambda f: f.cost)


def _resolved(problem: Problem, fits: list[Fit]) -> Fit:
    """The last of fits with 0, 1, ... terms, less terms that end on a bound of T_c, where they are
    white noise or random walk under another name, and gain less than AT_BOUND_PAYS."""
    while len(fits) > 1:
        ends = np.isin(fits[-1].log_T, problem.log_T[[0, -1]])
        if not ends.any() or fits[-2].cost - fits[-1].cost > AT_BOUND_PAYS:
            break
        fits = fits[:-1]
    return fits[-1]


def _chosen(white: Whitened, curves: Curves, options: Settings) -> tuple[tuple[int, ...], Fit]:
    """Power laws and fit of least cost plus price."""
    price = 2.0 if options["criterion"] == "aicc" else float(np.log(white.n_effective))
    problem = white.problem
    # As many as the data could resolve, beside five power laws and a sinusoid
    most = max(min(options["max_gauss_markov"], (problem.target.size - 7) // 2), 0)
    best = _cheapest(problem, separable.path(problem, most), price)
    if not options["sinusoid"]:
        return best
    tones = white.matrix @ curves.tones
    line = separable.with_line(_only(problem, best[0]), best[1], curves.log_f, tones)
    if line is not None and line.cost + 2 * price < best[1].cost:
        # The terms may have replaced the line
        again = _cheapest(problem, separable.path(problem, most, line.log_f), price)
        choices = [best, (best[0], line), again]
        best = min(choices, key=lambda choice: choice[1].cost + _price(choice[1], price))
    return best


def _price(fit: Fit, price: float) -> float:
    return price * (np.count_nonzero(fit.amplitudes > 0) + fit.shapes.size)


def _cheapest(problem: Problem, fits: list[Fit], price: float) -> tuple[tuple[int, ...], Fit]:
    """Least cost plus price over numbers of terms, each after power laws that do not pay are gone.
    A term whose T_c is an end of the range is not resolved and does not count as found."""
    low, high = problem.log_T[[0, -1]]
    choices = []
    for fit in fits:
        alphas, left = _pay(problem, fit, price)
        resolved = np.all((left.log_T > low) & (left.log_T < high))
        choices.append((not resolved, left.cost + _price(left, price), alphas, left))
    return min(choices, key=lambda choice: choice[:2])[2:]


def _pay(problem: Problem, fit: Fit, price: float) -> tuple[tuple[int, ...], Fit]:
    """Without the power laws that lower the cost by less than `price`, least first."""
    alphas = tuple(a for a, h in zip(ALPHAS, fit.amplitudes, strict=False) if h > 0)
    fit = separable.solved(_only(problem, alphas), fit.log_T, fit.log_f)
    while len(alphas) > (not fit.shapes.size):
        rests = [tuple(a for a in alphas if a != alpha) for alpha in alphas]
        costs = [separable.solved(_only(problem, r), fit.log_T, fit.log_f).cost for r in rests]
        rest = rests[int(np.argmin(costs))]
        least = separable.polish(_only(problem, rest), fit.log_T, fit.log_f, rough=True)
        if least.cost - fit.cost >= price:
            break
        alphas, fit = rest, least
    return alphas, fit


def _options(settings: Settings | None) -> Settings:
    options: Settings = {**SETTINGS, **(settings or {})}
    unknown = sorted(set(options) - set(SETTINGS))
    if unknown:
        raise Refusal(f"weighted fit: setting {unknown[0]!r}, expected {', '.join(SETTINGS)}")
    if options["criterion"] not in ("bic", "aicc"):
        raise Refusal(f"weighted fit: criterion {options['criterion']!r}, expected bic or aicc")
    return options


def _checked(
    m: np.ndarray,
    avar: np.ndarray,
    edf: np.ndarray,
    n: int,
    frame_rate_hz: float,
    components: Components | None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    m, avar, edf = (np.atleast_1d(np.asarray(x, float)) for x in (m, avar, edf))
    if not m.shape == avar.shape == edf.shape or m.ndim != 1:
        raise Refusal(
            f"weighted fit: {m.size} averaging factors, {avar.size} Allan variances and "
            f"{edf.size} degrees of freedom, expected as many of each"
        )
    for name, values in (("Allan variance", avar), ("degrees of freedom", edf)):
        wrong = np.flatnonzero(~(np.isfinite(values) & (values > 0)))
        if wrong.size:
            raise Refusal(
                f"weighted fit: {name} {values[wrong[0]]} at m = {m[wrong[0]]:g}, "
                "expected a number > 0"
            )
    if not (np.all(m == np.rint(m)) and np.all(m >= 1) and np.all(np.diff(m) > 0)):
        raise Refusal("weighted fit: averaging factors, expected rising whole numbers >= 1")
    if m.size and 2 * m[-1] > n:
        raise Refusal(f"weighted fit: m = {m[-1]:g} of {n} samples, expected at most half of them")
    if not (np.isfinite(frame_rate_hz) and frame_rate_hz > 0):
        raise Refusal(f"weighted fit: frame rate {frame_rate_hz} Hz, expected a number > 0")
    if components is not None and not (components.alphas or components.gauss_markov):
        raise Refusal("weighted fit: no noise to fit, expected a power law or a Gauss-Markov term")
    needed = 2 if components is None else max(len(components.names), 1)
    if m.size < needed:
        raise Refusal(
            f"weighted fit: {m.size} Allan variances for {needed} coefficients, "
            "expected at least as many"
        )
    return m.astype(np.int64), avar, edf
