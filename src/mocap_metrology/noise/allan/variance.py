"""Allan, modified Allan and Hadamard variance of sampled coordinates, gaps included.

The series y is the coordinate itself, which frequency metrology would call frequency data. With
window means ybar_i(m) = (y_i + ... + y_(i+m-1)) / m and tau = m / frame rate, each estimator uses
all overlapping windows [Riley, NIST SP 1065, sections 5.2.4, 5.2.5, 5.2.10; S Eq. 4]:

    oadev:  AVAR(m) = 1/2 <(ybar_(i+m) - ybar_i)^2>
    mdev:   MVAR(m) = 1/2 <(1/m sum_(j=i)^(i+m-1) (ybar_(j+m) - ybar_j))^2>
    hdev:   HVAR(m) = 1/6 <(ybar_(i+2m) - 2 ybar_(i+m) + ybar_i)^2>

**Gaps.** A window mean is that of its valid samples, c of m, and a window counts from
`min_coverage * m` on. Were the gaps a random choice, such a mean would scatter about that of the
full window with variance (1/c - 1/m) s^2, s^2 being the sample variance within the window (simple
random sampling without replacement, whatever the noise [Cochran 1977, theorem 2.2]); that much is
subtracted, so that randomly missing samples do not bias the variance. White noise is corrected for
any pattern of gaps; a slow noise under long gaps keeps a small positive bias. For mdev, which
averages overlapping windows, this is an approximation: its terms need nine tenths of their parts.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.types import Floats, Integers

ESTIMATORS = ("oadev", "mdev", "hdev")
ORDER = {"oadev": 2, "mdev": 3, "hdev": 3}  # windows side by side that one term spans
SCALE = {"oadev": 0.5, "mdev": 0.5, "hdev": 1 / 6}
BLOCK = 8192  # samples worked on for every tau before moving on: 64 KB stay in the cache
EXCESS_SAMPLES = 1_000_000  # samples looked at for each tau: the correction is then known to 0.3 %
EXCESS_TERMS = 10_000  # and terms at least
# Reassociation lets the compiler add in vector lanes; it reorders sums and changes nothing else.
REORDER = {"reassoc", "nsz", "contract"}


@dataclass(frozen=True)
class AllanVariance:
    """Variances over averaging factors.

    m: (k,) int64; variance: (k,) unit of the series squared, NaN where no term was left or where
    what the gaps added is more than all there was; n_terms: (k,) int64 terms averaged; n_full: (k,)
    int64 terms a series without gaps has; kept: (k,) share of the variance left when what the gaps
    added is gone (1 without gaps).
    """

    m: np.ndarray
    variance: np.ndarray
    n_terms: np.ndarray
    n_full: np.ndarray
    kept: np.ndarray


def averaging_factors(
    n: int, n_taus: int = 100, min_m: int = 1, max_fraction: float = 1 / 3
) -> np.ndarray:
    """About `n_taus` distinct integers m, log-spaced from `min_m` to `max_fraction * n`.

    Integers, never times: floor(tau * rate) loses one in 50 of them to rounding. Short series
    yield every integer there is.
    """
    last = max(int(n * max_fraction), min_m)
    for count in range(n_taus, 20 * n_taus, 5):
        factors = np.unique(np.rint(np.geomspace(min_m, last, count)).astype(np.int64))
        if factors.size >= n_taus:
            break
    return factors


def allan_variance(
    series: np.ndarray, m: np.ndarray, estimator: str = "oadev", min_coverage: float = 0.5
) -> AllanVariance:
    """Variance of `series` (n,) at the averaging factors `m`; NaN and infinite samples are gaps.

    The mean is removed first, else the running sum loses digits. Without gaps this is the textbook
    estimator (agrees with allantools to 1e-13).
    """
    if estimator not in ESTIMATORS:
        raise Refusal(f"Allan variance: estimator {estimator!r}; expected {', '.join(ESTIMATORS)}")
    series = np.ascontiguousarray(series, dtype=np.float64)
    m = np.ascontiguousarray(m, dtype=np.int64)
    if m.size and m.min() < 1:
        raise Refusal(f"Allan variance: averaging factor {m.min()}; expected whole numbers >= 1")
    # An mdev term spans 3m - 1 samples, the others a whole number of windows
    n_full = np.maximum(series.size - ORDER[estimator] * m + 1 + (estimator == "mdev"), 0)
    valid = np.isfinite(series)
    centred = about_mean(series, valid)
    if valid.all():
        total = sums_without_gaps(centred, m, n_full, estimator)
        n_terms, excess = n_full, np.zeros(m.size)
    else:
        total, n_terms, excess = gapped(centred, valid, m, n_full, estimator, min_coverage)
    with np.errstate(invalid="ignore", divide="ignore"):
        variance = SCALE[estimator] * (total / n_terms - excess)
        left = np.where(total > 0, 1 - excess * n_terms / total, 1.0)
    usable = (n_terms > 0) & (left > 0)
    return AllanVariance(m, np.where(usable, variance, np.nan), n_terms, n_full, left)


def about_mean(series: np.ndarray, valid: np.ndarray) -> Floats:
    """The series (n,) less its mean; 0 where it is not valid (n,)."""
    known = series if valid.all() else series[valid]
    centred = series - (known.mean() if known.size else 0.0)
    centred[~valid] = 0.0
    return centred


def running_sum(series: np.ndarray) -> np.ndarray:
    """(n + 1,) sums of the first 0, 1, ... n samples; a window sum is a difference of two."""
    sums = np.empty(series.size + 1)
    sums[0] = 0.0
    np.cumsum(series, out=sums[1:])
    return sums


def sums_without_gaps(
    series: np.ndarray, m: np.ndarray, n_full: np.ndarray, estimator: str
) -> np.ndarray:
    """(k,) sums of the squared terms of a series (n,) of mean 0 without gaps, over the averaging
    factors m (k,), of which n_full (k,) terms there are; as `variance` scales them."""
    if estimator == "mdev":
        return _sum_modified(running_sum(series), m, n_full)
    return _sum(running_sum(series), m, n_full, estimator == "hdev")


def gapped(
    series: np.ndarray,
    valid: np.ndarray,
    m: np.ndarray,
    n_full: np.ndarray,
    estimator: str,
    min_coverage: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The same of a series with gaps, `valid` (n,) where there are samples: sums, number of terms,
    and what the gaps add to the mean of the squares (see `variance`), each (k,). The series is
    squared in place: of 90 hours a copy takes 0.3 GB."""
    sums, counts, n_terms = running_sum(series), running_sum(valid), np.zeros(m.size)
    # One sample has no scatter, so a window needs two
    least = np.maximum(np.minimum(m, 2), np.ceil(min_coverage * m)).astype(np.float64)
    modified, hadamard = estimator == "mdev", estimator == "hdev"
    if modified:
        total = _sum_modified_gapped(sums, counts, m, least, n_full, n_terms)
    else:
        total = _sum_gapped(sums, counts, m, least, n_full, hadamard, n_terms)
    weights = np.array([1.0, 4.0, 1.0] if hadamard else [1.0, 1.0, 0.0])
    squares = running_sum(np.square(series, out=series))
    excess = _gap_excess(sums, squares, counts, m, least, n_full, weights)
    # Averaging over m overlapping windows leaves this much of what a single one has
    left = (m**2.0 + 1) / (2 * m**2.0) if modified else 1.0
    return total, n_terms.astype(np.int64), left * excess


