"""How far means of n frames stray from the mean of N frames: as a model expects it.

W(n) is the expected variance of n successive frames about their own mean. A stretch of N frames is
made of N/n stretches of n, so (analysis of variance)

    u^2(n, N) = W(N) - W(n)

is the expected squared distance of the mean of n frames, anywhere in N, from the mean of the N:
what a lab that measures n frames now has to reckon with, as against all it could have measured in
the horizon of N frames. u^2(1, N) is the same of a single frame. Two halves show that W(2n) =
W(n) + AVAR(n)/2, so u^2 is half the sum of the Allan variances at n, 2n, 4n, ... N/2: unlike
ADEV(n), which compares a mean with the next, it counts all the slower wander there is up to N.
Everything converges for every power law here, and needs no true value.

`measured` has the same of the series itself.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from mocap_metrology.noise.fit.estimates import NoiseRow
from mocap_metrology.noise.fit.spectral.line import line_errors
from mocap_metrology.noise.fit.spectral.periodogram import Periodogram, bins_of
from mocap_metrology.noise.fit.spectral.whittle import Likelihood, spectrum_of
from mocap_metrology.noise.model.components import (
    Component,
    Form,
    GaussMarkov,
    NoiseModel,
    PowerLaw,
    Sinusoid,
)
from mocap_metrology.noise.model.deterministic import Deterministic

OCTAVES = 30  # beyond n, for blue and violet noise, whose Allan variances fall by 4 an octave
NAMES = {-2: "random walk", -1: "flicker", 0: "white", 1: "blue", 2: "violet"}
STEP = 1e-3  # of ln T_c, for a derivative
NO_PART = Deterministic()


def spread(
    component: Component, n: int, N: int, frame_rate_hz: float, form: Form = "sampled"
) -> float:
    """u^2(n, N) of one component, mm^2; 1 <= n <= N frames of tau0 = 1 / frame_rate_hz.

    White and random walk (steps of variance s^2 = 2 pi^2 tau0 h): h/(2 tau0) (1/n - 1/N) and
    s^2/6 (N - 1/N - n + 1/n). Gauss-Markov and sinusoid: the variance of a mean of n less that of
    a mean of N (over all phases). Flicker, blue, violet: sums of Allan variances over octaves,
    exact where n and N are powers of two, else interpolated (to 2e-3 from 30 frames up).
    `form` continuous: of frames that are averages, so of averages over time; random walk
    s^2/6 (N - n).
    """
    tau0 = 1 / frame_rate_hz
    if isinstance(component, GaussMarkov):
        a = tau0 / component.T_c
        if form == "continuous":
            return component.variance * (_time_mean(n * a) - _time_mean(N * a))
        return component.variance * (_correlated_mean(n, a) - _correlated_mean(N, a))
    if isinstance(component, Sinusoid):
        x = math.pi * component.f_0 * tau0
        alternates = abs(component.f_0 * tau0 - 0.5) < 1e-9  # at Nyquist every sample is +-A
        variance = component.recorded(frame_rate_hz, form) ** 2 / (1 if alternates else 2)
        return variance * (_gain(n, x) - _gain(N, x))
    if component.alpha == 0:
        return component.h / (2 * tau0) * (1 / n - 1 / N)
    if component.alpha == -2:
        ends = 0.0 if form == "continuous" else 1 / n - 1 / N
        return 2 * math.pi**2 * tau0 * component.h / 6 * (N - n + ends)
    return _by_octaves(component, n, N, frame_rate_hz, form)


def _correlated_mean(n: int, a: float) -> float:
    """Variance of the mean of n samples of an AR(1) series of variance 1, phi = exp(-a)."""
    if n == 1:
        return 1.0
    q, p = -math.expm1(-a), -math.expm1(-n * a)
    return (n * q * (2 - q) - 2 * (1 - q) * p) / (n * q) ** 2


def _time_mean(x: float) -> float:
    """Variance of the mean over x correlation times of a Gauss-Markov component of variance 1."""
    if x < 1e-4:
        return 1 - x / 3 + x**2 / 12
    return 2 * (x + math.expm1(-x)) / x**2


def _gain(n: int, x: float) -> float:
    """|mean of n points of exp(2 i x k)|^2."""
    if abs(math.sin(x)) < 1e-9:  # aliased to a constant
        return 1.0
    return (math.sin(n * x) / (n * math.sin(x))) ** 2


def _by_octaves(law: PowerLaw, n: int, N: int, frame_rate_hz: float, form: Form) -> float:
    octaves = np.arange(math.ceil(math.log2(N)) + 2)
    if law.alpha < 0:  # W grows by the same amount each octave
        halves = law.avar(2.0**octaves, frame_rate_hz, form) / 2
        within = np.concatenate([[0.0], np.cumsum(halves)[:-1]])
        at = np.interp(np.log2([n, N]), octaves, within)
        return float(at[1] - at[0])
    octaves = np.arange(octaves.size + OCTAVES)
    left = np.cumsum((law.avar(2.0**octaves, frame_rate_hz, form) / 2)[::-1])[
        ::-1
    ]  # variance of a mean of 2^k
    if law.h == 0:
        return 0.0
    at = np.exp(np.interp(np.log2([n, N]), octaves, np.log(left)))
    return float(at[0] - at[1])


@dataclass(frozen=True)
class Share:
    """A kind of noise and its share of u^2; T_c_s of correlated noise, f_hz of a line, else NaN."""

    kind: str
    share: float
    T_c_s: float = math.nan
    f_hz: float = math.nan

    @property
    def name(self) -> str:
        """`white`, `correlated (T_c 1380 s)`, `periodic (14.4 Hz)`: what a reader calls it."""
        if self.kind == "correlated":
            return f"correlated (T_c {_three_digits(self.T_c_s)} s)"
        return f"periodic ({_three_digits(self.f_hz)} Hz)" if self.kind == "periodic" else self.kind


def joined(shares: Iterable[Share]) -> tuple[Share, ...]:
    """Those of one name added up, in order of their first."""
    totals: dict[str, Share] = {}
    for one in shares:
        before = totals.get(one.name)
        totals[one.name] = replace(one, share=before.share + one.share) if before else one
    return tuple(totals.values())


def kind(component: Component, frame_rate_hz: float) -> str:
    """Name of a component for a reader."""
    return _share(component, frame_rate_hz, 0.0).name


def _share(component: Component, frame_rate_hz: float, share: float) -> Share:
    """A correlation that is over within a frame is white noise."""
    if isinstance(component, PowerLaw):
        return Share(NAMES[component.alpha], share)
    if isinstance(component, Sinusoid):
        return Share("periodic", share, f_hz=component.f_0)
    white = component.T_c <= 1 / frame_rate_hz
    return Share("white", share) if white else Share("correlated", share, T_c_s=component.T_c)


def _three_digits(value: float) -> str:
    """Three digits: 0.225, 1380."""
    return f"{float(f'{value:.3g}'):.10g}"


class WithShares:
    """What has `kinds` of noise."""

    kinds: tuple[Share, ...]

    @property
    def shares(self) -> dict[str, float]:
        """Share of u^2 of each kind by its name."""
        return {one.name: one.share for one in self.kinds}


@dataclass(frozen=True)
class Spread(WithShares):
    """u (mm) with its interval, and the kinds of noise with their shares of u^2 (they add up to
    1)."""

    value: float
    lower: float
    upper: float
    kinds: tuple[Share, ...]


def expected_spread(
    model: NoiseModel,
    n: int,
    N: int,
    frame_rate_hz: float,
    recorded: int,
    confidence: float = 0.683,
    part: Deterministic = NO_PART,
    A_error: float = math.nan,
) -> Spread:
    """u(n, N) of a model, and a deterministic part, that were fitted to `recorded` frames.

    The interval is that of the coefficients: ln u normal, its variance from the inverse Fisher
    information of the spectrum (errors of coefficients are correlated, and mostly cancel in u).
    They are of the components that BIC chose, as if it had chosen right: what it did not detect is
    not in the interval. Of 68 % ones of recordings of two minutes, with N the whole recording, 0
    to 69 % held the truth (`series.assess_series` widens them by what was measured).
    A_error: standard error of A_s, mm, where it is not that of a sinusoid (`wide_line_error`).
    """
    from scipy.special import ndtri

    tau0 = 1 / frame_rate_hz
    parts = [spread(c, n, N, frame_rate_hz, model.form) for c in model.components]
    still = part.variance_of_means(n * tau0, N * tau0, recorded * tau0)
    total = sum(parts) + still
    if not total > 0:
        return Spread(0.0, 0.0, 0.0, ())
    shares = [Share(part.name, still / total)] if still else []
    for component, variance in zip(model.components, parts, strict=True):
        shares.append(_share(component, frame_rate_hz, variance / total))
    error = (
        math.sqrt(_variance(model, n, N, frame_rate_hz, recorded, A_error)) / total / 2
    )  # of ln u
    wide = float(ndtri((1 + confidence) / 2)) * min(error, 50.0)
    value = math.sqrt(total)
    return Spread(value, value * math.exp(-wide), value * math.exp(wide), joined(shares))


def wide_line_error(noise_rows: Iterable[NoiseRow]) -> float:
    """Standard error of A_s, mm, of a line whose frequency wanders, out of rows of noise.csv of one
    series and estimator: greater than that of a sinusoid, as it fills a band. NaN where the line is
    a sinusoid, or none."""
    rows = {r["parameter"]: r for r in noise_rows if r["status"] not in ("not_detected", "refused")}
    return float(rows["A_s"]["std_error"]) if {"A_s", "width_f"} <= rows.keys() else math.nan


def _variance(
    model: NoiseModel, n: int, N: int, frame_rate_hz: float, recorded: int, A_error: float
) -> float:
    """Variance of u^2 by the errors of the coefficients (h, ln q_c^2, ln T_c; A_s)."""
    tau0 = 1 / frame_rate_hz
    broadband, form = replace(model, components=model.broadband).ordered(), model.form
    spectrum = spectrum_of(broadband)
    gradient = [spread(PowerLaw(alpha, 1.0), n, N, frame_rate_hz, form) for alpha in spectrum.h]
    for q2, T_c in zip(spectrum.q2, spectrum.T_c, strict=True):
        term = GaussMarkov(math.sqrt(q2), float(T_c))
        near = [replace(term, T_c=T_c * math.exp(sign * STEP)) for sign in (-1, 1)]
        ends = [spread(one, n, N, frame_rate_hz, form) for one in near]
        gradient += [spread(term, n, N, frame_rate_hz, form), (ends[1] - ends[0]) / (2 * STEP)]
    bins = bins_of(recorded, frame_rate_hz, form=form)
    weight = bins.n.astype(float)
    data = Periodogram(bins, np.ones(weight.size), weight)
    information = Likelihood(data, (tau0 / 2, recorded * tau0)).information(spectrum)
    total = _quadratic(np.array(gradient), information) if gradient else 0.0
    for line in model.lines:
        at = np.array([min(line.f_0, 0.5 / tau0)])
        high = line.recorded(frame_rate_hz, form)
        error = line_errors(high, float(broadband.psd(at, frame_rate_hz)[0]), recorded * tau0)[0]
        if math.isfinite(A_error) and line.A_s > 0:  # of A_s itself
            error = A_error * high / line.A_s
        if high > 0 and math.isfinite(error):
            total += (2 * spread(line, n, N, frame_rate_hz, form) * error / high) ** 2
    return total


def _quadratic(gradient: np.ndarray, information: np.ndarray) -> float:
    """g' I^-1 g, without what the spectrum does not depend on."""
    diagonal = np.diag(information)
    known = diagonal > 1e-290
    scale = 1 / np.sqrt(diagonal[known])
    value, vector = np.linalg.eigh(scale[:, None] * information[np.ix_(known, known)] * scale)
    along = vector.T @ (gradient[known] * scale)
    return float(np.sum(along**2 / np.maximum(value, 1e-12)))
