"""Density of the noise under and beside the lines of a periodogram, by medians.

The power of one coefficient is exponentially distributed: its median is ln 2 of its mean.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

MEDIAN_OF = 4096  # coefficients at most that a median is taken of
SIDE_OCTAVES, SIDE_LEAST = 1 / 16, 32  # width of the bands beside a line, and their coefficients
SURE = 2.0  # standard errors by which a band beside a line must exceed the level to count
TINY = np.finfo(float).tiny


def level(power: np.ndarray, k: np.ndarray) -> np.ndarray:
    """Noise density at coefficients k (ascending, without holes): medians of bands a quarter octave
    wide, interpolated in log-log."""
    edge = np.geomspace(k[0] / 1.1, k[-1] + 1, max(round(math.log2(k[-1] / k[0]) * 4), 2) + 1)
    edge = np.unique(edge.astype(np.int64))
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
    if len(edge) > 2:  # the last band is a whole one
        edge[-1] = int(k[-1]) + 1
        edge = edge if edge[-1] - edge[-2] >= SIDE_LEAST else [*edge[:-2], edge[-1]]
    else:
        edge[-1] = int(k[-1]) + 1
    width = np.diff(edge)
    sure = np.exp(-SURE / (math.log(2) * np.sqrt(np.minimum(width, MEDIAN_OF))))
    own = _medians(power, np.array(edge)) * sure
    left, right = np.roll(own, 1), np.roll(own, -1)
    left[0], right[-1] = right[0], left[-1]
    return np.repeat(np.maximum(np.maximum(left, right), own), width)


def around(power: np.ndarray, low: int, high: int, width: int) -> float:
    """Density between `width` coefficients on each side of low ... high: geometric mean of the
    sides, of those that there are."""
    sides = power[max(low - width, 1) : low], power[high + 1 : high + 1 + width]
    known = [float(np.median(side)) for side in sides if 2 * side.size >= width]
    if not known:
        known = [float(np.median(np.concatenate(sides)))] if sum(s.size for s in sides) else [TINY]
    return max(math.prod(known) ** (1 / len(known)) / math.log(2), TINY)


def _medians(power: np.ndarray, edge: np.ndarray) -> np.ndarray:
    found = [np.median(power[a : b : (b - a) // MEDIAN_OF + 1]) for a, b in pairwise(edge)]
    return np.maximum(np.array(found) / math.log(2), TINY)
