"""Resonances: what a floor, a tripod or a mount adds when it is shaken by broadband noise.

A damped oscillator of natural frequency f_0 and damping ratio zeta, driven by white noise, moves
with the one-sided density

    R(f) = A / ((1 - (f/f_0)^2)^2 + (2 zeta f/f_0)^2)

[e.g. Bendat & Piersol, Random Data, section 2.4]. Welch's spectrum is explained by power laws
(f^-2, f^-1, 1, f^2), correlated noise of any time constants and noise behind Butterworth filters
(1 / (1 + (f/f_c)^2n) and its square), or with R as well; the deviance of gamma-distributed
ordinates decides. These densities only fall, so that R is a resonance by its peak alone. It is
reported where nothing else in the recording has the same spectrum: no line at its frequency, no
filter, no smoothing.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.linear import non_negative
from mocap_metrology.common.types import Floats

POWERS = (-2, -1, 0, 2)
LOWEST_HZ, HIGHEST = 0.3, 0.8  # of f_0, the latter of Nyquist
SLOW = 1 / 6  # of the lowest f_0: below it a slow cycle or step may have any spectrum
DAMPING = np.geomspace(0.005, 0.15, 10)
BROADEST = 0.25  # damping; broader, a peak is hardly told from correlated noise
CORNERS = 24  # of what falls, between the lowest frequency and Nyquist's
ORDERS = 1, 2, 4  # of Butterworth filters
PLACES, BAND = 60, 0.015  # of f_0 that are tried; of the frequency, a band
RANDOM = 1.6, 4.0  # mean square of the power over the square of its mean; Gaussian noise has 2
MOST_GAPS = 0.1  # share of the frames; bridges over more have a spectrum of their own
STEADY = 0.6  # share of the mean square that its median is
NARROWEST = 0.006  # damping; narrower, it may be a line that wanders
HEIGHT = 1.0  # times the power laws at f_0, at least
LEAST = 40.0  # of the deviance that R explains; chance: 28 at most in 80 series
MISFIT = 10.0  # mean deviance of bands within an octave that are not described
HANN = (4 / 9, 1 / 36)  # correlation of ordinates one and two bins apart [Welch 1967]


@dataclass(frozen=True)
class Resonance:
    """f_hz: natural frequency; damping: ratio zeta; rms_mm: of the oscillation."""

    series: str
    f_hz: float
    damping: float
    rms_mm: float


def resonance(
    name: str,
    values: np.ndarray,
    rate_hz: float,
    spectrum: Mapping[str, np.ndarray],
    lines_hz: Iterable[float] = (),
) -> Resonance | None:
    """The broad resonance of a series (n,) in mm, NaN in gaps, or None. spectrum: columns `f_hz`,
    `psd_mm2_hz` (k,), `n_segments` of their Welch spectrum; lines_hz: frequencies of periodic
    disturbances, whose bins are left out."""
    f, psd = spectrum["f_hz"], spectrum["psd_mm2_hz"]
    if np.isnan(values).mean() > MOST_GAPS:
        return None
    bin_hz, nyquist = float(f[1] - f[0]), float(f[-1])
    keep = (f > max(bin_hz, SLOW * LOWEST_HZ)) & (f < nyquist) & (psd > 0)
    for line in lines_hz:
        keep &= np.abs(f - line) > 3 * bin_hz
    f, psd, count = _bands(f[keep], psd[keep])
    if f.size < PLACES:
        return None
    alike = sum(2 * r * np.maximum(1 - k / count, 0) for k, r in enumerate(HANN, 1))
    weight = float(np.median(spectrum["n_segments"])) * count / (1 + alike)
    laws = np.stack([f ** float(p) for p in POWERS])
    alone, size = _deviance(laws, psd, weight)
    best = alone, math.nan, math.nan, np.zeros(0)
    for f_0, damping in _candidates(
        f, psd, laws[size > 0], weight, size[size > 0], bin_hz, nyquist
    ):
        best = min(best, _fit(f, psd, laws, weight, f_0, damping), key=lambda one: one[0])
    if not alone - best[0] > LEAST:
        return None
    for step in (0.02, 0.005):  # finer
        for f_0 in best[1] * (1 + step * np.arange(-2, 3)):
            for damping in np.minimum(best[2] * (1 + 8 * step * np.arange(-2, 3)), BROADEST):
                best = min(best, _fit(f, psd, laws, weight, f_0, damping), key=lambda one: one[0])
    laws = np.vstack([laws, *_falling(f, nyquist)])
    with_it, f_0, damping, size = _fit(f, psd, laws, weight, *best[1:3])
    if not _deviance(laws, psd, weight)[0] - with_it > LEAST:
        return None
    power = size[-1] * _oscillator(f, f_0, damping)
    ratio, near = psd / (size[:-1] @ laws + power), np.abs(np.log2(f / f_0)) < 1
    if float(np.mean(2 * weight * (ratio - 1 - np.log(ratio)), where=near)) > MISFIT:
        return None
    base = float(np.interp(f_0, f, size[:-1] @ laws))
    inside = LOWEST_HZ <= f_0 <= HIGHEST * nyquist and NARROWEST <= damping < 0.99 * BROADEST
    if (
        not inside
        or power.max() < HEIGHT * base
        or not _steady(values, rate_hz, f_0, damping, base)
    ):
        return None
    rms = math.sqrt(float(power @ count) * bin_hz)
    return Resonance(name, float(f_0), float(damping), rms)


def _falling(f: Floats, nyquist: float) -> Iterator[Floats]:
    """Densities (CORNERS, k) of correlated noise, and of white noise behind Butterworth filters run
    one way and both ways."""
    corners = np.geomspace(f[0], nyquist, CORNERS + 1)[:-1, None]
    for w in (f / corners, np.tan(np.pi / 2 * f / nyquist) / np.tan(np.pi / 2 * corners / nyquist)):
        for order in ORDERS:
            yield 1 / (1 + w ** (2 * order))
            yield 1 / (1 + w ** (2 * order)) ** 2


def _candidates(
    f: Floats,
    psd: Floats,
    laws: Floats,
    weight: Floats,
    size: Floats,
    bin_hz: float,
    nyquist: float,
) -> Floats:
    """(k, 2) frequencies and damping, of a grid, whose R may explain enough by its score [Rao 1948]
    beside the power laws of these sizes: z^2, about what it takes from the deviance."""
    among = np.geomspace(LOWEST_HZ, HIGHEST * nyquist, PLACES)
    tried = np.array([(f_0, zeta) for f_0 in among for zeta in DAMPING if f_0 * zeta > bin_hz])
    level = size @ laws
    scale = np.sqrt(weight) / level
    basis, _ = np.linalg.qr((laws * scale).T)
    peaks = _oscillator(f, *tried.T[:, :, None]) * scale
    peaks = peaks - (peaks @ basis) @ basis.T
    z = peaks @ ((psd - level) * scale) / np.sqrt((peaks**2).sum(axis=1))
    return np.asarray(tried[z > math.sqrt(LEAST)])


def _bands(f: Floats, psd: Floats) -> tuple[Floats, Floats, Floats]:
    """Means over bands of BAND of their frequency, or of one bin, and how many bins each has."""
    if not f.size:
        return f, psd, f
    number = np.floor(np.log(f / f[0]) / BAND)
    starts = np.flatnonzero(np.diff(number, prepend=-1.0))
    count = np.diff(np.append(starts, f.size)).astype(float)
    return np.add.reduceat(f, starts) / count, np.add.reduceat(psd, starts) / count, count


def _steady(values: np.ndarray, rate_hz: float, f_0: float, damping: float, base: float) -> bool:
    """Whether the oscillation goes on all the time, as no burst and no sweep does, with an
    amplitude that is random, as that of no line, and Gaussian, as that of no bursts: powers at f_0
    of blocks of eight times its decay (of means over four, which are narrower than the peak), less
    that of the noise of density `base`, have a median of `STEADY` of their mean at least, powers
    over half a decay a mean square in `RANDOM`."""
    decay = 1 / (2 * math.pi * damping * f_0)
    short, long = max(round(decay * rate_hz / 2), 1), 16
    known = np.where(np.isfinite(values), values - np.nanmean(values), 0.0)
    known = known[: known.size // (short * long) * short * long]
    if known.size < 8 * short * long:
        return False
    turned = known * np.exp(-2j * np.pi * f_0 / rate_hz * np.arange(known.size))
    means = turned.reshape(-1, 2, long // 2, short).mean(axis=3)
    power, blocks = np.abs(means) ** 2, (np.abs(means.mean(axis=2)) ** 2).mean(axis=1)
    noise = base * rate_hz / 2 / short
    size = float(power.mean()) - noise  # E |s + n|^4 = E |s|^4 + 4 S N + 2 N^2 of Gaussian noise
    square = float(np.mean(power**2)) - 4 * size * noise - 2 * noise**2
    if not RANDOM[0] * size**2 <= square <= RANDOM[1] * size**2:
        return False
    noise /= long / 2
    return float(np.median(blocks)) - noise > STEADY * (float(blocks.mean()) - noise)


def _oscillator(f: Floats, f_0: float | Floats, damping: float | Floats) -> Floats:
    x = f / f_0
    return np.asarray(1 / ((1 - x**2) ** 2 + (2 * damping * x) ** 2))


def _fit(
    f: Floats, psd: Floats, laws: Floats, weight: Floats, f_0: float, damping: float
) -> tuple[float, float, float, Floats]:
    value, size = _deviance(np.vstack([laws, _oscillator(f, f_0, damping)]), psd, weight)
    return value, float(f_0), float(damping), size


def _deviance(terms: Floats, psd: Floats, weight: Floats) -> tuple[float, Floats]:
    """2 K sum (I/S - 1 - ln I/S) of ordinates I with K segments each, and the sizes of the terms of
    S, by non-negative least squares of relative errors, twice."""
    level = psd
    for _ in range(2):
        scale = np.sqrt(weight) / level
        size = non_negative((terms * scale).T, psd * scale)
        level = np.maximum(size @ terms, 1e-3 * psd)
    ratio = psd / level
    return float(2 * weight @ (ratio - 1 - np.log(ratio))), size
