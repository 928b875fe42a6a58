"""Periodic disturbances: lines of a Fourier spectrum above the noise around them.

Searched on the unbinned periodogram, between its frequencies too; amplitude, frequency and phase
by least squares on the Fourier coefficients next to the line, which is maximum likelihood where
the noise is flat over some 16/T Hz. Where one sinusoid does not take a line away, as its frequency
wanders, the line is the whole band that it fills (`line`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.common.transforms import rfft
from mocap_metrology.common.types import Floats
from mocap_metrology.noise.fit.spectral.line import (
    MARGIN,
    NEAR_COEFFICIENTS,
    Line,
    beside,
    grown,
    kernel,
    level,
    line_errors,
    measured,
    refined,
    without_ramp,
)

__all__ = [
    "Line",
    "bands_of",
    "find_lines",
    "find_slow_lines",
    "line_again",
    "line_at",
    "line_errors",
]

FIRST_CYCLES = 10  # fewer cycles in a recording look like a random walk
MEDIAN_FROM = 128  # below, a band of a quarter octave holds too few coefficients for its median
SLOW_SAMPLES = 1 << 13  # block means that show the frequencies below
ONE_BAND = 3  # lines so near to each other (`_reach`) are one of finite width
UNRESOLVED = 3.0  # coefficients: two lines within are one of finite width
MIRRORED = 8.0  # power over noise of a sideband's other side: exp(-8), three places
REST = (3, 8, 24)  # coefficients a side in which one sinusoid must leave nothing
REST_P = 1e-4  # probability that noise leaves so much there
TRIES = 20  # places that look like a line and are none
WIDEST = 0.05  # width over frequency of a line


def threshold(n: int) -> float:
    """Gain in twice the log likelihood that a line must bring in n samples.

    BIC's 3 ln n for three parameters, or, if greater, what noise alone brings in one recording of a
    thousand: with N independent places in the spectrum exp(-gain/2) N = 1/1000, where
    N = 1.25 n, as the places between the n/2 coefficients count too. (With the noise's level taken
    from the spectrum, 4 of 1200 series of 24 000 white samples.)
    """
    return max(3 * math.log(n), 2 * math.log(1250 * n))


def find_lines(
    series: np.ndarray,
    frame_rate_hz: float,
    at_most: int = 40,
) -> list[Line]:
    """Lines of a complete series (n,), strongest (greatest gain) first, up to `at_most`; from 128
    cycles in the recording up to Nyquist, which counts too: a difference of odd and even frames.

    A line counts when it raises twice the log likelihood by more than `threshold(n)`. The noise is
    taken from medians of bands a quarter octave wide, or of the bands on either side of the line
    where they are higher.
    """
    tau0 = 1 / frame_rate_hz
    n = series.size
    last = (n - 1) // 2  # Nyquist's coefficient has no partner
    if last < MEDIAN_FROM + 2 * NEAR_COEFFICIENTS:
        return []
    return _search(series, tau0, (MEDIAN_FROM, last), None, at_most, threshold(n))


def find_slow_lines(
    series: np.ndarray,
    frame_rate_hz: float,
    density: Callable[[np.ndarray], np.ndarray],
    at_most: int = 40,
) -> list[Line]:
    """Lines of 10 to 128 cycles in the recording, as `find_lines`; density: the noise spectrum,
    f -> unit^2/Hz, which medians of so few coefficients cannot resolve."""
    tau0 = 1 / frame_rate_hz
    n = series.size
    step = max(n // SLOW_SAMPLES, 1)
    means = series[: n // step * step].reshape(-1, step).mean(axis=1)
    last = min(MEDIAN_FROM, (means.size - 1) // 2)
    if last < FIRST_CYCLES + 2 * NEAR_COEFFICIENTS:
        return []
    found = _search(means, tau0 * step, (FIRST_CYCLES, last), density, at_most, threshold(n))
    return [_of_means(line, step, tau0) for line in found]


def _of_means(line: Line, step: int, tau0: float) -> Line:
    """The line of the series itself: a block's mean is that of its middle, (step - 1)/2 frames
    after its first."""
    if line.parts is None:
        return replace(line, phase=line.phase - line.f_0 * np.pi * tau0 * (step - 1))
    period = line.period * step
    k = line.first + np.arange(line.parts.size)
    parts = line.parts * step * np.exp(-1j * np.pi * k * (step - 1) / period)
    return replace(line, parts=parts, period=period)


@dataclass
class _State:
    """What a search works on. power, level: of coefficients 1/T apart, level from `first` on;
    floor: the level that a line must stand out of; given: whether the level was, so that it needs
    no measuring beside a line."""

    spectrum: np.ndarray
    power: Floats
    level: Floats
    floor: Floats
    first: int
    n: int
    spacing_s: float
    given: bool
    least_gain: float

    def at(self, place: float) -> int:
        """Index into `level` of a place in units of 1/T."""
        return min(max(round(place) - self.first, 0), self.level.size - 1)

    def ratio(self) -> Floats:
        """Power relative to the level that a line must exceed."""
        return self.power[self.first : self.first + self.level.size] / self.floor


def _search(
    series: np.ndarray,
    spacing_s: float,
    between_k: tuple[int, int],
    density: Callable[[np.ndarray], np.ndarray] | None,
    at_most: int,
    least_gain: float,
) -> list[Line]:
    n = series.size
    spectrum = rfft(without_ramp(series), overwrite_x=True)
    scale = 2 * spacing_s / n
    power = scale * (spectrum.real**2 + spectrum.imag**2)
    first, last = between_k
    k = np.arange(first, last + 1)
    own = (
        np.maximum(density(k / (n * spacing_s)), np.finfo(float).tiny)
        if density
        else level(power, k)
    )
    floor = own if density else np.maximum(own, beside(power, k))
    del k  # of a long recording 160 MB
    state = _State(
        spectrum, power, own, floor, first, n, spacing_s, density is not None, least_gain
    )
    found: list[Line] = []
    sought = floor.copy()
    for _ in range(2 * at_most + TRIES):
        if len(found) >= at_most:
            break
        start, peak = _highest(spectrum, power, sought, first, scale)
        if peak < 0.4 * least_gain:
            break
        line = refined(spectrum, start, n, spacing_s, float(floor[state.at(start)]))
        if line.gain < least_gain:
            sought[int(start) - first] = np.inf
            continue
        _take_out(state, line)
        found = _joined(state, [*found, line])
    if last == (n - 1) // 2 and n % 2 == 0 and len(found) < at_most:
        for line in _at_nyquist(spectrum[-1].real, n, spacing_s, float(floor[-1]), least_gain):
            _take_out(state, line)
            found = _joined(state, [*found, line])
    found = _widened(state, found)
    return sorted(found, key=lambda line: -line.gain)


def _joined(state: _State, found: list[Line]) -> list[Line]:
    """The lines, the last of which is new; those too near to it are merged with it."""
    duration = state.n * state.spacing_s
    new = found[-1]
    group, left = [new], found[:-1]
    while True:
        near = [a for a in left if any(_apart(a, b) < _reach(b, duration) for b in group)]
        if not near:
            break
        group, left = [*group, *near], [a for a in left if a not in near]
    if len(group) == 1:
        return found
    one = any(line.wide for line in group) or len(group) >= ONE_BAND or _sidebands(state, group)
    return [*left, *_as_band(state, group)] if one else found


def _reach(line: Line, duration_s: float) -> float:
    """Hz within which another line belongs to the same: sidebands of a frequency that goes up and
    down within 20 s or more, or a few coefficients."""
    return max(6 / duration_s, min(0.05, line.f_0 / 200))


def _apart(a: Line, b: Line) -> float:
    """Hz between the edges of two lines."""
    (low, high), (other_low, other_high) = (x.band_hz or (x.f_0, x.f_0) for x in (a, b))
    return max(low - other_high, other_low - high, 0.0)


def _sidebands(state: _State, pair: list[Line]) -> bool:
    """Whether two lines are one: not resolved, or with power on the other side of the stronger, or
    on both sides of Nyquist, where that is undecided."""
    strong, weak = sorted(pair, key=lambda line: -line.gain)
    duration = state.n * state.spacing_s
    folded = 0.5 / state.spacing_s - max(strong.f_0, weak.f_0) < _reach(strong, duration)
    if folded or abs(strong.f_0 - weak.f_0) * duration < UNRESOLVED:
        return True
    mirror = state.at((2 * strong.f_0 - weak.f_0) * duration)
    return bool(state.ratio()[max(mirror - 1, 0) : mirror + 2].max() > MIRRORED)


def _widened(state: _State, found: list[Line]) -> list[Line]:
    """The lines; as bands those that one sinusoid does not remove."""
    from scipy.special import gammaincc

    for line in sorted(found, key=lambda line: -line.gain):
        if line.wide or line not in found:
            continue
        at, ratio = state.at(line.f_0 * state.n * state.spacing_s), state.ratio()
        for side in REST:
            near = ratio[max(at - side, 0) : at + side + 1]
            near = near[near > 0]  # not what a band has removed
            if near.size > 2 and gammaincc(near.size - 1.5, near.sum()) < REST_P:
                found = [x for x in found if x is not line]
                for band in _as_band(state, [line]):
                    within = [x for x in found if _apart(x, band) == 0]
                    found = [x for x in found if x not in within]
                    found += _as_band(state, [band, *within]) if within else [band]
                break
    return found


def _as_band(state: _State, group: list[Line]) -> list[Line]:
    """The lines of a group as one of finite width, taken out of the spectrum; none where it is so
    wide that it is a hump of the noise."""
    for line in group:
        _take_out(state, line, -1)
    step = 1 / (state.n * state.spacing_s)
    ends = [end / step for line in group for end in (line.band_hz or (line.f_0, line.f_0))]
    low, high = math.floor(min(ends)) - MARGIN, math.ceil(max(ends)) + MARGIN
    low, high = max(low, state.first), min(high, state.first + state.level.size - 1)
    low, high = grown(state.ratio(), state.first, low, high)
    if high == (state.n - 1) // 2:
        high = state.n // 2  # Nyquist's own, if there is one
    psd = float(state.level[state.at(low) : state.at(high) + 1].mean()) if state.given else None
    line = measured(state.spectrum, low, high, state.n, state.spacing_s, psd)
    _take_out(state, line)
    narrow = line.width_f < max(WIDEST * line.f_0, UNRESOLVED * step)
    return [line] if narrow and line.gain > state.least_gain else []


@njit
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
        if k + 1 == power.size:
            continue
        apart = spectrum[k] - spectrum[k + 1]
        half = 0.5 * scale * (apart.real**2 + apart.imag**2) / level[i]
        if half > best:
            best, place = half, k + 0.5
    return place, best


def _at_nyquist(
    coefficient: float, n: int, spacing_s: float, psd: float, least_gain: float
) -> list[Line]:
    """The line at Nyquist if there is one: its coefficient is real, with one degree of freedom."""
    gain = 2 * spacing_s / n * coefficient**2 / psd
    if gain < least_gain:
        return []
    phase = math.copysign(math.pi / 2, coefficient)
    return [Line(float(abs(coefficient)) / n, 0.5 / spacing_s, phase, psd, float(gain))]


def _take_out(state: _State, line: Line, sign: int = 1) -> None:
    """Subtract a line from `spectrum` and `power`, as far as it can be seen; -1: put it back."""
    spectrum = state.spectrum
    if line.parts is not None:
        k = np.arange(line.first, line.first + line.parts.size)
        spectrum[k] = line.parts if sign < 0 else 0.0
    else:
        centre = round(line.f_0 * state.n * state.spacing_s)
        reach = int(100 + 10 * math.sqrt(line.gain))
        k = np.arange(max(1, centre - reach), min(spectrum.size, centre + reach))
        cosine, sine = kernel(line.f_0, k, state.n, state.spacing_s)
        wave = math.sin(line.phase) * cosine + math.cos(line.phase) * sine
        spectrum[k] -= sign * line.A_s * wave
    state.power[k] = 2 * state.spacing_s / state.n * (spectrum[k].real ** 2 + spectrum[k].imag ** 2)


def line_at(series: np.ndarray, frame_rate_hz: float, f_0: float, psd: float) -> Line:
    """The line nearest to f_0 (within 1/T) of a complete series, significant or not."""
    tau0 = 1 / frame_rate_hz
    return refined(rfft(without_ramp(series)), f_0 * series.size * tau0, series.size, tau0, psd)


def line_again(series: np.ndarray, frame_rate_hz: float, line: Line) -> Line:
    """A line that was found elsewhere in this complete series (n,): with amplitude and phase of its
    own, or what stands in its band."""
    tau0 = 1 / frame_rate_hz
    if line.band_hz is None:
        return line_at(series, frame_rate_hz, line.f_0, line.psd)
    n = series.size
    low, high = (
        round(f * n * tau0 + side) for f, side in zip(line.band_hz, (0.5, -0.5), strict=True)
    )
    more = 0 if n == line.period else MARGIN
    low, high = max(low - more, 1), min(high + more, n // 2)
    return measured(rfft(without_ramp(series)), low, high, n, tau0, line.psd)


def waves(lines: Sequence[Line], n: int, frame_rate_hz: float) -> Floats:
    """(n,) sum of lines."""
    total = np.zeros(n)
    for line in lines:
        total += line.wave(n, frame_rate_hz)
    return total


def bands_of(lines: Sequence[Line], duration_s: float) -> list[tuple[float, float]]:
    """Bands of the wide ones in a stretch of that duration, Hz."""
    more = MARGIN / duration_s
    return [(x.band_hz[0] - more, x.band_hz[1] + more) for x in lines if x.band_hz]


def warm_up() -> None:
    """Compile the kernel."""
    find_lines(np.random.default_rng(0).normal(size=400), 1.0)
