"""The simple Gaussian model of two markers and their distance (S 2.2, 4.2, Table 4)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

MIN_PER_BIN = 5  # expected count below which the chi-squared approximation is poor
LEAST_OF_MEDIAN = 5  # samples in a block, so that one or two wrong ones do not make its median


@dataclass(frozen=True)
class GaussianModel:
    """A row of S Table 4; all in the unit of the series, sigma_12 in its square."""

    mu_1: float
    sigma_1: float
    mu_2: float
    sigma_2: float
    sigma_12: float
    rho_12: float
    mu_L: float
    sigma_L: float
    mu_e: float
    sigma_A1: float
    sigma_A2: float
    sigma_B: float
    sigma_C: float


@dataclass(frozen=True)
class ChiSquared:
    """Test of a sample against a stated normal distribution."""

    statistic: float
    dof: int
    p_value: float
    step: int
    n_independent: int


@dataclass(frozen=True)
class Drift:
    """Slow movement of a series: slope of the least-squares line, and range of its means (or
    medians) over `block_s`."""

    per_hour: float
    range: float
    block_s: float


def gaussian_model(first: np.ndarray, second: np.ndarray, length: np.ndarray) -> GaussianModel:
    """S Table 4 from positions (n,) of two markers along one axis, and their distance (n,).

    Sample moments with n - 1 over the frames where all three are valid, and (S 2.2)
    mu_e = |mu_2 - mu_1|, sigma_Ak = sqrt(2) sigma_k (equal, independent),
    sigma_B = sqrt(sigma_1^2 + sigma_2^2) (independent; S prints sigma_1 twice),
    sigma_C = sqrt(sigma_1^2 + sigma_2^2 - 2 sigma_12) (correlated).
    """
    valid = np.isfinite(first) & np.isfinite(second) & np.isfinite(length)
    if np.count_nonzero(valid) < 2:
        return GaussianModel(*[math.nan] * 13)
    a, b, distances = first[valid], second[valid], length[valid]
    (v_1, v_12), (_, v_2) = np.cov(a, b)
    return GaussianModel(
        mu_1=float(a.mean()),
        sigma_1=math.sqrt(v_1),
        mu_2=float(b.mean()),
        sigma_2=math.sqrt(v_2),
        sigma_12=float(v_12),
        rho_12=float(v_12 / math.sqrt(v_1 * v_2)) if v_1 * v_2 > 0 else math.nan,
        mu_L=float(distances.mean()),
        sigma_L=float(distances.std(ddof=1)),
        mu_e=float(abs(b.mean() - a.mean())),
        sigma_A1=math.sqrt(2 * v_1),
        sigma_A2=math.sqrt(2 * v_2),
        sigma_B=math.sqrt(v_1 + v_2),
        sigma_C=math.sqrt(max(v_1 + v_2 - 2 * v_12, 0.0)),
    )


def along_pair(first: np.ndarray, second: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions (n,) of two markers, each (3, n), along the line from the first to the second.

    Along a coordinate axis, as in S, sigma_C describes the distance only if the axis happens to be
    the line; along the line it does by construction, to first order.
    """
    line = np.nanmean(second, axis=1) - np.nanmean(first, axis=1)
    line = line / np.linalg.norm(line)
    return line @ first, line @ second


def correlation_time(series: np.ndarray) -> float:
    """Integrated autocorrelation time, in samples: 1/2 + sum_k rho(k), at least 1/2.

    The sum ends at the first lag of at least five times the sum so far [Sokal 1997, section 3];
    rho(k) by FFT from the pairs that are valid.
    """
    from scipy import fft

    valid = np.isfinite(series)
    n = series.size
    if not valid.any():
        return 0.5
    size = fft.next_fast_len(2 * n, real=True)
    filled = np.where(valid, series - series[valid].mean(), 0.0)
    spectrum = fft.rfft(filled, size)
    covariance = fft.irfft(np.abs(spectrum) ** 2, size)[:n]
    if valid.all():
        pairs = np.arange(n, 0, -1.0)
    else:
        pairs = np.maximum(fft.irfft(np.abs(fft.rfft(valid.astype(float), size)) ** 2, size)[:n], 1)
    rounding = np.finfo(float).eps * np.abs(series[valid]).max()
    if not covariance[0] > n * rounding**2:  # constant but for rounding
        return 0.5
    rho = covariance / pairs
    tau = np.cumsum(rho / rho[0]) - 0.5
    enough = np.flatnonzero(np.arange(n) >= 5 * tau)
    return max(float(tau[enough[0]] if enough.size else tau[-1]), 0.5)


