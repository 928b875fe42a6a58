"""The simple Gaussian model of two markers and their distance (S 2.2, 4.2, Table 4), kernel
densities to hold beside it, and their results for a recording: rows of gaussian.csv.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import NamedTuple

import numpy as np

from mocap_metrology.common.transforms import dct
from mocap_metrology.common.types import Floats, Row
from mocap_metrology.noise.series import AXES, block_means, pair_name

PER_BANDWIDTH = 8  # bins; the error of binning is then below 0.1 % of the peak
BEYOND = 4.0  # bandwidths past the extremes, where the estimate has vanished
MIN_PER_BIN = 5  # expected count below which the chi-squared approximation is poor
SAMPLES = 1 << 13  # of the test: more would detect the tails that the outlier filter removes
SURROGATES = 999
LOWEST = 16  # coefficients of each half, at first
SAME_LEVEL = 3.0  # standard errors that two halves of one level may differ by
BLOCK = 1 << 20  # frames worked on at a time, so that long recordings need little memory
LEAST_OF_MEDIAN = 5  # samples in a block, so that one or two wrong ones do not make its median


class Density(NamedTuple):
    """x in the series' unit and density in its inverse, (k,) each; the kernel's SD."""

    x: np.ndarray
    density: np.ndarray
    bandwidth: float


def kernel_density(series: np.ndarray) -> Density:
    """Gaussian kernel estimate of a series (n,), gaps left out [Silverman 1986].

    SD of the kernel: Silverman's 0.9 min(s, IQR/1.349) n^(-1/5) of all n valid samples. (They are
    not independent: bumps are where that recording has been.) Samples are counted in bins of an
    eighth of it, and the counts smoothed. Empty for fewer than two values.
    """
    from scipy.ndimage import gaussian_filter1d

    valid = np.asarray(series, float)[np.isfinite(series)]
    if valid.size < 2 or not np.ptp(valid) > 0:
        return Density(np.empty(0), np.empty(0), 0.0)
    low, high = np.quantile(valid, [0.25, 0.75])
    spread = float(valid.std(ddof=1))
    robust = float(high - low) / 1.349
    bandwidth = 0.9 * (min(spread, robust) if robust > 0 else spread) * valid.size**-0.2
    step = bandwidth / PER_BANDWIDTH
    start = valid.min() - BEYOND * bandwidth
    size = int(np.ceil((valid.max() + BEYOND * bandwidth - start) / step)) + 1
    counts = np.bincount(np.rint((valid - start) / step).astype(np.int64), minlength=size)
    smooth = gaussian_filter1d(counts.astype(float), PER_BANDWIDTH, truncate=6.0, mode="constant")
    return Density(start + step * np.arange(size), smooth / (valid.size * step), bandwidth)


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
    a, b, distances = (s if valid.all() else s[valid] for s in (first, second, length))
    (v_1, v_12), (_, v_2) = _covariance(a, b)
    means = a.mean(), b.mean(), distances.mean()
    columns = table_4(*means, v_1, v_12, v_2, distances.var(ddof=1))
    return GaussianModel(**{name: float(value) for name, value in columns.items()})


def table_4(
    mu_1: Floats, mu_2: Floats, mu_L: Floats, v_1: Floats, v_12: Floats, v_2: Floats, v_L: Floats
) -> dict[str, Floats]:
    """Columns of S Table 4 by name, from means, variances and the covariance (any shape)."""
    with np.errstate(invalid="ignore"):  # 0 / 0 without noise
        rho_12 = v_12 / np.sqrt(v_1 * v_2)
    return {
        **{"mu_1": mu_1, "sigma_1": np.sqrt(v_1), "mu_2": mu_2, "sigma_2": np.sqrt(v_2)},
        **{"sigma_12": v_12, "rho_12": rho_12},
        **{"mu_L": mu_L, "sigma_L": np.sqrt(np.maximum(v_L, 0.0)), "mu_e": np.abs(mu_2 - mu_1)},
        **{"sigma_A1": np.sqrt(2 * v_1), "sigma_A2": np.sqrt(2 * v_2)},
        "sigma_B": np.sqrt(v_1 + v_2),
        "sigma_C": np.sqrt(np.maximum(v_1 + v_2 - 2 * v_12, 0.0)),
    }


def _covariance(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(2, 2) with n - 1, as `numpy.cov` of (n,) values, without copies of both together."""
    off = a - a.mean(), b - b.mean()
    return np.array([[x @ y for y in off] for x in off]) / (a.size - 1)


