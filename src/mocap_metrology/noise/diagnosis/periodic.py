"""Periodic disturbances: named with frequency and size, cross-checked in spectrum and ADEV."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mocap_metrology.noise.allan.variance import allan_variance
from mocap_metrology.noise.fit.spectral.gaps import bridged, filled, stretches
from mocap_metrology.noise.fit.spectral.line import Line
from mocap_metrology.noise.fit.spectral.lines import (
    find_lines,
    find_slow_lines,
    line_again,
    threshold,
    waves,
)
from mocap_metrology.noise.model.components import Sinusoid

MAINS = (50.0, 60.0)  # Hz; lamps flicker at twice that
MAINS_HARMONICS = 4
MAINS_TOLERANCE = 0.004  # share by which a grid may be off
LEAST_FOLDED_HZ = 1.0  # what folds to less looks like any slow line
PSD_P = 1e-3  # probability that noise alone reaches so high in Welch's spectrum
PSD_REACH = 64  # neighbours on each side for its level
PSD_LEAVE = 3  # next to the line that are left out
VISIBLE = 0.1  # share of the Allan variance from which a bump is seen
LONGEST_GAP, SHORT_GAP = 1200, 12  # frames that are filled with noise, or bridged
SAME_PHASE = 0.9  # of the products of neighbouring means, where a frequency stands
FEWEST_TEETH, COMB_P = 4, 1e-3  # of a comb; chance of one
MULTIPLES_APART = 8.0  # coefficients
LEAST = 1000  # samples of a stretch with lines


@dataclass(frozen=True)
class Mains:
    """A multiple of the frequency of the mains that a line may be, which a frame rate of
    `folded_at_hz` shows where it is not; None where it is below Nyquist."""

    f_hz: float
    mains_hz: float
    folded_at_hz: float | None = None


@dataclass(frozen=True)
class SpectralLine:
    """One line of one series, a sinusoid or, where its frequency wanders, a band (`line.width_f`).

    lower, upper: 95 % of A_s, mm; f_error: standard error, Hz; harmonic: number and fundamental, or
    None; mains: what of them it may be; snr_psd, in_psd: Welch's spectrum at the
    line over its level, and whether noise does not reach that; tau_s, share, in_adev: first maximum
    of the line's Allan variance, its part of all of it there, and whether that is a tenth at least;
    amplitude: least and greatest, mm (quantiles of 10 and 90 %), of a band that its amplitude makes
    (`_amplitudes`).
    """

    series: str
    line: Line
    lower: float
    upper: float
    f_error: float
    harmonic: tuple[int, float] | None
    mains: Mains | None
    snr_psd: float
    in_psd: bool | None
    tau_s: float
    share: float
    in_adev: bool | None
    amplitude: tuple[float, float] | None = None

    @property
    def wanders(self) -> bool:
        """Whether its frequency wanders, as far as known: it may be a narrow resonance."""
        return self.line.wide and not self.amplitude


@dataclass(frozen=True)
class Disturbance:
    """A line with all series that show it, the largest first."""

    lines: tuple[SpectralLine, ...]

    @property
    def first(self) -> SpectralLine:
        """The largest."""
        return self.lines[0]

    @property
    def matters(self) -> bool:
        """Whether a reader is warned: where a series shows it in its Allan deviation."""
        return any(one.in_adev for one in self.lines)


def disturbances(lines: Sequence[SpectralLine], duration_s: float) -> list[Disturbance]:
    """Lines of one frequency together, within 1/T, three standard errors and their width; the
    largest first."""
    left = sorted(lines, key=lambda x: -x.line.A_s)
    groups = []
    while left:
        first = left[0]
        near = 1 / duration_s + 3 * first.f_error + first.line.width_f
        same = [x for x in left if abs(x.line.f_0 - first.line.f_0) <= near + 3 * x.f_error]
        left = [x for x in left if x not in same]
        by_series = {x.series: x for x in reversed(same)}  # of two of a series the larger
        groups.append(Disturbance(tuple(reversed(by_series.values()))))
    return groups


def comb(lines: Sequence[Disturbance], duration_s: float) -> tuple[float, list[Disturbance]]:
    """Frequency in Hz of which the most disturbances are multiples, to within 1/2T, and these; none
    where they are fewer than `FEWEST_TEETH`, or chance may do that."""
    from scipy.special import bdtrc

    f = np.sort([one.first.line.f_0 for one in lines])
    apart = np.concatenate([np.diff(f), *(f / k for k in (1, 2, 3))]) if f.size else f
    tries = apart[apart > MULTIPLES_APART / duration_s]
    best, members = math.nan, np.zeros(len(lines), bool)
    for f_1 in np.sort(tries)[::-1]:  # a half has as many multiples
        n, f_n = 0.0, 0.0
        for one in f:
            number = round(one / f_1)
            if number and abs(one - number * f_1) < 0.5 / duration_s:
                n, f_n = n + number**2, f_n + number * one
                f_1 = f_n / n  # by least squares
        every = np.array([one.first.line.f_0 for one in lines]) / f_1
        near = np.abs(every - np.round(every)) * f_1 < 0.5 / duration_s
        chance = tries.size * bdtrc(near.sum() - 2, f.size - 1, 1 / duration_s / f_1)
        if near.sum() > max(members.sum(), FEWEST_TEETH - 1) and chance < COMB_P:
            best, members = float(f_1), near
    return best, [one for one, line in zip(lines, members, strict=True) if line]


def series_lines(
    series: np.ndarray,
    frame_rate_hz: float,
    at_most: int,
    density: Callable[[np.ndarray], np.ndarray] | None = None,
    n_series: int = 1,
) -> tuple[list[Line], np.ndarray]:
    """Lines of the longest stretch of (n,) without long gaps, strongest first, and that stretch.

    density: of the noise, f -> mm^2/Hz. With it, gaps of up to 1200 frames are filled with a draw
    of that noise, and lines of fewer than 128 cycles looked for too; without it gaps of up to 12
    frames are bridged. (A straight line over a longer one is a slow bump, which looks like lines.)
    Of n_series together no more lines are by chance than of one (`threshold`).
    """
    parts = stretches(series, LONGEST_GAP if density else SHORT_GAP, LEAST)
    if not parts:
        return [], series[:0]
    longest = max(parts, key=lambda p: p.stop - p.start)
    measurable = series[longest]
    measured = float(np.isfinite(measurable).mean())

    def whole(values: np.ndarray) -> np.ndarray:
        if density:
            return filled(values, density, frame_rate_hz, np.random.default_rng(0))
        return bridged(values)

    full = whole(measurable)
    sinusoids = find_lines(full, frame_rate_hz, at_most)
    if sinusoids and measured < 1:  # a line that is missing in gaps is less, and has sidebands
        kept: list[Line] = []
        for one in sinusoids:
            again = line_again(full, frame_rate_hz, replace(one, band_hz=None))
            if all(abs(again.f_0 - x.f_0) > frame_rate_hz / full.size for x in kept):  # once each
                kept.append(replace(again, A_s=again.A_s / measured))
        lines = waves(kept, measurable.size, frame_rate_hz)
        full = whole(measurable - lines) + lines
        sinusoids = find_lines(full, frame_rate_hz, at_most)
    if density:
        bare = waves(sinusoids, full.size, frame_rate_hz)
        np.subtract(full, bare, out=bare)
        sinusoids += find_slow_lines(bare, frame_rate_hz, density, at_most)
    least = threshold(full.size) + 2 * math.log(n_series)
    sinusoids = [line for line in sinusoids if line.gain > least]
    return sorted(sinusoids, key=lambda line: -line.gain)[:at_most], measurable


def described(
    series: str,
    lines: Sequence[Line],
    values: np.ndarray,
    rate_hz: float,
    psd: Mapping[str, np.ndarray] | None = None,
) -> list[SpectralLine]:
    """The lines with their errors, names and cross-checks.

    values: (n,) what they were found in; psd: its `f_hz`, `psd_mm2_hz`, `n_segments`.
    """
    duration_s = values.size / rate_hz
    m = np.array([first_maximum(line.f_0, rate_hz) for line in lines], np.int64)
    avar = allan_variance(values, m).variance if len(lines) else m
    rows = []
    for line, size, total in zip(lines, m, avar, strict=True):
        a_error, f_error = line.errors(duration_s)
        snr, in_psd = _in_psd(line, psd)
        variance = Sinusoid(line.A_s, line.f_0).avar(size, rate_hz)
        if line.wide:  # its amplitude may change; less the noise in its band
            wave = line.wave(values.size, rate_hz)
            known = np.where(np.isfinite(values), wave, np.nan)
            (variance,) = allan_variance(known, np.array([size])).variance
            variance *= line.A_s**2 / 2 / np.mean(wave**2)
        share = float(variance) / total if total > 0 else math.nan
        rows.append(
            SpectralLine(
                series, line, max(line.A_s - 1.96 * a_error, 0.0), line.A_s + 1.96 * a_error,
                f_error, _harmonic(line, lines, duration_s), mains_of(line.f_0, rate_hz, f_error),
                snr, in_psd, size / rate_hz, share, None if math.isnan(share) else share >= VISIBLE,
                _amplitudes(values, line, rate_hz) if line.wide else None,
            )
        )  # fmt: skip
    return rows


def _amplitudes(values: np.ndarray, line: Line, rate_hz: float) -> tuple[float, float] | None:
    """Least and greatest amplitude of a band whose frequency stands, None where that wanders.

    Of the means z of values exp(-2 pi i f_0 t) over blocks of a sixteenth of 1 / width: the phase
    goes on evenly where the amplitude alone makes the band, so that |sum z_k+4 conj(z_k)| over
    sum |z_k+4| |z_k| is near 1.
    """
    length = max(round(rate_hz / line.width_f / 16), round(2 * rate_hz / line.f_0), 1)
    count = values.size // length
    if count < 32:
        return None
    known = np.isfinite(values[: count * length])
    mean = float(np.nanmean(values))
    turned = np.where(known, values[: count * length] - mean, 0.0)
    turned = turned * np.exp(-2j * np.pi * line.f_0 / rate_hz * np.arange(turned.size))
    z = 2 * turned.reshape(count, length).mean(axis=1)
    far = 4
    products = z[far:] * np.conj(z[:-far])
    if abs(products.sum()) < SAME_PHASE * np.abs(products).sum():
        return None
    low, high = np.quantile(np.abs(z), [0.1, 0.9])
    return (float(low), float(high)) if low < high / 2 else None


def _harmonic(line: Line, lines: Sequence[Line], duration_s: float) -> tuple[int, float] | None:
    """A whole multiple, 2 to 20, of a line at least as strong, to within 1/T and their widths."""
    for other in sorted(lines, key=lambda x: x.f_0):
        number = round(line.f_0 / other.f_0)
        apart = 1 / duration_s + line.width_f + number * other.width_f
        near = abs(line.f_0 - number * other.f_0) < apart
        if 2 <= number <= 20 and near and other.gain >= line.gain:
            return number, other.f_0
    return None


def mains_of(f_0: float, rate_hz: float, f_error: float) -> Mains | None:
    """A frame rate cannot distinguish f from rate - f, rate + f, ...: mains and lamps that would
    show here, or None where none would."""
    for mains in MAINS:
        for k in range(1, MAINS_HARMONICS + 1):
            true = mains * k
            folded = abs((true + rate_hz / 2) % rate_hz - rate_hz / 2)
            reach = MAINS_TOLERANCE * mains * k + 3 * f_error
            if folded < LEAST_FOLDED_HZ:
                continue
            if abs(folded - f_0) <= reach and true > rate_hz / 2:
                return Mains(true, mains, rate_hz)
            if abs(true - f_0) <= reach:
                return Mains(true, mains)
    return None


def _in_psd(line: Line, psd: Mapping[str, np.ndarray] | None) -> tuple[float, bool | None]:
    """Greatest of the three points nearest to the line over the level round it, the median of its
    neighbours put right to their mean; noise of K averaged segments reaches a gamma(K) quantile."""
    if psd is None or not len(psd["f_hz"]):
        return math.nan, None
    from scipy.special import gammaincinv, gdtrc

    f, density = np.asarray(psd["f_hz"], float), np.asarray(psd["psd_mm2_hz"], float)
    at = int(np.argmin(np.abs(f - line.f_0)))
    peak = float(density[max(at - 1, 0) : at + 2].max())
    k = np.arange(max(at - PSD_REACH, 1), min(at + PSD_REACH + 1, f.size))
    k = k[np.abs(k - at) > PSD_LEAVE]
    if not k.size:
        return math.nan, None
    # Half-overlapping Hann windows
    degrees = max(float(np.max(psd["n_segments"])) / 1.1, 1.0)
    level = float(np.median(density[k]) * degrees / gammaincinv(degrees, 0.5))
    if not level > 0:
        return math.nan, None
    return peak / level, bool(3 * gdtrc(degrees, degrees, peak / level) < PSD_P)


def first_maximum(f_0: float, rate_hz: float) -> int:
    """m at which the Allan variance of a sinusoid is greatest, about 0.37 periods."""
    m = np.arange(1, max(math.ceil(rate_hz / f_0), 1) + 1)
    return int(m[np.argmax(Sinusoid(1.0, f_0).avar(m, rate_hz))])
