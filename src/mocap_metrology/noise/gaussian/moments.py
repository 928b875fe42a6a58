"""Moments a recording of finite length may show: their expectation and their scatter.

Random walk and slow correlated noise make mean, standard deviation and correlation of nine hours a
matter of chance. `expected_variance` and `mean_variance` are their expectations, in closed form for
continuous time over T (sampling changes them by parts of tau0/T); `pair_moments` draws as many
recordings of a twin as wanted.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mocap_metrology.noise.gaussian.two_markers import GaussianModel, table_4
from mocap_metrology.noise.model.components import Component, GaussMarkov, NoiseModel, Sinusoid
from mocap_metrology.noise.model.synthesis import (
    circle_length,
    circle_normals,
    implied_coherence,
    increment_spectrum,
)
from mocap_metrology.noise.twins.twin import Twin

SLOW_SAMPLES = 1 << 15  # of a recording: what is slower than two of them is drawn, one by one
FAST_POINTS = 4001  # of the integral over what is faster
QUANTITIES = tuple(GaussianModel.__dataclass_fields__)


def expected_variance(model: NoiseModel, duration_s: float, frame_rate_hz: float) -> float:
    """Expected sample variance, mm^2, over T: of the points about their own mean.

    Random walk pi^2 h_-2 T / 3; flicker h_-1 (ln(2 pi f_h T) + gamma - 3/2); Gauss-Markov, with
    r = T_c/T, var [1 - 2 r + 2 r^2 (1 - e^(-1/r))]; sinusoid (A^2/2) (1 - sinc^2(f_0 T));
    white, blue and violet all they have up to f_h.
    """
    tau0 = 1 / frame_rate_hz
    return sum(_variance(part, duration_s, 0.5 / tau0)[0] for part in model.components)


def mean_variance(model: NoiseModel, duration_s: float, frame_rate_hz: float) -> float:
    """Mean square, mm^2, of the mean over T less the first point: a recording has no other
    reference, as random walk has no mean to estimate.

    Random walk 2 pi^2 h_-2 T / 3; flicker h_-1 (ln(2 pi f_h T) + gamma - 1/2); Gauss-Markov
    var [1 + 2 r (1 - r e) - 2 r e], e = 1 - e^(-1/r); sinusoid (A^2/2) (1 - 2 sinc(2 f_0 T) +
    sinc^2(f_0 T)); white, blue and violet what the first point has.
    """
    tau0 = 1 / frame_rate_hz
    return sum(_variance(part, duration_s, 0.5 / tau0)[1] for part in model.components)


def _variance(part: Component, duration_s: float, f_h: float) -> tuple[float, float]:
    """Sample variance, and mean square of mean less first point."""
    if isinstance(part, GaussMarkov):
        r = part.T_c / duration_s
        e = -math.expm1(-1 / r)
        of_mean = 2 * r * (1 - r * e)
        return part.variance * (1 - of_mean), part.variance * (1 + of_mean - 2 * r * e)
    if isinstance(part, Sinusoid):
        turns = part.f_0 * duration_s
        of_mean = float(np.sinc(turns)) ** 2
        both = 1 - 2 * float(np.sinc(2 * turns)) + of_mean
        return part.A_s**2 / 2 * (1 - of_mean), part.A_s**2 / 2 * both
    if part.alpha == -2:
        each = math.pi**2 * part.h * duration_s / 3
        return each, 2 * each
    if part.alpha == -1:
        octaves = math.log(2 * math.pi * f_h * duration_s) + np.euler_gamma
        return part.h * (octaves - 1.5), part.h * (octaves - 0.5)
    white = part.h * f_h ** (part.alpha + 1) / (part.alpha + 1)
    return white, white


def expected_moments(twin: Twin) -> dict[str, float]:
    """Root of the expected sample variance of x1, x2 and L (`sigma_1`, `sigma_2`, `sigma_L`), the
    expected covariance (`sigma_12`), and the standard errors of the means about the first frame
    (`mu_1`, `mu_2`, `mu_L`), mm, of a recording of a twin; L along x.

    With a model of L: sums over the spectra, so right as far as no coherence is clipped.
    """
    moments: dict[str, float] = {}
    a, b = (twin.scale.get(s, 1.0) for s in ("x1", "x2"))
    for names, of in (
        (("sigma_1", "sigma_2", "sigma_L"), expected_variance),
        (("mu_1", "mu_2", "mu_L"), mean_variance),
    ):
        v_1, v_2, *rest = (
            of(twin.models[s], twin.duration_s, twin.frame_rate_hz) for s in _names(twin)
        )
        common = (v_1 + v_2 - rest[0]) / 2 * twin.coherence_factor if rest else 0.0
        v_1, v_2, v_12 = a * a * v_1, b * b * v_2, a * b * common
        moments |= dict(zip(names, map(math.sqrt, (v_1, v_2, v_1 + v_2 - 2 * v_12)), strict=True))
        moments.setdefault("sigma_12", v_12)
    return moments


@dataclass(frozen=True)
class Cleaning:
    """What an outlier filter does to noise without outliers (`hampel.white_level_kept`): it leaves
    the share `kept` of the variance of what is faster than its window, that is above `above_hz`.

    In series cleaned one by one the tails of both go, so of what they have in common kept^2 is
    left (for small correlations)."""

    kept: float = 1.0
    above_hz: float = 0.5


@dataclass(frozen=True)
class _Slow:
    """What is drawn: spectral amplitudes (3, k) over bins of x1, x2 and of what y and z add to the
    distance, and the coherence of the first two; n_slow of every step-th frame. fast: covariance
    (3, 3) of the faster bins."""

    amplitude: np.ndarray
    coherence: np.ndarray
    fast: np.ndarray
    length: int
    n_slow: int


def pair_moments(
    twin: Twin,
    repeats: int,
    rng: np.random.Generator,
    cleaning: Cleaning | None = None,
    slow_samples: int = SLOW_SAMPLES,
) -> dict[str, np.ndarray]:
    """Moments of x1, x2 and their distance in `repeats` recordings of a twin: (repeats,) of every
    one of `QUANTITIES`, the columns of S Table 4; the means less the values in the first frame.

    Drawn is what `simulate` draws, the same spectra on the same kind of circle, but only its
    lowest frequencies, and of a long recording only every so many-th frame (`slow_samples` at
    least). What is faster enters by its stationary variance and covariance, of which a recording
    holds so many periods that they scatter by less than 1 %. L is taken along the line between
    the markers at their start (to first order; a line 0.3 degrees off x still lets y and z wander
    into it). Without outliers, crump, drift, gaps and sinusoids of y and z; as recorded, or as
    `cleaning` leaves it, L as a series of its own.
    """
    slow = _slow(twin, slow_samples)
    scale = np.array([twin.scale.get("x1", 1.0), twin.scale.get("x2", 1.0), 1.0])
    fast = slow.fast.copy()
    fast[:2, :2] += _line_covariance(twin)
    tiny = 1e-12 * np.trace(fast) + 1e-300
    spread = np.linalg.cholesky(fast + tiny * np.eye(3))
    along = direction(twin)[0]
    weights = np.array([along, -along, 1.0])  # of L = along (x1 - x2) + what y and z add
    lost, lost_L = _filtered_covariance(twin, cleaning or Cleaning(), along)
    rows = np.empty((repeats, 7))
    for k in range(repeats):
        x = _draw(slow, rng)
        covariance = (np.cov(x) + fast) * np.outer(scale, scale)
        means = scale * (x.mean(axis=1) - x[:, 0] - spread @ rng.standard_normal(3))
        v_1, v_12, v_2 = (covariance[:2, :2] - lost)[[0, 0, 1], [0, 1, 1]]
        v_L = weights @ covariance @ weights - lost_L
        rows[k] = *means[:2], v_1, v_2, v_12, weights @ means, v_L
    return _quantities(rows, math.copysign(1.0, along))


def direction(twin: Twin) -> np.ndarray:
    """(3,) unit vector from marker 2 to marker 1 at the start."""
    line = np.subtract(*twin.start_mm)
    return line / np.linalg.norm(line)


def _quantities(rows: np.ndarray, sign: float) -> dict[str, np.ndarray]:
    """The columns of S Table 4 out of (repeats, 7) means, variances and covariance; `sign` of
    x1 - x2, as mu_e is never negative."""
    mu_1, mu_2, v_1, v_2, v_12, mu_L, v_L = rows.T
    return table_4(mu_1, mu_2, mu_L, v_1, v_12, v_2, v_L) | {"mu_e": sign * (mu_1 - mu_2)}


def _slow(twin: Twin, slow_samples: int) -> _Slow:
    """Spectra of the differences at the lowest bins of the circle, divided by the gain of the
    difference (but in bin 0, the drift), and the rest's variance."""
    rate = twin.frame_rate_hz
    n, tau0 = round(twin.duration_s * rate), 1 / rate
    step = max(n // slow_samples, 1)
    n_slow = -(-n // step)
    short = circle_length(n_slow + 1)
    length, bins = step * short, short // 2

    def of_differences(series: str) -> np.ndarray:
        return increment_spectrum(twin.models[series], length, rate, bins, twin.form)

    spectra = np.array([of_differences(series) for series in _names(twin)])
    rise = (np.exp(2j * np.pi * np.arange(bins) / length) - 1) * step
    rise[0] = 1.0
    drawn = np.array([*spectra[:2], _transverse_spectrum(twin, of_differences)])
    amplitude = np.sqrt(drawn * (length / (2 * tau0))) / rise
    fast = _fast_covariance(twin, (bins - 0.5) / (length * tau0))
    return _Slow(amplitude, _coherence(twin, spectra), fast, short, n_slow)


def _transverse_spectrum(twin: Twin, spectrum: Callable[[str], np.ndarray]) -> np.ndarray:
    """Spectrum of what y and z add to the distance, given one of any of their series."""
    total: np.ndarray = np.zeros(())
    for letter, part in zip("yz", direction(twin)[1:], strict=True):
        names = [f"{letter}{k}" for k in (1, 2)]
        first, second = (twin.scale.get(name, 1.0) ** 2 * spectrum(name) for name in names)
        difference = first + second - 2 * twin.yz_coherence * np.sqrt(first * second)
        total = total + part**2 * difference
    return total


def _names(twin: Twin) -> tuple[str, ...]:
    return ("x1", "x2", "L") if "L" in twin.models else ("x1", "x2")


def _coherence(twin: Twin, spectra: np.ndarray) -> np.ndarray:
    """Coherence of both markers as simulated: clipped, times the factor of the twin; zero without a
    model of L."""
    if spectra.shape[0] == 2:
        return np.zeros(spectra.shape[1])
    return np.clip(implied_coherence(*spectra), -1.0, 1.0) * twin.coherence_factor


def _fast_covariance(twin: Twin, edge_hz: float) -> np.ndarray:
    """(3, 3) integrals of the spectra from `edge_hz` up: of x1 and x2, their common part, and of
    what y and z add to the distance."""
    tau0 = 1 / twin.frame_rate_hz
    log_f = np.linspace(math.log(edge_hz), math.log(0.5 / tau0), FAST_POINTS)
    f = np.exp(log_f)

    def density(series: str) -> np.ndarray:
        return twin.models[series].psd(f, twin.frame_rate_hz, twin.form)

    spectra = np.array([density(series) for series in _names(twin)])
    common = _coherence(twin, spectra) * np.sqrt(spectra[0] * spectra[1])
    parts = (*spectra[:2], common, _transverse_spectrum(twin, density))
    v_1, v_2, v_12, across = (np.trapezoid(s * f, log_f) for s in parts)
    return np.array([[v_1, v_12, 0.0], [v_12, v_2, 0.0], [0.0, 0.0, across]])


def _filtered_covariance(twin: Twin, cleaning: Cleaning, along: float) -> tuple[np.ndarray, float]:
    """(2, 2) of x1 and x2, and of L, that the filter takes away."""
    if cleaning.kept == 1.0 or cleaning.above_hz >= twin.frame_rate_hz / 2:
        return np.zeros((2, 2)), 0.0
    scale = [twin.scale.get(s, 1.0) for s in ("x1", "x2")]
    whole = _fast_covariance(twin, cleaning.above_hz)
    fast = whole[:2, :2] * np.outer(scale, scale)
    once, twice = 1 - cleaning.kept, 1 - cleaning.kept**2
    of_L = once * along**2 * (fast[0, 0] + fast[1, 1] - 2 * fast[0, 1])
    of_L += once * whole[2, 2]
    return fast * np.array([[once, twice], [twice, once]]), float(of_L)


def _line_covariance(twin: Twin) -> np.ndarray:
    """(2, 2) of the sinusoids, whole periods of them; L's goes half into x1 and x2 (`simulate`)."""
    covariance = np.zeros((2, 2))
    squares = {
        series: [line.recorded(twin.frame_rate_hz, twin.form) ** 2 for line in model.lines]
        for series, model in twin.models.items()
    }
    for k, series in enumerate(("x1", "x2")):
        covariance[k, k] += sum(square / 2 for square in squares[series])
    if twin.distance_line == "split":
        share = sum(square / 8 for square in squares.get("L", ()))
        covariance += share * np.array([[1.0, -1.0], [-1.0, 1.0]])
    return covariance


def _draw(slow: _Slow, rng: np.random.Generator) -> np.ndarray:
    """(3, n_slow) slow parts of x1, x2 and of what y and z add to L, each 0 at first.

    x_j = sum_(i<j) d_i of the circle's differences d is A_0 j + sum_k A_k (e^(i w j) - 1) /
    (e^(i w) - 1): bin by bin, at every step-th j.
    """
    from scipy.fft import irfft

    bins = slow.coherence.size
    first, second, third = (circle_normals(slow.length, rng)[:bins] for _ in range(3))
    second = slow.coherence * first + np.sqrt(1 - slow.coherence**2) * second
    amplitude = slow.amplitude * np.array([first, second, third])
    drift = amplitude[:, 0].real / slow.length
    amplitude[:, 0] = 0.0
    x = irfft(amplitude, slow.length, axis=1, workers=1)[:, : slow.n_slow]
    x -= x[:, :1].copy()
    return x + drift[:, None] * np.arange(slow.n_slow)
