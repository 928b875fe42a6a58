"""Misfit of a noise model to Allan variances, compiled: what the fits after S 3.4 minimise.

    cost = sum_k (w_k (obs_k - model_k))^2

with w = 1/obs (Eq. 13 of Skurowski & Pawlyta 2019, the weight inside the square: relative
residuals) or the same w at every tau (ordinary least squares, the other curve of their Figure 6).

The coordinates searched, all natural logarithms: for every component its share, the root mean
square over tau of its part of w * model (w is scaled so that w * obs has 1; so a share is between
nothing and about 1 whatever the unit); beside it log T_c of a Gauss-Markov term, log f_0 of the
sinusoid. Order: power laws by alpha, (share, T_c) of each Gauss-Markov term, (share, f_0).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.fit.allan import descent
from mocap_metrology.noise.fit.estimates import Components
from mocap_metrology.noise.model.components import (
    Component,
    Form,
    GaussMarkov,
    NoiseModel,
    PowerLaw,
    Sinusoid,
    check_form,
    unit_avar,
)
from mocap_metrology.settings import Annealing

Weighting = Literal["relative", "equal"]
PER_COEFFICIENT = 3  # Allan variances that are fitted in any case
WITHIN = 1e-6  # of a bound: on it


@dataclass(frozen=True, eq=False)
class Misfit:
    """Cost of a point of the search, for one series; d coordinates, k averaging times.

    m, avar: (k,), avar in mm^2; lower, upper: (d,) bounds; weights: (k,) w, 1/mm^2; fixed:
    (n_alpha, k) w * curve of each power law at share 1; unit: (n_alpha,) its h there.
    """

    m: np.ndarray
    avar: np.ndarray
    frame_rate_hz: float
    components: Components
    form: Form
    weights: np.ndarray
    fixed: np.ndarray
    unit: np.ndarray
    lower: np.ndarray
    upper: np.ndarray

    @cached_property
    def _problem(self) -> descent.Problem:
        tau0, sampled = 1 / self.frame_rate_hz, self.form == "sampled"
        target = self.weights * self.avar
        return (
            *(self.fixed, self.m, np.log(self.m), self.weights, target),
            *(tau0, self.components.gauss_markov, sampled, descent.correlated_table()),
        )

    def costs(self, points: np.ndarray) -> np.ndarray:
        """(n,) sums of squares at the points (n, d)."""
        return descent.costs_at(np.ascontiguousarray(points), self._problem)

    def residual(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(k,) w (model - obs) at x, and its derivatives (d, k) by the coordinates."""
        jacobian = np.empty((x.size, self.m.size))
        return descent.residual(x, self._problem, jacobian), jacobian

    def polished(self, x: np.ndarray, iterations: int = 100) -> tuple[np.ndarray, float]:
        """The local minimum below x inside the bounds, and its cost (see `descent.descend`)."""
        return descent.descend(x, self.lower, self.upper, iterations, self._problem)

    def model(self, x: np.ndarray) -> NoiseModel:
        """The noise model at x, Gauss-Markov terms by rising T_c; T_c and f_0 kept if absent."""
        n = len(self.components.alphas)
        parts: list[Component] = [
            PowerLaw(alpha, float(share * unit))
            for alpha, share, unit in zip(
                self.components.alphas, np.exp(x[:n]), self.unit, strict=True
            )
        ]
        for i in range(n, n + 2 * self.components.gauss_markov, 2):
            T_c = math.exp(x[i + 1])
            norm = self._norm(GaussMarkov(math.sqrt(2 / T_c), T_c))
            parts.append(GaussMarkov(math.sqrt(2 / T_c * math.exp(x[i]) / norm), T_c))
        if self.components.sinusoid:
            f_0 = math.exp(x[-1])
            norm = self._norm(Sinusoid(1.0, f_0))
            parts.append(Sinusoid(math.sqrt(math.exp(x[-2]) / norm), f_0))
        return NoiseModel(tuple(parts)).ordered()

    def at_bound(self, x: np.ndarray) -> dict[str, bool]:
        """Whether x lies on a bound, by coefficient (named as in `model`). Where a share does, so
        do q_c and T_c, or A_s and f_0, together: an absent component has no T_c."""
        on = (x <= self.lower + WITHIN) | (x >= self.upper - WITHIN)
        n, count = len(self.components.alphas), self.components.gauss_markov
        pairs = [(on[i], on[i] or on[i + 1]) for i in range(n, x.size, 2)]
        order = np.argsort(x[n + 1 : n + 2 * count : 2], kind="stable")
        flags = [*on[:n], *(flag for i in order for flag in pairs[i])]
        flags += pairs[-1] if self.components.sinusoid else ()
        return dict(zip(self.components.names, map(bool, flags), strict=True))

    def freedom(self, x: np.ndarray, rise: float) -> dict[str, float]:
        """For each power law off its bounds how far, relatively, its coefficient can move from the
        minimum x while the cost, with all others refitted, grows by `rise` (in the quadratic
        approximation: sqrt(rise [(J'J)^-1]_ii))."""
        inside = np.flatnonzero((x > self.lower + WITHIN) & (x < self.upper - WITHIN))
        jacobian = self.residual(x)[1][inside]
        scale = np.sqrt(np.sum(jacobian**2, axis=1))
        values, vectors = np.linalg.eigh((jacobian @ jacobian.T) / np.outer(scale, scale))
        inverse = vectors**2 @ (1 / np.maximum(values, 1e-15)) / scale**2
        by_place = dict(zip(inside.tolist(), np.sqrt(rise * inverse).tolist(), strict=True))
        alphas = self.components.alphas
        return {f"h_{a}": by_place[i] for i, a in enumerate(alphas) if i in by_place}

    def _norm(self, part: Component) -> float:
        return _rms(self.weights * part.avar(self.m, self.frame_rate_hz, self.form))


