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

import numpy as np

from mocap_metrology.noise.fit.spectral.periodogram import Periodogram, Slow
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
        """Of the rows of the covariance."""
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


def line_column(slow: Slow, frame_rate_hz: float) -> np.ndarray:
    """(M,) slow coefficients of x(t) = t, t in s: of odd k alone."""
    tau0 = 1 / frame_rate_hz
    half = np.pi * slow.k / (2 * slow.n)
    unit = -tau0 * np.cos(half) / (2 * np.sin(half) ** 2)
    return np.where(slow.k % 2 == 1, unit, 0.0) * np.sqrt(4 * tau0 / slow.n)


def warm_up_column(slow: Slow, frame_rate_hz: float, T_w: float) -> np.ndarray:
    """(M,) slow coefficients of x(t) = exp(-t / T_w)."""
    tau0 = 1 / frame_rate_hz
    half = np.pi * slow.k / (2 * slow.n)
    a = tau0 / T_w
    sign = np.where(slow.k % 2 == 1, -1.0, 1.0)
    below = math.expm1(-a) ** 2 + 4 * math.exp(-a) * np.sin(half) ** 2
    unit = -math.expm1(-a) * (1 - sign * np.exp(-a * slow.n)) * np.cos(half) / below
    return unit * np.exp(-slow.start_s / T_w) * np.sqrt(4 * tau0 / slow.n)


def T_w_range(slow: Slow, frame_rate_hz: float) -> tuple[float, float]:
    """T_w that are searched, s."""
    tau0 = 1 / frame_rate_hz
    span = float(np.max(slow.start_s + slow.n * tau0))
    return min(max(SHORTEST * span, LEAST_FRAMES * tau0), span / 2), span


def _least_squares(
    columns: np.ndarray, value: np.ndarray, weight: np.ndarray
) -> tuple[np.ndarray, np.ndarray, float]:
    """Coefficients (p,), covariance (p, p), and by how much they lower the sum of squares."""
    normal = (columns * weight) @ columns.T
    scale = 1 / np.sqrt(np.diag(normal))
    covariance = np.linalg.pinv(normal * scale * scale[:, None], hermitian=True) * scale
    covariance *= scale[:, None]
    right = (columns * weight) @ value
    found = covariance @ right
    return found, covariance, float(right @ found)


class Designs:
    """Columns of every kind over the slow coefficients of one recording, computed once."""

    def __init__(self, slow: Slow, frame_rate_hz: float) -> None:
        self.slow, self.frame_rate_hz = slow, frame_rate_hz
        self.bounds = T_w_range(slow, frame_rate_hz)
        self.line = line_column(slow, frame_rate_hz) / HOUR
        self.grid = np.geomspace(*self.bounds, GRID)
        self.warm_ups = [self.warm_up(T_w) for T_w in self.grid]

    def warm_up(self, T_w: float) -> np.ndarray:
        """(M,) of A_w = 1."""
        return warm_up_column(self.slow, self.frame_rate_hz, T_w)

    def columns(self, kind: str, warm_up: np.ndarray) -> np.ndarray:
        """(p, M) of what is linear."""
        own = [self.line] if "drift" in KINDS[kind] else []
        return np.stack([*own, warm_up] if "A_w" in KINDS[kind] else own)

    def part(self, kind: str, weight: np.ndarray) -> Part:
        """Least squares with weights (M,), 1/variance of the coefficients."""
        if kind == "line":
            found, covariance, _ = _least_squares(self.line[None], self.slow.value, weight)
            return Part(kind, Deterministic(float(found[0])), covariance)
        T_w = self._best_T_w(kind, weight)
        return self.given(kind, weight, T_w)

    def given(self, kind: str, weight: np.ndarray, T_w: float) -> Part:
        """The same with T_w known; the covariance has its row nevertheless."""
        columns = self.columns(kind, self.warm_up(T_w))
        found, _, _ = _least_squares(columns, self.slow.value, weight)
        A_w = float(found[-1])
        drift = float(found[0]) if "drift" in KINDS[kind] else 0.0
        up, down = (self.warm_up(T_w * math.exp(s * STEP)) for s in (1, -1))
        columns = np.vstack([columns, A_w * (up - down) / (2 * STEP)])
        _, covariance, _ = _least_squares(columns, self.slow.value, weight)
        return Part(kind, Deterministic(drift, A_w, T_w), covariance)

    def linear(self, kind: str, weight: np.ndarray, T_w: float) -> tuple[np.ndarray, np.ndarray]:
        """Values and covariance of drift and A_w with T_w known."""
        columns = self.columns(kind, self.warm_up(T_w))
        return _least_squares(columns, self.slow.value, weight)[:2]

    def gain(self, kind: str, weight: np.ndarray, T_w: float) -> float:
        """By how much line and warm-up of this T_w lower the weighted sum of squares."""
        columns = self.columns(kind, self.warm_up(T_w))
        return _least_squares(columns, self.slow.value, weight)[2]

    def _best_T_w(self, kind: str, weight: np.ndarray) -> float:
        from scipy.optimize import minimize_scalar

        gains = [
            _least_squares(self.columns(kind, column), self.slow.value, weight)[2]
            for column in self.warm_ups
        ]
        at = int(np.argmax(gains))
        ends = np.log(self.grid[[max(at - 1, 0), min(at + 1, GRID - 1)]])
        found = minimize_scalar(
            lambda log: -self.gain(kind, weight, math.exp(log)),
            bounds=tuple(ends),
            method="bounded",
        )
        best = (-found.fun, math.exp(found.x)), (gains[at], float(self.grid[at]))
        return max(best)[1]

    def of(self, part: Part) -> np.ndarray:
        """(p, M): derivatives of the slow coefficients by the part's parameters."""
        if part.kind == "line":
            return self.line[None]
        T_w = part.values.T_w
        up, down = (self.warm_up(T_w * math.exp(s * STEP)) for s in (1, -1))
        own = self.columns(part.kind, self.warm_up(T_w))
        return np.vstack([own, part.values.A_w * (up - down) / (2 * STEP)])

    def wave(self, part: Part) -> np.ndarray:
        """(M,) slow coefficients of the part."""
        out = part.values.drift * self.line
        return out + part.values.A_w * self.warm_up(part.values.T_w) if part.values.A_w else out


