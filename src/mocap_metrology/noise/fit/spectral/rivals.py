"""Noise models that explain a periodogram about as well as the chosen one, and intervals that hold
whichever of them is true.

An interval given the chosen model does not know that it was chosen: a slow Gauss-Markov term taken
for a random walk leaves h_-2 far too high and its interval far too narrow. So every neighbour of
the chosen model (one component less, more, or exchanged) is fitted, and their neighbours where they
fit as well; model k has the excess

    e_k = D_k + c_k - min_j (D_j + c_j) >= 0,

D its deviance, c the price of its parameters. The interval is the set of values that some model
does not reject: of model k those within sqrt(z^2 - e_k) standard errors, z = 1.96 or 0.994. This is
the likelihood-ratio interval of the model number as one more unknown parameter, c its prior.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mocap_metrology.noise.fit.estimates import Z_68, Z_95, Coefficient
from mocap_metrology.noise.fit.spectral.detrend import Alternative
from mocap_metrology.noise.fit.spectral.order import extended, with_power
from mocap_metrology.noise.fit.spectral.whittle import Fit, Likelihood, Spectrum, standard_errors

# Prices of a power law, of a Gauss-Markov term slower than FAST_FRAMES, whose T_c hardly matters
# beside other slow noise, and of a faster one, which can stand for white or flicker noise. AIC asks
# for 2 a parameter, BIC for 6 in nine hours. With these the 95 % intervals of every coefficient
# hold in nine of ten of S's series and, where the right model is chosen, are 1.0 to 1.25 times as
# wide as the bound (medians; 2 to 4 times for a weak walk or flicker:
# benchmarks/sentences/models.py).
PRICE, SLOW, FAST = 3.5, 4.5, 8.0
FAST_FRAMES = 1000
HARDLY_BIC = 2.0  # difference of BIC "not worth more than a bare mention" [Kass & Raftery 1995]
MOST_MODELS = 60  # models that are fitted
ALIKE_LN_T = 0.7  # of ln T_c: fits whose terms are as near are one model
PAIRED_LN_T = math.log(3)  # of ln T_c: terms of two models that are one component
LAWS = {
    -2: "a random walk",
    -1: "flicker noise",
    0: "white noise",
    1: "blue noise",
    2: "violet noise",
}


@dataclass(frozen=True)
class Rival:
    """excess: e_k of the module's formula."""

    fit: Fit
    excess: float


def judged(
    parts: Sequence[Alternative], alphas: Sequence[int], most: int, cost: Callable[[int], float]
) -> tuple[Fit, tuple[Rival, ...]]:
    """The noise of the first alternative, and the rivals: models with an excess below 1.96^2, those
    round other deterministic parts that explain the recording as well among them, best first.

    parts: deterministic parts with the noise round them, the best first. The noise is that of the
    least criterion, which may be a rival that the search for it passed by. alphas: power laws a
    model may have; most: greatest number of Gauss-Markov terms; cost: of p parameters by the
    criterion (`order.penalty`).
    """
    priced: list[tuple[float, Fit]] = []
    for one in parts:
        if one.score - parts[0].score > Z_95**2:
            break
        likelihood = Likelihood(one.data)
        fits = _explored(likelihood, one.fit, alphas, most)
        price = _penalised_deviance(likelihood)
        priced += [(price(fit) + one.offset, fit) for fit in fits]
        if one is parts[0]:
            chosen = min(fits, key=lambda fit: fit.deviance + cost(fit.spectrum.size))
    least = min(price for price, _ in priced)
    near = [Rival(fit, price - least) for price, fit in priced if price - least < Z_95**2]
    return chosen, tuple(sorted(near, key=lambda rival: rival.excess))


def _explored(likelihood: Likelihood, chosen: Fit, alphas: Sequence[int], most: int) -> list[Fit]:
    """The chosen model, its neighbours, and the neighbours of those that fit as well."""
    price = _penalised_deviance(likelihood)
    fits = {_key(chosen.spectrum): chosen}
    waiting, tried = [chosen], set()
    while waiting and len(fits) < MOST_MODELS:
        waiting.sort(key=price, reverse=True)
        now = waiting.pop()
        if price(now) - min(map(price, fits.values())) > Z_95**2:
            break
        for start in _neighbours(likelihood, now, alphas, most):
            if _key(start) in tried:
                continue
            tried.add(_key(start))
            fit = likelihood.fit(with_power(likelihood, start))
            key = _key(fit.spectrum)
            if key not in fits:
                waiting.append(fit)
            elif fit.deviance >= fits[key].deviance:
                continue
            fits[key] = fit
    return [*fits.values()]


def _penalised_deviance(likelihood: Likelihood) -> Callable[[Fit], float]:
    """Deviance of a fit with the price of its parameters."""
    tau0 = 1 / likelihood.bins.frame_rate_hz
    fast = FAST_FRAMES * tau0
    return lambda fit: (
        fit.deviance
        + PRICE * len(fit.spectrum.h)
        + SLOW * int(np.count_nonzero(fit.spectrum.T_c >= fast))
        + FAST * int(np.count_nonzero(fit.spectrum.T_c < fast))
    )


def _key(spectrum: Spectrum) -> tuple[tuple[int, ...], tuple[int, ...]]:
    terms = (round(math.log(T_c) / ALIKE_LN_T) for T_c in spectrum.T_c)
    return tuple(sorted(spectrum.h)), tuple(sorted(terms))


