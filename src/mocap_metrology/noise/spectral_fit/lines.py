"""Periodic disturbances: lines of a Fourier spectrum that stand above the noise round them.

Searched on the unbinned periodogram, between its frequencies too; amplitude, frequency and phase
by least squares on the Fourier coefficients next to the line, which is maximum likelihood where
the noise is flat over some 16/T Hz.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from mocap_metrology.common.compiled import njit

FIRST_CYCLES = 10  # fewer cycles in a recording cannot be told from a random walk
MEDIAN_FROM = 128  # below, a band of a quarter octave holds too few coefficients for its median
SLOW_SAMPLES = 1 << 13  # block means that show the frequencies below
MEDIAN_OF = 4096  # coefficients at most that a median is taken of
NEAR = 8  # coefficients on each side that the least squares uses: 99 % of a line's power
ROW = 2048  # samples of a sinusoid made at once
END_FRAMES = 16  # averaged at each end for the ramp


@dataclass(frozen=True)
class Line:
    """A_s sin(2 pi f_0 t + phase), t = 0 at the first frame; psd: density of the noise at f_0;
    gain: rise of twice the log likelihood by the line."""

    A_s: float
    f_0: float
    phase: float
    psd: float
    gain: float

    def wave(self, n: int, tau0: float) -> np.ndarray:
        """(n,) samples; the sine of a sum of a slow and a fast angle, so few sines are taken."""
        step = 2 * np.pi * self.f_0 * tau0
        fast = step * np.arange(ROW)
        slow = step * ROW * np.arange(-(-n // ROW))[:, None] + self.phase
        rows = (self.A_s * np.sin(slow)) * np.cos(fast)
        rows += (self.A_s * np.cos(slow)) * np.sin(fast)
        return rows.ravel()[:n]


def line_errors(A_s: float, psd: float, duration_s: float) -> tuple[float, float]:
    """Least standard errors (Cramer-Rao) of A_s and f_0 of a sinusoid of unknown phase in noise of
    one-sided density `psd`: sqrt(S/T) and sqrt(3 S / (pi^2 A^2 T^3)) [Rife & Boorstyn 1974]."""
    if not A_s > 0:
        return math.sqrt(psd / duration_s), math.inf
    return (
        math.sqrt(psd / duration_s),
        math.sqrt(3 * psd / (math.pi**2 * A_s**2 * duration_s**3)),
    )


def threshold(n: int) -> float:
    """Gain in twice the log likelihood that a line must bring in n samples.

    BIC's 3 ln n for three parameters, or, if greater, what noise alone brings in one recording of a
    thousand: with N independent places in the spectrum exp(-gain/2) N = 1/1000, where
    N = 1.25 n, as the places between the n/2 coefficients count too.
    """
    return max(3 * math.log(n), 2 * math.log(1250 * n))


def find_lines(
    series: np.ndarray,
    tau0: float,
    at_most: int = 40,
) -> list[Line]:
    """Lines of a complete series (n,), strongest (greatest gain) first, up to `at_most`; from 128
    cycles in the recording up to Nyquist, which counts too: a difference of odd and even frames.

    A line counts when it raises twice the log likelihood by more than `threshold(n)`. The noise is
    taken from medians of bands a quarter octave wide.
    """
    n = series.size
    last = (n - 1) // 2  # Nyquist's coefficient has no partner
    if last < MEDIAN_FROM + 2 * NEAR:
        return []
    return _search(series, tau0, (MEDIAN_FROM, last), None, at_most, threshold(n))


def find_slow_lines(
    series: np.ndarray, tau0: float, density: Callable[[np.ndarray], np.ndarray], at_most: int = 40
) -> list[Line]:
    """Lines of 10 to 128 cycles in the recording, as `find_lines`; density: the noise spectrum,
    f -> unit^2/Hz, which medians of so few coefficients cannot tell."""
    n = series.size
    step = max(n // SLOW_SAMPLES, 1)
    means = series[: n // step * step].reshape(-1, step).mean(axis=1)
    last = min(MEDIAN_FROM, (means.size - 1) // 2)
    if last < FIRST_CYCLES + 2 * NEAR:
        return []
    found = _search(means, tau0 * step, (FIRST_CYCLES, last), density, at_most, threshold(n))
    # A block's mean is that of its middle, (step - 1)/2 frames after its first
    late = np.pi * tau0 * (step - 1)
    return [replace(line, phase=line.phase - line.f_0 * late) for line in found]


def _search(
    series: np.ndarray,
    tau0: float,
    between_k: tuple[int, int],
    density: Callable[[np.ndarray], np.ndarray] | None,
    at_most: int,
    least_gain: float,
) -> list[Line]:
    from scipy.fft import rfft

    n = series.size
    spectrum = rfft(_without_ramp(series), overwrite_x=True)
    scale = 2 * tau0 / n
    power = scale * (spectrum.real**2 + spectrum.imag**2)
    first, last = between_k
    k = np.arange(first, last)
    level = density(k / (n * tau0)) if density else _level(power, k)
    found: list[Line] = []
    while len(found) < at_most:
        start, peak = _highest(spectrum, power, level, first, scale)
        if peak < 0.4 * least_gain:
            break
        psd = float(level[round(start) - first])
        line = _refined(spectrum, start, n, tau0, psd)
        if line.gain < least_gain:
            break
        found.append(line)
        _take_out(spectrum, power, line, n, tau0)
    if last == (n - 1) // 2 and n % 2 == 0 and len(found) < at_most:
        found += _at_nyquist(spectrum[-1].real, n, tau0, float(level[-1]), least_gain)
    return sorted(found, key=lambda line: -line.gain)


@njit(cache=True)
def _highest(
    spectrum: np.ndarray, power: np.ndarray, level: np.ndarray, first: int, scale: float
) -> tuple[float, float]:
    """Where, in units of 1/T, the power stands highest over the noise, and by what factor.

    Half way between two coefficients it is pi/4 (X_k - X_k+1), whose noise has 2 (pi/4)^2 the
    power of theirs.
    """
    best, place = 0.0, 0.0
    for i in range(level.size):
        k = first + i
        ratio = power[k] / level[i]
        if ratio > best:
            best, place = ratio, float(k)
        apart = spectrum[k] - spectrum[k + 1]
        half = 0.5 * scale * (apart.real**2 + apart.imag**2) / level[i]
        if half > best:
            best, place = half, k + 0.5
    return place, best


def _at_nyquist(
    coefficient: float, n: int, tau0: float, psd: float, least_gain: float
) -> list[Line]:
    """The line at Nyquist if there is one: its coefficient is real, with one degree of freedom."""
    gain = 2 * tau0 / n * coefficient**2 / psd
    if gain < least_gain:
        return []
    phase = math.copysign(math.pi / 2, coefficient)
    return [Line(abs(coefficient) / n, 0.5 / tau0, phase, psd, gain)]


def _without_ramp(series: np.ndarray) -> np.ndarray:
    """Less the straight line through the means of both ends: a loop has no jump to leak."""
    width = min(END_FRAMES, series.size // 2)
    jump = series[-width:].mean() - series[:width].mean()
    slope = jump / max(series.size - width, 1)
    out = np.arange(series.size, dtype=np.float64)
    out *= -slope
    out += series
    out -= out.mean()
    return out


def _level(power: np.ndarray, k: np.ndarray) -> np.ndarray:
    """Noise density at coefficients k: medians of bands, interpolated in log-log.

    The power of one coefficient is exponentially distributed: its median is ln 2 of its mean.
    """
    edge = np.geomspace(k[0] / 1.1, k[-1] + 1, max(round(math.log2(k[-1] / k[0]) * 4), 2) + 1)
    edge = np.unique(edge.astype(np.int64))
    middle = np.sqrt(edge[:-1] * (edge[1:] - 1.0))
    median = np.array(
        [np.median(power[a : b : (b - a) // MEDIAN_OF + 1]) for a, b in pairwise(edge)]
    )
    median = np.log(np.maximum(median / math.log(2), np.finfo(float).tiny))
    return np.exp(np.interp(np.log(k), np.log(middle), median))


def _kernel(f_0: float, k: np.ndarray, n: int, tau0: float) -> np.ndarray:
    """(2, k): Fourier coefficients k >= 1 of cos and sin (2 pi f_0 t) over n frames, less the ramp
    `_without_ramp` takes from them, in closed form."""
    forward, backward = (_dirichlet(sign * f_0 * tau0 - k / n, n) for sign in (1, -1))
    waves = np.stack([(forward + backward) / 2, (forward - backward) / 2j])
    width = min(END_FRAMES, n // 2)
    angle = 2 * np.pi * f_0 * tau0 * np.stack([np.arange(width), np.arange(n - width, n)])
    ends = np.stack([np.cos(angle), np.sin(angle)]).mean(axis=2)
    slope = (ends[:, 1] - ends[:, 0]) / max(n - width, 1)
    ramp = n / np.expm1(-2j * np.pi * k / n)
    return waves - slope[:, None] * ramp


def _dirichlet(delta: np.ndarray, n: int) -> np.ndarray:
    """sum of exp(2 pi i delta t), t = 0 ... n - 1."""
    sine = np.sin(np.pi * delta)
    safe = np.where(np.abs(sine) < 1e-15, 1.0, sine)
    size = np.where(np.abs(sine) < 1e-15, n, np.sin(np.pi * n * delta) / safe)
    return np.exp(1j * np.pi * (n - 1) * delta) * size


def _refined(spectrum: np.ndarray, start: float, n: int, tau0: float, psd: float) -> Line:
    """Least squares of the coefficients within NEAR of `start` (in units of 1/T)."""
    from scipy.optimize import minimize_scalar

    k = np.arange(max(1, round(start) - NEAR), min(spectrum.size - 1, round(start) + NEAR) + 1)
    data = spectrum[k]
    y = np.concatenate([data.real, data.imag])

    def solved(place: float) -> tuple[np.ndarray, float]:
        columns = _kernel(place / (n * tau0), k, n, tau0)
        matrix = np.concatenate([columns.real, columns.imag], axis=1).T
        x, *_ = np.linalg.lstsq(matrix, y, rcond=None)
        return x, float(np.sum((y - matrix @ x) ** 2))

    best = minimize_scalar(
        lambda place: solved(place)[1],
        bounds=(start - 1, start + 1),
        method="bounded",
        options={"xatol": 1e-6},
    )
    (cosine, sine), rest = solved(best.x)
    gain = (np.sum(y**2) - rest) * 2 * tau0 / n / psd * 2
    amplitude = math.hypot(cosine, sine)
    return Line(amplitude, best.x / (n * tau0), math.atan2(cosine, sine), psd, float(gain))


def _take_out(spectrum: np.ndarray, power: np.ndarray, line: Line, n: int, tau0: float) -> None:
    """Subtract a line from `spectrum` and `power`, as far out as it can be seen."""
    centre = round(line.f_0 * n * tau0)
    reach = int(100 + 10 * math.sqrt(line.gain))
    k = np.arange(max(1, centre - reach), min(spectrum.size, centre + reach))
    cosine, sine = _kernel(line.f_0, k, n, tau0)
    spectrum[k] -= line.A_s * (math.sin(line.phase) * cosine + math.cos(line.phase) * sine)
    power[k] = 2 * tau0 / n * (spectrum[k].real ** 2 + spectrum[k].imag ** 2)


def line_at(series: np.ndarray, tau0: float, f_0: float, psd: float) -> Line:
    """The line nearest to f_0 (within 1/T) of a complete series, significant or not."""
    from scipy.fft import rfft

    return _refined(rfft(_without_ramp(series)), f_0 * series.size * tau0, series.size, tau0, psd)


def warm_up() -> None:
    """Compile the kernel."""
    find_lines(np.random.default_rng(0).normal(size=400), 1.0)
