"""Which components a periodogram shows: starts, order and information criterion."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.fit.spectral.periodogram import gauss_markov_unit
from mocap_metrology.noise.fit.spectral.whittle import Fit, Likelihood, Spectrum, dictionary

CRITERIA = ("bic", "aicc")
INSERTIONS = 2  # best places for a further component that are tried
GRID = 32  # values of T_c a place is looked for among


def penalty(criterion: str, n: float) -> Callable[[int], float]:
    """What p parameters fitted to n values cost, in units of twice the log likelihood.

    BIC: p ln n [Schwarz 1978]; AICc: 2p + 2p(p + 1)/(n - p - 1) [Hurvich & Tsai 1989].
    """
    if criterion not in CRITERIA:
        raise Refusal(f"criterion {criterion!r}, expected one of {', '.join(CRITERIA)}")
    if criterion == "aicc":
        return lambda p: 2 * p + 2 * p * (p + 1) / max(n - p - 1, 1.0)
    return lambda p: p * math.log(n)


def fit_order(likelihood: Likelihood, mixture: Spectrum, terms: int, smaller: Fit | None) -> Fit:
    """Best fit of the mixture's power laws and `terms` Gauss-Markov components, of several starts.

    Starts: the components of the mixture (see `dictionary`), joined or split to the number wanted,
    and `smaller` (a fit with one component less) with another put where the likelihood rises most.
    """
    starts = [with_power(likelihood, _resized(mixture, terms, likelihood.bounds))]
    if smaller is not None:
        starts += extended(likelihood, smaller.spectrum, tuple(mixture.h))
    return min((likelihood.fit(start) for start in starts), key=lambda fit: fit.deviance)


def fit_known(likelihood: Likelihood, alphas: Sequence[int], terms: int) -> Fit:
    """Best fit of a known order, built up one component at a time."""
    if not (alphas or terms):
        raise Refusal("no component to fit, expected a power law or a Gauss-Markov term")
    mixture, least = dictionary(likelihood, alphas), 0 if alphas else 1
    best = fit_order(likelihood, mixture, least, None)
    for k in range(least + 1, terms + 1):
        best = fit_order(likelihood, mixture, k, best)
    return best


def choose(likelihood: Likelihood, alphas: Sequence[int], most: int, criterion: str = "bic") -> Fit:
    """The fit with the least criterion among 0 ... `most` Gauss-Markov components and all subsets
    of the power laws that backward elimination visits.

    The n of the criterion is the number of bins. With that of coefficients, four million in nine
    hours, BIC requires of a slow component what only a million coefficients could give, although it
    shows in a few hundred: T_c of minutes would be missed that stand out by five sigma. With the
    bins, 95 of 100 recordings of pure white noise and more show nothing else (a test).
    """
    cost = penalty(criterion, float(likelihood.psd.size))
    pruned: list[Fit] = []
    full: Fit | None = None
    mixture = dictionary(likelihood, alphas)
    for terms in range(most + 1):
        full = fit_order(likelihood, mixture, terms, full)
        pruned.append(_pruned(likelihood, full, cost))
    return min(pruned, key=lambda fit: fit.deviance + cost(fit.spectrum.size))


def _pruned(likelihood: Likelihood, fit: Fit, cost: Callable[[int], float]) -> Fit:
    """Power laws removed one by one while the criterion falls."""
    while len(fit.spectrum.h) + len(fit.spectrum.T_c) > 1 and fit.spectrum.h:
        saved = cost(fit.spectrum.size) - cost(fit.spectrum.size - 1)
        empty = [a for a, h in fit.spectrum.h.items() if h <= 0]  # nothing but the count changes
        tried = [_without(likelihood, fit, alpha) for alpha in empty[:1] or fit.spectrum.h]
        smaller = min(tried, key=lambda t: t.deviance)
        if not empty and smaller.deviance - fit.deviance >= saved:
            return fit
        fit = smaller
    return fit


def _without(likelihood: Likelihood, fit: Fit, alpha: int) -> Fit:
    others = {a: h for a, h in fit.spectrum.h.items() if a != alpha}
    return likelihood.fit(replace(fit.spectrum, h=others))


def extended(likelihood: Likelihood, now: Spectrum, alphas: Sequence[int]) -> list[Spectrum]:
    """`now` with one more component, at the places with the highest score statistics.

    Score statistic of q_c^2 at 0: gradient^2 / information left by the other parameters.
    """
    now = replace(now, h={a: now.h.get(a, 0.0) for a in alphas})
    density, columns = likelihood.jacobian(now)
    root = np.sqrt(likelihood.weight / 2)
    basis, _ = np.linalg.qr(columns / density[:, None] * root[:, None])
    rest = root * (likelihood.psd / density - 1)
    rest = rest - basis @ (basis.T @ rest)
    grid = np.geomspace(*likelihood.bounds, GRID)
    places = []
    for T_c in grid:
        unit = gauss_markov_unit(likelihood.bins, T_c) / density * root
        left = unit - basis @ (basis.T @ unit)
        information = left @ left
        score = left @ rest
        if information > 1e-12 * (unit @ unit) and score > 0:
            places.append((score**2 / information, score / information, T_c))
    places.sort(reverse=True)
    chosen: list[tuple[float, float, float]] = []
    for place in places:
        if all(abs(math.log(place[2] / other[2])) > 1.5 for other in chosen):
            chosen.append(place)
    return [
        replace(now, q2=np.append(now.q2, q2), T_c=np.append(now.T_c, T_c))
        for _, q2, T_c in chosen[:INSERTIONS]
    ]


def with_power(likelihood: Likelihood, start: Spectrum) -> Spectrum:
    """`start`, or, where joining left no power at all, an equal share for every power law."""
    if not start.h or any(start.h.values()) or start.T_c.size:
        return start
    share = {a: np.median(likelihood.psd / likelihood.laws[a]) / len(start.h) for a in start.h}
    return replace(start, h=share)


def _resized(mixture: Spectrum, terms: int, bounds: tuple[float, float]) -> Spectrum:
    """The mixture with exactly `terms` components: nearest ones joined, or the widest split."""
    q2, T_c = mixture.q2.copy(), mixture.T_c.copy()
    while T_c.size > terms:
        if T_c.size == 1:
            q2, T_c = q2[:0], T_c[:0]
            break
        k = int(np.diff(np.log(T_c)).argmin())
        total = q2[k] + q2[k + 1]
        middle = (q2[k] * math.log(T_c[k]) + q2[k + 1] * math.log(T_c[k + 1])) / total
        q2 = np.concatenate([q2[:k], [total], q2[k + 2 :]])
        T_c = np.concatenate([T_c[:k], [math.exp(middle)], T_c[k + 2 :]])
    while T_c.size < terms:
        if T_c.size == 0:
            h0 = max(mixture.h.values(), default=1.0)
            middle = math.sqrt(bounds[0] * bounds[1])
            q2, T_c = np.array([1e-6 * h0 / middle**2]), np.array([middle])
            continue
        k = int(q2.argmax())
        q2 = np.concatenate([q2[:k], [q2[k] / 2, q2[k] / 2], q2[k + 1 :]])
        T_c = np.concatenate([T_c[:k], [T_c[k] / 1.5, T_c[k] * 1.5], T_c[k + 1 :]])
        T_c = np.clip(T_c, *bounds)
    return replace(mixture, q2=q2, T_c=T_c)