def _neighbours(
    likelihood: Likelihood, now: Fit, alphas: Sequence[int], most: int
) -> Iterator[Spectrum]:
    """Starts of models with one component less, one more, or one exchanged for another."""
    whole = now.spectrum
    bases = [whole]
    bases += [replace(whole, h={b: h for b, h in whole.h.items() if b != a}) for a in whole.h]
    for k in range(whole.T_c.size):
        bases.append(replace(whole, q2=np.delete(whole.q2, k), T_c=np.delete(whole.T_c, k)))
    for base in bases:
        if not base.size:
            continue
        fitted = now if base is whole else likelihood.fit(with_power(likelihood, base))
        left = fitted.spectrum
        if base is not whole:
            yield left
        for alpha in set(alphas) - set(whole.h):
            # A tenth of the most the periodogram has room for: far from 0, where steps are slow
            level = 0.1 * float(np.min(likelihood.psd / likelihood.laws[alpha]))
            yield replace(left, h={**left.h, alpha: level})
        if left.T_c.size < most:
            yield from extended(likelihood, left, tuple(left.h))


def widened(
    rows: Sequence[Coefficient], chosen: Fit, near: Sequence[Rival], slowest: float
) -> tuple[Coefficient, ...]:
    """The rows with intervals and limits that reach as far as any of the rivals' allow.

    A rival moves an end outwards only, and only to its own side of the value: where it is the
    chosen model with one more component, the other side is that component's end at zero. slowest:
    the longest T_c that was searched, s.
    """
    columns = [_values_of_rival(rival.fit, chosen.spectrum, slowest) for rival in near]
    out = []
    for row in rows:
        for z, level in ((Z_68, 68), (Z_95, 95)) if row.detected and row.value < math.inf else ():
            lower, upper = getattr(row, f"lower_{level}"), getattr(row, f"upper_{level}")
            for rival, column in zip(near, columns, strict=True):
                if rival.excess < z**2 and rival.fit is not chosen:
                    effect, errors = column.get(row.parameter), math.sqrt(z**2 - rival.excess)
                    low, high = _ends_by_rival(row, effect, errors)
                    lower, upper = min(lower, low), max(upper, high)
            row = replace(row, **{f"lower_{level}": lower, f"upper_{level}": upper})
        out.append(row)
    return tuple(out)


def _ends_by_rival(
    row: Coefficient, effect: tuple[float, float] | None, errors: float
) -> tuple[float, float]:
    """Ends that a rival adds to an interval: (value, standard error), or None where it has no such
    component."""
    if effect is None:  # without the component there is no T_c
        return (math.inf if row.parameter[0] == "T" else 0.0), -math.inf
    value, error = effect
    spread = math.exp(min(errors * error / value, 700.0))
    if value >= row.value:
        return math.inf, value * spread
    normal = row.parameter[0] == "h"
    return max(value - errors * error, 0.0) if normal else value / spread, -math.inf


def _values_of_rival(fit: Fit, chosen: Spectrum, slowest: float) -> dict[str, tuple[float, float]]:
    """(value, standard error) by the parameter names of the chosen model; its terms are paired with
    those of the fit by T_c (see `widened`)."""
    from scipy.optimize import linear_sum_assignment

    spectrum, error = fit.spectrum, standard_errors(fit.information, fit.spectrum)
    out = {f"h_{a}": (h, error[f"h_{a}"]) for a, h in spectrum.h.items() if h > 0}
    if "h_-2" not in out and np.any(spectrum.T_c >= 0.99 * slowest):
        # A term of the longest T_c that is searched is a walk of h_-2 = q_c^2 / (2 pi^2)
        q_c, k = math.sqrt(spectrum.q2[-1]), spectrum.T_c.size
        out["h_-2"] = (q_c**2 / (2 * math.pi**2), q_c * error[f"q_c{k}"] / math.pi**2)
    apart = np.abs(np.log(chosen.T_c[:, None] / spectrum.T_c[None, :]))
    for i, j in zip(*linear_sum_assignment(np.minimum(apart, 2 * PAIRED_LN_T)), strict=True):
        if apart[i, j] <= PAIRED_LN_T:
            out[f"q_c{i + 1}"] = (math.sqrt(spectrum.q2[j]), error[f"q_c{j + 1}"])
            out[f"T_c{i + 1}"] = (float(spectrum.T_c[j]), error[f"T_c{j + 1}"])
    return out


def undecided(chosen: Fit, near: Sequence[Rival], cost: Callable[[int], float]) -> str:
    """What the best rival of another composition has instead, in words; empty without such a rival.

    cost: of p parameters by the criterion. A rival that only has a component more or less counts
    where the criterion hardly prefers the chosen model.
    """

    def score(fit: Fit) -> float:
        return fit.deviance + cost(fit.spectrum.size)

    for rival in near:
        mine, theirs = _differences(chosen.spectrum, rival.fit.spectrum)
        if mine and theirs:
            return f"the data cannot distinguish {' and '.join(mine)} from {' and '.join(theirs)}"
        if (mine or theirs) and score(rival.fit) - score(chosen) < HARDLY_BIC:
            return f"the data cannot decide whether there is {' and '.join(mine or theirs)}"
    return ""


def _differences(one: Spectrum, other: Spectrum) -> tuple[list[str], list[str]]:
    """What each of two models has that the other has not."""
    apart = np.abs(np.log(one.T_c[:, None] / other.T_c[None, :])) > PAIRED_LN_T
    return (
        _words(set(one.h) - set(other.h), one.T_c[apart.all(axis=1)]),
        _words(set(other.h) - set(one.h), other.T_c[apart.all(axis=0)]),
    )


def _words(alphas: set[int], T_c: np.ndarray) -> list[str]:
    laws = [LAWS[alpha] for alpha in sorted(alphas)]
    return laws + [f"a Gauss-Markov term of {T:.2g} s" for T in T_c]