def misfit(
    m: np.ndarray,
    avar: np.ndarray,
    frame_rate_hz: float,
    components: Components,
    form: Form = "continuous",
    weighting: Weighting = "relative",
    search: Annealing | None = None,
    duration: float | None = None,
) -> Misfit:
    """The misfit of `components` to Allan variances `avar` (k,) in mm^2 at tau = m tau0 (s).

    search: `negligible` ... `longest_tau_share` of the settings are the range of the coefficients;
    what ends at the least share is absent to the fit, and the best fit has a root mean square of at
    most 1, or scaling it would pay. duration: of the recording, s; by default three times the
    longest tau. Variances beyond `longest_tau_share` of it are left out, but for three a
    coefficient at least: relative residuals weigh them, which are a handful of independent
    differences, like short ones, and a slow sinusoid or correlated term then fits their chance.
    """
    m, avar = checked(m, avar, frame_rate_hz)
    search, tau0 = search or Annealing(), 1 / frame_rate_hz
    n = len(components.names)
    if n == 0:
        raise Refusal(f"{components}, expected at least one component to fit")
    if m.size < n:
        raise Refusal(f"{m.size} Allan variances for {n} coefficients, expected at least {n}")
    check_form(form)
    duration = 3 * m[-1] * tau0 if duration is None else duration
    if not m[-1] * tau0 < duration < 1e8 * tau0 / min(search.shortest_frames, 1):
        raise Refusal(
            f"recording of {duration} s, expected more than the longest tau, {m[-1] * tau0:.4g} s, "
            "and less than 10^8 frames"
        )
    within = np.count_nonzero(m * tau0 <= search.longest_tau_share * duration)
    fitted = max(within, PER_COEFFICIENT * n)
    m, avar = m[:fitted], avar[:fitted]
    weights = 1 / avar if weighting == "relative" else np.full(avar.size, 1 / _rms(avar))
    key = form, frame_rate_hz, m.tobytes()
    curves = [unit_avar(alpha, *key) for alpha in components.alphas]
    fixed = weights * np.array(curves).reshape(-1, m.size)
    unit = 1 / np.sqrt(np.mean(fixed**2, axis=1))
    lower, upper = _bounds(components, frame_rate_hz, search, duration)
    scaled = fixed * unit[:, None]
    return Misfit(m, avar, frame_rate_hz, components, form, weights, scaled, unit, lower, upper)


def checked(m: np.ndarray, avar: np.ndarray, frame_rate_hz: float) -> tuple[np.ndarray, np.ndarray]:
    """m and avar as float arrays by rising m, refused where they are no Allan variances."""
    m, avar = np.atleast_1d(np.asarray(m, float)), np.atleast_1d(np.asarray(avar, float))
    if m.ndim != 1 or m.shape != avar.shape:
        raise Refusal(f"{m.shape} averaging factors, {avar.shape} Allan variances: expected equal")
    if not (math.isfinite(frame_rate_hz) and frame_rate_hz > 0):
        raise Refusal(f"frame rate {frame_rate_hz} Hz, expected a number > 0")
    order = np.argsort(m, kind="stable")
    m, avar = m[order], avar[order]
    if not (np.all(m >= 1) and np.all(m == np.round(m)) and np.all(np.diff(m) > 0)):
        raise Refusal("averaging factors m, expected different whole numbers >= 1")
    bad = np.flatnonzero(~(np.isfinite(avar) & (avar > 0)))
    if bad.size:
        raise Refusal(
            f"Allan variance at m = {m[bad[0]]:.0f}: {avar[bad[0]]}, expected a number > 0"
            + (f" ({bad.size} of {m.size} are none)" if bad.size > 1 else "")
        )
    return m, avar


def _bounds(
    components: Components, frame_rate_hz: float, search: Annealing, duration: float
) -> tuple[np.ndarray, np.ndarray]:
    tau0 = 1 / frame_rate_hz
    shortest, longest = search.shortest_frames * tau0, search.longest_share * duration
    if components.gauss_markov and shortest >= longest:
        raise Refusal(
            f"{duration:.4g} s of recording: T_c would be searched from {shortest:.3g} s to "
            f"{longest:.3g} s, expected a longer recording"
        )
    lowest, highest = max(search.lowest_hz, 1 / duration), 0.5 / tau0
    if components.sinusoid and lowest >= highest:
        raise Refusal(
            f"f_0 would be searched from {lowest:.3g} Hz to {highest:.3g} Hz, half of the frame "
            "rate; expected a lower lowest_hz or a longer recording"
        )
    share = (math.log(search.negligible), math.log(search.largest))
    ranges = [share] * len(components.alphas)
    ranges += [share, (math.log(shortest), math.log(longest))] * components.gauss_markov
    ranges += [share, (math.log(lowest), math.log(highest))] * components.sinusoid
    lower, upper = np.array(ranges).T
    return np.ascontiguousarray(lower), np.ascontiguousarray(upper)


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def warm_up() -> None:
    """Compile for float64."""
    m, search = np.array([1.0, 2, 4, 8]), Annealing(longest_share=0.5)
    problem = misfit(m, 1 / m, 1.0, Components((0,), 1), search=search)
    problem.costs(np.array([problem.polished(problem.lower)[0]]))
    problem.residual(problem.lower)
