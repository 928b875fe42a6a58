"""Which noise dominates at an averaging time.

Exponents alpha are those of the series' power spectral density, S(f) ~ f^alpha: 2 violet, 1 blue,
0 white, -1 flicker, -2 random walk, -3 and -4 (Hadamard only) flicker walk and random run.
"""

from __future__ import annotations

import math

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.common.types import Floats
from mocap_metrology.noise.allan.variance import about_mean, running_sum

MIN_MEANS = 30  # the identification needs that many window means [Riley & Greenhall 2004]
DIFFERENCING = {"oadev": 2, "mdev": 2, "hdev": 3}  # d of Greenhall & Riley
STEEPEST = {"oadev": -2, "mdev": -2, "hdev": -4}  # steepest noise the variance converges for
STEEPER = -0.9  # lag-1 autocorrelation below that of violet, -0.5: of samples that alternate


def noise_exponents(series: np.ndarray, m: np.ndarray, estimator: str = "oadev") -> np.ndarray:
    """(k,) whole exponents alpha of the noise that dominates at each averaging factor.

    Lag-1 autocorrelation of the N window means [Riley & Greenhall, "Power law noise identification
    using the lag 1 autocorrelation", EFTF 2004]: with r1 of the means, differenced d times until
    delta = r1 / (1 + r1) < 1/4, alpha = -2 (delta + d), rounded. Going from short tau to long, an
    exponent stands until that departs from it by more than rounding and two standard errors
    (2 / sqrt(N)) explain (of blue and violet noise downwards rounding alone: it has the most
    degrees of freedom, and gives way), and where fewer than 30 means remain, though not above 0, as
    of GPS data by Stable32: one white series in six would be called blue at N = 31, with seven
    times the degrees of freedom it has. It never rises above 0 and above that before: of a sum of
    power laws and Gauss-Markov terms the higher exponents fade as tau grows, and among so many tau
    chance alone makes blue of white in one series in twenty, with hundreds of times its degrees of
    freedom. (Noise that is violet down to the longest tau has wider intervals there than it
    needs.) NaN samples are left out of the means, windows without any out of the sum.
    """
    valid = np.isfinite(series)
    sums = running_sum(about_mean(series, valid))
    counts = np.empty(0) if valid.all() else running_sum(valid)
    exponents = np.zeros(len(m), dtype=np.int64)
    last = None
    for k in np.argsort(m):
        if series.size // m[k] >= MIN_MEANS:
            exponent = _lag1_exponent(sums, counts, m[k], DIFFERENCING[estimator])
            n_means = series.size // m[k]
            known = math.isfinite(exponent)
            if known and (last is None or _departs(exponent, last, n_means)):
                steepest_rise = 2 if last is None else max(last, 0)
                last = min(max(round(exponent), STEEPEST[estimator]), steepest_rise)
            exponents[k] = last or 0
        else:
            exponents[k] = min(last or 0, 0)
    return exponents


def _departs(exponent: float, last: int, n_means: int) -> bool:
    errors = 0 if exponent < last and last > 0 else 2
    return abs(exponent - last) > 0.5 + errors * 2 / math.sqrt(n_means)


@njit
def _lag1_exponent(sums: Floats, counts: Floats, m: int, most: int) -> float:
    """-2 (delta + d), of window means differenced `most` times at most; NaN of too few. sums,
    counts: running sums (n + 1,) of values and of how many there are, the latter empty where none
    is missing."""
    size = (sums.size - 1) // m
    for differences in range(most + 1):
        n_known, n_pairs, total, squares, _ = _moments(sums, counts, m, differences, 0.0)
        if n_known < MIN_MEANS - most or not n_pairs:
            break
        mean = total / n_known
        _, _, _, power, products = _moments(sums, counts, m, differences, mean)
        if not power > 1e-15 * squares:
            break
        # Without gaps, the textbook ratio of sums
        length = size - differences
        r1 = products / power * (length - 1) / n_pairs * n_known / length
        r1 = max(r1, STEEPER)
        delta = r1 / (1 + r1)
        if delta < 0.25 or differences == most:
            return -2 * (delta + differences)
    return math.nan


@njit
def _moments(
    sums: Floats, counts: Floats, m: int, differences: int, mean: float
) -> tuple[int, int, float, float, float]:
    """Of window means, differenced so many times, less `mean`: how many are known, and how many
    pairs of neighbours; their sum, that of squares, and of products of neighbours. No arrays, as
    those of 90 hours need gigabytes."""
    whole, run, before = counts.size == 0, 0, 0.0
    n_known, n_pairs, total, squares, products = 0, 0, 0.0, 0.0, 0.0
    last = np.zeros(differences)
    for i in range((sums.size - 1) // m):
        count = float(m) if whole else counts[(i + 1) * m] - counts[i * m]
        run = run + 1 if count > 0 else 0
        x = (sums[(i + 1) * m] - sums[i * m]) / max(count, 1.0)
        for k in range(differences):
            x, last[k] = x - last[k], x
        if run > differences:
            x -= mean
            n_known += 1
            total += x
            squares += x * x
            if run > differences + 1:
                n_pairs += 1
                products += x * before
            before = x
    return n_known, n_pairs, total, squares, products


def warm_up() -> None:
    """Compile all kernels."""
    noise_exponents(np.arange(2.0 * MIN_MEANS), np.array([1]))