def along_pair(
    first: Sequence[np.ndarray], second: Sequence[np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Positions (n,) of two markers, each (3, n), along the line from the first to the second.

    Along a coordinate axis, as in S, sigma_C describes the distance only if the axis happens to be
    the line; along the line it does by construction, to first order.
    """
    start, end = ([np.nanmean(np.asarray(row, float)) for row in m] for m in (first, second))
    line = np.subtract(end, start)
    line = line / np.linalg.norm(line)
    return _component_along(line, first), _component_along(line, second)


def _component_along(line: np.ndarray, marker: Sequence[np.ndarray]) -> np.ndarray:
    """(n,) component along a unit vector, a part of the frames at a time."""
    out = np.empty(len(marker[0]))
    for start in range(0, out.size, BLOCK):
        part = slice(start, start + BLOCK)
        out[part] = line @ np.array([row[part] for row in marker], dtype=np.float64)
    return out


def correlation_time(series: np.ndarray) -> float:
    """Integrated autocorrelation time of a series (n,), in valid samples: 1/2 + sum_k rho(k), which
    is half the two-sided spectrum at zero over the variance; at least 1/2. So a mean of N valid
    samples scatters like one of N / (2 tau) independent ones. Two samples do not tell: 1/2.

    The spectrum at zero is taken from the lowest squared cosine coefficients (DCT-II, missing
    samples put at the mean): the first `LOWEST`, twice as many while those added do not differ from
    those before by more than `SAME_LEVEL` standard errors, with the slope between the halves
    carried on to zero. So white noise does not hide slow noise, as it does from a sum of rho(k)
    that ends where rho is small. Of a random walk, whose spectrum has no end at zero, it is a share
    of the recording.
    """
    valid = np.isfinite(series)
    n_valid = np.count_nonzero(valid)
    if n_valid < 3:
        return 0.5
    centre = series[valid].mean()
    filled = np.where(valid, series - centre, 0.0)
    power = float(np.dot(filled, filled))
    if not power > n_valid * (np.finfo(float).eps * np.abs(series[valid]).max()) ** 2:
        return 0.5  # constant but for rounding
    square = dct(filled, norm="ortho", overwrite_x=True)[1:] ** 2
    half = min(LOWEST, square.size // 2)
    while 4 * half <= square.size:
        below, above = square[: 2 * half].mean(), square[2 * half : 4 * half].mean()
        if abs(below - above) > SAME_LEVEL * (below + above) / math.sqrt(2 * half):
            break
        half *= 2
    below, above = square[:half].mean(), square[half : 2 * half].mean()
    # Of a (1 - (f / b)^2) the halves have means a (1 - h^2 / 3b^2) and a (1 - 7 h^2 / 3b^2)
    at_zero = float(below + (below - above) / 6)
    return max(at_zero * series.size / power / 2, 0.5)


@dataclass(frozen=True)
class Sample:
    """What the chi-squared test needs of a series: mean and standard deviation of its valid values;
    every `step`-th of them, brought to that mean and deviation; as many bins as these fill; its
    number of independent values; and Pearson's statistic of Gaussian series like it."""

    mean: float
    spread: float
    values: np.ndarray
    step: int
    bins: int
    n_independent: int
    null: np.ndarray


def gaussian_sample(series: np.ndarray, n_bins: int) -> Sample:
    """At most `SAMPLES` values of `series` (n,), and what Pearson's statistic would be, were it
    Gaussian: of `SURROGATES` series whose cosine coefficients are its own with random signs.

    The coefficients of a stationary Gaussian series, and of a random walk, are normal, of mean 0
    and independent: given their sizes, their signs are tosses of a coin. So the test is right on
    all time scales at once, however slow the noise. Each surrogate is held against its own mean and
    deviation. No null, and no bins, where fewer than four bins expect five values each.
    """
    from scipy.fft import idct

    valid = series[np.isfinite(series)]
    step = max(math.ceil(valid.size / SAMPLES), 1)
    bins = min(n_bins, -(-valid.size // step) // MIN_PER_BIN)
    independent = round(valid.size / (2 * correlation_time(series))) if valid.size else 0
    mean, spread = (float(valid.mean()), float(valid.std())) if valid.size else (math.nan, 0.0)
    centred = valid[::step] - np.mean(valid[::step] if valid.size else 0.0)
    if bins < 4 or not (spread > 0 and centred.std() > 0):  # equal values have a mean beside them
        return Sample(mean, spread, centred, step, 0, independent, np.empty(0))
    centred *= spread / centred.std()
    coefficients = dct(centred, norm="ortho")
    rng = np.random.default_rng(0)
    null = np.empty(SURROGATES)
    for k in range(SURROGATES):
        signs = 2.0 * rng.integers(0, 2, coefficients.size, dtype=np.int8) - 1
        null[k] = _pearson(idct(signs * coefficients, norm="ortho"), 0.0, spread, bins)
    return Sample(mean, spread, mean + centred, step, bins, max(independent, 1), null)


def chi_squared_normal(
    series: np.ndarray, mu: float, sigma: float, n_bins: int = 30, sample: Sample | None = None
) -> ChiSquared:
    """Pearson's chi-squared test of `series` (n,) against N(mu, sigma) of the same frames (S 4.2),
    right for noise that is not white (`gaussian_sample`, by default made here of the series).

    Bins are equally probable. statistic: times dof over its mean among Gaussian series like it
    [Rao & Scott 1981], and so comparable with dof = bins - 3 (mu and sigma are taken for estimates
    from the same frames). p_value: share of Gaussian series with as large a statistic, no smaller
    than 1 / (`SURROGATES` + 1). Where few coefficients hold all variance, hardly anything is
    rejected: see `n_independent`. NaN where `gaussian_sample` has no bins.
    """
    sample = gaussian_sample(series, n_bins) if sample is None else sample
    if not (sample.null.size and sigma > 0):
        return ChiSquared(math.nan, 0, math.nan, sample.step, sample.n_independent)
    observed = _pearson(sample.values, mu, sigma, sample.bins)
    dof = sample.bins - 3
    p = (1 + np.count_nonzero(sample.null >= observed)) / (sample.null.size + 1)
    scaled = observed * dof / float(sample.null.mean())
    return ChiSquared(scaled, dof, p, sample.step, sample.n_independent)


def _pearson(sample: np.ndarray, mu: float, sigma: float, bins: int) -> float:
    """Pearson's statistic of sample (n,) in bins equally probable under N(mu, sigma)."""
    from scipy.special import ndtri

    edges = mu + sigma * ndtri(np.arange(1, bins) / bins)
    below = np.searchsorted(np.sort(sample), edges)
    counts = np.diff(below, prepend=0, append=sample.size)
    expected = sample.size / bins
    return float(np.sum((counts - expected) ** 2) / expected)


def _block_length(n: int, frame_rate_hz: float, least: int) -> int:
    """Frames of a second, or a tenth of a shorter series of n, but `least` frames where it has
    twice as many."""
    block = max(min(round(frame_rate_hz), n // 10), 1)
    return max(block, min(least, n // 2))


def _drift(values: np.ndarray, known: np.ndarray, frames: int, frame_rate_hz: float) -> Drift:
    """Drift of one value a block; `known`: the numbers of the blocks that have one."""
    block_s = frames / frame_rate_hz
    if known.size < 2:
        return Drift(math.nan, math.nan, block_s)
    hours = known * frames / frame_rate_hz / 3600
    hours = hours - hours.mean()
    slope = float(np.sum(hours * (values - values.mean())) / np.sum(hours**2))
    return Drift(slope, float(np.ptp(values)), block_s)


def drift(series: np.ndarray, frame_rate_hz: float) -> Drift:
    """Drift velocity (unit per hour) and drift range of a series (n,) [Jensenius et al., in S 2.1].

    Both of one-second means (means of a tenth of a series shorter than ten seconds), so that the
    range tells how far the marker seemed to wander and not how noisy a single frame is. Blocks
    without a valid sample are left out.
    """
    length = _block_length(series.size, frame_rate_hz, 1)
    means = block_means(series, length, 0.0)
    known = np.flatnonzero(np.isfinite(means))
    return _drift(means[known], known, length, frame_rate_hz)


def median_drift(series: np.ndarray, frame_rate_hz: float) -> Drift:
    """Drift of block medians, for raw data, where one wrong sample of 1e9 mm would move a mean by
    kilometres. Blocks have `LEAST_OF_MEDIAN` frames or more where the series (n,) has twice as
    many; those with less than half as many valid samples as is usual are left out."""
    length = _block_length(series.size, frame_rate_hz, LEAST_OF_MEDIAN)
    blocks = series[: series.size // length * length].reshape(-1, length)
    valid = np.isfinite(blocks)
    counts = valid.sum(axis=1)
    seen = counts[counts > 0]
    known = np.flatnonzero(counts >= max(np.median(seen) / 2, 1)) if seen.size else seen
    rising = np.sort(np.where(valid, blocks, np.nan)[known], axis=1)  # NaN come last
    counts, row = counts[known], np.arange(known.size)
    medians = (rising[row, (counts - 1) // 2] + rising[row, counts // 2]) / 2
    return _drift(medians, known, length, frame_rate_hz)


LONG_S = 60.0  # length from which a drift per hour is reported


def gaussian_rows(
    series: Mapping[str, np.ndarray],
    labels: Sequence[str],
    pairs: Sequence[tuple[int, int]],
    frame_rate_hz: float,
    n_bins: int,
) -> list[Row]:
    """Rows of gaussian.csv from named series in mm: two a pair, along x and along the line.

    Columns are those of S Table 4; then the chi-squared test of L against N(mu_e, sigma_C) (S 4.2)
    and drift and drift range of either marker along the axis and of L. Without a pair, one row for
    each marker with what it alone can tell.
    """
    rows, unknown = [], Drift(math.nan, math.nan, math.nan)
    for number in range(1, len(labels) + 1) if not pairs else ():
        x = np.asarray(series[f"x{number}"], float)
        model = GaussianModel(float(np.nanmean(x)), float(np.nanstd(x, ddof=1)), *[math.nan] * 11)
        test, moves = ChiSquared(math.nan, 0, math.nan, 0, 0), [drift(x, frame_rate_hz), unknown]
        rows.append(_row(("", labels[number - 1], "", "x"), model, test, [*moves, unknown]))
    for pair in pairs:
        length = np.asarray(series[pair_name(pair, pairs)], float)
        sample = gaussian_sample(length, n_bins)
        ends = [[np.asarray(series[f"{axis}{k}"], float) for axis in AXES] for k in pair]
        for axis in ("x", "pair"):
            first, second = (ends[0][0], ends[1][0]) if axis == "x" else along_pair(*ends)
            model = gaussian_model(first, second, length)
            test = chi_squared_normal(length, model.mu_e, model.sigma_C, n_bins, sample)
            names = pair_name(pair, pairs), labels[pair[0] - 1], labels[pair[1] - 1], axis
            moves = [drift(one, frame_rate_hz) for one in (first, second, length)]
            rows.append(_row(names, model, test, moves))
    return rows


def _row(
    names: tuple[str, str, str, str], model: GaussianModel, test: ChiSquared, moves: Sequence[Drift]
) -> Row:
    units = {"rho_12": "rho_12", "sigma_12": "sigma_12_mm2"}
    ends = ("_1", "_2", "")
    return {
        **dict(zip(("pair", "marker_1", "marker_2", "axis"), names, strict=True)),
        **{units.get(key, f"{key}_mm"): value for key, value in asdict(model).items()},
        "chi2": test.statistic,
        "chi2_dof": test.dof,
        "chi2_p": test.p_value,
        "thinning_frames": test.step,
        "n_independent": test.n_independent,
        **{f"drift{end}_mm_per_h": move.per_hour for end, move in zip(ends, moves, strict=True)},
        **{f"range{end}_mm": move.range for end, move in zip(ends, moves, strict=True)},
    }
