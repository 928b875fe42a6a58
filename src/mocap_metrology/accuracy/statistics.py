"""Statistics of few repeated values, of correlated series, and of series with gross errors.

Random effects: values x_i = mu + b_i + e_i with known variances v_i of e_i; the variance tau^2 of
b_i by DerSimonian & Laird [Control. Clin. Trials 7 (1986) 177], its limits by the profile of
Q(tau^2) = sum (x_i - mu)^2 / (v_i + tau^2) ~ chi^2(k - 1) [Viechtbauer, Stat. Med. 26 (2007) 37],
those of mu by Hartung & Knapp [Stat. Med. 20 (2001) 3875], whose t(k - 1) holds with few values.

The mean of n values with autocorrelation rho_k has the variance sigma^2 tau / n with the integrated
correlation time tau = 1 + 2 sum rho_k, in samples; n_eff = n / tau. The sum is cut by Geyer's
initial monotone sequence [Stat. Sci. 7 (1992) 473, section 3.3]: sums of adjacent pairs of
autocovariances Gamma_m = gamma_2m + gamma_2m+1 of a reversible chain are positive and fall with m;
the sequence ends with the first that is not positive, and none exceeds one before it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.hampel import MAD_TO_SIGMA
from mocap_metrology.common.transforms import irfft, rfft

FEWEST = 3  # values that show how they scatter
BATCHES = 10
COARSER, LEAST_SUMS = 4, 100  # values in a sum of the next level, and sums of the coarsest
TUNING = 1.345  # Huber's, of 95 % efficiency for normal noise
ROUNDS = 30
LEAST_EFFECTIVE = 25.0  # below it the interval of a mean holds in fewer than 90 % of takes


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


def effective_number(series: np.ndarray) -> float:
    """n_eff of (n,) values, NaN in gaps: from 1 to the number of known values; NaN of fewer than
    two. A constant series counts as one value. The least by sums of 1, 4, 16 ... values, as
    white noise hides what is slow and small."""
    known = np.isfinite(series)
    n = int(known.sum())
    if n < 2:
        return math.nan
    sums = np.where(known, series - np.nanmean(series), 0.0)
    squares, of_sum = float((sums**2).sum()), n * _long_term(sums, known)
    if not squares > 0:
        return 1.0
    while sums.size >= COARSER * LEAST_SUMS:
        sums = sums[: sums.size // COARSER * COARSER].reshape(-1, COARSER).sum(axis=1)
        of_sum = max(of_sum, sums.size * _long_term(sums, np.ones(sums.size, bool)))
    return float(np.clip(n * squares / of_sum, 1.0, n)) if of_sum > 0 else float(n)


def _long_term(centred: np.ndarray, known: np.ndarray) -> float:
    """sigma^2 tau of (n,) values by Geyer's sequence."""
    gamma = _autocovariance(centred, known)
    pairs = gamma[: gamma.size // 2 * 2].reshape(-1, 2).sum(axis=1)
    ends = np.flatnonzero(~(pairs > 0))
    pairs = np.minimum.accumulate(pairs[: ends[0] if ends.size else None])
    return 2 * float(pairs.sum()) - float(gamma[0])


def _autocovariance(centred: np.ndarray, known: np.ndarray) -> np.ndarray:
    """At all lags, of values that are 0 in gaps: the mean product of pairs that are both known,
    times 1 - k/n, as the estimate that is positive definite without gaps."""
    from scipy.fft import next_fast_len

    n = centred.size
    size = next_fast_len(2 * n, real=True)
    sums = irfft(np.abs(rfft(centred, size)) ** 2, size)[:n]
    taper = (1 - np.arange(n) / n) / n
    if known.all():
        return np.asarray(sums / n)
    pairs = np.round(irfft(np.abs(rfft(known.astype(float), size)) ** 2, size)[:n])
    return np.asarray(sums * n * taper / np.maximum(pairs, 1))


def half_interval(series: np.ndarray) -> float:
    """Half the 95 % interval of the mean of (n,) correlated values, NaN in gaps: t(n_eff - 1) s /
    sqrt(n_eff), or t(9) of the means of ten batches where that is wider; NaN where n_eff, or the
    number of independent values by which the batch means scatter, 10 s^2 / s_b^2, is below
    `LEAST_EFFECTIVE`: a series of few correlation times often hides that it is one."""
    from scipy.special import stdtrit

    values = series[np.isfinite(series)]
    n_eff = effective_number(series)
    if not n_eff >= LEAST_EFFECTIVE:  # there are as many values or more
        return math.nan
    sd = float(values.std(ddof=1))
    batches = values[: values.size // BATCHES * BATCHES].reshape(BATCHES, -1)
    spread = float(batches.mean(axis=1).std(ddof=1))
    if BATCHES * sd**2 < LEAST_EFFECTIVE * spread**2:
        return math.nan
    half = float(stdtrit(n_eff - 1, 0.975)) * sd / math.sqrt(n_eff)
    return max(half, float(stdtrit(BATCHES - 1, 0.975)) * spread / math.sqrt(BATCHES))


def robust_sd(values: np.ndarray) -> float:
    """1.4826 times the median absolute deviation from the median; NaN are left out."""
    return float(MAD_TO_SIGMA * np.nanmedian(np.abs(values - np.nanmedian(values))))


def huber_fit(design: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Coefficients (p,) of target (n,) = design (n, p) by Huber's M estimate with the scale of the
    residuals' median [Huber, Robust Statistics, ch. 7], by iterated weights; the shortest ones
    where the design does not determine them."""
    weight, coefficients = np.ones(target.size), np.zeros(design.shape[1])
    for _ in range(ROUNDS):
        before = coefficients
        weighted = design.T * weight
        coefficients = np.linalg.lstsq(weighted @ design, weighted @ target, rcond=1e-10)[0]
        residual = np.abs(target - design @ coefficients)
        limit = TUNING * MAD_TO_SIGMA * float(np.median(residual))
        if not limit > 0 or np.allclose(before, coefficients, rtol=1e-4, atol=1e-4 * limit):
            break
        weight = np.minimum(limit / np.maximum(residual, limit), 1.0)
    return np.asarray(coefficients)
