"""How noise falls with the number of cameras: sigma / sqrt(n), S Eq. 3, fitted and tested."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.types import Floats

LEAST_RANGE = 1.5  # of the numbers: 8, 9 and 10 cameras differ by their places, not by a law


@dataclass(frozen=True)
class Scaling:
    """`one`: SD that the law gives one camera, in the unit of the SDs; `exponent` of n in a free
    power law and its standard error (NaN with two numbers only); `rms`: of ln(SD / law)."""

    one: float
    exponent: float
    exponent_error: float
    rms: float

    def law(self, n: Floats) -> Floats:
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


@dataclass(frozen=True)
class Law:
    """sigma ~ n^-b: exponent, its standard error from the scatter about the line, the probability
    of a b so far from 1/2 if 1/2 is true, and the standard deviation of ln(n sigma^2)."""

    b: float
    std_error: float
    p_value: float
    scatter: float
    n_subsets: int


def law(n_cameras: Sequence[int], sigma: Sequence[float]) -> Law | None:
    """Line through ln sigma against ln n by ordinary least squares; None with fewer than three
    different numbers of cameras, or numbers all within `LEAST_RANGE`.

    The geometry of each subset scatters sigma far more than the length of a recording does, so the
    points weigh the same.
    """
    from scipy.stats import t

    n, s = np.asarray(n_cameras, dtype=np.float64), np.asarray(sigma, dtype=np.float64)
    use = np.isfinite(s) & (s > 0)
    n, s = n[use], s[use]
    line = fit_scaling(n, s)
    if line is None or np.unique(n).size < 3 or n.max() < LEAST_RANGE * n.min():
        return None
    b, error = -line.exponent, line.exponent_error
    p = 2 * t.sf(abs(b - 0.5) / error, n.size - 2) if error > 0 else float("nan")
    scatter = float(np.log(n * s**2).std(ddof=1))
    return Law(b, error, float(p), scatter, int(n.size))
