"""How noise falls with the number of cameras: the law sigma / sqrt(n), S Eq. 3."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Scaling:
    """`one`: SD that the law gives one camera, in the unit of the SDs; `exponent` of n in a free
    power law and its standard error (NaN with two numbers only); `rms`: of ln(SD / law)."""

    one: float
    exponent: float
    exponent_error: float
    rms: float

    def law(self, n: np.ndarray) -> np.ndarray:
        """one / sqrt(n)."""
        return self.one / np.sqrt(n)


def fit_scaling(n: np.ndarray, deviation: np.ndarray) -> Scaling | None:
    """Fit sigma / sqrt(n) to standard deviations (k,) at n cameras (k,), by the mean of logarithms
    (they scatter in proportion), and beside it a free exponent, by least squares.

    None with fewer than two different n of a positive SD.
    """
    n, deviation = np.asarray(n, float), np.asarray(deviation, float)
    known = np.isfinite(deviation) & (deviation > 0) & (n > 0)
    x, y = np.log(n[known]), np.log(deviation[known])
    if np.unique(x).size < 2:
        return None
    law = float(np.mean(y + x / 2))
    centred = x - x.mean()
    slope = float(centred @ y / (centred @ centred))
    rest = y - y.mean() - slope * centred
    error = math.nan
    if x.size > 2:
        error = math.sqrt(float(rest @ rest) / (x.size - 2) / float(centred @ centred))
    return Scaling(math.exp(law), slope, error, float(np.sqrt(np.mean((y - law + x / 2) ** 2))))
