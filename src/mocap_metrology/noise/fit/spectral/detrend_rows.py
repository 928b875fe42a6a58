"""The lines `drift`, `A_w` and `T_w` of noise.csv, from the alternatives that were compared.

An interval is that of a mixture: every alternative with its weight exp(-score/2) [Buckland et al.
1997], in it every kind of slow noise that the data allow, and T_w over its likelihood. Where noise
alone explains the data about as well, the mixture holds zero, and so does the interval.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from mocap_metrology.noise.fit.estimates import Coefficient
from mocap_metrology.noise.fit.spectral.detrend import (
    KINDS,
    Alternative,
    Designs,
    Part,
    slow_weight,
)
from mocap_metrology.noise.fit.spectral.whittle import Likelihood
from mocap_metrology.noise.model.deterministic import PARAMETERS

SLOW_LAWS = (-2, -1)  # noise that a deterministic part competes with
PRICE = 2.0  # of a parameter of the noise, in twice the log likelihood [Akaike 1974]
LEAST_WEIGHT = 1e-4
REACH = 6.0  # standard errors of ln T_w to either side that are gone over
PLACES = 41  # T_w there
QUANTILES = {"lower_68": 0.16, "upper_68": 0.84, "lower_95": 0.025, "upper_95": 0.975}
LONGEST = 0.5  # T_w, of the recording, up to which a limit of A_w is given
AT_BOUND = 1e-2  # of ln T_w
WIDEST = 10.0  # standard error of ln T_w
ABSENT = 0.01  # standard error, of the one there is, given to a parameter that is zero
Row = tuple[float, np.ndarray, np.ndarray]


def quantile(rows: Sequence[tuple[float, float, float]], p: float) -> float:
    """Value below which the share p of a mixture of normal distributions lies; rows: share, mean
    and standard deviation of each."""
    from scipy.optimize import brentq
    from scipy.special import ndtr

    weight, mean, sd = np.array(rows).T
    weight, sd = weight / weight.sum(), np.maximum(sd, 1e-300)
    low, high = float((mean - 9 * sd).min()), float((mean + 9 * sd).max())
    return float(brentq(lambda x: weight @ ndtr((x - mean) / sd) - p, low, high))


def deterministic_rows(alternatives: Sequence[Alternative]) -> tuple[Coefficient, ...]:
    """drift, A_w and T_w: value, errors and intervals, or limits. alternatives: the best first."""
    best = alternatives[0]
    designs = Designs(best.data)
    noises = _weights_of(best)
    mixture = []
    for one in alternatives:
        share = math.exp((best.score - one.score) / 2)
        if share > LEAST_WEIGHT:
            weights = noises if one is best else _weights_of(one)
            mixture.append((share, one.part.names, list(_distributions(one, weights, designs))))
    limits = {"drift": _drift_limit, "A_w": _warm_up_limit}
    rows = []
    for name in PARAMETERS:
        if name in best.part.names:
            rows.append(_detected(name, best, mixture, designs))
        elif name in limits:  # of its size, given the rest of the best alternative
            wanted = {*best.part.names, name} | ({"T_w"} if name == "A_w" else set())
            kind = next(kind for kind, names in KINDS.items() if set(names) == wanted)
            rows.append(limits[name](kind, noises, designs))
        else:
            rows.append(Coefficient.limit(name))
    return tuple(rows)


def _weights_of(one: Alternative) -> list[tuple[float, np.ndarray]]:
    """Kinds of noise round a deterministic part, its fit, and slow noise more: the share of each,
    and the weights of the slow coefficients that it gives."""
    likelihood = Likelihood(one.data)
    fits = [one.fit]
    for alpha in SLOW_LAWS:
        if not one.fit.spectrum.h.get(alpha, 0.0) > 0:
            start = 0.1 * float(np.min(one.data.psd / likelihood.laws[alpha]))
            h = {**one.fit.spectrum.h, alpha: start}
            fits.append(likelihood.fit(replace(one.fit.spectrum, h=h)))
    scores = [fit.deviance + PRICE * fit.spectrum.size for fit in fits]
    shares = [math.exp((min(scores) - score) / 2) for score in scores]
    weights = [slow_weight(one.data, likelihood.density(fit.spectrum)) for fit in fits]
    return list(zip(shares, weights, strict=True))


def _detected(
    name: str,
    best: Alternative,
    mixture: Sequence[tuple[float, tuple[str, ...], list[Row]]],
    designs: Designs,
) -> Coefficient:
    """mixture: share, names and distributions of every alternative."""
    values, place = best.part.values, best.part.names.index(name)
    value = getattr(values, name)
    size = values.T_w if name == "T_w" else 1.0
    error = size * math.sqrt(best.part.covariance[place, place])
    density = Likelihood(best.data).density(best.fit.spectrum)
    whole = designs.derivatives(best.part.kind, values) / np.sqrt(density)[designs.slow.bin]
    bound = size * math.sqrt(np.linalg.pinv(whole @ whole.T, hermitian=True)[place, place])
    rows = []
    for likely, names, distributions in mixture:
        if name in names:
            at = names.index(name)
            rows += [(likely * share, mean[at], sd[at]) for share, mean, sd in distributions]
        elif name != "T_w":
            rows.append((likely, 0.0, ABSENT * error))
    ends: dict[str, Any] = {end: quantile(rows, p) for end, p in QUANTILES.items()}
    status = "ok"
    if name == "T_w":
        ends = {end: math.exp(v) for end, v in ends.items()}
        at_end = np.min(np.abs(np.log(value / np.array(designs.bounds)))) < AT_BOUND
        status = "at_bound" if at_end else "ok"
    return Coefficient(name, value, error, bound, **ends, status=status)


def _distributions(
    one: Alternative, noises: Sequence[tuple[float, np.ndarray]], designs: Designs
) -> Iterator[Row]:
    """Share (they add up to 1), means and standard deviations of the parameters (ln T_w in place
    of T_w) of one alternative, over the kinds of noise round it and over T_w."""
    kind, total = one.part.kind, sum(share for share, _ in noises)
    for likely, weight in noises if one.part.names else ():
        part = designs.part(kind, weight)
        if kind == "line":
            yield likely / total, np.array([part.values.drift]), np.sqrt(np.diag(part.covariance))
            continue
        logs, shares, step = _places(part, designs, weight)
        fits = designs.linear(kind, weight, np.exp(logs))
        for k, log in enumerate(logs):
            sd = np.append(np.sqrt(np.diag(fits.covariance[k])), step / 2)
            yield likely / total * shares[k], np.append(fits.values[k], log), sd


def _places(
    part: Part, designs: Designs, weight: np.ndarray
) -> tuple[np.ndarray, np.ndarray, float]:
    """ln T_w round its estimate, the likelihood of each, and how far they are apart."""
    spread = min(math.sqrt(part.covariance[-1, -1]), WIDEST)
    middle, low, high = (math.log(T) for T in (part.values.T_w, *designs.bounds))
    ends = max(middle - REACH * spread, low), min(middle + REACH * spread, high)
    logs = np.linspace(*ends, PLACES)
    gains = designs.linear(part.kind, weight, np.exp(logs)).gain
    shares = np.exp((gains - gains.max()) / 2)
    keep = shares > LEAST_WEIGHT
    return logs[keep], shares[keep] / shares[keep].sum(), (ends[1] - ends[0]) / (PLACES - 1)


def _drift_limit(
    kind: str, noises: Sequence[tuple[float, np.ndarray]], designs: Designs
) -> Coefficient:
    rows = []
    for share, weight in noises:
        part = designs.part(kind, weight)
        rows.append((share, abs(part.values.drift), math.sqrt(part.covariance[0, 0])))
    return Coefficient.limit("drift", quantile(rows, 0.95))


def _warm_up_limit(
    kind: str, noises: Sequence[tuple[float, np.ndarray]], designs: Designs
) -> Coefficient:
    longest = LONGEST * designs.bounds[1]
    fits = [(share, designs.over_grid(kind, weight)) for share, weight in noises]
    limits = []
    for k in np.flatnonzero(designs.grid <= longest):
        rows = [
            (share, abs(float(fit.values[k, -1])), math.sqrt(fit.covariance[k, -1, -1]))
            for share, fit in fits
        ]
        limits.append(quantile(rows, 0.95))
    note = f"limit for every T_w from {designs.bounds[0]:.3g} to {longest:.3g} s"
    return Coefficient.limit("A_w", max(limits, default=math.nan), note)
