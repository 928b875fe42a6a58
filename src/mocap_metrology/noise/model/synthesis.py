"""Random series whose Allan variance is a noise model's, alone or as correlated pairs: of frames
that are points (`sampled`) or averages over the frame period (`continuous`, see `sampling`).

Drawn are first differences D, which are stationary even where the series is not (random walk,
correlation times beyond the recording), on a circle of M >= 2n frames (circulant embedding, after
Davies & Harte 1987 and Dietrich & Newsam 1997); n - 1 of them are kept and summed from 0. On
the circle D has the spectrum of its autocovariance cut at lag M/2, so every lag in the recording
is right. That is 4 sin^2(pi f tau0) S(f), corrected in the lowest bins for what lies beyond M/2:
without the correction a Gauss-Markov component with T_c far above the recording would become a
bridge (Allan variance at n/3 a quarter too low) and flicker noise would lose 3 %.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from copy import deepcopy
from typing import NamedTuple

import numpy as np

from mocap_metrology.common.transforms import irfft
from mocap_metrology.noise.model.components import (
    Form,
    GaussMarkov,
    NoiseModel,
    PowerLaw,
    four_sin2,
)
from mocap_metrology.noise.model.sampling import correlated_gain

CORRECTED_BINS = 1024  # beyond, the correction is below 1e-7 of the spectrum
BLOCK = 1 << 15  # bins at a time: stays in the processor's cache
NO_TAIL = 40.0  # frames over T_c from which nothing is left beyond half the circle: exp(-120)


def circle_length(n: int) -> int:
    """Even, fast for the FFT, at least 2 (n - 1)."""
    from scipy.fft import next_fast_len

    return int(2 * next_fast_len(max(n - 1, 4), real=True))


def increment_spectrum(
    model: NoiseModel,
    length: int,
    frame_rate_hz: float,
    bins: int | None = None,
    form: Form = "sampled",
) -> np.ndarray:
    """One-sided spectrum of the differences, mm^2/Hz, at k / (length tau0), k = 0 ... length/2 or
    the first `bins` of them."""
    tau0 = 1 / frame_rate_hz
    spectrum = np.zeros(length // 2 + 1 if bins is None else bins)
    for start in range(1, spectrum.size, BLOCK):
        stop = min(start + BLOCK, spectrum.size)
        f = np.arange(start, stop) / (length * tau0)
        gain = four_sin2(f, frame_rate_hz)
        for component in model.broadband:
            spectrum[start:stop] += gain * component.psd(f, frame_rate_hz, gain, form)
    low = spectrum[:CORRECTED_BINS]
    for component in model.broadband:
        if isinstance(component, GaussMarkov):
            low += _correlated_tail(component, length, frame_rate_hz, low.size, form)
        elif component.alpha == -1:
            low += _flicker_tail(component, length, frame_rate_hz, low.size)
        elif component.alpha == -2:
            low[0] += component.h * (2 * np.pi * tau0) ** 2
    return spectrum


def _correlated_tail(
    part: GaussMarkov, length: int, frame_rate_hz: float, bins: int, form: Form
) -> np.ndarray:
    """-2 tau0 * 2 sum over j > M/2 of R_D(j) cos(2 pi j k/M), R_D(j) = -var (1-phi)^2 phi^(j-1),
    of averages `correlated_gain` times that; the lag M/2 itself counts half. A geometric series."""
    tau0 = 1 / frame_rate_hz
    a = tau0 / part.T_c
    if a > NO_TAIL:
        return np.zeros(bins)
    variance = part.variance * (correlated_gain(a) if form == "continuous" else 1.0)
    k = np.arange(bins)
    sign = np.where(k % 2 == 0, 1.0, -1.0)
    one_minus = -np.expm1(-a)
    denominator = one_minus**2 + np.exp(-a) * 4 * np.sin(np.pi * k / length) ** 2
    beyond = np.exp(-a * (length / 2 - 1)) * -np.expm1(-2 * a)
    return 2 * tau0 * variance * one_minus**2 * beyond * sign / denominator


def _flicker_tail(part: PowerLaw, length: int, frame_rate_hz: float, bins: int) -> np.ndarray:
    """The same for R_D(j) = -h / j^2 (far lags of flicker, points or averages), the sum taken as
    an integral: Int_1^inf cos(a t)/t^2 dt = cos a - a (pi/2 - Si(a)), a = pi k."""
    from scipy.special import sici

    tau0 = 1 / frame_rate_hz
    a = np.pi * np.arange(bins)
    integral = np.cos(a) - a * (np.pi / 2 - sici(a)[0])
    return 8 * tau0 * part.h / length * integral


class Cross(NamedTuple):
    """How two series go together: by the model of their difference, which implies a coherence
    (clipped to [-1, 1]), and a factor on it; or, without such a model, by a constant coherence."""

    difference: NoiseModel | None = None
    factor: float = 1.0
    constant: float = 0.0


class Shared(NamedTuple):
    """Random numbers of the frequencies below `below_hz`, for several pairs of series alike."""

    rng: np.random.Generator
    below_hz: float


def implied_coherence(first: np.ndarray, second: np.ndarray, difference: np.ndarray) -> np.ndarray:
    """(S_1 + S_2 - S_d) / (2 sqrt(S_1 S_2)), 0 where a spectrum is 0."""
    scale = 2 * np.sqrt(first * second)
    return np.divide(first + second - difference, scale, out=np.zeros_like(scale), where=scale > 0)


def coherence(
    models: Mapping[str, NoiseModel], f: np.ndarray, frame_rate_hz: float, form: Form = "sampled"
) -> np.ndarray:
    """(S_x1 + S_x2 - S_L) / (2 sqrt(S_x1 S_x2)) of the frames' spectra, not clipped: what the
    models of x1, x2 and their distance L imply. Beyond [-1, 1] the three contradict each other."""
    return implied_coherence(
        *(models[series].psd(f, frame_rate_hz, form) for series in ("x1", "x2", "L"))
    )


def clipped_bands(
    models: Mapping[str, NoiseModel], frame_rate_hz: float, n: int, form: Form
) -> list[list[float]]:
    """Bands [f_lo, f_hi] in Hz within frame_rate/n ... Nyquist where |coherence| > 1 and the
    simulation clips it, so that the distance differs from its model there; edges to 1 %."""
    if "L" not in models:
        return []
    low, high = frame_rate_hz / n, frame_rate_hz / 2
    f = np.geomspace(low, high, max(2, int(np.log(high / low) * 200)))
    clipped = np.abs(coherence(models, f, frame_rate_hz, form)) > 1
    edges = np.flatnonzero(np.diff(np.concatenate([[False], clipped, [False]])))
    return [[float(f[a]), float(f[b - 1])] for a, b in edges.reshape(-1, 2)]


def draw_pair(
    first: NoiseModel,
    second: NoiseModel,
    cross: Cross,
    n: int,
    frame_rate_hz: float,
    rng: np.random.Generator,
    form: Form = "sampled",
    shared: Shared | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Two series of n values in mm, each 0 at its first frame, without the models' sinusoids.

    Per frequency, with independent complex normals n1 and n2 and the real coherence c:
    X1 = sqrt(S1) n1, X2 = sqrt(S2) (c n1 + sqrt(1 - c^2) n2).
    """
    length = circle_length(n)
    both = [increment_spectrum(one, length, frame_rate_hz, form=form) for one in (first, second)]
    if cross.difference is None:
        c = np.full_like(both[0], cross.constant)
    else:
        third = increment_spectrum(cross.difference, length, frame_rate_hz, form=form)
        c = implied_coherence(both[0], both[1], third)
        np.clip(c, -1.0, 1.0, out=c)
        c *= cross.factor
        del third
    slow_first, slow_own = np.empty(0), np.empty(0)
    if shared is not None:
        slow = min(int(shared.below_hz * length * (1 / frame_rate_hz)) + 1, length // 2)
        slow_first, slow_own = (circle_normals(2 * slow, shared.rng)[:slow] for _ in range(2))
    again = deepcopy(rng)  # the first normals are drawn twice: of 90 hours they are 1.2 GB
    amplitude = circle_normals(length, rng)
    amplitude[: slow_first.size] = slow_first
    for start in range(0, amplitude.size, BLOCK):
        amplitude[start : start + BLOCK] *= np.sqrt(both[0][start : start + BLOCK])
    del both[0]
    one = _series(amplitude, n, length, frame_rate_hz)
    del amplitude
    amplitude = circle_normals(length, again)
    amplitude[: slow_first.size] = slow_first
    for part, normals in _normals(length, rng):
        common = slow_own[part]
        normals[: common.size] = common
        normals *= np.sqrt(1 - c[part] * c[part])
        normals += amplitude[part] * c[part]
        amplitude[part] = normals * np.sqrt(both[0][part])
    del c, both
    return one, _series(amplitude, n, length, frame_rate_hz)


def draw(
    spectrum: np.ndarray, n: int, length: int, frame_rate_hz: float, rng: np.random.Generator
) -> np.ndarray:
    """A series of n values, 0 at its first, whose differences have the given one-sided spectrum,
    (length/2 + 1,)."""
    return _series(circle_normals(length, rng) * np.sqrt(spectrum), n, length, frame_rate_hz)


def circle_normals(length: int, rng: np.random.Generator) -> np.ndarray:
    """Complex normals of unit mean square for bins 0 ... length/2; the two end bins are real."""
    values = np.empty(length // 2 + 1, complex)
    for part, drawn in _normals(length, rng):
        values[part] = drawn
    return values


def _normals(length: int, rng: np.random.Generator) -> Iterator[tuple[slice, np.ndarray]]:
    """Some bins of `circle_normals` at a time, and their numbers."""
    size = length // 2 + 1
    for start in range(0, size, BLOCK):
        part = slice(start, min(start + BLOCK, size))
        drawn = rng.standard_normal(2 * (part.stop - start))
        drawn *= np.sqrt(0.5)
        drawn = drawn.view(complex)
        for end in (0, size - 1):
            if start <= end < part.stop:
                drawn[end - start] = np.sqrt(2) * drawn[end - start].real
        yield part, drawn


def _series(amplitude: np.ndarray, n: int, length: int, frame_rate_hz: float) -> np.ndarray:
    """Sum the differences whose spectral amplitudes are given (mean square = one-sided S)."""
    tau0 = 1 / frame_rate_hz
    amplitude *= np.sqrt(length / (2 * tau0))
    series = np.zeros(n)
    np.cumsum(irfft(amplitude, length, workers=1, overwrite_x=True)[: n - 1], out=series[1:])
    return series
