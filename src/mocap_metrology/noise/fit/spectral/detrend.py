"""Straight line and exponential warm-up under the noise, chosen with it by one criterion.

In the cosine transform of `periodogram` the noise is as good as independent from coefficient to
coefficient, and line and exponential are known sums: given the spectrum, slope and A_w are weighted
least squares over the slow coefficients, T_w a search in one dimension; given them, the spectrum is
fitted to what is left. What the coefficients lose by that, X V X' at each (V the covariance of the
estimates), is put back before the spectrum is fitted: the expectation-maximisation form of
restricted likelihood [Harville 1977], so that h_-2 is not biased low. Alternatives are compared by
-2 ln L of the data, a parameter of the deterministic part costing what one of the noise costs, and
e to 1 against a line or a warm-up: a weak random walk now and then looks like a line.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from mocap_metrology.noise.fit.spectral.line import EXACT, TINY
from mocap_metrology.noise.fit.spectral.periodogram import Periodogram
from mocap_metrology.noise.fit.spectral.whittle import Fit, Likelihood, dictionary
from mocap_metrology.noise.model.components import ALPHAS
from mocap_metrology.noise.model.deterministic import HOUR, Deterministic

KINDS = {
    "none": (),
    "line": ("drift",),
    "warm_up": ("A_w", "T_w"),
    "line and warm_up": ("drift", "A_w", "T_w"),
}
ROUNDS = 3  # of spectrum and least squares in turn, before the order is chosen, and after
SHORTEST = 1e-3  # T_w searched: from this share of the recording,
LEAST_FRAMES = 100  # and from so many frames, up to the recording
GRID = 48  # T_w at which the search starts
STEP = 1e-3  # of ln T_w, for a derivative
UNLIKELY = 2.0  # twice the log of the odds against a line, and against a warm-up, before a look
PROMISING = 4.0  # in twice the log likelihood: what may fail to pay in the search and yet be tried


@dataclass(frozen=True)
class Part:
    """A deterministic part by generalised least squares given a spectrum. values: of the names of
    its kind (drift in mm/h); covariance: of them, with ln T_w in place of T_w."""

    kind: str
    values: Deterministic
    covariance: np.ndarray

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the rows of the covariance."""
        return KINDS[self.kind]


@dataclass(frozen=True)
class Alternative:
    """A deterministic part with the noise round it.

    data: periodogram of what is left, its expectation that of the noise (see above); fit: of the
    noise; score: -2 ln L of the whole + penalty, to compare alternatives; offset: what deviance +
    penalty of `fit`, or of any other fit of noise to `data`, lack to be such a score.
    """

    part: Part
    data: Periodogram
    fit: Fit
    score: float
    offset: float


class LeastSquares(NamedTuple):
    """Coefficients (..., p), covariance (..., p, p), and by how much they lower the sum of squares
    (...,)."""

    values: np.ndarray
    covariance: np.ndarray
    gain: np.ndarray


