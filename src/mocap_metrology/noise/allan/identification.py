"""Which noise dominates at an averaging time.

Exponents alpha are those of the series' power spectral density, S(f) ~ f^alpha: 2 violet, 1 blue,
0 white, -1 flicker, -2 random walk, -3 and -4 (Hadamard only) flicker walk and random run.
"""

from __future__ import annotations

import math

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.common.types import Floats
from mocap_metrology.noise.allan.sums import REORDER, running_sum

MIN_MEANS = 30  # the identification needs that many window means [Riley & Greenhall 2004]
DIFFERENCING = {"oadev": 2, "mdev": 2, "hdev": 3}  # d of Greenhall & Riley
STEEPEST = {"oadev": -2, "mdev": -2, "hdev": -4}  # steepest noise the variance converges for
STEEPER = -0.9  # lag-1 autocorrelation below that of violet, -0.5: of samples that alternate
BLOCK = 2048  # window means worked on at a time, which stay in the cache


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
    if valid.all():
        sums, counts = running_sum(series - series.mean() if series.size else series), np.empty(0)
    else:
        mean = series[valid].mean() if valid.any() else 0.0
        sums, counts = running_sum(np.where(valid, series - mean, 0.0)), running_sum(valid)
    exponents = np.zeros(len(m), dtype=np.int64)
    last = None
    for k in np.argsort(m):
        if series.size // m[k] >= MIN_MEANS:
            exponent = _lag1_exponent(sums, counts, m[k], DIFFERENCING[estimator])
            n_means = series.size // m[k]
            if exponent is not None and (last is None or _departs(exponent, last, n_means)):
                steepest_rise = 2 if last is None else max(last, 0)
                last = min(max(round(exponent), STEEPEST[estimator]), steepest_rise)
            exponents[k] = last or 0
        else:
            exponents[k] = min(last or 0, 0)
    return exponents


def _departs(exponent: float, last: int, n_means: int) -> bool:
    errors = 0 if exponent < last and last > 0 else 2
    return abs(exponent - last) > 0.5 + errors * 2 / math.sqrt(n_means)


def _lag1_exponent(sums: Floats, counts: Floats, m: int, most: int) -> float | None:
    """-2 (delta + d), of window means differenced `most` times at most. sums, counts: running sums
    (n + 1,) of values and of how many there are, the latter empty where none is missing."""
    for differences, row in enumerate(_moments(sums, counts, m, most)):
        n_known, n_pairs, first, squares, products, both = row
        if n_known < MIN_MEANS - most or not n_pairs:
            return None
        mean = first / n_known
        power = squares - n_known * mean**2
        if not power > 1e-15 * squares:
            return None
        size = (sums.size - 1) // m - differences
        # Without gaps, the textbook ratio of sums
        lagged = products - mean * both + n_pairs * mean**2
        r1 = lagged / power * (size - 1) / n_pairs * n_known / size
        r1 = max(r1, STEEPER)
        delta = r1 / (1 + r1)
        if delta < 0.25 or differences == most:
            return float(-2 * (delta + differences))
    return None


@njit
def _moments(sums: Floats, counts: Floats, m: int, most: int) -> Floats:
    """Sums that give the lag-1 autocorrelation of window means and of their differences up to the
    order `most`, a row an order: numbers of known values and of neighbouring pairs; sums of values
    and of squares; over pairs, sums of products and of both values. Means are about that of the
    series, first differences about the slope from end to end, so that no digits are lost on a
    drift.

    One pass, block by block: a block stays in the cache while all orders use it.
    """
    n = (sums.size - 1) // m
    x, known = np.empty(BLOCK + most + 1), np.empty(BLOCK + most + 1)
    moments = np.zeros((most + 1, 6))
    slope = _slope(sums, counts, m, n)
    for start in range(0, n, BLOCK):
        size = min(BLOCK + most + 1, n - start)
        _means(sums, counts, start * m, m, x[:size], known[:size])
        for order in range(most + 1):
            if order > 0:
                _difference(x, known, size - order, slope if order == 1 else 0.0)
            length = min(BLOCK, size - order)
            paired = min(BLOCK, size - order - 1)
            if length > 0:
                _add(x, known, length, max(paired, 0), moments[order])
    return moments


@njit
def _slope(sums: Floats, counts: Floats, m: int, n: int) -> float:
    """From the first known mean to the last, per window."""
    first, last, whole = 0, n - 1, counts.size == 0
    while not whole and first < last and counts[(first + 1) * m] == counts[first * m]:
        first += 1
    while not whole and first < last and counts[(last + 1) * m] == counts[last * m]:
        last -= 1
    if first == last:
        return 0.0
    ends = np.empty(2)
    for k, window in enumerate((first, last)):
        a, b = window * m, (window + 1) * m
        ends[k] = (sums[b] - sums[a]) / (m if whole else counts[b] - counts[a])
    return (ends[1] - ends[0]) / (last - first)


@njit(fastmath=REORDER)
def _means(sums: Floats, counts: Floats, at: int, m: int, x: Floats, known: Floats) -> None:
    """Write the means of the windows from sample `at` on to `x`, and to `known` whether they are
    known; an unknown mean is 0."""
    if counts.size == 0:
        known[:] = 1.0
        for i in range(x.size):
            x[i] = (sums[at + (i + 1) * m] - sums[at + i * m]) / m
        return
    for i in range(x.size):
        a = at + i * m
        count = counts[a + m] - counts[a]
        known[i] = 1.0 if count > 0 else 0.0
        x[i] = (sums[a + m] - sums[a]) / (count + (1.0 - known[i]))


@njit(fastmath=REORDER)
def _difference(x: Floats, known: Floats, size: int, centre: float) -> None:
    """The next difference in place, less its centre; 0 where it is not known."""
    for i in range(size):
        known[i] *= known[i + 1]
        x[i] = known[i] * (x[i + 1] - x[i] - centre)


@njit(fastmath=REORDER)
def _add(x: Floats, known: Floats, size: int, paired: int, sums: Floats) -> None:
    """To `sums` (6,) the sums of `_moments` over the values that begin here."""
    count, first, squares = 0.0, 0.0, 0.0
    for i in range(size):
        count += known[i]
        first += x[i]
        squares += x[i] * x[i]
    pairs, products, both = 0.0, 0.0, 0.0
    for i in range(paired):
        pair = known[i] * known[i + 1]
        pairs += pair
        products += x[i] * x[i + 1]
        both += pair * (x[i] + x[i + 1])
    sums += np.array([count, pairs, first, squares, products, both])


def warm_up() -> None:
    """Compile all kernels."""
    noise_exponents(np.arange(2.0 * MIN_MEANS), np.array([1]))
