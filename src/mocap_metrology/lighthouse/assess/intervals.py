"""Interval of the length of a vector that is measured with a covariance."""

from __future__ import annotations

import numpy as np

POINTS = 12  # 2^12 normal vectors: quantiles within 1 % of a standard deviation


def length_interval(vector: np.ndarray, covariance: np.ndarray) -> tuple[float, float]:
    """95 % interval of the true length |v| where v + e is measured, e normal with a covariance.

    A measured length is larger than the true one on average. So the lower end is the true length s,
    along the measured direction, with which the measured length would be exceeded with probability
    2.5 %; 0 where s = 0 exceeds it more often. The upper end is the quantile
    97.5 % of the length of the measured vector with as much noise again: 1.96
    standard deviations above a length far from 0, and conservative near 0, where it stays above the
    measured one. Quantiles are of a Sobol sequence of normal vectors.
    """
    from scipy.optimize import brentq
    from scipy.stats import norm, qmc

    n, size = len(vector), float(np.linalg.norm(vector))
    uniform = qmc.Sobol(n, scramble=False).random_base2(POINTS) + 0.5 ** (POINTS + 1)
    variances, axes = np.linalg.eigh(covariance)
    error = norm.ppf(uniform) * np.sqrt(np.maximum(variances, 0)) @ axes.T
    direction = vector / size if size > 0 else axes[:, -1]

    def reached(s: float) -> float:
        lengths = np.linalg.norm(s * direction + error, axis=1)
        return float(np.quantile(lengths, 0.975))

    lower = 0.0
    if reached(0.0) < size:
        lower = float(brentq(lambda s: reached(s) - size, 0.0, size))
    return lower, reached(size)
