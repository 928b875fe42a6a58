"""One line of a spectrum: what it is, the noise under it, and its fit, as sinusoid or as band.

A sinusoid is fitted to the Fourier coefficients next to it, up to Nyquist and its fold. The power
of one coefficient of noise is exponentially distributed: its median is ln 2 of its mean.

A line of finite width (mains whose frequency wanders, a fan, a resonance) fills a band of
coefficients k_1 ... k_2, of density S of the noise and duration T:

    A_s = sqrt(2 P),  P = sum (power_k - S) / T      its whole power
    f_0 = sum f_k (power_k - S) / sum (power_k - S)  its mean frequency
    width_f = sqrt(sum (f_k - f_0)^2 (power_k - S) / sum (power_k - S))  standard deviation of its
        frequency over time (of a sinusoid that goes up and down by d slowly, d / sqrt 2)

Standard errors: of P from the products of line and noise and from the noise in the band,
(S/T) sqrt(2 P T/S + M + M^2/W) for M coefficients and S from W others; and, where greater, the
scatter over blocks of time, as jackknife: the band's coefficients, transformed back, are the line's
complex amplitude over time. At the fold (Nyquist) upper and lower half overlap: the line's power
depends on its phases, of which there are some width_f T independent ones.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from mocap_metrology.common.transforms import irfft, rfft
from mocap_metrology.common.types import Floats, Integers

ROW = 2048  # samples of a sinusoid made at once
MEDIAN_OF = 4096  # coefficients of a median, at most
SIDE_OCTAVES, SIDE_LEAST = 1 / 16, 32  # width of the bands beside a line, and their coefficients
SIDE_STANDARD_ERRORS = 2.0  # by which a band beside a line must exceed the level to count
TINY, EXACT = np.finfo(float).tiny, 1e-18  # of a line that stands in no noise: least density
NEAR_COEFFICIENTS = 8  # on each side that the least squares uses: 99 % of a line's power
END_FRAMES = 16  # averaged at each end for the ramp
FOLD, STEP = 2.0, 1e-3  # coefficients from Nyquist that a line overlaps with its fold; a derivative
APART_GAIN = 6.0  # gain by not being Nyquist: chi-squared of two, 95 %
DETERMINED_SHARE = 0.5  # relative error of A_s beyond which it is not
LEAST_SIDE, MOST_SIDE = 32, 256  # coefficients on each side that determine the noise
MARGIN = 4  # coefficients beyond the outermost line
BLOCKS = ((32, 8, 1.207), (0, 4, 1.624))  # from so many coefficients; blocks; Student t over 1.96
GROWS = 1.0  # times 1/sqrt(w): two standard deviations of the share above the median
PHASES = 8.0  # of a folded line over width_f T: its power depends on where they fall
FOLDED = 1.9  # standard errors to the fold: 95 % reach just beyond
LEAST_WIDTH = 0.5  # coefficients: less is not resolved


@dataclass(frozen=True)
class Line:
    """A_s sin(2 pi f_0 t + phase), t = 0 at the first frame; psd: density of the noise at f_0;
    gain: rise of twice the log likelihood by the line, A_s^2 T / psd.

    width_f (Hz): 0 for a sinusoid, else as defined above; such a line fills `band_hz`, has
    no phase (NaN), and its wave is that of the Fourier coefficients `parts`, from number `first`
    on, of `period` samples. A_error, f_error, width_error: standard errors where they are greater
    than those of `line_errors`, else 0.
    """

    A_s: float
    f_0: float
    phase: float
    psd: float
    gain: float
    width_f: float = 0.0
    A_error: float = 0.0
    f_error: float = 0.0
    width_error: float = 0.0
    band_hz: tuple[float, float] | None = None
    parts: np.ndarray | None = field(default=None, repr=False, compare=False)
    first: int = 0
    period: int = 0

    @property
    def wide(self) -> bool:
        """Whether it is wider than the recording resolves."""
        return self.band_hz is not None

    def wave(self, n: int, frame_rate_hz: float) -> np.ndarray:
        """(n,) samples; the sine of a sum of a slow and a fast angle, so few sines are taken."""
        tau0 = 1 / frame_rate_hz
        if self.parts is not None:
            return self._band(self.parts, n)
        step = 2 * np.pi * self.f_0 * tau0
        fast = step * np.arange(ROW)
        slow = step * ROW * np.arange(-(-n // ROW))[:, None] + self.phase
        rows = (self.A_s * np.sin(slow)) * np.cos(fast)
        rows += (self.A_s * np.cos(slow)) * np.sin(fast)
        return rows.ravel()[:n]

    def _band(self, parts: np.ndarray, n: int) -> np.ndarray:
        spectrum = np.zeros(self.period // 2 + 1, complex)
        spectrum[self.first : self.first + parts.size] = parts
        wave = irfft(spectrum, self.period, overwrite_x=True)
        return wave if n == self.period else np.resize(wave, n)

    def errors(self, duration_s: float, psd: float | None = None) -> tuple[float, float]:
        """Standard errors of A_s and f_0 in noise of density `psd` (default: its own)."""
        bound = line_errors(self.A_s, self.psd if psd is None else psd, duration_s)
        return max(bound[0], self.A_error), max(bound[1], self.f_error)


def line_errors(A_s: float, psd: float, duration_s: float) -> tuple[float, float]:
    """Least standard errors (Cramer-Rao) of A_s and f_0 of a sinusoid of unknown phase in noise of
    one-sided density `psd`: sqrt(S/T) and sqrt(3 S / (pi^2 A^2 T^3)) [Rife & Boorstyn 1974]."""
    if not A_s > 0:
        return math.sqrt(psd / duration_s), math.inf
    return (math.sqrt(psd / duration_s), math.sqrt(3 * psd / (math.pi**2 * A_s**2 * duration_s**3)))


def noise_density(power: Floats, k: Integers) -> Floats:
    """Noise density at coefficients k (ascending, without holes): medians of bands a quarter octave
    wide, interpolated in log-log."""
    bands = max(round(math.log2(k[-1] / k[0]) * 4), 2)
    edge = np.unique(np.geomspace(k[0] / 1.1, k[-1] + 1, bands + 1).astype(np.int64))
    middle = np.sqrt(edge[:-1] * (edge[1:] - 1.0))
    return np.exp(np.interp(np.log(k), np.log(middle), np.log(_medians(power, edge))))


def beside(power: np.ndarray, k: np.ndarray) -> np.ndarray:
    """Greatest of the densities in the bands of each k, left and right of it, less two standard
    errors.

    A line must stand out of both sides: beside the null of a filter, on its flank, on the top of a
    lobe or at the fold of the spectrum (Nyquist: its right side is its left one) nothing does.
    """
    edge = [int(k[0])]
    while edge[-1] <= k[-1]:
        edge.append(edge[-1] + max(int(edge[-1] * (2**SIDE_OCTAVES - 1)), SIDE_LEAST))
    edge[-1] = int(k[-1]) + 1
    if len(edge) > 2 and edge[-1] - edge[-2] < SIDE_LEAST:  # the last band is a whole one
        del edge[-2]
    width = np.diff(edge)
    sure = np.exp(-SIDE_STANDARD_ERRORS / (math.log(2) * np.sqrt(np.minimum(width, MEDIAN_OF))))
    floor = _medians(power, np.array(edge)) * sure
    left, right = np.roll(floor, 1), np.roll(floor, -1)
    left[0], right[-1] = right[0], left[-1]
    return np.repeat(np.maximum(np.maximum(left, right), floor), width)


def density_around(power: np.ndarray, low: int, high: int, width: int) -> float:
    """Density between `width` coefficients on each side of low ... high: geometric mean of the
    sides, of those that there are."""
    sides = power[max(low - width, 1) : low], power[high + 1 : high + 1 + width]
    known = [float(np.median(side)) for side in sides if 2 * side.size >= width]
    if not known:
        known = [float(np.median(np.concatenate(sides)))] if sum(s.size for s in sides) else [TINY]
    return max(math.prod(known) ** (1 / len(known)) / math.log(2), TINY)


def _medians(power: np.ndarray, edge: np.ndarray) -> Floats:
    medians = [np.median(power[a : b : (b - a) // MEDIAN_OF + 1]) for a, b in pairwise(edge)]
    return np.maximum(np.array(medians) / math.log(2), TINY)


@dataclass(frozen=True)
class Transform:
    """Fourier coefficients (rfft) of n samples, spacing_s apart (frames, or means of several), less
    the straight line through the means of both ends: a loop has no jump to leak."""

    coefficients: np.ndarray
    n: int
    spacing_s: float

    @classmethod
    def of(cls, series: np.ndarray, spacing_s: float) -> Transform:
        """The transform of a complete series (n,)."""
        n = series.size
        width = END_FRAMES
        slope = (series[-width:].mean() - series[:width].mean()) / (n - width)
        level = np.arange(n, dtype=np.float64)
        level *= -slope
        level += series
        level -= level.mean()
        return cls(rfft(level, overwrite_x=True), n, spacing_s)

    @property
    def duration_s(self) -> float:
        """Duration of the series, s."""
        return self.n * self.spacing_s

    @property
    def nyquist_hz(self) -> float:
        """Half of the sampling rate."""
        return 0.5 / self.spacing_s

    def power(self, part: slice | np.ndarray = slice(None)) -> Floats:
        """One-sided density of the coefficients, or of a part of them."""
        c = self.coefficients[part]
        return 2 * self.spacing_s / self.n * (c.real**2 + c.imag**2)

    def kernel(self, f_0: float, k: np.ndarray) -> np.ndarray:
        """(2, k): coefficients k >= 1 of cos and sin (2 pi f_0 t) over the samples, less their
        ramp, in closed form."""
        n, spacing_s = self.n, self.spacing_s
        forward, backward = (_dirichlet(sign * f_0 * spacing_s - k / n, n) for sign in (1, -1))
        waves = np.stack([(forward + backward) / 2, (forward - backward) / 2j])
        width = END_FRAMES
        angle = 2 * np.pi * f_0 * spacing_s * np.stack([np.arange(width), np.arange(n - width, n)])
        ends = np.stack([np.cos(angle), np.sin(angle)]).mean(axis=2)
        slope = (ends[:, 1] - ends[:, 0]) / (n - width)
        ramp = n / np.expm1(-2j * np.pi * k / n)
        return waves - slope[:, None] * ramp

    def refined(self, start: float, psd: float) -> Line:
        """Line by least squares of the coefficients within NEAR_COEFFICIENTS of `start` (in units
        of 1/T), in noise of density `psd`."""
        from scipy.optimize import minimize_scalar

        n, duration, near = self.n, self.duration_s, NEAR_COEFFICIENTS
        first, last = max(1, round(start) - near), round(start) + near
        k = np.arange(first, min(self.coefficients.size - 1, last) + 1)
        root = np.where(2 * k == n, math.sqrt(0.5), 1.0)  # Nyquist's coefficient is real

        def stacked(parts: np.ndarray) -> np.ndarray:
            return np.concatenate([root * parts.real, root * parts.imag], axis=-1)

        y = stacked(self.coefficients[k])

        def solved(place: float) -> tuple[np.ndarray, float]:
            matrix = stacked(self.kernel(place / duration, k)).T
            x, *_ = np.linalg.lstsq(matrix, y, rcond=None)
            return x, float(np.sum((y - matrix @ x) ** 2))

        best = minimize_scalar(
            lambda place: solved(place)[1],
            bounds=(max(start - 1, 0.5), min(start + 1, n / 2)),
            method="bounded",
            options={"xatol": 1e-6},
        )
        x, rest = solved(best.x)
        gain = float((np.sum(y**2) - rest) * 2 * self.spacing_s / n / psd * 2)
        line = Line(math.hypot(*x), float(best.x) / duration, math.atan2(*x), psd, gain)
        if best.x < n / 2 - FOLD:
            return line
        # Change of the line's coefficients with its place in units of 1/T
        low, high = (self.kernel((best.x + step) / duration, k) for step in (-STEP, STEP))
        slope = stacked(x @ (high - low) / (2 * STEP))
        matrix = np.vstack([stacked(self.kernel(line.f_0, k)), slope]).T
        whole = folded(line, x, matrix, n, self.spacing_s)
        half = self._alternating(line, stacked(self.kernel(self.nyquist_hz, k))[0], y)
        return whole if whole and line.gain - half.gain > APART_GAIN else half

    def _alternating(self, line: Line, wave: np.ndarray, y: np.ndarray) -> Line:
        """The line as a difference of odd and even samples; wave: coefficients of (-1)^i, i of the
        sample."""
        energy, nyquist, step = float(wave @ wave), self.nyquist_hz, 1 / self.duration_s
        size = float(wave @ y) / energy
        gain = size**2 * energy * 4 * self.spacing_s / self.n / line.psd
        phase = math.copysign(math.pi / 2, size)
        f_error = min(max(nyquist - line.f_0, step / 4), step)
        return Line(abs(size), nyquist, phase, line.psd, gain, f_error=f_error)

    def measured(self, low: int, high: int, psd: float | None = None) -> Line:
        """The line of finite width in coefficients low ... high.

        psd: of the noise; without it, the median of what stands on both sides.
        """
        size, duration = high - low + 1, self.duration_s
        away, side = min(size, low // 8), max(LEAST_SIDE, min(max(MOST_SIDE, 2 * size), low // 8))
        if psd is None:
            power = self.power(slice(high + 1 + away + side))
            psd = density_around(power, low - away, high + away, side)
        band = self.coefficients[low : high + 1].copy()
        A_s, f_0, width = self._moments(band, low, psd)
        psd = max(psd, EXACT * A_s**2 * duration, TINY)
        gain = A_s**2 * duration / psd
        # A median has twice the variance of a mean: 1 / ln(2)^2
        noise = math.sqrt(gain + size + size**2 / side) * psd / duration
        A_error, f_error, width_error = self._jackknife(band, low, psd)
        A_error = max(noise / A_s, A_error) if A_s > 0 else math.sqrt(noise)
        if high >= (self.n - 1) // 2:
            A_error = math.hypot(A_error, A_s / math.sqrt(PHASES * max(width * duration, 1.0)))
            f_error = max(f_error, (self.nyquist_hz - f_0) / FOLDED)
        f_error = max(f_error, 0.5 / duration / math.sqrt(max(gain, 1.0)))
        step = 1 / duration
        return Line(
            A_s, f_0, math.nan, psd, gain, width, A_error, f_error, max(width_error, f_error),
            band_hz=((low - 0.5) * step, (high + 0.5) * step), parts=band, first=low, period=self.n,
        )  # fmt: skip

    def _moments(
        self, band: np.ndarray, low: int, psd: float, share: float = 1.0
    ) -> tuple[float, float, float]:
        """A_s, f_0, width_f of the band's coefficients, of which a share of the time was kept."""
        k, step = np.arange(low, low + band.size), 1 / self.duration_s
        power = 2 * self.spacing_s / self.n * (band.real**2 + band.imag**2) / share
        excess = np.where(2 * k == self.n, 0.5, 1.0) * (power - psd)
        total = float(excess.sum())
        if total <= 0:
            return 0.0, float(k.mean()) / self.duration_s, 0.0
        centre = float(np.clip(excess @ k / total, k[0], k[-1]))
        width = math.sqrt(max(excess @ (k - centre) ** 2 / total, LEAST_WIDTH**2))
        return math.sqrt(2 * total * step), centre * step, width * step

    def _jackknife(self, band: np.ndarray, low: int, psd: float) -> list[float]:
        """Standard errors of `_moments` from what they are without one block of time each."""
        from scipy.fft import fft, ifft

        blocks, student = next((b, t) for least, b, t in BLOCKS if band.size >= least)
        wave = ifft(band)
        of, left = np.arange(wave.size) * blocks // wave.size, []
        for block in range(blocks):
            rest = of != block
            left.append(self._moments(fft(np.where(rest, wave, 0)), low, psd, rest.mean()))
        scatter = np.std(left, axis=0) * math.sqrt(blocks - 1)
        return [float(student * s) for s in scatter]


