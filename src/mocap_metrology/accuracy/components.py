"""Few repeated values: their mean and the next one by Student's t, and how much of their scatter is
real.

Random effects: values x_i = mu + b_i + e_i with known variances v_i of e_i; the variance tau^2 of
b_i by DerSimonian & Laird [Control. Clin. Trials 7 (1986) 177], its limits by the profile of
Q(tau^2) = sum (x_i - mu)^2 / (v_i + tau^2) ~ chi^2(k - 1) [Viechtbauer, Stat. Med. 26 (2007) 37],
those of mu by Hartung & Knapp [Stat. Med. 20 (2001) 3875], whose t(k - 1) holds with few values.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

FEWEST = 3  # values that show how they scatter


@dataclass(frozen=True)
class Repeated:
    """A statistic of k repeats: its mean (geometric where positive), the interval of the mean, and
    that of the next repeat. NaN below FEWEST."""

    k: int
    value: float
    lower: float = math.nan
    upper: float = math.nan
    next_lower: float = math.nan
    next_upper: float = math.nan


def repeated(values: Sequence[float] | np.ndarray, positive: bool = False) -> Repeated:
    """mean +- t(k - 1) s / sqrt(k), the next value +- t(k - 1) s sqrt(1 + 1/k), 95 % each; of
    logarithms where the statistic is `positive` and no value is 0. NaN values are left out."""
    from scipy.special import stdtrit

    known = np.asarray(values, dtype=float)
    known = known[np.isfinite(known)]
    logs = positive and bool(known.size) and bool((known > 0).all())
    x = np.log(known) if logs else known
    k = x.size
    mean = x.mean() if k else math.nan
    half = math.nan
    if k >= FEWEST:
        half = stdtrit(k - 1, 0.975) * x.std(ddof=1) / math.sqrt(k)
    further = half * math.sqrt(k + 1)
    ends = np.array([mean, mean - half, mean + half, mean - further, mean + further])
    return Repeated(k, *(float(end) for end in (np.exp(ends) if logs else ends)))


@dataclass(frozen=True)
class Effects:
    """Random effects of k groups: common mean, its standard error and 95 % interval; sd between
    groups with its interval; chance of a scatter as large without any. NaN below two groups."""

    k: int
    mean: float
    se: float
    lower: float
    upper: float
    between: float
    between_lower: float
    between_upper: float
    chance: float


def random_effects(
    values: Sequence[float] | np.ndarray,
    variances: Sequence[float] | np.ndarray,
    dof: float = math.inf,
) -> Effects:
    """Values (k,) and the variances (k,) > 0 of their errors, up to one factor of `dof` degrees of
    freedom: Q / (k - 1) ~ F(k - 1, dof)."""
    from scipy.special import chdtrc, chdtri, fdtrc, fdtri, stdtrit

    x, v = np.asarray(values, dtype=float), np.asarray(variances, dtype=float)
    k = x.size
    if k < 2:
        return Effects(k, float(x[0]) if k else math.nan, *(math.nan,) * 7)
    w = 1 / v
    alone = _cochran_q(x, v, 0.0)[0]
    between = max((alone - (k - 1)) / (w.sum() - (w**2).sum() / w.sum()), 0.0)
    q, mean = _cochran_q(x, v, between)
    se = math.sqrt(q / (k - 1) / float((1 / (v + between)).sum()))
    half = float(stdtrit(k - 1, 0.975)) * se
    known, tails = math.isinf(dof), (0.025, 0.975)
    limits = (chdtri(k - 1, p) if known else (k - 1) * fdtri(k - 1, dof, 1 - p) for p in tails)
    low, high = (math.sqrt(_solve(x, v, float(limit))) for limit in limits)
    chance = float(chdtrc(k - 1, alone) if known else fdtrc(k - 1, dof, alone / (k - 1)))
    return Effects(k, mean, se, mean - half, mean + half, math.sqrt(between), low, high, chance)


def _cochran_q(x: np.ndarray, v: np.ndarray, between: float) -> tuple[float, float]:
    """Q(tau^2), and the weighted mean."""
    w = 1 / (v + between)
    mean = float((w * x).sum() / w.sum())
    return float((w * (x - mean) ** 2).sum()), mean


def _solve(x: np.ndarray, v: np.ndarray, q: float) -> float:
    """tau^2 with Q(tau^2) = q; 0 where Q is smaller for all."""
    from scipy.optimize import brentq

    if _cochran_q(x, v, 0.0)[0] <= q:
        return 0.0
    high = float(((x - x.mean()) ** 2).sum()) / q + float(v.max())  # Q is below q there
    return float(brentq(lambda tau: _cochran_q(x, v, tau)[0] - q, 0.0, high))