@njit(fastmath=REORDER)
def _allan_block(s: Floats, m: int, n: int) -> float:
    near, middle, far = s[:n], s[m : m + n], s[2 * m : 2 * m + n]
    total = 0.0
    for i in range(n):
        difference = far[i] - 2.0 * middle[i] + near[i]
        total += difference * difference
    return total


@njit(fastmath=REORDER)
def _hadamard_block(s: Floats, m: int, n: int) -> float:
    first, second, third, fourth = s[:n], s[m : m + n], s[2 * m : 2 * m + n], s[3 * m : 3 * m + n]
    total = 0.0
    for i in range(n):
        difference = fourth[i] - 3.0 * third[i] + 3.0 * second[i] - first[i]
        total += difference * difference
    return total


@njit
def _sum(s: Floats, m: Integers, n_full: Integers, hadamard: bool) -> Floats:
    """(k,) sums of squared differences, block by block of the series and not tau by tau: the block
    stays in the cache while all taus use it."""
    total = np.zeros(m.size)
    for start in range(0, s.size, BLOCK):
        for k in range(m.size):
            n = min(BLOCK, n_full[k] - start)
            if n > 0 and hadamard:
                total[k] += _hadamard_block(s[start:], m[k], n)
            elif n > 0:
                total[k] += _allan_block(s[start:], m[k], n)
    for k in range(m.size):
        total[k] /= float(m[k]) ** 2
    return total


@njit
def _sum_modified(s: Floats, m: Integers, n_full: Integers) -> Floats:
    """(k,) sums of squares of the inner mean, which slides: one difference enters, one leaves. (A
    second running sum would be quicker and, at nine hours of drift, lose all digits of the first
    taus.)"""
    total = np.zeros(m.size)
    for k in range(m.size):
        f, inner = m[k], 0.0
        if n_full[k] > 0:
            for i in range(f):
                inner += s[i + 2 * f] - 2.0 * s[i + f] + s[i]
            squares = inner * inner
            for i in range(n_full[k] - 1):
                near = s[i + 2 * f] - 2.0 * s[i + f] + s[i]
                inner += (s[i + 3 * f] - 2.0 * s[i + 2 * f] + s[i + f]) - near
                squares += inner * inner
            total[k] = squares / float(f) ** 4
    return total