class Designs:
    """Columns of every kind over the slow coefficients of one recording, computed once.

    bounds: of the T_w that are searched, s; grid: of T_w; line: (M,) slow coefficients of t, t in
    hours. weight: (M,), 1/variance of the coefficients.
    """

    def __init__(self, data: Periodogram) -> None:
        self.slow, self._tau0 = data.slow, 1 / data.bins.frame_rate_hz
        span = float(np.max(self.slow.start_s + self.slow.n * self._tau0))
        self.bounds = min(max(SHORTEST * span, LEAST_FRAMES * self._tau0), span / 2), span
        half, odd = np.pi * self.slow.k / (2 * self.slow.n), self.slow.k % 2 == 1
        self._cos = np.cos(half) * np.sqrt(4 * self._tau0 / self.slow.n)
        self._four_sin2, self._sign = 4 * np.sin(half) ** 2, np.where(odd, 1.0, -1.0)
        self.line = np.where(odd, -2 * self._tau0 / HOUR * self._cos / self._four_sin2, 0.0)
        self.grid = np.geomspace(*self.bounds, GRID)
        self._warm_ups = self.warm_up(self.grid)

    def warm_up(self, T_w: float | np.ndarray) -> np.ndarray:
        """(M,) slow coefficients of exp(-t / T_w), of A_w = 1; of some T_w (g,) they are (g, M)."""
        rate = 1 / np.asarray(T_w)[..., None]
        a = self._tau0 * rate
        below = np.expm1(-a) ** 2 + np.exp(-a) * self._four_sin2
        ends = (1 + self._sign * np.exp(-a * self.slow.n)) * np.exp(-rate * self.slow.start_s)
        return -np.expm1(-a) * ends * self._cos / below

    def _fit(self, columns: np.ndarray, weight: np.ndarray) -> LeastSquares:
        """columns: (..., p, M)"""
        weighted = columns * weight
        normal = weighted @ np.swapaxes(columns, -1, -2)
        scale = 1 / np.sqrt(np.diagonal(normal, axis1=-2, axis2=-1))
        scale = scale[..., None] * scale[..., None, :]
        covariance = np.linalg.pinv(normal * scale, hermitian=True) * scale
        right = weighted @ self.slow.value
        values = (covariance @ right[..., None])[..., 0]
        return LeastSquares(values, covariance, np.sum(right * values, axis=-1))

    def _linear(self, kind: str, warm_up: np.ndarray) -> np.ndarray:
        """(..., p, M) of what is linear: drift and A_w."""
        parts = [self.line, warm_up] if "drift" in KINDS[kind] else [warm_up]
        return np.stack(np.broadcast_arrays(*parts), axis=-2)

    def linear(self, kind: str, weight: np.ndarray, T_w: float | np.ndarray) -> LeastSquares:
        """Drift and A_w with T_w known."""
        return self._fit(self._linear(kind, self.warm_up(T_w)), weight)

    def over_grid(self, kind: str, weight: np.ndarray) -> LeastSquares:
        """Drift and A_w for each T_w of the grid."""
        return self._fit(self._linear(kind, self._warm_ups), weight)

    def part(self, kind: str, weight: np.ndarray) -> Part:
        """The part of this kind by least squares."""
        if kind == "line":
            fit = self._fit(self.line[None], weight)
            return Part(kind, Deterministic(float(fit.values[0])), fit.covariance)
        T_w = self._best_T_w(kind, weight)
        linear = self.linear(kind, weight, T_w).values.tolist()
        values = Deterministic(linear[0] if "drift" in KINDS[kind] else 0.0, linear[-1], T_w)
        covariance = self._fit(self.derivatives(kind, values), weight).covariance
        return Part(kind, values, covariance)

    def _best_T_w(self, kind: str, weight: np.ndarray) -> float:
        from scipy.optimize import minimize_scalar

        gains = self.over_grid(kind, weight).gain
        at = int(np.argmax(gains))
        ends = np.log(self.grid[[max(at - 1, 0), min(at + 1, GRID - 1)]])
        lowest = minimize_scalar(
            lambda log: -float(self.linear(kind, weight, math.exp(log)).gain),
            bounds=tuple(ends),
            method="bounded",
        )
        best = (-lowest.fun, math.exp(lowest.x)), (float(gains[at]), float(self.grid[at]))
        return max(best)[1]

    def derivatives(self, kind: str, values: Deterministic) -> np.ndarray:
        """(p, M): of the slow coefficients by the parameters of a part, T_w by its logarithm."""
        if kind == "line":
            return self.line[None]
        up, down = (self.warm_up(values.T_w * math.exp(s * STEP)) for s in (1, -1))
        linear = self._linear(kind, self.warm_up(values.T_w))
        return np.vstack([linear, values.A_w * (up - down) / (2 * STEP)])

    def wave(self, values: Deterministic) -> np.ndarray:
        """(M,) slow coefficients of a part."""
        line = values.drift * self.line
        return line + values.A_w * self.warm_up(values.T_w) if values.A_w else line


