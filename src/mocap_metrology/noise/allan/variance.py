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

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.allan.sums import gapped, sums_without_gaps

ESTIMATORS = ("oadev", "mdev", "hdev")
ORDER = {"oadev": 2, "mdev": 3, "hdev": 3}  # windows side by side that one term spans
SCALE = {"oadev": 0.5, "mdev": 0.5, "hdev": 1 / 6}


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
    n_valid = np.count_nonzero(valid)
    if n_valid == series.size:
        total = sums_without_gaps(series - series.mean(), m, n_full, estimator)
        n_terms, excess = n_full, np.zeros(m.size)
    else:
        mean = series[valid].mean() if n_valid else 0.0
        total, n_terms, excess = gapped(
            np.where(valid, series - mean, 0.0), valid, m, n_full, estimator, min_coverage
        )
    with np.errstate(invalid="ignore", divide="ignore"):
        variance = SCALE[estimator] * (total / n_terms - excess)
        left = np.where(total > 0, 1 - excess * n_terms / total, 1.0)
    usable = (n_terms > 0) & (left > 0)
    return AllanVariance(m, np.where(usable, variance, np.nan), n_terms, n_full, left)


def warm_up() -> None:
    """Compile all kernels."""
    gapped = np.arange(20.0)
    gapped[7] = np.nan
    for estimator in ESTIMATORS:
        allan_variance(np.arange(20.0), np.array([1, 3]), estimator)
        allan_variance(gapped, np.array([1, 3]), estimator)
