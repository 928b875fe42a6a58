"""Millions of samples reduced to those that a figure can show, including the extremes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

CHUNK = 1 << 16  # samples worked on at a time: they stay in the cache


@dataclass(frozen=True)
class Columns:
    """A series cut into consecutive columns of equal length; every field is (k,).

    first, stop: samples of the column; low, high, mean: of its valid samples, NaN without one;
    n_valid: how many there are.
    """

    first: np.ndarray
    stop: np.ndarray
    low: np.ndarray
    high: np.ndarray
    mean: np.ndarray
    n_valid: np.ndarray

    def about(self, centre: float) -> Columns:
        """The same, with values about `centre`."""
        return replace(
            self, low=self.low - centre, high=self.high - centre, mean=self.mean - centre
        )


def columns(values: np.ndarray, n_columns: int) -> Columns:
    """Least, greatest and mean value of each of `n_columns` columns (or of each sample, if fewer).

    values: (n,); NaN and infinite samples are gaps. A single sample that stands out is the `low` or
    the `high` of its column, whatever n.
    """
    values = np.asarray(values, dtype=np.float64)
    n_columns = max(min(n_columns, values.size), 0)
    edges = np.arange(n_columns + 1) * values.size // max(n_columns, 1)
    first, stop = edges[:-1], edges[1:]
    parts = [np.empty((4, 0))]
    start = 0
    while start < n_columns:
        end = int(np.searchsorted(edges, edges[start] + CHUNK, side="right")) - 1
        end = max(end, start + 1)
        parts.append(_columns(values[edges[start] : edges[end]], first[start:end] - edges[start]))
        start = end
    low, high, mean, n_valid = np.concatenate(parts, axis=1)
    return Columns(first, stop, low, high, mean, n_valid.astype(np.int64))


def _columns(values: np.ndarray, first: np.ndarray) -> np.ndarray:
    """(4, k): low, high, mean, number of valid samples of the columns that begin at `first`."""
    valid = np.isfinite(values)
    whole = bool(valid.all())
    values = values if whole else np.where(valid, values, np.nan)
    n_valid = np.add.reduceat(valid, first, dtype=np.int64)
    low, high = np.fmin.reduceat(values, first), np.fmax.reduceat(values, first)
    known = n_valid > 0
    centre = float(low[known].min() + high[known].max()) / 2 if known.any() else 0.0
    about = values - centre  # sums about it retain their digits
    sums = np.add.reduceat(about if whole else np.where(valid, about, 0.0), first)
    mean = np.where(known, centre + sums / np.maximum(n_valid, 1), np.nan)
    return np.array([low, high, mean, n_valid])


def standouts(
    deviation: np.ndarray, position: np.ndarray, n: int, n_bins: int, n_top: int
) -> np.ndarray:
    """Which of many points to draw: indices of the largest in each of `n_bins` stretches of the
    series and of the `n_top` largest of all.

    deviation: (k,) size, position: (k,) ascending sample numbers below n. At most
    n_bins + n_top indices, ascending; the largest of all is always among them.
    """
    if deviation.size <= n_bins + n_top:
        return np.arange(deviation.size)
    bins = position * n_bins // max(n, 1)
    order = np.lexsort((deviation, bins))
    last = np.append(np.flatnonzero(np.diff(bins[order])), order.size - 1)
    top = np.argpartition(deviation, -n_top)[-n_top:] if n_top else np.empty(0, dtype=np.int64)
    return np.unique(np.concatenate([order[last], top]))


def runs(flags: np.ndarray) -> np.ndarray:
    """(k, 2) first and past-the-end index of every stretch of True."""
    edges = np.diff(np.concatenate([[0], flags.astype(np.int8), [0]]))
    return np.column_stack([np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)])


@dataclass(frozen=True)
class Bins:
    """Values over logarithmic bins: centre, median and greatest, each (k,); empty bins left out."""

    centre: np.ndarray
    median: np.ndarray
    high: np.ndarray


def log_bins(x: np.ndarray, y: np.ndarray, per_decade: int) -> Bins:
    """Median and maximum of `y` (n,) over bins of `x` (n,) of equal width in log x.

    x is ascending. Points with x <= 0 or y not finite are left out. Where the bins are narrower
    than the spacing of x, every point is its own bin and nothing is changed; elsewhere a narrow
    line remains in `high`. The centre is the geometric mean of the x in the bin.
    """
    keep = (x > 0) & np.isfinite(y)
    x, y = x[keep], y[keep]
    if not x.size:
        return Bins(x, y, y)
    number = np.floor(np.log10(x) * per_decade + 1e-9)
    first = np.concatenate([[0], np.flatnonzero(np.diff(number)) + 1])
    counts = np.diff(np.append(first, x.size))
    centre = 10 ** (np.add.reduceat(np.log10(x), first) / counts)
    median = np.array([np.median(y[a : a + c]) for a, c in zip(first, counts, strict=True)])
    return Bins(np.where(counts == 1, x[first], centre), median, np.maximum.reduceat(y, first))