def chi_squared_normal(
    series: np.ndarray, mu: float, sigma: float, n_bins: int = 30, step: int | None = None
) -> ChiSquared:
    """Pearson's chi-squared test of `series` (n,) against N(mu, sigma) (S 4.2).

    Successive frames are far from independent, and the test supposes that they are: so every
    `step`-th valid sample is used, by default step = 2 x `correlation_time`. The bins are equally
    probable, `n_bins` or as many as expect five samples each. dof = bins - 1 is right for stated
    mu and sigma; where they are in effect fitted to the same series, as along the line between two
    markers, p is an upper bound (the truth lies between bins - 3 and bins - 1). NaN statistic where
    fewer than four bins can be had: too few independent samples to say.
    """
    from scipy.special import chdtrc, ndtr

    valid = series[np.isfinite(series)]
    if valid.size < 2 or not sigma > 0:
        return ChiSquared(math.nan, 0, math.nan, 0, 0)
    step = math.ceil(2 * correlation_time(series)) if step is None else step
    sample = valid[::step]
    bins = min(n_bins, sample.size // MIN_PER_BIN)
    if bins < 4:
        return ChiSquared(math.nan, 0, math.nan, step, sample.size)
    place = np.minimum((ndtr((sample - mu) / sigma) * bins).astype(int), bins - 1)
    expected = sample.size / bins
    statistic = float(np.sum((np.bincount(place, minlength=bins) - expected) ** 2) / expected)
    return ChiSquared(statistic, bins - 1, float(chdtrc(bins - 1, statistic)), step, sample.size)


def drift(series: np.ndarray, frame_rate_hz: float) -> Drift:
    """Drift velocity (unit per hour) and drift range of a series (n,) [Jensenius et al., in S 2.1].

    Both of one-second means (means of a tenth of a series shorter than ten seconds), so that the
    range tells how far the marker seemed to wander and not how noisy a single frame is. Blocks
    without a valid sample are left out.
    """
    block = max(min(round(frame_rate_hz), series.size // 10), 1)
    n_blocks = max(series.size // block, 1)
    blocks = series[: n_blocks * block].reshape(n_blocks, -1)
    valid = np.isfinite(blocks)
    counts = valid.sum(axis=1)
    known = counts > 0
    if np.count_nonzero(known) < 2:
        return Drift(math.nan, math.nan, block / frame_rate_hz)
    means = np.where(valid, blocks, 0.0).sum(axis=1)[known] / counts[known]
    hours = np.flatnonzero(known) * block / frame_rate_hz / 3600
    hours = hours - hours.mean()
    slope = float(np.sum(hours * (means - means.mean())) / np.sum(hours**2))
    return Drift(slope, float(np.ptp(means)), block / frame_rate_hz)


def median_drift(series: np.ndarray, frame_rate_hz: float) -> Drift:
    """As `drift`, of medians and not of means: of raw data, where one wrong sample of 1e9 mm would
    move a mean by kilometres. Blocks have `LEAST_OF_MEDIAN` frames or more where the series (n,)
    has twice as many; those with less than half as many valid samples as is usual are left out.
    """
    block = max(min(round(frame_rate_hz), series.size // 10), 1)
    block = max(block, min(LEAST_OF_MEDIAN, series.size // 2))
    n_blocks = max(series.size // block, 1)
    blocks = series[: n_blocks * block].reshape(n_blocks, -1)
    valid = np.isfinite(blocks)
    counts = valid.sum(axis=1)
    seen = counts[counts > 0]
    known = np.flatnonzero(counts >= max(np.median(seen) / 2, 1)) if seen.size else seen
    if known.size < 2:
        return Drift(math.nan, math.nan, block / frame_rate_hz)
    rising = np.sort(np.where(valid, blocks, np.nan)[known], axis=1)  # NaN come last
    counts, rows = counts[known], np.arange(known.size)
    medians = (rising[rows, (counts - 1) // 2] + rising[rows, counts // 2]) / 2
    hours = known * block / frame_rate_hz / 3600
    hours = hours - hours.mean()
    slope = float(np.sum(hours * (medians - medians.mean())) / np.sum(hours**2))
    return Drift(slope, float(np.ptp(medians)), block / frame_rate_hz)