def slow_of(data: Periodogram) -> Slow:
    """The slow coefficients one by one, which a periodogram must have to be detrended."""
    if data.slow is None:
        raise ValueError("periodogram without its slow coefficients")
    return data.slow


def slow_weight(data: Periodogram, density: np.ndarray) -> np.ndarray:
    """(M,) weights of the slow coefficients: the share that was measured over the variance."""
    slow = slow_of(data)
    return slow.share / density[slow.bin]


def _left(data: Periodogram, designs: Designs, part: Part, restored: bool) -> Periodogram:
    """The periodogram without the part; restored: with the power that its estimate removed (X V
    X')."""
    slow = slow_of(data)
    power = (slow.value - designs.wave(part)) ** 2
    if restored:
        columns = designs.of(part)
        power += np.einsum("pm,pq,qm->m", columns, part.covariance, columns)
    count = np.bincount(slow.bin, minlength=data.psd.size)
    mean = np.bincount(slow.bin, power, data.psd.size) / np.maximum(count, 1)
    psd = np.where(count > 0, np.maximum(mean, np.finfo(float).tiny), data.psd)
    return replace(data, psd=psd)


def _minus_two_log(data: Periodogram, density: np.ndarray) -> float:
    return float(np.sum(data.weight * (np.log(density) + data.psd / density)))


def _quick(data: Periodogram, designs: Designs, kind: str) -> tuple[Periodogram, float]:
    """What is left, and -2 ln L, with a mixture of every noise: no order is chosen."""
    left = data
    for step in range(ROUNDS + 1):
        likelihood = Likelihood(left, data.bins.T_c_range)
        density = likelihood.density(dictionary(likelihood, ALPHAS))
        if kind == "none":
            return data, _minus_two_log(data, density)
        if step == ROUNDS:
            break
        part = designs.part(kind, slow_weight(data, density))
        left = _left(data, designs, part, restored=step > 0)
    return left, _minus_two_log(_left(data, designs, part, restored=False), density)


def _settled(
    data: Periodogram, designs: Designs, kind: str, left: Periodogram, fit: Fit
) -> tuple[Part, Periodogram, Fit]:
    """Least squares with the fit's weights, and the fit of what it leaves, in turn."""
    for _ in range(ROUNDS):
        density = Likelihood(left, data.bins.T_c_range).density(fit.spectrum)
        part = designs.part(kind, slow_weight(data, density))
        left = _left(data, designs, part, restored=True)
        fit = Likelihood(left, data.bins.T_c_range).fit(fit.spectrum)
    return part, left, fit


def without_part(data: Periodogram, fit: Fit, cost: Callable[[int], float]) -> Alternative:
    """The alternative that all is noise."""
    offset = float(np.sum(data.weight * (1 + np.log(data.psd))))
    score = fit.deviance + offset + cost(fit.spectrum.size)
    nothing = Part("none", Deterministic(), np.empty((0, 0)))
    return Alternative(nothing, data, fit, score, offset)


def alternatives(
    data: Periodogram, fitted: Callable[[Periodogram], Fit], cost: Callable[[int], float]
) -> list[Alternative]:
    """Noise alone, and noise with every deterministic part that may pay; the best first.

    fitted: the choice of a noise model for a periodogram; cost: of so many parameters, in units of
    twice the log likelihood (`order.penalty`).
    """
    found = [without_part(data, fitted(data), cost)]
    if data.slow is None:
        return found
    designs = Designs(data.slow, data.bins.frame_rate_hz)
    bare = _quick(data, designs, "none")[1]
    for kind in list(KINDS)[1:]:
        left, value = _quick(data, designs, kind)
        p = len(KINDS[kind])
        price = UNLIKELY * (("drift" in KINDS[kind]) + ("A_w" in KINDS[kind]))
        if value + price + cost(p) > bare + PROMISING:
            continue
        part, left, fit = _settled(data, designs, kind, left, fitted(left))
        # sum of X V X' / S = p: taken off, so that the likelihood is that of the data
        offset = float(np.sum(left.weight * (1 + np.log(left.psd)))) - p + price + cost(p)
        score = fit.deviance + offset + cost(fit.spectrum.size)
        found.append(Alternative(part, left, fit, score, offset))
    return sorted(found, key=lambda one: one.score)
