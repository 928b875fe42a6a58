"""How sure an Allan variance is: equivalent degrees of freedom, and an interval from them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import NamedTuple

import numpy as np

from mocap_metrology.common.types import Floats
from mocap_metrology.noise.allan.identification import DIFFERENCING, noise_exponents
from mocap_metrology.noise.allan.variance import ORDER, allan_variance

PARTS, LEAST_PARTS, LEAST_PART = 16, 6, 8  # of a recording; windows of one
STRETCH_S = 60.0  # over which a marker's noise is one level, or is not
FEWEST, MANY = 3.0, 12  # independent values of a mean; parts that show how they are correlated
CHANCE, MOST_CELLS = 0.01, 1 << 18


@cache  # of series of one length at the same averaging factors they are the same
def equivalent_dof(
    alpha: int, m: int, n: int, estimator: str = "oadev", max_terms: int = 1024
) -> float:
    """Equivalent degrees of freedom of the overlapping estimator for n samples without gaps.

    Greenhall & Riley, "Uncertainty of stability variances based on finite differences", PTTI 2003:
    edf = M R(0)^2 / sum_(|j|<M) (1 - |j|/M) R(j)^2 for M terms with autocovariance R, which is zero
    beyond the span of a term. R is a difference of the generalised autocovariance of the running
    sum of the series. They take that of continuous noise; here it is that of sampled noise
    (`_running_sum_covariance`), which is exact at small m too, where theirs is off by up to 30 %.
    Long sums are taken at an equal ratio of length to stride with `max_terms` terms. NaN where n
    samples hold no term.
    """
    d = DIFFERENCING[estimator]
    modified = estimator == "mdev"
    n_terms = float(n - ORDER[estimator] * m + 1 + modified)
    if n_terms < 1:
        return math.nan
    power = _term_covariance(np.zeros(1), float(m), alpha, d, modified)[0]
    stride = float(m)
    whitened = alpha == 2 and not modified  # uncorrelated but at whole strides
    if min(n_terms, (d + 1) * m) > max_terms and not whitened:
        stride = float(math.floor(max_terms / min(n_terms / m, d + 1)))
        n_terms *= stride / m
    step = stride if whitened else 1.0
    lag = np.arange(0.0, min(n_terms, (d + 1) * stride) + 1, step)
    weights = np.maximum(1 - lag / n_terms, 0.0)
    weights[1:] *= 2
    covariance = _term_covariance(lag, stride, alpha, d, modified)
    if alpha <= 0 or modified:
        power = covariance[0]  # scales with the stride; for blue noise it grows as log m instead
    return float(power**2 * n_terms / np.sum(weights * covariance**2))


def _term_covariance(
    lag: np.ndarray, stride: float, alpha: int, d: int, modified: bool
) -> np.ndarray:
    """Autocovariance, but for a factor, of the terms: the d-th difference at distance `stride` of
    the running sum, for the modified variance averaged over `stride` samples first."""
    total = math.comb(2 * d, d) * _averaged(lag, stride, alpha, modified)
    for k in range(1, d + 1):
        pair = _averaged(lag - k * stride, stride, alpha, modified)
        pair = pair + _averaged(lag + k * stride, stride, alpha, modified)
        total = total + (-1) ** k * math.comb(2 * d, d - k) * pair
    return total


def _averaged(lag: np.ndarray, stride: float, alpha: int, modified: bool) -> np.ndarray:
    if not modified:
        return _running_sum_covariance(lag, alpha)
    # A mean over m samples is a difference of running sums, and a running sum lowers alpha by 2
    return (
        _running_sum_covariance(lag + stride, alpha - 2)
        - 2 * _running_sum_covariance(lag, alpha - 2)
        + _running_sum_covariance(lag - stride, alpha - 2)
    )


def _running_sum_covariance(lag: np.ndarray, alpha: int) -> np.ndarray:
    """Generalised autocovariance of the running sum of sampled noise with exponent alpha.

    Its running sum is white noise summed p = 1 - alpha / 2 times [Kasdin 1995], which has
    Gamma(j + p) / Gamma(j + 1 - p) at lag j, up to a factor, and to even polynomials of lower
    degree, which the differences of a term remove. For even
    alpha that is a polynomial in |j|: delta(j), |j|, |j|^3 - |j|, ...; for odd alpha the derivative
    by p: a polynomial times digamma functions.
    """
    from scipy.special import digamma

    j = np.abs(lag)
    if alpha == 2:
        return np.where(j == 0, 1.0, 0.0)
    p = 1 - alpha / 2
    product: np.ndarray = np.ones_like(j)
    for root in np.arange(1 - p, p):  # Gamma(j + p) / Gamma(j + 1 - p) for whole 2 p - 1
        product = product * (j + root)
    if alpha % 2:
        product = product * (digamma(j + p) + digamma(j + 1 - p))
    return product


def interval(
    variance: np.ndarray, edf: np.ndarray, confidence: float = 0.683
) -> tuple[np.ndarray, np.ndarray]:
    """Two-sided interval of a deviation: edf * estimate / truth is chi-squared with edf degrees.

    variance: (k,) estimates; returns lower and upper deviations, each (k,).
    """
    from scipy.special import chdtri

    tail = (1 - confidence) / 2
    with np.errstate(invalid="ignore", divide="ignore"):
        return (
            np.sqrt(variance * edf / chdtri(edf, tail)),
            np.sqrt(variance * edf / chdtri(edf, 1 - tail)),
        )


@dataclass(frozen=True)
class AllanCurve:
    """An Allan curve with its intervals; fields are (k,), deviations in the series' unit.
    stretches: (3, k), how it varies along its series (`levels_of_stretches`), where known."""

    m: np.ndarray
    tau_s: np.ndarray
    variance: Floats
    n_terms: np.ndarray
    alpha: np.ndarray
    edf: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    stretches: Floats | None = None

    @property
    def deviation(self) -> Floats:
        """Square root of the variance."""
        return np.sqrt(self.variance)

    def with_upper_raised(self, taken: float) -> AllanCurve:
        """The curve of a filtered series with its upper ends raised: before the filter the
        deviation was higher, at most by the share `taken` of it. The interval then holds it at
        least as often as it says."""
        return replace(self, upper=self.upper / (1 - taken))

    def as_scattered(self, series: np.ndarray, confidence: float = 0.683) -> AllanCurve:
        """The curve with the degrees of freedom that the scatter of parts of the series leaves
        (`excess_scatter`), where it is more than that of stationary Gaussian noise."""
        terms = list(octave_terms(series, self.m))
        edf = np.maximum(self.edf / excess_scatter(terms, self.m, self.edf), 1.0)
        lower, upper = interval(self.variance, edf, confidence)
        stretches = levels_of_stretches(terms, self.m, self.tau_s, series.size)
        return replace(self, edf=edf, lower=lower, upper=upper, stretches=stretches)


def mean_variance(parts: np.ndarray) -> float:
    """s^2 (1 + 2 r_1) / K of the mean of (K,) parts, r_1 >= 0 the correlation with the next."""
    off = parts - parts.mean()
    power = float(off @ off)
    if not power > 0:
        return 0.0
    r_1 = max(float(off[1:] @ off[:-1]) / power, 0.0)
    return power / (parts.size - 1) * (1 + 2 * r_1) / parts.size


def mean_of_wandering(parts: np.ndarray) -> tuple[float, float]:
    """Variance of the mean of (K,) successive parts whose level wanders, and its number of
    independent values: K (1 - r) / (1 + r), as of an autoregression of first order, r >= 0 the
    correlation with the next. With fewer than MANY r is uncertain: `mean_variance`, K values."""
    off = parts - parts.mean()
    power = float(off @ off)
    if parts.size < MANY or not power > 0:
        return mean_variance(parts), float(parts.size)
    r = max(float(off[1:] @ off[:-1]) / power, 0.0)
    independent = max(parts.size * (1 - r) / (1 + r), FEWEST)
    return power / (parts.size - 1) / independent, independent


class Terms(NamedTuple):
    """Squares (z_(i+1) - z_i)^2 at m = 2^octave, (n,), `windows` of them for each m samples."""

    octave: int
    windows: int
    squares: np.ndarray

    def means(self, count: int) -> np.ndarray:
        """(count,) means of parts of equal length."""
        size = self.squares.size // count
        return self.squares[: size * count].reshape(count, size).mean(axis=1)


def octave_terms(series: np.ndarray, m: np.ndarray) -> Iterator[Terms]:
    """Terms of the Allan variance at the octaves up to the last of m, which rises; series: (n,),
    NaN in gaps. Beyond the first they overlap by half."""
    first = max((series.size // MOST_CELLS).bit_length() - 1, 0)  # what comes and goes is in all
    cells = np.asarray(series, dtype=float)
    cells = cells[: cells.size >> first << first].reshape(-1, 1 << first).mean(axis=1)
    for octave in range(first, int(m[-1]).bit_length() if m.size else 0):
        windows = 1 if octave == first else 2
        if octave > first + 1:
            pairs = cells[: cells.size // 2 * 2].reshape(-1, 2)
            cells = np.where(np.isfinite(pairs).all(axis=1), pairs.sum(axis=1) / 2, np.nan)
        means = cells if windows == 1 else (cells[1:] + cells[:-1]) / 2
        squares = (means[windows:] - means[:-windows]) ** 2
        yield Terms(octave, windows, squares[np.isfinite(squares)])


def excess(parts: np.ndarray, edf: float) -> float:
    """Times by which the variance of the mean of (K,) parts of squares exceeds that of stationary
    Gaussian noise, 2 / edf of its square; 1 where K - 1 degrees of freedom do so in CHANCE."""
    from scipy.special import chdtri

    times, dof = mean_variance(parts) / parts.mean() ** 2 * edf / 2, parts.size - 1
    return float(times) if times > max(chdtri(dof, CHANCE) / dof, 1.0) else 1.0


def excess_scatter(terms: Iterable[Terms], m: np.ndarray, edf: np.ndarray) -> Floats:
    """(k,) times by which the variance of an Allan variance exceeds that of stationary Gaussian
    noise, 2 / edf: of a marker between two levels, or a gain that follows the light, much.

    The terms at every octave of m are averaged over K parts of the recording, K <= PARTS, each of
    LEAST_PART or more windows (`excess`). Between octaves the logarithm is interpolated; where
    parts become too short the last value stands.
    """
    at: list[float] = []
    excesses: list[float] = []
    for one in terms:
        count = min(PARTS, one.squares.size // (LEAST_PART * one.windows))
        if count < LEAST_PARTS:
            break
        parts = one.means(count)
        if not np.ptp(parts) > 0:
            break
        of_edf = np.exp(np.interp(one.octave * math.log(2), np.log(m), np.log(edf)))
        at.append(one.octave * math.log(2))
        excesses.append(math.log(excess(parts, of_edf)))
    return np.exp(np.interp(np.log(m), at, excesses)) if at else np.ones(m.size)


def levels_of_stretches(terms: Iterable[Terms], m: np.ndarray, tau_s: np.ndarray, n: int) -> Floats:
    """(3, k): mean of the logarithms of the Allan variances of stretches of a series of n samples,
    its standard uncertainty, and of how many independent values it is the mean.

    What comes a few times in a recording, a burst or a shift, decides on the Allan variance, and
    chance on how often it comes; the mean of logarithms it moves little, and raises its
    uncertainty. Stretches last LEAST_PART windows, at least STRETCH_S, or of a shorter recording
    1/PARTS: those of longer ones are no longer, so that their means are alike. Up to PARTS means of
    neighbours are the values. Interpolated between octaves in logarithms of m; NaN beyond the next
    octave after the last of LEAST_PARTS stretches.
    """
    rows: list[tuple[float, ...]] = []
    for one in terms:
        length = max(min(STRETCH_S * m[0] / tau_s[0], n / PARTS) / (1 << one.octave), LEAST_PART)
        count = one.squares.size // round(length * one.windows)
        if count < LEAST_PARTS or not (means := one.means(count)).all():
            break
        logs = np.log(means / 2)
        few = min(count, PARTS)
        values = logs[: count // few * few].reshape(few, -1).mean(axis=1)
        variance, independent = mean_of_wandering(values)
        rows.append((one.octave, float(values.mean()), math.sqrt(variance), independent))
    if not rows:
        return np.full((3, m.size), np.nan)
    octaves, *columns = np.array(rows).T
    at = np.log2(m)
    return np.where(at < octaves[-1] + 1, [np.interp(at, octaves, one) for one in columns], np.nan)


def allan_curve(
    series: np.ndarray,
    frame_rate_hz: float,
    m: np.ndarray,
    estimator: str = "oadev",
    confidence: float = 0.683,
    min_coverage: float = 0.5,
) -> AllanCurve:
    """Variances of `series` at the factors `m` where there is one, with intervals.

    The degrees of freedom are those of the noise found at each tau. Gaps lower them in proportion
    to the terms they cost, and by the square of what is left of the variance when that of the gaps
    is subtracted: the scatter stays and the mean shrinks.
    """
    allan = allan_variance(series, m, estimator, min_coverage)
    keep = np.isfinite(allan.variance)
    m, variance, n_terms = allan.m[keep], allan.variance[keep], allan.n_terms[keep]
    alpha = noise_exponents(series, m, estimator)
    pairs = zip(alpha.tolist(), m.tolist(), strict=True)
    dof = np.array([equivalent_dof(a, k, series.size, estimator) for a, k in pairs])
    edf = np.maximum(dof * n_terms / allan.n_full[keep] * allan.kept[keep] ** 2, 1.0)
    lower, upper = interval(variance, edf, confidence)
    return AllanCurve(m, m / frame_rate_hz, variance, n_terms, alpha, edf, lower, upper)
