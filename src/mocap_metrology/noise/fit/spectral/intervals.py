"""From a maximum of the likelihood to the lines of noise.csv: errors, intervals, limits."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from mocap_metrology.noise.fit.estimates import (
    CLASSES,
    ONE_SIDED_95,
    Z_68,
    Z_95,
    Coefficient,
    Components,
)
from mocap_metrology.noise.fit.spectral.line import Line, line_errors
from mocap_metrology.noise.fit.spectral.lines import threshold
from mocap_metrology.noise.fit.spectral.periodogram import Periodogram, gauss_markov_unit
from mocap_metrology.noise.fit.spectral.rivals import Rival, widened
from mocap_metrology.noise.fit.spectral.whittle import Fit, Likelihood, model_of, standard_errors
from mocap_metrology.noise.model.components import ALPHAS, Sinusoid

LINE_FROM_HZ = 1.0  # a limit on lines is given from here up: below, the noise rises and so does it
GONE_RELATIVE_ERROR = 3.0  # standard error over value from which a term is not there
LIMIT_TOLERANCE = 3e-3  # of twice the log likelihood: a thousandth of the fall at a limit
DOUBLINGS = 40  # of a first guess of a limit
PLACES = 8  # values of T_c in a class a limit is computed for


def coefficients(
    data: Periodogram,
    fit: Fit,
    line: Line | None,
    components: Components | None,
    most_terms: int,
    wants_line: bool,
    near: Sequence[Rival] = (),
    cost: Callable[[int], float] = lambda p: 0.0,
) -> tuple[Coefficient, ...]:
    """Every coefficient with its error and intervals; limits for what is not there.

    Intervals: q_c, T_c, A_s log-normal, as they are positive scales; h normal below, from 0 up,
    and log-normal above. Where the relative error exceeds 0.3 (T_c of a tenth of the recording),
    95 % ones hold in some 90 %.
    near: `rivals` of the fit, whose intervals theirs are joined with; cost: of p parameters by the
    criterion that chose the fit (`order.penalty`), which limits must know (`upper_limit`).
    """
    likelihood = Likelihood(data)
    complete = Likelihood(replace(data, weight=data.bins.n.astype(float)))
    spectrum, rows = fit.spectrum, []
    error = standard_errors(fit.information, spectrum)
    bound = standard_errors(complete.information(spectrum), spectrum)
    status = dict.fromkeys(error, "ok" if fit.converged else "not_converged")
    at = np.isclose(spectrum.T_c[:, None], likelihood.bounds).any(axis=1)
    status |= {f"T_c{k + 1}": "at_bound" for k in np.flatnonzero(at)}
    for alpha in components.alphas if components else ALPHAS:
        name = f"h_{alpha}"
        if (h := spectrum.h.get(alpha, 0.0)) > 0:
            rows.append(_law(name, h, error[name], bound[name], status[name]))
        else:
            upper = law_limit(likelihood, fit, alpha, cost(1))
            rows.append(Coefficient.limit(name, upper))
    for k, (q2, T_c) in enumerate(zip(spectrum.q2, spectrum.T_c, strict=True), start=1):
        gone = error[f"q_c{k}"] > GONE_RELATIVE_ERROR * math.sqrt(q2)
        for name, value in ((f"q_c{k}", math.sqrt(q2)), (f"T_c{k}", float(T_c))):
            # With the number of terms given, one that is not there ends anywhere
            gone_row = Coefficient.limit(name, note="no such term was detected")
            row = _positive(name, value, error[name], bound[name], status[name])
            rows.append(gone_row if gone else row)
    rows = list(widened(rows, fit, near, likelihood.bounds[1]))
    if components is None and len(spectrum.T_c) < most_terms:
        rows += _class_limits(likelihood, fit, most_terms, cost(2))
    if wants_line:
        rows += _line_rows(line, likelihood, fit)
    return tuple(rows)


def _interval(end: Callable[[float], float]) -> dict[str, Any]:
    """Ends of the intervals at 68 and 95 %, by standard errors from the value."""
    both = (("lower", -1), ("upper", 1))
    levels = ((68, Z_68), (95, Z_95))
    return {f"{name}_{level}": end(sign * z) for level, z in levels for name, sign in both}


def _ends(value: float, error: float) -> dict[str, Any]:
    """Ends of the normal intervals, not below 0."""
    return _interval(lambda z: max(value + z * error, 0.0))


def _positive(
    name: str, value: float, error: float, bound: float, status: str = "ok"
) -> Coefficient:
    """A scale, with log-normal intervals."""
    ends = _interval(lambda z: value * math.exp(min(z * (error / value), 700.0)))
    return Coefficient(name, value, error, bound, **ends, status=status)


def _law(name: str, value: float, error: float, bound: float, status: str) -> Coefficient:
    """h: its error grows with it, so one that came out low has too small an error, and the upper
    end is the log-normal one; the lower is the normal one, which reaches zero."""
    normal, log = _ends(value, error), _positive(name, value, error, bound, status)
    return replace(log, lower_68=normal["lower_68"], lower_95=normal["lower_95"])


def _one_step(likelihood: Likelihood, fit: Fit, column: np.ndarray) -> tuple[float, float]:
    """Coefficient of a further spectrum `column` (B,) by one scoring step from 0, the others
    refitted, and its standard error."""
    density, columns = likelihood.jacobian(fit.spectrum)
    root = np.sqrt(likelihood.weight / 2)
    used = columns[:, np.abs(columns).max(axis=0) > 0] / density[:, None] * root[:, None]
    basis, _ = np.linalg.qr(used)
    whitened = column / density * root
    left = whitened - basis @ (basis.T @ whitened)
    information = left @ left
    if information < 1e-12 * (whitened @ whitened):
        return 0.0, math.inf
    rest = root * (likelihood.psd / density - 1)
    return max(left @ rest / information, 0.0), 1 / math.sqrt(information)


def upper_limit(likelihood: Likelihood, fit: Fit, column: np.ndarray, price: float) -> float:
    """Upper 95 % limit of the coefficient of a further spectrum `column` (B,), >= 0.

    Profile likelihood: the value at which twice the log likelihood, all else refitted, has fallen
    by 1.645^2 + price from its maximum (one-sided). price: what the component would have had to
    gain to be taken in. Without it the limit holds on average over all recordings, but not of those
    in which the component was missed: there its estimate is low by chance. A scoring step would do
    if the fit without the component had the right weights, which it has not where the component
    would stand out.
    """
    from scipy.optimize import brentq

    most = ONE_SIDED_95**2 + price
    estimate, error = _one_step(likelihood, fit, column)
    if not math.isfinite(error):
        return math.inf

    def deviance(value: float) -> float:
        return likelihood.fit(fit.spectrum, value * column, LIMIT_TOLERANCE).deviance

    # (deviance, value) of the lowest point seen: the maximum of the likelihood, near enough
    best = min((fit.deviance, 0.0), (deviance(estimate), estimate))
    high = estimate + math.sqrt(most) * error
    for _ in range(DOUBLINGS):
        reached = deviance(high)
        if reached > best[0] + most:
            break
        best, high = min(best, (reached, high)), 2 * high
    else:
        return math.inf  # something else gives way to it: the spectrum does not limit it
    fall = best[0] + most
    return float(
        brentq(lambda value: deviance(value) - fall, best[1], high, rtol=0.01, xtol=1e-300)
    )


def law_limit(likelihood: Likelihood, fit: Fit, alpha: int, price: float) -> float:
    """`upper_limit` of h_alpha."""
    others = {a: h for a, h in fit.spectrum.h.items() if a != alpha}
    alone = replace(fit, spectrum=replace(fit.spectrum, h=others))
    return upper_limit(likelihood, alone, likelihood.laws[alpha], price)


def _class_limits(likelihood: Likelihood, fit: Fit, most: int, price: float) -> list[Coefficient]:
    """Limits of q_c of a further term in each class of S 4.6 that has none; the greatest over the
    class, so they hold for every T_c in it."""
    rows, number = [], len(fit.spectrum.T_c)
    for name, low, high in CLASSES:
        low, high = max(low, likelihood.bounds[0]), min(high, likelihood.bounds[1])
        taken = any(low <= T_c < high for T_c in fit.spectrum.T_c)
        if taken or high <= low or number == most:
            continue
        number += 1
        units = [gauss_markov_unit(likelihood.bins, T) for T in np.geomspace(low, high, PLACES)]
        worst = max(units, key=lambda unit: sum(_one_step(likelihood, fit, unit)))
        upper = math.sqrt(upper_limit(likelihood, fit, worst, price))
        note = f"class {name}: limit for every T_c from {low:.3g} to {high:.3g} s"
        rows.append(Coefficient.limit(f"q_c{number}", upper, note))
    return rows


def _line_rows(line: Line | None, likelihood: Likelihood, fit: Fit) -> list[Coefficient]:
    bins, duration = likelihood.bins, likelihood.bins.span_s
    if line is not None:
        tau0 = 1 / bins.frame_rate_hz
        frequency = np.array([min(line.f_0, 0.5 / tau0)])
        psd = float(model_of(fit.spectrum, bins.form).psd(frequency, bins.frame_rate_hz)[0])
        bounds = line_errors(line.A_s, psd, duration)
        share = float(likelihood.weight.sum() / bins.n.sum())
        errors = [error / math.sqrt(share) for error in line.errors(duration, psd)]
        # By averages over a frame
        left = Sinusoid(1.0, line.f_0).recorded(bins.frame_rate_hz, bins.form)
        rows = [
            _positive("A_s", line.A_s / left, errors[0] / left, bounds[0] / left),
            Coefficient("f_0", line.f_0, errors[1], bounds[1], **_ends(line.f_0, errors[1])),
        ]
        if line.wide:
            rows.append(_positive("width_f", line.width_f, line.width_error, math.nan))
        return rows
    from_hz = min(max(LINE_FROM_HZ, 12 / duration), bins.centre_hz.max())
    psd = float(likelihood.density(fit.spectrum)[bins.centre_hz >= from_hz].max())
    # gain = A^2 T / S must exceed the threshold; its root has unit variance
    root = math.sqrt(threshold(int(bins.n.sum()))) + ONE_SIDED_95
    note = f"a line of this size, from {from_hz:.3g} Hz up, is detected in 95 of 100 recordings"
    upper = root * math.sqrt(psd / duration)
    return [Coefficient.limit("A_s", upper, note), Coefficient.limit("f_0")]
