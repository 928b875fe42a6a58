"""The lines `drift`, `A_w` and `T_w` of noise.csv, from the alternatives that were compared.

An interval is that of a mixture: every alternative with its weight exp(-score/2) [Buckland et al.
1997], in it every kind of slow noise that the data allow, and T_w over its likelihood. Where noise
alone explains the data about as well, the mixture holds zero, and so does the interval.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mocap_metrology.noise.fit.estimates import Coefficient
from mocap_metrology.noise.fit.spectral.detrend import (
    KINDS,
    Alternative,
    Designs,
    Part,
    slow_of,
    slow_weight,
)
from mocap_metrology.noise.fit.spectral.whittle import Fit, Likelihood
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


@dataclass(frozen=True)
class Mixture:
    """Normal distributions: weight, mean and standard deviation, (k,) each."""

    weight: np.ndarray
    mean: np.ndarray
    sd: np.ndarray

    @classmethod
    def of(cls, rows: Sequence[tuple[float, float, float]]) -> Mixture:
        """From (weight, mean, standard deviation)."""
        weight, mean, sd = (np.array(column) for column in zip(*rows, strict=True))
        return cls(weight / weight.sum(), mean, np.maximum(sd, 1e-300))

    def quantile(self, p: float) -> float:
        """Value below which the share p lies."""
        from scipy.optimize import brentq
        from scipy.special import ndtr

        low, high = float((self.mean - 9 * self.sd).min()), float((self.mean + 9 * self.sd).max())
        return float(brentq(lambda x: self.weight @ ndtr((x - self.mean) / self.sd) - p, low, high))


def deterministic_rows(
    alternatives: Sequence[Alternative], frame_rate_hz: float
) -> tuple[Coefficient, ...]:
    """drift, A_w and T_w: value, errors and intervals, or limits. alternatives: the best first."""
    best = alternatives[0]
    designs = Designs(slow_of(best.data), frame_rate_hz)
    likely = [math.exp((best.score - one.score) / 2) for one in alternatives]
    kept = [(w, one) for w, one in zip(likely, alternatives, strict=True) if w > LEAST_WEIGHT]
    own = [(w, one.part.names, list(_distributions(one, designs))) for w, one in kept]
    rows = []
    for name in PARAMETERS:
        if name in best.part.names:
            rows.append(_found(name, best, own, designs))
        else:
            rows.append(_limit(name, best, designs))
    return tuple(rows)


def rival_noises(one: Alternative) -> list[tuple[Fit, float]]:
    """Kinds of noise round a deterministic part, with weights: its fit, and slow noise more."""
    likelihood = Likelihood(one.data, one.data.bins.T_c_range)
    fits = [one.fit]
    for alpha in SLOW_LAWS:
        if one.fit.spectrum.h.get(alpha, 0.0) > 0:
            continue
        start = 0.1 * float(np.min(one.data.psd / likelihood.laws[alpha]))
        h = {**one.fit.spectrum.h, alpha: start}
        fits.append(likelihood.fit(replace(one.fit.spectrum, h=h)))
    scores = [fit.deviance + PRICE * fit.spectrum.size for fit in fits]
    least = min(scores)
    return [(fit, math.exp((least - s) / 2)) for fit, s in zip(fits, scores, strict=True)]


def _density(one: Alternative, fit: Fit) -> np.ndarray:
    return Likelihood(one.data, one.data.bins.T_c_range).density(fit.spectrum)


def _found(
    name: str,
    best: Alternative,
    own: Sequence[tuple[float, tuple[str, ...], list[Row]]],
    designs: Designs,
) -> Coefficient:
    """own: weight, names and distributions of every alternative."""
    values, place = best.part.values, best.part.names.index(name)
    value = getattr(values, name)
    size = values.T_w if name == "T_w" else 1.0
    error = size * math.sqrt(best.part.covariance[place, place])
    whole = designs.of(best.part) / np.sqrt(_density(best, best.fit))[slow_of(best.data).bin]
    bound = size * math.sqrt(np.linalg.pinv(whole @ whole.T, hermitian=True)[place, place])
    rows = []
    for likely, names, found in own:
        if name in names:
            at = names.index(name)
            rows += [(likely * share, mean[at], sd[at]) for share, mean, sd in found]
        elif name != "T_w":
            rows.append((likely, 0.0, ABSENT * error))
    mixture = Mixture.of(rows)
    ends = {end: mixture.quantile(p) for end, p in QUANTILES.items()}
    if name == "T_w":
        ends = {end: math.exp(v) for end, v in ends.items()}
    at_end = name == "T_w" and np.min(np.abs(np.log(value / np.array(designs.bounds)))) < AT_BOUND
    status = "at_bound" if at_end else "ok"
    return Coefficient(
        name,
        value,
        error,
        bound,
        ends["lower_68"],
        ends["upper_68"],
        ends["lower_95"],
        ends["upper_95"],
        status=status,
    )


def _distributions(one: Alternative, designs: Designs) -> Iterator[Row]:
    """Weight (they add up to 1), means and standard deviations of the parameters (ln T_w in place
    of T_w) of one alternative, over the kinds of noise round it and over T_w."""
    noises = rival_noises(one) if one.part.names else []
    total = sum(likely for _, likely in noises)
    for fit, likely in noises:
        weight = slow_weight(one.data, _density(one, fit))
        part = designs.part(one.part.kind, weight)
        if one.part.kind == "line":
            yield likely / total, np.array([part.values.drift]), np.sqrt(np.diag(part.covariance))
            continue
        logs, shares, step = _places(part, designs, weight)
        for log, share in zip(logs, shares, strict=True):
            mean, variance = designs.linear(one.part.kind, weight, math.exp(log))
            sd = np.append(np.sqrt(np.diag(variance)), step / 2)
            yield likely / total * share, np.append(mean, log), sd


def _places(
    part: Part, designs: Designs, weight: np.ndarray
) -> tuple[np.ndarray, np.ndarray, float]:
    """ln T_w round its estimate, the likelihood of each, and how far they are apart."""
    spread = min(math.sqrt(part.covariance[-1, -1]), WIDEST)
    middle, low, high = (math.log(T) for T in (part.values.T_w, *designs.bounds))
    ends = max(middle - REACH * spread, low), min(middle + REACH * spread, high)
    logs = np.linspace(*ends, PLACES)
    gains = np.array([designs.gain(part.kind, weight, math.exp(log)) for log in logs])
    shares = np.exp((gains - gains.max()) / 2)
    keep = shares > LEAST_WEIGHT
    return logs[keep], shares[keep] / shares[keep].sum(), (ends[1] - ends[0]) / (PLACES - 1)


def _limit(name: str, best: Alternative, designs: Designs) -> Coefficient:
    """Of what was not detected: 95 % limit of its size, given the rest of the best alternative."""
    upper, note = math.nan, ""
    if name == "drift":
        upper = _drift_limit(best, designs)
    elif name == "A_w":
        upper = _warm_up_limit(best, designs)
        note = f"limit for every T_w from {designs.bounds[0]:.3g} to "
        note += f"{LONGEST * designs.bounds[1]:.3g} s"
    return Coefficient(
        name, math.nan, upper_95=upper, detected=False, status="not_detected", note=note
    )


def _kind_with(best: Alternative, name: str) -> str:
    wanted = {*best.part.names, name} | ({"T_w"} if name == "A_w" else set())
    return next(kind for kind, names in KINDS.items() if set(names) == wanted)


def _drift_limit(best: Alternative, designs: Designs) -> float:
    kind = _kind_with(best, "drift")
    rows = []
    for fit, likely in rival_noises(best):
        weight = slow_weight(best.data, _density(best, fit))
        part = designs.part(kind, weight)
        rows.append((likely, abs(part.values.drift), math.sqrt(part.covariance[0, 0])))
    return Mixture.of(rows).quantile(0.95)


def _warm_up_limit(best: Alternative, designs: Designs) -> float:
    kind = _kind_with(best, "A_w")
    found = []
    fits = [(fit, slow_weight(best.data, _density(best, fit)), w) for fit, w in rival_noises(best)]
    for T_w in designs.grid[designs.grid <= LONGEST * designs.bounds[1]]:
        rows = []
        for _, weight, likely in fits:
            mean, variance = designs.linear(kind, weight, T_w)
            rows.append((likely, abs(float(mean[-1])), math.sqrt(variance[-1, -1])))
        found.append(Mixture.of(rows).quantile(0.95))
    return max(found, default=math.nan)
