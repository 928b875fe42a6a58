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
from mocap_metrology.common.types import Floats
from mocap_metrology.noise.fit.spectral.line import (
    MARGIN,
    NEAR_COEFFICIENTS,
    Line,
    Transform,
    beside,
    grown,
    noise_density,
)

FIRST_CYCLES = 10  # fewer cycles in a recording look like a random walk
MEDIAN_FROM = 128  # below, a band of a quarter octave holds too few coefficients for its median
SLOW_SAMPLES = 1 << 13  # block means that show the frequencies below
ONE_BAND = 3  # lines so near to each other (`_reach`) are one of finite width
UNRESOLVED = 3.0  # coefficients: two lines within are one of finite width
SLOW_NEAR = 16  # coefficients a side whose median shows that no model describes the noise
MIRRORED = 8.0  # power over noise of a sideband's other side: exp(-8), three places
REST = (3, 8, 24)  # coefficients a side in which one sinusoid must leave nothing
REST_P = 1e-4  # probability that noise leaves so much there
TRIES = 20  # places that look like a line and are none
WIDEST = 0.05  # width over frequency of a line
FEW = 400  # samples, of which the level beside a line is uncertain


def threshold(n: int) -> float:
    """Gain in twice the log likelihood that a line must bring in n samples.

    BIC's 3 ln n for three parameters, or, if greater, what noise alone brings in one recording of a
    thousand: with N independent places in the spectrum exp(-gain/2) N = 1/1000, where
    N = 1.25 n, as the places between the n/2 coefficients count too. (With the noise's level taken
    from the spectrum, 4 of 1200 series of 24 000 white samples.) Of few samples that level is
    uncertain, and noise brings more.
    """
    return max(3 * math.log(n), 2 * math.log(1250 * n)) * (1 + FEW / n)


def find_lines(series: np.ndarray, frame_rate_hz: float, at_most: int = 40) -> list[Line]:
    """Lines of a complete series (n,), strongest (greatest gain) first, up to `at_most`; from 128
    cycles in the recording up to Nyquist, which counts too: a difference of odd and even frames.

    A line counts when it raises twice the log likelihood by more than `threshold(n)`. The noise is
    taken from medians of bands a quarter octave wide, or of the bands on either side of the line
    where they are higher.
    """
    last = (series.size - 1) // 2  # Nyquist's coefficient has no partner
    if last < MEDIAN_FROM + 2 * NEAR_COEFFICIENTS:
        return []
    transform = Transform.of(series, 1 / frame_rate_hz)
    k = np.arange(MEDIAN_FROM, last + 1)
    power = transform.power()
    noise = noise_density(power, k)
    floor = np.maximum(noise, beside(power, k))
    del k  # of a long recording 160 MB
    search = _Search(transform, power, noise, floor, MEDIAN_FROM, False, threshold(series.size))
    return search.lines(at_most)


