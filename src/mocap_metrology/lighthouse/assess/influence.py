"""Influence of a circumstance of calibrations, such as the board's speed, on their errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

SPAN = 0.05, 0.95  # quantiles within groups: the range in which a circumstance was varied


@dataclass(frozen=True)
class Influence:
    """`p`: probability of so strong a relation by chance; `detectable`: smallest factor in the
    error that would be detected with the given power (inf: the circumstance was not varied)."""

    p: float
    detectable: float


def influence(
    log_errors: np.ndarray,
    circumstance: np.ndarray,
    groups: Sequence[str],
    alpha: float,
    power: float,
) -> Influence:
    """Log errors (n,) against a circumstance (n, k), both less their group's mean.

    Circumstance: one column of numbers, or an indicator (0 or 1) of each of k kinds. Given that
    within a group every order of the errors is equally likely, T = sum a x (a, x less their group's
    mean) has the mean 0 and, by groups g of n_g, the covariance sum_g (sum a^2) (sum x x') /
    (n_g - 1); T' cov^-1 T is chi-squared with its rank (Strasser & Weber 1999). `detectable` of a
    number: factor between the 5 and the 95 % points of its values within groups; of kinds: factor
    between one and the others, for the kind least often varied.
    """
    from scipy.optimize import brentq
    from scipy.stats import chi2, ncx2

    names = np.asarray(groups)
    a, x = np.array(log_errors, dtype=float), np.array(circumstance, dtype=float)
    cov, free = np.zeros((x.shape[1], x.shape[1])), 0
    for name in np.unique(names):
        members = names == name
        a[members] -= a[members].mean()
        x[members] -= x[members].mean(axis=0)
        x[members] *= (
            np.ptp(x[members], axis=0) > 1e-9
        )  # the same in the whole group, but for rounding
        if members.sum() > 1:
            cov += np.sum(a[members] ** 2) * (x[members].T @ x[members]) / (members.sum() - 1)
            free += members.sum() - 1
    rank = int(np.linalg.matrix_rank(cov))
    if not rank:
        return Influence(np.nan, np.inf)
    total = a @ x
    p = float(chi2.sf(total @ np.linalg.pinv(cov) @ total, rank))
    limit = chi2.isf(alpha, rank)
    needed = brentq(lambda shift: ncx2.sf(limit, rank, shift) - power, 1e-3, 1e3)
    spread = np.sum(x**2, axis=0)
    reach = np.ptp(np.quantile(x, SPAN, axis=0), axis=0) if x.shape[1] == 1 else 1.0
    steps = np.sqrt(needed * np.sum(a**2) / free / spread[spread > 0]) * reach
    return Influence(p, float(np.exp(np.max(steps))))