@njit
def _gap_excess(
    sums: Floats,
    squares: Floats,
    counts: Floats,
    m: Integers,
    least: Floats,
    n_full: Integers,
    weights: Floats,
) -> Floats:
    """Mean over the terms of sum_w weights_w (1/c_w - 1/m) s_w^2: what the gaps of the windows of a
    term add to its square. Taken over evenly spread terms, not all."""
    excess = np.zeros(m.size)
    state = 1
    for k in range(m.size):
        factor = m[k]
        used = 0
        stride = max(1, n_full[k] // max(EXCESS_TERMS, EXCESS_SAMPLES // factor))
        for start in range(0, n_full[k] - stride + 1, stride):
            state = (state * 1103515245 + 12345) & 0x7FFFFFFF
            i = start + (state >> 8) % stride  # anywhere in the stride: no beat with regular gaps
            term = 0.0
            whole = True
            for w in range(weights.size):
                if weights[w] > 0.0 and whole:
                    a = i + w * factor
                    b = a + factor
                    count = counts[b] - counts[a]
                    whole = count >= least[k]
                    if whole and 1 < count < factor:
                        inside = squares[b] - squares[a] - (sums[b] - sums[a]) ** 2 / count
                        share = (factor - count) / (float(factor) * count * (count - 1.0))
                        term += weights[w] * share * max(inside, 0.0)
            if whole:
                excess[k] += term
                used += 1
        excess[k] /= max(used, 1)
    return excess


@njit(fastmath=REORDER)
def _differences(
    s: Floats, c: Floats, m: int, least: float, hadamard: bool, difference: Floats, use: Floats
) -> None:
    """Terms that begin in the first samples: differences of window means (n,), and whether they are
    known, both as 1 and 0. Branches as factors 0 and 1: so it runs in lanes."""
    n = difference.size
    s0, s1, s2 = s[:n], s[m : m + n], s[2 * m : 2 * m + n]
    c0, c1, c2 = c[:n], c[m : m + n], c[2 * m : 2 * m + n]
    for i in range(n):
        first, second = c1[i] - c0[i], c2[i] - c1[i]
        use[i] = 1.0 if (first >= least) & (second >= least) else 0.0
        value = (s2[i] - s1[i]) * first - (s1[i] - s0[i]) * second
        difference[i] = value * use[i] / (first * second + (1.0 - use[i]))
    if hadamard:
        s3, c3 = s[3 * m : 3 * m + n], c[3 * m : 3 * m + n]
        for i in range(n):
            second, third = c2[i] - c1[i], c3[i] - c2[i]
            use[i] *= 1.0 if third >= least else 0.0
            value = (s3[i] - s2[i]) * second - (s2[i] - s1[i]) * third
            difference[i] = use[i] * (value / (second * third + (1.0 - use[i])) - difference[i])


@njit(fastmath=REORDER)
def _sum_gapped(
    s: Floats,
    c: Floats,
    m: Integers,
    least: Floats,
    n_full: Integers,
    hadamard: bool,
    n_terms: Floats,
) -> Floats:
    """(k,) sums like `_sum`, over the terms that exist."""
    total, differences, uses = np.zeros(m.size), np.empty(BLOCK), np.empty(BLOCK)
    for start in range(0, s.size, BLOCK):
        for k in range(m.size):
            n = min(BLOCK, n_full[k] - start)
            if n > 0:
                difference, use = differences[:n], uses[:n]
                _differences(s[start:], c[start:], m[k], least[k], hadamard, difference, use)
                total[k] += np.dot(difference, difference)
                n_terms[k] += use.sum()
    return total


@njit
def _sum_modified_gapped(
    s: Floats, c: Floats, m: Integers, least: Floats, n_full: Integers, n_terms: Floats
) -> Floats:
    """(k,) sums like `_sum_modified`, over the differences that exist; a term needs nine tenths of
    them."""
    total, differences, uses = np.zeros(m.size), np.empty(s.size), np.empty(s.size)
    for k in range(m.size):
        f = m[k]
        n_inner = max(n_full[k] + f - 1, 0)
        difference, use = differences[:n_inner], uses[:n_inner]
        _differences(s, c, f, least[k], False, difference, use)
        inner = 0.0
        count = 0.0
        for i in range(n_inner):
            inner += difference[i]
            count += use[i]
            if i >= f:
                inner -= difference[i - f]
                count -= use[i - f]
            if i >= f - 1 and count >= 0.9 * f:
                total[k] += (inner / count) ** 2
                n_terms[k] += 1.0
    return total


def warm_up() -> None:
    """Compile all kernels."""
    gapped = np.arange(20.0)
    gapped[7] = np.nan
    for estimator in ESTIMATORS:
        allan_variance(np.arange(20.0), np.array([1, 3]), estimator)
        allan_variance(gapped, np.array([1, 3]), estimator)
