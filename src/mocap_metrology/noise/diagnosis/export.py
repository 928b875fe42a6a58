"""What an export may have done to a recording: rounded it, or low-pass filtered it.

Filtered. White noise, flicker, random walk, Gauss-Markov noise (of any correlation time, at any
frame rate), blue and violet noise and all their sums share one property: the spectrum of the
differences from frame to frame, W(f) = 4 sin^2(pi f tau0) S(f), never falls with f. Behind a
low-pass it falls. So nothing is assumed of how strong each kind of noise is; a smoothing of first
order, which has the spectrum of Gauss-Markov noise, cannot be distinguished from it. Movement, too,
makes W fall, to the white noise of the system: behind a filter it falls to the rounding of the
file, or never levels.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, Literal

import numpy as np

from mocap_metrology.common.hampel import SAMPLED, own_step
from mocap_metrology.common.linear import non_negative
from mocap_metrology.noise.diagnosis.filtering import middle
from mocap_metrology.noise.fit.spectral.gaps import bridged, stretches

# Rounded
FINE, MOST = 0.01, 0.2  # shares of the Allan variance at one frame
DOMINATES: Final = "dominates"

# Low-pass filtered
SEGMENT_S = 32.0
SEGMENTS = 256  # at most, evenly over the recording
LEAST_SEGMENT = 256  # frames
LONGEST_GAP = 2  # frames that are bridged
OCTAVE = 4  # bands an octave
LEAST_ORDINATES = 8  # of the periodograms, a band
MIDDLE, TOP = (0.50, 0.70), (0.70, 0.95)  # of Nyquist: at the top a filter has left little
FALLS_SHARE = 0.4  # W at most, of that of a whole octave below
QUIET_SHARE = 0.2  # S of the top at most, of that of the same octave
PEAKED = 1.5  # S at most, of a filter of no overshoot, of its least in three octaves below
ROUNDED_LEVELS = 4.0  # times the white level of rounding that is no noise of the system
COARSE_SHARE = 0.02  # of S at the edge, in rounding, from which no cutoff is reported
PIECES = 32  # of the middle and the top
FLAT_RATIO = 0.7  # S of the middle and of the top differ by less where a stop band has levelled
FILTER_ORDERS = (1, 2, 3, 4, 6)  # of amplitudes 1 / (1 + (f/f_c)^2n) that are tried
FOLLOWED = 0.01  # of the greatest W, down to which a cutoff is fitted


@dataclass(frozen=True)
class Resolution:
    """One series: rounding_h0, white level that rounding adds, mm^2/Hz; noise_mm: Allan deviation
    at one frame, all together; share: of its square that rounding makes."""

    series: str
    step_mm: float
    kind: str
    rounding_mm: float
    rounding_h0: float
    noise_mm: float
    share: float

    @property
    def word(self) -> Literal["fine", "noticeable", "dominates", "unknown"]:
        """What it does to the noise; `unknown` without any."""
        if math.isnan(self.share):
            return "unknown"
        if self.share > MOST:
            return DOMINATES
        return "fine" if self.share < FINE else "noticeable"

    def share_of(self, step_mm: float) -> float:
        """What steps of another size would add to the noise, of its square."""
        return step_mm**2 / 12 / self.noise_mm**2 if self.noise_mm > 0 else math.inf


def resolution(
    series: str,
    step_mm: float,
    kind: str,
    avar_1: float,
    frame_rate_hz: float,
    distance: bool = False,
) -> Resolution:
    """Rounding to steps q adds white noise of variance q^2/12, one-sided density h_0 = q^2 tau0/6
    [Widrow, 1956], as long as the noise moves values from step to step; a distance has that of both
    its ends, q^2/6. avar_1: Allan variance at one frame, mm^2, that of white noise its variance.

    Of Gaussian noise sigma = s q, what is stored has, beside sigma^2 + q^2/12, a variance of
    (q^2/pi^2 + 4 sigma^2) exp(-2 pi^2 s^2) cos(2 pi x/q), x being where in a step the marker is;
    and slow noise passes 1 + 2 exp(-2 pi^2 s^2) cos(2 pi x/q) times. From s = 0.58 on, a share of a
    fifth, either moves an Allan deviation by 0.3 % at most; at s = 0.4 by 6 and 8 %, and below that
    the place within a step decides. A share above a fifth therefore `dominates`: the largest that
    sigma < 0.42 q can seem, just between two steps, is q^2/4, a share of a third.
    """
    tau0 = 1 / frame_rate_hz
    variance = step_mm**2 / 12 * (2 if distance else 1)
    share = rounding_share(step_mm, avar_1, distance)
    noise = math.sqrt(avar_1) if avar_1 >= 0 else math.nan
    return Resolution(series, step_mm, kind, math.sqrt(variance), 2 * tau0 * variance, noise, share)


def rounding_share(step_mm: float, avar_1: float, distance: bool) -> float:
    """Share of the Allan variance at one frame that rounding to steps makes; 1 of a constant."""
    if not avar_1 >= 0:
        return math.nan
    if not step_mm:
        return 0.0
    variance = step_mm**2 / 12 * (2 if distance else 1)
    return min(variance / avar_1, 1.0) if avar_1 > 0 else 1.0


def hiding_step(series: np.ndarray, step_mm: float, distance: bool) -> float:
    """Step of (n,) values, mm, that hides their noise; 0 where none does. step_mm: of the file."""
    changes = np.diff(middle(series)[:SAMPLED])
    avar_1 = float(np.nanmean(changes**2)) / 2 if np.isfinite(changes).any() else math.nan
    step = max(step_mm, own_step(series))
    return step if rounding_share(step, avar_1, distance) > MOST else 0.0


@dataclass(frozen=True)
class LowPass:
    """A filter that ran: cutoff_hz, where it halves the amplitude, NaN in coarse files; ratio: S of
    the top (0.70 to 0.95 Nyquist) to S of the pass band; peaked: whether S rises before it falls,
    as that of what oscillates."""

    series: str
    cutoff_hz: float
    ratio: float
    peaked: bool = False


@dataclass(frozen=True)
class Bands:
    """Spectrum in bands, four an octave: f_hz their centres, psd medians of the ordinates (of the
    mean they are ln 2 times as much), middle and top those of 0.5 to 0.7 and of 0.7 to 0.95
    Nyquist; mm^2/Hz. least: of the `PIECES` of both."""

    f_hz: np.ndarray
    psd: np.ndarray
    middle: float
    top: float
    least: float


def bands(series: np.ndarray, rate_hz: float) -> Bands | None:
    """The spectrum of a series (n,), NaN in gaps, in bands: medians over Hann segments of half a
    minute and over each band, which neither an event nor a line decides. None where too little is
    left."""
    size = min(round(SEGMENT_S * rate_hz), series.size)
    parts = stretches(series, LONGEST_GAP, LEAST_SEGMENT)
    if not parts:
        return None
    size = min(size, max(p.stop - p.start for p in parts))
    starts = [k for p in parts for k in range(p.start, p.stop - size + 1, size // 2)]
    starts = starts[:: len(starts) // SEGMENTS + 1]
    if size < LEAST_SEGMENT or not starts:
        return None
    window = np.hanning(size + 1)[:-1]
    scale = 2 / (rate_hz * float(window @ window))
    rows = np.array([_periodogram(bridged(series[k : k + size]), window) for k in starts]) * scale
    f = np.arange(rows.shape[1]) * rate_hz / size
    edges = [TOP[1] * rate_hz / 2]
    while True:
        low = edges[-1] / 2 ** (1 / OCTAVE)
        width = (edges[-1] - low) * size / rate_hz
        if width < 2 or width * (len(starts) + 1) / 2 < LEAST_ORDINATES:
            break
        edges.append(low)
    edges = edges[::-1]
    if len(edges) < 3 * OCTAVE // 2:
        return None
    psd = [float(np.median(rows[:, _inside(f, *pair)])) for pair in pairwise(edges)]
    middle, top = (
        float(np.median(rows[:, _inside(f, low * rate_hz / 2, high * rate_hz / 2)]))
        for low, high in (MIDDLE, TOP)
    )
    pieces = pairwise(np.linspace(MIDDLE[0], TOP[1], PIECES + 1) * rate_hz / 2)
    least = min(float(np.median(rows[:, _inside(f, *pair)])) for pair in pieces)
    return Bands(np.sqrt(np.array(edges[:-1]) * edges[1:]), np.array(psd), middle, top, least)


def _periodogram(values: np.ndarray, window: np.ndarray) -> np.ndarray:
    line = np.linspace(values[0], values[-1], values.size)  # a walk's ends meet
    values = values - line
    spectrum = np.fft.rfft((values - values.mean()) * window)
    return spectrum.real**2 + spectrum.imag**2


def _inside(f: np.ndarray, low: float, high: float) -> np.ndarray:
    return (f >= low) & (f < high)


def low_pass(
    name: str, spectrum: Bands | None, rate_hz: float, step_mm: float = 0.0
) -> LowPass | None:
    """The low-pass filter that a spectrum shows, or None; step_mm: resolution of the file."""
    if spectrum is None or not spectrum.psd.min() > 0:
        return None
    steps = 4 * np.sin(np.pi * spectrum.f_hz / rate_hz) ** 2
    w = spectrum.psd * steps
    below = np.array([np.median(w[max(k - OCTAVE, 0) : k]) for k in range(OCTAVE, w.size)])
    level = np.array([np.median(spectrum.psd[k - OCTAVE : k]) for k in range(OCTAVE, w.size)])
    high = int(np.argmax(below))
    after = w[high + OCTAVE + 1 :]
    if after.size < 2:
        return None
    after = np.maximum(after[:-1], after[1:])  # of two neighbours: no notch
    lowest = float(after.min())
    ratio = spectrum.top / float(level[high])
    if lowest > FALLS_SHARE * below[high] or ratio > QUIET_SHARE:
        return None
    rounding = 2 * step_mm**2 / 12 / rate_hz * math.log(2)
    levelled = FLAT_RATIO < spectrum.middle / spectrum.top < 1 / FLAT_RATIO
    levelled &= (
        spectrum.least > FLAT_RATIO / 2 * spectrum.top
    )  # a stop band has nulls between its lobes
    if levelled and spectrum.top > ROUNDED_LEVELS * rounding:
        return None
    fallen = high + OCTAVE + 1 + int(np.argmin(after))
    peak = int(np.argmax(level[max(high - OCTAVE, 0) :])) + max(high - OCTAVE, 0)
    peaked = level[peak] > PEAKED * level[max(peak - 3 * OCTAVE, 0) : peak + 1].min()
    return LowPass(name, _cutoff(spectrum, steps, fallen, rounding), ratio, bool(peaked))


def low_passes(
    spectra: Mapping[str, Bands | None], rate_hz: float, step_mm: float
) -> list[LowPass]:
    """The low-pass filters of still series where most coordinates show one, since an export filters
    all of them, and most of these no peak; else none."""
    by_series = {name: low_pass(name, one, rate_hz, step_mm) for name, one in spectra.items()}
    coordinates = [v is not None for k, v in by_series.items() if not k.startswith("L")]
    peaked = sum(v.peaked for k, v in by_series.items() if v and not k.startswith("L"))
    agree = 2 * sum(coordinates) >= len(coordinates) and 2 * peaked <= sum(coordinates)
    return [v for v in by_series.values() if v is not None] if agree else []


def wander(means: np.ndarray, of: int = 10) -> float:
    """Median range of `of` consecutive means of a second: of what moves, not of what wanders."""
    means = means[np.isfinite(means)]
    if means.size < 2:
        return 0.0
    rows = means[: means.size // of * of].reshape(-1, of) if means.size >= of else means[None]
    return float(np.median(np.ptp(rows, axis=1)))


def _cutoff(spectrum: Bands, steps: np.ndarray, fallen: int, rounding: float) -> float:
    """The cutoff, Hz, of the best fit of (a + b / f + c / f^2) |H|^2 + d around the edge: from
    three octaves below it to where W is least, or a hundredth of its greatest; of a sharp edge to
    the first band beyond, in which less counts as that; least squares of logarithms."""
    w = spectrum.psd * steps
    greatest = w[:fallen].max()
    edge = int(np.flatnonzero(w[:fallen] >= greatest / 2)[-1])
    if rounding > COARSE_SHARE * spectrum.psd[edge]:
        return math.nan
    low = np.flatnonzero(w[edge:] < FOLLOWED * greatest)
    last = min(edge + max(int(low[0]), 2) if low.size else w.size, fallen + 2)
    near = slice(max(edge - 3 * OCTAVE, 0), last)
    f, steps = spectrum.f_hz[near], steps[near]
    psd = np.maximum(w[near], FOLLOWED * greatest) / steps
    best = (math.inf, math.nan)
    for cutoff in np.geomspace(f[0], f[-1], 100):
        for order in FILTER_ORDERS:
            gain = 1 / (1 + (f / cutoff) ** (2 * order)) ** 2
            terms = np.stack([gain, gain / np.sqrt(steps), gain / steps, np.ones_like(f)]) / psd
            size = non_negative(terms.T, np.ones(f.size))
            off = np.log(np.maximum(size @ terms, 1e-9))
            best = min(best, (float(off @ off), float(cutoff)))
    return best[1]