def slow_weight(data: Periodogram, density: np.ndarray) -> np.ndarray:
    """(M,) weights of the slow coefficients: the share that was measured over the variance."""
    return data.slow.share / density[data.slow.bin]


def _periodogram_without(
    data: Periodogram, designs: Designs, part: Part, restored: bool
) -> Periodogram:
    """The periodogram without the part; restored: with the power that its estimate removed (X V
    X')."""
    slow = data.slow
    power = (slow.value - designs.wave(part.values)) ** 2
    if restored:
        columns = designs.derivatives(part.kind, part.values)
        power += np.einsum("pm,pq,qm->m", columns, part.covariance, columns)
    count = np.bincount(slow.bin, minlength=data.psd.size)
    mean = np.bincount(slow.bin, power, data.psd.size) / np.maximum(count, 1)
    psd = np.where(count > 0, np.maximum(mean, np.finfo(float).tiny), data.psd)
    return replace(data, psd=psd)


def _minus_two_log(data: Periodogram, density: np.ndarray) -> float:
    return float(np.sum(data.weight * (np.log(density) + data.psd / density)))


def _mixture_density(data: Periodogram) -> np.ndarray:
    likelihood = Likelihood(data)
    return likelihood.density(dictionary(likelihood, ALPHAS))


def _quick_fit(data: Periodogram, designs: Designs, kind: str) -> tuple[Periodogram, float]:
    """What is left, and -2 ln L, with a mixture of every noise: no order is chosen."""
    left = data
    for step in range(ROUNDS):
        part = designs.part(kind, slow_weight(data, _mixture_density(left)))
        left = _periodogram_without(data, designs, part, restored=step > 0)
    density = _mixture_density(left)
    return left, _minus_two_log(_periodogram_without(data, designs, part, restored=False), density)


def without_part(data: Periodogram, fit: Fit, cost: Callable[[int], float]) -> Alternative:
    """The alternative that all is noise."""
    nothing = Part("none", Deterministic(), np.empty((0, 0)))
    return _alternative(nothing, data, fit, cost, 0.0)


def _alternative(
    part: Part, left: Periodogram, fit: Fit, cost: Callable[[int], float], price: float
) -> Alternative:
    # sum of X V X' / S = p: taken off, so that the likelihood is that of the data
    p = len(part.names)
    psd = np.maximum(left.psd, EXACT * left.psd.max() + TINY)
    offset = float(np.sum(left.weight * (1 + np.log(psd)))) - p + price + cost(p)
    score = fit.deviance + offset + cost(fit.spectrum.size)
    return Alternative(part, left, fit, score, offset)


def alternatives(
    data: Periodogram, fitted: Callable[[Periodogram], Fit], cost: Callable[[int], float]
) -> list[Alternative]:
    """Noise alone, and noise with every deterministic part that may pay; the best first.

    fitted: the choice of a noise model for a periodogram; cost: of so many parameters, in units of
    twice the log likelihood (`order.penalty`).
    """
    compared = [without_part(data, fitted(data), cost)]
    designs = Designs(data)
    bare = _minus_two_log(data, _mixture_density(data))
    for kind in list(KINDS)[1:]:
        left, value = _quick_fit(data, designs, kind)
        price = UNLIKELY * len({"drift", "A_w"} & {*KINDS[kind]})
        if value + price + cost(len(KINDS[kind])) > bare + PROMISING:
            continue
        fit = fitted(left)
        for _ in range(ROUNDS):  # least squares with the fit's weights, the fit of what it leaves
            density = Likelihood(left).density(fit.spectrum)
            part = designs.part(kind, slow_weight(data, density))
            left = _periodogram_without(data, designs, part, restored=True)
            fit = Likelihood(left).fit(fit.spectrum)
        compared.append(_alternative(part, left, fit, cost, price))
    return sorted(compared, key=lambda one: one.score)
