"""Lines of finite width: mains whose frequency wanders, a fan, a resonance.

Such a line fills a band of coefficients k_1 ... k_2, of density S of the noise and duration T:

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

import numpy as np

from mocap_metrology.noise.fit.spectral.line_level import around
from mocap_metrology.noise.fit.spectral.line_of import Line

LEAST_SIDE, MOST_SIDE = 32, 256  # coefficients on each side that the noise is told from
MARGIN = 4  # coefficients beyond the outermost line
BLOCKS = ((32, 8, 1.207), (0, 4, 1.624))  # from so many coefficients; blocks; Student t over 1.96
GROWS = 1.0  # times 1/sqrt(w): two standard deviations of the share above the median
PHASES = 8.0  # of a folded line over width_f T: its power depends on where they fall
FOLDED = 1.9  # standard errors to the fold: 95 % reach just beyond
LEAST_WIDTH = 0.5  # coefficients: less is not resolved


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


def measured(
    spectrum: np.ndarray, low: int, high: int, n: int, tau0: float, psd: float | None = None
) -> Line:
    """The line of finite width in coefficients low ... high of `spectrum`, rfft of n samples.

    psd: of the noise; without it, the median of what stands on both sides.
    """
    size = high - low + 1
    away, side = min(size, low // 8), max(LEAST_SIDE, min(max(MOST_SIDE, 2 * size), low // 8))
    if psd is None:
        near = spectrum[: high + 1 + away + side]
        power = 2 * tau0 / n * (near.real**2 + near.imag**2)
        psd = around(power, low - away, high + away, side)
    band = spectrum[low : high + 1].copy()
    folded = high >= (n - 1) // 2
    duration = n * tau0
    whole = _moments(band, low, n, tau0, psd)
    A_s, f_0, width = whole
    gain = A_s**2 * duration / psd
    noise = math.sqrt(gain + size + size**2 / (2 * side)) * psd / duration
    own = _jackknife(band, low, n, tau0, psd)
    errors = [max(noise / A_s, own[0]) if A_s > 0 else math.sqrt(noise), own[1], own[2]]
    if folded:
        errors[0] = math.hypot(errors[0], A_s / math.sqrt(PHASES * max(width * duration, 1.0)))
        errors[1] = max(errors[1], (0.5 / tau0 - f_0) / FOLDED)
    errors[1] = max(errors[1], 0.5 / duration / math.sqrt(max(gain, 1.0)))
    errors[2] = max(errors[2], errors[1])
    step = 1 / duration
    return Line(
        A_s, f_0, math.nan, psd, gain, width, *errors,
        band_hz=((low - 0.5) * step, (high + 0.5) * step), parts=band, first=low, period=n,
    )  # fmt: skip


def _moments(
    band: np.ndarray, low: int, n: int, tau0: float, psd: float, share: float = 1.0
) -> tuple[float, float, float]:
    """A_s, f_0, width_f of the band's coefficients, of which a share of the time was kept."""
    k = np.arange(low, low + band.size)
    power = 2 * tau0 / n * (band.real**2 + band.imag**2) / share
    excess = np.where(2 * k == n, 0.5, 1.0) * (power - psd)
    total = float(excess.sum())
    if total <= 0:
        return 0.0, float(k.mean()) / (n * tau0), 0.0
    centre = float(np.clip(excess @ k / total, k[0], k[-1]))
    width = math.sqrt(max(excess @ (k - centre) ** 2 / total, LEAST_WIDTH**2))
    step = 1 / (n * tau0)
    return math.sqrt(2 * total * step), centre * step, width * step


def _jackknife(band: np.ndarray, low: int, n: int, tau0: float, psd: float) -> list[float]:
    """Standard errors of `_moments` from what they are without one block of time each."""
    from scipy.fft import fft, ifft

    blocks, student = next((b, t) for least, b, t in BLOCKS if band.size >= least)
    wave = ifft(band)
    of = np.arange(wave.size) * blocks // wave.size
    left = []
    for block in range(blocks):
        kept = of != block
        left.append(_moments(fft(np.where(kept, wave, 0)), low, n, tau0, psd, kept.mean()))
    scatter = np.std(left, axis=0) * math.sqrt(blocks - 1)
    return [float(student * s) for s in scatter]
