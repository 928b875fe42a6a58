"""S Eq. 3: does the standard deviation fall as one over the root of the number of cameras?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mocap_metrology.noise.cameras.scaling import fit_scaling

LEAST_RANGE = 1.5  # of the numbers: 8, 9 and 10 cameras tell of their places, not of a law


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
    if np.unique(n).size < 3 or n.max() < LEAST_RANGE * n.min():
        return None
    line = fit_scaling(n, s)
    b, error = -line.exponent, line.exponent_error
    p = 2 * t.sf(abs(b - 0.5) / error, n.size - 2) if error > 0 else float("nan")
    scatter = float(np.log(n * s**2).std(ddof=1))
    return Law(b, error, float(p), scatter, int(n.size))
