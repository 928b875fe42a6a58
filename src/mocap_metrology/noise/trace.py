"""One trajectory reduced to what a figure has room for: ranges, means, outliers, limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

MEAN_S, LEAST_MEANS = 1.0, 8
CLIP_FROM, CLIP_FEW = 2.0, 0.1  # an axis stops short of what lies so many times the range of the
CORE = (0.01, 0.99)  # rest (between these quantiles) off it, in less than this share of columns
LEAST_RANGE_MM = 1e-3  # of an axis
MOST_STEPS = 100_000  # differences from which the noise of one frame is estimated
MARKED_SIGMA = 6.0  # outliers farther off than noise ever is are marked


@dataclass(frozen=True)
class Trace:
    """One trajectory of `n` samples about `centre`, the mean of its clean samples; values in mm.

    raw, clean: `columns` of it; means: of `mean_s`, empty if the series is short. marked:
    numbers and raw values of those of its `n_outliers` that are more than 6 standard deviations of
    one frame off. limits: of the axis; core: range without what stands out; beyond: raw values
    outside of the limits.
    """

    name: str
    n: int
    n_missing: int
    n_outliers: int
    centre: float
    raw: pd.DataFrame
    clean: pd.DataFrame
    means: pd.DataFrame
    mean_s: float
    marked: pd.Series
    limits: tuple[float, float]
    core: float
    beyond: np.ndarray


def columns(values: np.ndarray, n_columns: int) -> pd.DataFrame:
    """A series (n,) cut into `n_columns` consecutive columns of equal length (or of one sample, if
    there are fewer), a row each.

    `first`, `stop`: samples of the column; `low`, `high`, `mean`: of its valid samples, NaN without
    one; `n_valid`: how many there are. NaN and infinite samples are gaps.
    """
    names = ("first", "stop", "low", "high", "mean", "n_valid")
    n_columns = min(n_columns, values.size)
    if not n_columns:
        return pd.DataFrame(columns=names, dtype=float)
    edges = np.arange(n_columns + 1) * values.size // n_columns
    valid = np.isfinite(values)
    centre = values[np.argmax(valid)] if valid.any() else 0.0  # sums about it keep their digits
    of = (edges[:-1], edges[1:], *_columns(values, edges[:-1], centre))
    return pd.DataFrame(dict(zip(names, of, strict=True))).astype({"n_valid": np.int64})


def _columns(values: np.ndarray, first: np.ndarray, centre: float) -> np.ndarray:
    """(4, k): low, high, mean and number of valid samples of the columns that begin at `first`."""
    valid = np.isfinite(values)
    about = values - centre
    if not valid.all():
        values = np.where(valid, values, np.nan)
        about = np.where(valid, about, 0.0)
    n_valid = np.add.reduceat(valid, first, dtype=np.int64)
    mean = centre + np.add.reduceat(about, first) / np.where(n_valid > 0, n_valid, np.nan)
    low, high = np.fmin.reduceat(values, first), np.fmax.reduceat(values, first)
    return np.array([low, high, mean, n_valid])


def trace_of(
    name: str,
    raw: np.ndarray,
    clean: np.ndarray,
    outlier: np.ndarray,
    frame_rate_hz: float,
    n_columns: int,
) -> Trace:
    """Reduce one series: raw, clean (n,) mm, NaN in gaps; outlier (n,) bool."""
    raw, clean = np.asarray(raw, np.float64), np.asarray(clean, np.float64)
    n_means = min(n_columns, int(raw.size / frame_rate_hz / MEAN_S))
    ranges, cleaned = columns(raw, n_columns), columns(clean, n_columns)
    of_means = n_means if n_means >= LEAST_MEANS else 0
    means = cleaned.copy() if n_means == len(cleaned) else columns(clean, of_means)
    known = cleaned.dropna()
    centre = float(np.average(known["mean"], weights=known["n_valid"])) if len(known) else 0.0
    for part in (ranges, cleaned, means):
        part[["low", "high", "mean"]] -= centre
    limits, core = axis_limits(ranges, cleaned)
    at = np.flatnonzero(outlier)
    at = at[np.isfinite(raw[at])]
    expected = cleaned["mean"].to_numpy()[np.searchsorted(ranges["first"], at, side="right") - 1]
    off = np.nan_to_num(np.abs(raw[at] - centre - expected), nan=np.inf)
    far = at[off > MARKED_SIGMA * _frame_sigma(clean)]
    wide = np.flatnonzero((ranges["low"] < limits[0]) | (ranges["high"] > limits[1]))
    around = [raw[ranges["first"][k] : ranges["stop"][k]] - centre for k in wide]
    about = np.concatenate([np.empty(0), *around])
    return Trace(
        name=name,
        n=raw.size,
        n_missing=raw.size - int(ranges["n_valid"].sum()),
        n_outliers=at.size,
        centre=centre,
        raw=ranges,
        clean=cleaned,
        means=means,
        mean_s=raw.size / frame_rate_hz / max(n_means, 1),
        marked=pd.Series(raw[far] - centre, far),
        limits=limits,
        core=core,
        beyond=about[np.isfinite(about) & ((about < limits[0]) | (about > limits[1]))],
    )


def _frame_sigma(clean: np.ndarray) -> float:
    """Standard deviation of one frame, from differences of successive ones; 0 without any."""
    at = np.arange(0, max(clean.size - 1, 0), max(clean.size // MOST_STEPS, 1))
    steps = clean[at + 1] - clean[at]
    steps = steps[np.isfinite(steps)]
    return float(np.sqrt(np.mean(steps**2) / 2)) if steps.size else 0.0


def axis_limits(raw: pd.DataFrame, clean: pd.DataFrame) -> tuple[tuple[float, float], float]:
    """Limits that show all; or, where a few samples would squeeze the rest, the rest alone. And the
    range of that rest."""
    if not clean["n_valid"].any():
        return (-LEAST_RANGE_MM / 2, LEAST_RANGE_MM / 2), 0.0
    least, greatest = float(raw["low"].min()), float(raw["high"].max())
    low, high = float(clean["low"].quantile(CORE[0])), float(clean["high"].quantile(CORE[1]))
    core = high - low
    if low - least > CLIP_FROM * core > 0 and (raw["low"] < low - core / 2).mean() < CLIP_FEW:
        least = low - core / 2
    if greatest - high > CLIP_FROM * core > 0 and (raw["high"] > high + core / 2).mean() < CLIP_FEW:
        greatest = high + core / 2
    pad = 0.06 * (greatest - least) + max(LEAST_RANGE_MM - (greatest - least), 0.0) / 2
    return (least - pad, greatest + pad), core
