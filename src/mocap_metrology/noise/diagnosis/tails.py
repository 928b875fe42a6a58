"""Heavy tails: are large differences from frame to frame more frequent than Gaussian noise has?"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

BLOCK = 1000  # differences whose kurtosis is taken at once, so no change of level makes any
FEWEST = 8  # blocks
CHANCE = 0.005  # that any series of a Gaussian recording is said to have heavy tails
LEAST = 0.2  # excess that is told


@dataclass(frozen=True)
class Tails:
    """Excess kurtosis of the differences of frames of a series, with its 95 % interval."""

    series: str
    excess: float
    lower: float
    upper: float


def heavy_tails(series: Mapping[str, np.ndarray], resolution_mm: float) -> list[Tails]:
    """Of (n,) values in mm, NaN in gaps, those with surely more than a Gaussian's."""
    step = resolution_mm if math.isfinite(resolution_mm) else 0.0
    chance = CHANCE / max(len(series), 1)
    found = [_tails(name, values, step, chance) for name, values in series.items()]
    return [one for one in found if one]


def _tails(name: str, series: np.ndarray, step: float, chance: float) -> Tails | None:
    """m_4 / m_2^2 - 3 + 6/n of blocks [unbiased for Gaussian noise to 1/n], and Student's t of
    their mean. Frames that repeat the one before tell nothing; steps as large as the noise, less.
    """
    from scipy.special import stdtrit

    d = np.diff(series.astype(np.float64))
    d = d[np.isfinite(d)]
    size = float(d.std()) if d.size else 0.0
    if size > 10 * step:
        d = d[d != 0]
    if d.size < FEWEST * BLOCK or size < step or not size > 0:
        return None
    rows = d[: d.size // BLOCK * BLOCK].reshape(-1, BLOCK)
    squares = (rows - rows.mean(axis=1, keepdims=True)) ** 2
    power = squares.mean(axis=1)
    squares = squares[power > 0]
    if len(squares) < FEWEST:
        return None
    excess = (squares**2).mean(axis=1) / squares.mean(axis=1) ** 2 - 3 + 6 / BLOCK
    mean, error = float(excess.mean()), float(excess.std(ddof=1) / math.sqrt(excess.size))
    if mean < LEAST or mean < -float(stdtrit(excess.size - 1, chance)) * error:
        return None
    reach = float(stdtrit(excess.size - 1, 0.975)) * error
    return Tails(name, mean, mean - reach, mean + reach)
