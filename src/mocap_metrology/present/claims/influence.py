"""What a circumstance that varies within groups does to errors, apart from what the groups do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

SPAN = (0.05, 0.95)  # of a circumstance within its groups: from here to there it was tried


@dataclass(frozen=True)
class Influence:
    """`p` that errors go with a circumstance so much by chance; `seen`: by what factor it would
    have to change the error to be found with the given power (inf: it was not varied)."""

    p: float
    seen: float


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
    (n_g - 1); T' cov^-1 T is chi-squared with its rank (Strasser & Weber 1999). `seen`: of a number
    the factor between the 5 and the 95 % points of what was tried within groups; of kinds that of
    one against the others, of the kind least often varied.
    """
    from scipy.optimize import brentq
    from scipy.stats import chi2, ncx2

    names = np.asarray(groups)
    a, x = np.array(log_errors, dtype=float), np.array(circumstance, dtype=float)
    cov, free = np.zeros((x.shape[1], x.shape[1])), 0
    for name in np.unique(names):
        own = names == name
        a[own] -= a[own].mean()
        x[own] -= x[own].mean(axis=0)
        x[own] *= np.ptp(x[own], axis=0) > 1e-9  # the same in the whole group, but for rounding
        if own.sum() > 1:
            cov += np.sum(a[own] ** 2) * (x[own].T @ x[own]) / (own.sum() - 1)
            free += own.sum() - 1
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
