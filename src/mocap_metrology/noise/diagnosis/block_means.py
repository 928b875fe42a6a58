"""Means of blocks of a series, in which slow wander is looked for."""

from __future__ import annotations

import math

import numpy as np

from mocap_metrology.common.types import Floats

LOUD, SURE = 2.0, 7.0  # times the usual variance of frames; standard errors beyond it, at least
LEFT_OUT = 0.4  # of the blocks, at most
AMONG = 9  # blocks whose median shows that they are loud, though some are less so by chance
LEAST_FRAMES = 8  # of a block, to know that variance
MOST_BLOCKS = 1000
FEW_BLOCKS, BLOCK_S = 100, 1.0  # at least, of a short recording; what is faster is no slow wander


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