def _dirichlet(delta: np.ndarray, n: int) -> np.ndarray:
    """sum of exp(2 pi i delta t), t = 0 ... n - 1."""
    delta = delta - np.rint(delta)
    sine = np.sin(np.pi * delta)
    safe = np.where(np.abs(sine) < 1e-15, 1.0, sine)
    size = np.where(np.abs(sine) < 1e-15, n, np.sin(np.pi * n * delta) / safe)
    return np.exp(1j * np.pi * (n - 1) * delta) * size


def folded(line: Line, x: np.ndarray, matrix: np.ndarray, n: int, spacing_s: float) -> Line | None:
    """A line so near to Nyquist that it overlaps with its own fold, with errors by the inverse
    information; None where they leave its size open."""
    noise = math.sqrt(line.psd * n / (4 * spacing_s))  # of a part of a coefficient
    information = matrix.T @ matrix / noise**2
    scale = 1 / np.sqrt(np.maximum(np.diag(information), TINY))
    scaled = information * np.outer(scale, scale)
    covariance = np.linalg.pinv(scaled, 1e-12) * np.outer(scale, scale)
    along = np.array([*(x / max(line.A_s, TINY)), 0.0])
    A_error = math.sqrt(max(along @ covariance @ along, 0.0))
    f_error = min(math.sqrt(max(covariance[2, 2], 0.0)), 1.0) / (n * spacing_s)
    sure = np.linalg.eigvalsh(scaled)[0] > 1e-10
    if sure and A_error < DETERMINED_SHARE * line.A_s:
        return replace(line, A_error=A_error, f_error=f_error)
    return None


def grown(ratio: np.ndarray, offset: int, low: int, high: int) -> tuple[int, int]:
    """The band low ... high widened as long as the coefficients beyond stand above the noise, and
    by half of itself on each side for what is too weak to see; ratio: power over noise from
    coefficient `offset` on."""
    first, last = offset, offset + ratio.size - 1

    def above(a: int, b: int) -> bool:
        part = ratio[max(a, first) - offset : min(b, last + 1) - offset]
        if part.size < MARGIN:
            return False
        return float(np.mean(part > math.log(2))) > 0.5 + GROWS / math.sqrt(part.size)

    moved = True
    while moved:
        step = max(4 * MARGIN, high - low)
        up, down = above(high + 1, high + 1 + step), above(low - step, low)
        high, low = high + step * up, low - step * down
        high, low = min(high, last), max(low, first)
        moved = (up and high < last) or (down and low > first)
    half = (high - low) // 2
    return max(low - half, first), min(high + half, last)
