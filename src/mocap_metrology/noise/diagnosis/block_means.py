"""Means of blocks of a series, in which slow wander is looked for, and spectra of their differences
for the noises that it may be, see `signatures`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache

import numpy as np

from mocap_metrology.common.types import Floats

LOUD, SURE = 2.0, 7.0  # times the usual variance of frames; standard errors beyond it, at least
LEFT_OUT = 0.4  # of the blocks, at most
AMONG = 9  # blocks whose median shows that they are loud, though some are less so by chance
LEAST_FRAMES = 8  # of a block, to know that variance
MOST_BLOCKS = 1000
FEW_BLOCKS, BLOCK_S = 100, 1.0  # at least, of a short recording; what is faster is no slow wander
FOLDED = 20  # to each side, of the spectra of block means
RATIOS = np.geomspace(1e-4, 1e3, 29)  # of slow noise to white noise in differences of blocks
STEEP = 2.5, 3.0  # exponents of steeper noise than a walk
LONGEST, SHARES = 0.1, 5  # of T_c of a Gauss-Markov term, from one block to this of all
EXACT = 1e-12  # of the variance, in a part where a fit is exact
LOUDNESS = 1, 2, 4, 8  # parts of a recording, in each of which noise has a size of its own


def block_length(size: int, frame_rate_hz: float) -> int:
    """Frames of a block of so many frames."""
    usual = min(round(BLOCK_S * frame_rate_hz), size // FEW_BLOCKS)
    return max(usual, -(-size // MOST_BLOCKS), 1)


def means_of_blocks(series: np.ndarray, length: int) -> tuple[Floats, np.ndarray, float]:
    """Means (n,) of the blocks that are there, and their numbers; blocks of fewer than three
    quarters of the usual number of samples are not, nor those in which frames scatter far more
    about a straight line than they do usually: of noise that is loud, or of a vibration. And the
    share of these."""
    from scipy.ndimage import median_filter

    rows = series[: series.size // length * length].reshape(-1, length)
    known = np.isfinite(rows)
    count = known.sum(axis=1)
    usual = np.median(count[count > 0]) if count.any() else math.inf
    there = np.flatnonzero(count >= 0.75 * usual)
    rest = np.where(known[there], rows[there], 0.0)
    mean = rest.sum(axis=1) / count[there]
    if length >= LEAST_FRAMES and there.size:
        time = np.arange(length) - (length - 1) / 2
        off = np.where(known[there], rest - mean[:, None], 0.0)
        square = (off**2).sum(axis=1) - (off @ time) ** 2 / (time @ time)
        most, usual = max(LOUD, 1 + SURE * math.sqrt(2 / length)), np.median(square)
        quiet = square <= most * usual
        quiet &= (median_filter(square, AMONG) <= (most + 1) / 2 * usual) | (usual == 0)
        if quiet.mean() >= 1 - LEFT_OUT:
            there, mean = there[quiet], mean[quiet]
        return mean, there, float(1 - quiet.mean())
    return mean, there, 0.0


def mean_variance(values: Floats) -> float:
    """Variance of the mean of correlated values, by the means of eighths."""
    parts = np.array([part.mean() for part in np.array_split(values, min(8, values.size))])
    return float(parts.var(ddof=1) / parts.size) if parts.size > 1 else math.nan


@lru_cache(maxsize=4)
def spectra(n: int) -> Mapping[str, Floats]:
    """(m, n) spectra of differences, by noise, white noise first, steep noise last."""
    weight = 4 * np.sin(np.pi * np.arange(1, n + 1) / (2 * (n + 1))) ** 2
    f = np.arange(1, n + 1)[:, None] / (2 * (n + 1)) + np.arange(-FOLDED, FOLDED + 1)
    share = np.sinc(f) ** 2

    def folded(psd: Floats) -> Floats:
        density = weight * (psd * share).sum(axis=1)
        return 4 * density / density.max()  # as white noise has it

    walk = weight + RATIOS[:, None] * (1 - weight / 6)
    flicker = weight + RATIOS[:, None] * folded(1 / np.abs(f))
    steep = [weight + r * folded(1 / np.abs(f) ** a) for a in STEEP for r in RATIOS[::2]]

    def correlated(T_c: float) -> list[Floats]:  # in blocks
        one = folded(1 / (1 + (2 * np.pi * f * T_c) ** 2))
        return [weight + ratio * one for ratio in RATIOS[::2]]

    slow = [one for T_c in np.geomspace(1, LONGEST * n, SHARES) for one in correlated(T_c)]
    return {
        "white": weight[None],
        "fast": np.array(correlated(0.25)),
        "random_walk": walk,
        "flicker": flicker,
        "correlated": np.array(slow),
        "steep": np.array(steep),
    }


@lru_cache(maxsize=4)
def _sums(n: int) -> tuple[Floats, Floats, Floats]:
    """(T_c, sizes, sizes, n) spectra of differences, of a walk and a Gauss-Markov term beside white
    noise; their inverse; the sums of their logarithms."""
    known = spectra(n)
    terms = np.vstack([known["fast"], known["correlated"]]) - known["white"]
    walks = known["random_walk"][::2]
    every = np.asarray(walks[:, None] + terms.reshape(-1, 1, len(RATIOS[::2]), n))
    return every, 1 / every, np.log(every).sum(axis=-1)


def likeliest_sums(y: Floats) -> Floats:
    """Spectra (m, n) of a walk and a Gauss-Markov term of one T_c, of the sizes that are likeliest
    for (n,) values, and smaller, as a shape leaves less to them."""
    every, inverse, logs = _sums(y.size)
    values = logs + y.size * np.log(inverse @ (y * y) / y.size)
    at, walk, term = np.unravel_index(np.argmin(values), values.shape)
    near = every[at, max(walk - 2, 0) : walk + 1, max(term - 2, 0) : term + 1]
    return near.reshape(-1, y.size)


def by_parts(y: Floats, X: Floats, spectrum: Floats) -> float:
    """BIC of a fit in noise whose size differs between equal parts of the recording, as many as it
    is best by; of what is left of the whitened differences, in order of time."""
    from scipy.fft import dst

    rows = dst(np.vstack([y, X]) / np.sqrt(spectrum), type=1, norm="ortho", axis=1)
    n, found = y.size, []
    for count in LOUDNESS:
        part, size = np.arange(n) * count // n, np.ones(n)
        for _ in range(2):
            weighted = rows / size
            rest = rows[0] - np.linalg.lstsq(weighted[1:].T, weighted[0], rcond=None)[0] @ rows[1:]
            variance = np.bincount(part, rest**2) / np.bincount(part)
            size = np.sqrt(np.maximum(variance, EXACT * variance.mean() + 1e-300))[part]
        found.append(2 * float(np.log(size).sum()) + (count - 1) * math.log(n))
    return float(np.log(spectrum).sum()) + min(found)
