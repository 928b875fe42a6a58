"""Compiled: sums of squared differences of window means, of which `variance` makes variances."""

from __future__ import annotations

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.common.types import Floats, Integers

BLOCK = 8192  # samples worked on for every tau before moving on: 64 KB stay in the cache
EXCESS_SAMPLES = 1_000_000  # samples looked at for each tau: the correction is then known to 0.3 %
EXCESS_TERMS = 10_000  # and terms at least
# Reassociation lets the compiler add in vector lanes; it reorders sums and changes nothing else.
REORDER = {"reassoc", "nsz", "contract"}
Three = tuple[Floats, Floats, Floats]
Four = tuple[Floats, Floats, Floats, Floats]


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
    sums, total = running_sum(series), np.zeros(m.size)
    if estimator == "mdev":
        _sum_modified(sums, m, n_full, total)
    else:
        _sum(sums, m, n_full, estimator == "hdev", total)
    return total


def gapped(
    series: np.ndarray,
    valid: np.ndarray,
    m: np.ndarray,
    n_full: np.ndarray,
    estimator: str,
    min_coverage: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The same of a series with gaps, `valid` (n,) where there are samples: sums, number of terms,
    and what the gaps add to the mean of the squares (see `variance`), each (k,)."""
    sums, squares = running_sum(series), running_sum(series * series)
    counts = running_sum(valid)
    # One sample has no scatter, so a window needs two
    least = np.maximum(np.minimum(m, 2), np.ceil(min_coverage * m)).astype(np.float64)
    total, n_terms = np.zeros(m.size), np.zeros(m.size)
    modified, hadamard = estimator == "mdev", estimator == "hdev"
    if modified:
        _sum_modified_gapped(sums, counts, m, least, n_full, total, n_terms)
    else:
        _sum_gapped(sums, counts, m, least, n_full, hadamard, total, n_terms)
    weights = np.array([1.0, 4.0, 1.0] if hadamard else [1.0, 1.0, 0.0])
    excess = _gap_excess(sums, squares, counts, m, least, n_full, weights)
    # Averaging over m overlapping windows leaves this much of what a single one has
    left = (m**2.0 + 1) / (2 * m**2.0) if modified else 1.0
    return total, n_terms.astype(np.int64), left * excess


@njit
def _three(x: np.ndarray, start: int, stop: int, m: int) -> Three:
    """Parts of a running sum that begin m apart."""
    return x[start:stop], x[start + m : stop + m], x[start + 2 * m : stop + 2 * m]


@njit
def _four(x: np.ndarray, start: int, stop: int, m: int) -> Four:
    a, b, c = _three(x, start, stop, m)
    return a, b, c, x[start + 3 * m : stop + 3 * m]


@njit(fastmath=REORDER)
def _allan_block(sums: Three) -> float:
    near, middle, far = sums
    total = 0.0
    for i in range(near.size):
        difference = far[i] - 2.0 * middle[i] + near[i]
        total += difference * difference
    return total


@njit(fastmath=REORDER)
def _hadamard_block(sums: Four) -> float:
    first, second, third, fourth = sums
    total = 0.0
    for i in range(first.size):
        difference = fourth[i] - 3.0 * third[i] + 3.0 * second[i] - first[i]
        total += difference * difference
    return total


@njit
def _sum(s: Floats, m: Integers, n_full: Integers, hadamard: bool, total: Floats) -> None:
    """Sum of squared differences, block by block of the series and not tau by tau: the block stays
    in the cache while all taus use it."""
    for start in range(0, s.size, BLOCK):
        for k in range(m.size):
            stop = min(start + BLOCK, n_full[k])
            if stop > start and hadamard:
                total[k] += _hadamard_block(_four(s, start, stop, m[k]))
            elif stop > start:
                total[k] += _allan_block(_three(s, start, stop, m[k]))
    for k in range(m.size):
        total[k] /= float(m[k]) ** 2


@njit
def _sum_modified(s: Floats, m: Integers, n_full: Integers, total: Floats) -> None:
    """The inner mean slides: one difference enters, one leaves. (A second running sum would be
    quicker and, at nine hours of drift, lose all digits of the first taus.)"""
    for k in range(m.size):
        f = m[k]
        inner = 0.0
        for i in range(min(f, s.size - 2 * f)):
            inner += s[i + 2 * f] - 2.0 * s[i + f] + s[i]
        squares = inner * inner
        for i in range(n_full[k] - 1):
            inner += (s[i + 3 * f] - 2.0 * s[i + 2 * f] + s[i + f]) - (
                s[i + 2 * f] - 2.0 * s[i + f] + s[i]
            )
            squares += inner * inner
        total[k] = squares / float(f) ** 4


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
def _allan_block_gapped(sums: Three, counts: Three, least: float) -> tuple[float, float]:
    """Sum of squares and number of terms. Branches as factors 0 and 1: so it runs in lanes."""
    s0, s1, s2 = sums
    c0, c1, c2 = counts
    total = 0.0
    n_terms = 0.0
    for i in range(s0.size):
        first, second = c1[i] - c0[i], c2[i] - c1[i]
        use = 1.0 if (first >= least) & (second >= least) else 0.0
        difference = (s2[i] - s1[i]) * first - (s1[i] - s0[i]) * second
        difference *= use / (first * second + (1.0 - use))
        total += difference * difference
        n_terms += use
    return total, n_terms


@njit(fastmath=REORDER)
def _hadamard_block_gapped(sums: Four, counts: Four, least: float) -> tuple[float, float]:
    s0, s1, s2, s3 = sums
    c0, c1, c2, c3 = counts
    total = 0.0
    n_terms = 0.0
    for i in range(s0.size):
        first, second, third = c1[i] - c0[i], c2[i] - c1[i], c3[i] - c2[i]
        use = 1.0 if (first >= least) & (second >= least) & (third >= least) else 0.0
        difference = (s3[i] - s2[i]) * first * second + (s1[i] - s0[i]) * second * third
        difference -= 2.0 * (s2[i] - s1[i]) * first * third
        difference *= use / (first * second * third + (1.0 - use))
        total += difference * difference
        n_terms += use
    return total, n_terms


@njit
def _sum_gapped(
    s: Floats,
    c: Floats,
    m: Integers,
    least: Floats,
    n_full: Integers,
    hadamard: bool,
    total: Floats,
    n_terms: Floats,
) -> None:
    for start in range(0, s.size, BLOCK):
        for k in range(m.size):
            stop = min(start + BLOCK, n_full[k])
            if stop <= start:
                continue
            if hadamard:
                sums, counts = _four(s, start, stop, m[k]), _four(c, start, stop, m[k])
                part, terms = _hadamard_block_gapped(sums, counts, least[k])
            else:
                near, known = _three(s, start, stop, m[k]), _three(c, start, stop, m[k])
                part, terms = _allan_block_gapped(near, known, least[k])
            total[k] += part
            n_terms[k] += terms


@njit(fastmath=REORDER)
def _differences_gapped(
    s: Floats, c: Floats, factor: int, least: float, difference: Floats, use: Floats
) -> None:
    for i in range(difference.size):
        first, second = c[i + factor] - c[i], c[i + 2 * factor] - c[i + factor]
        use[i] = 1.0 if (first >= least) & (second >= least) else 0.0
        value = (s[i + 2 * factor] - s[i + factor]) * first - (s[i + factor] - s[i]) * second
        difference[i] = value * use[i] / (first * second + (1.0 - use[i]))


@njit
def _sum_modified_gapped(
    s: Floats,
    c: Floats,
    m: Integers,
    least: Floats,
    n_full: Integers,
    total: Floats,
    n_terms: Floats,
) -> None:
    """Sum like `_sum_modified`, over the differences that exist; a term needs nine tenths of
    them."""
    differences, uses = np.empty(s.size), np.empty(s.size)
    for k in range(m.size):
        f = m[k]
        n_inner = max(n_full[k] + f - 1, 0)
        difference, use = differences[:n_inner], uses[:n_inner]
        _differences_gapped(s, c, f, least[k], difference, use)
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