def find_slow_lines(
    series: np.ndarray,
    frame_rate_hz: float,
    density: Callable[[np.ndarray], np.ndarray],
    at_most: int,
) -> list[Line]:
    """Lines of 10 to 128 cycles in the recording, as `find_lines`; density: the noise spectrum,
    f -> unit^2/Hz, which medians of so few coefficients cannot resolve; where these are twice as
    high all the same, no model describes the noise, and they count."""
    from scipy.ndimage import median_filter

    tau0 = 1 / frame_rate_hz
    n = series.size
    step = max(n // SLOW_SAMPLES, 1)
    means = series[: n // step * step].reshape(-1, step).mean(axis=1)
    last = min(MEDIAN_FROM, (means.size - 1) // 2)
    if last < FIRST_CYCLES + 2 * NEAR_COEFFICIENTS:
        return []
    transform = Transform.of(means, tau0 * step)
    k = np.arange(FIRST_CYCLES, last + 1)
    noise = np.maximum(density(k / transform.duration_s), np.finfo(float).tiny)
    least_gain, power = threshold(n), transform.power()
    above = median_filter(power[k] / noise, 2 * SLOW_NEAR + 1) / np.log(2)
    noise *= np.where(above > 2, above, 1.0)
    search = _Search(transform, power, noise, noise, FIRST_CYCLES, True, least_gain)
    return [_of_means(line, step, tau0) for line in search.lines(at_most)]


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
class _Search:
    """power: of the coefficients; level: of the noise, from coefficient `first` on; floor: the
    level that a line must stand out of; known: whether the level needs no measuring beside a line;
    least_gain: that a line must bring."""

    transform: Transform
    power: Floats
    level: Floats
    floor: Floats
    first: int
    known: bool
    least_gain: float

    @property
    def duration_s(self) -> float:
        return self.transform.duration_s

    def at(self, place: float) -> int:
        """Index into `level` of a place in units of 1/T."""
        return min(max(round(place) - self.first, 0), self.level.size - 1)

    def ratio(self) -> Floats:
        """Power relative to the level that a line must exceed."""
        return self.power[self.first : self.first + self.level.size] / self.floor

    def lines(self, at_most: int) -> list[Line]:
        """The strongest first."""
        transform, n, lines = self.transform, self.transform.n, list[Line]()
        scale, sought = 2 * transform.spacing_s / n, self.floor.copy()
        for _ in range(2 * at_most + TRIES):
            if len(lines) >= at_most:
                break
            start, peak = _highest(transform.coefficients, self.power, sought, self.first, scale)
            if peak < 0.4 * self.least_gain:
                break
            line = transform.refined(start, float(self.floor[self.at(start)]))
            if line.gain < self.least_gain:
                sought[int(start) - self.first] = np.inf
                continue
            self.take_out(line)
            lines = self.joined([*lines, line])
        return sorted(self.widened(lines), key=lambda line: -line.gain)

    def joined(self, lines: list[Line]) -> list[Line]:
        """The lines, the last of which is new; those too near to it are merged with it."""
        group, left = [lines[-1]], lines[:-1]
        while True:
            near = [a for a in left if any(_separation_hz(a, b) < self.reach(b) for b in group)]
            if not near:
                break
            group, left = [*group, *near], [a for a in left if a not in near]
        if len(group) == 1:
            return lines
        one = any(line.wide for line in group) or len(group) >= ONE_BAND or self.sidebands(group)
        return [*left, *self.as_band(group)] if one else lines

    def reach(self, line: Line) -> float:
        """Hz within which another line belongs to the same: sidebands of a frequency that goes up
        and down within 20 s or more, or a few coefficients."""
        return max(6 / self.duration_s, min(0.05, line.f_0 / 200))

    def sidebands(self, pair: list[Line]) -> bool:
        """Whether two lines are one: not resolved, or with power on the other side of the stronger,
        or on both sides of Nyquist, where that is undecided."""
        strong, weak = sorted(pair, key=lambda line: -line.gain)
        duration = self.duration_s
        fold = self.transform.nyquist_hz - max(strong.f_0, weak.f_0) < self.reach(strong)
        if fold or abs(strong.f_0 - weak.f_0) * duration < UNRESOLVED:
            return True
        mirror = self.at((2 * strong.f_0 - weak.f_0) * duration)
        return bool(self.ratio()[max(mirror - 1, 0) : mirror + 2].max() > MIRRORED)

    def widened(self, lines: list[Line]) -> list[Line]:
        """The lines; as bands those that one sinusoid does not remove."""
        from scipy.special import gammaincc

        for line in sorted(lines, key=lambda line: -line.gain):
            if line.wide or line not in lines:
                continue
            at, ratio = self.at(line.f_0 * self.duration_s), self.ratio()
            for side in REST:
                near = ratio[max(at - side, 0) : at + side + 1]
                near = near[near > 0]  # not what a band has removed
                if near.size > 2 and gammaincc(near.size - 1.5, near.sum()) < REST_P:
                    lines = [x for x in lines if x is not line]
                    for band in self.as_band([line]):
                        within = [x for x in lines if _separation_hz(x, band) == 0]
                        lines = [x for x in lines if x not in within]
                        lines += self.as_band([band, *within]) if within else [band]
                    break
        return lines

    def as_band(self, group: list[Line]) -> list[Line]:
        """The lines of a group as one of finite width, taken out of the spectrum; none where it is
        so wide that it is a hump of the noise."""
        for line in group:
            self.take_out(line, -1)
        n, step = self.transform.n, 1 / self.duration_s
        ends = [end / step for line in group for end in (line.band_hz or (line.f_0, line.f_0))]
        low, high = math.floor(min(ends)) - MARGIN, math.ceil(max(ends)) + MARGIN
        low, high = max(low, self.first), min(high, self.first + self.level.size - 1)
        low, high = grown(self.ratio(), self.first, low, high)
        if high == (n - 1) // 2:
            high = n // 2  # Nyquist's own, if there is one
        psd = float(self.level[self.at(low) : self.at(high) + 1].mean()) if self.known else None
        line = self.transform.measured(low, high, psd)
        self.take_out(line)
        narrow = line.width_f < max(WIDEST * line.f_0, UNRESOLVED * step)
        return [line] if narrow and line.gain > self.least_gain else []

    def take_out(self, line: Line, sign: int = 1) -> None:
        """Subtract a line from the spectrum and its power, as far as it can be seen; -1: put it
        back."""
        spectrum = self.transform.coefficients
        if line.parts is not None:
            k = np.arange(line.first, line.first + line.parts.size)
            spectrum[k] = line.parts if sign < 0 else 0.0
        else:
            centre = round(line.f_0 * self.transform.n * self.transform.spacing_s)
            reach = int(100 + 10 * math.sqrt(line.gain))
            k = np.arange(max(1, centre - reach), min(spectrum.size, centre + reach))
            cosine, sine = self.transform.kernel(line.f_0, k)
            wave = math.sin(line.phase) * cosine + math.cos(line.phase) * sine
            spectrum[k] -= sign * line.A_s * wave
        self.power[k] = self.transform.power(k)


def _separation_hz(a: Line, b: Line) -> float:
    """Hz between the edges of two lines."""
    (low, high), (other_low, other_high) = (x.band_hz or (x.f_0, x.f_0) for x in (a, b))
    return max(low - other_high, other_low - high, 0.0)


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


def line_again(series: np.ndarray, frame_rate_hz: float, line: Line) -> Line:
    """A line that was found elsewhere in this complete series (n,): with amplitude and phase of its
    own, or what stands in its band."""
    tau0, n = 1 / frame_rate_hz, series.size
    transform = Transform.of(series, tau0)
    if line.band_hz is None:  # the one nearest to its frequency, within 1/T, significant or not
        return transform.refined(line.f_0 * n * tau0, line.psd)
    ends = zip(line.band_hz, (0.5, -0.5), strict=True)
    low, high = (round(f * n * tau0 + side) for f, side in ends)
    more = 0 if n == line.period else MARGIN
    return transform.measured(max(low - more, 1), min(high + more, n // 2), line.psd)


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
