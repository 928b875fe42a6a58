"""What a figure shows of one trajectory: ranges, means, outliers, limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mocap_metrology.present.drawing.decimate import Columns, columns, standouts

SINGLE = 4  # samples a column up to which they are drawn one by one
MEAN_S, LEAST_MEANS = 1.0, 8
CLIP_FROM = 2.0  # an axis stops short of what lies so many times the rest's range off it
CLIP_FEW = 0.1  # and occurs in less than this share of the columns
CORE = (0.01, 0.99)  # "the rest": between these quantiles of the columns' ranges
LEAST_RANGE_MM = 1e-3  # of an axis


@dataclass(frozen=True)
class Prepared:
    """One trajectory about `centre`, the mean of its clean samples; values in mm.

    raw, clean: ranges over columns, of one sample each if `single`; means: over columns of
    `mean_s`, None if the series is too short for that. outliers: sample numbers and raw values of
    those shown, (k,) each, of `n_outliers`. limits: of the axis; core: range without what stands
    out; n_beyond: samples outside of the limits, farthest: the one that is (or NaN).
    """

    name: str
    n: int
    n_missing: int
    n_outliers: int
    centre: float
    single: bool
    raw: Columns
    clean: Columns
    means: Columns | None
    mean_s: float
    outliers: tuple[np.ndarray, np.ndarray]
    limits: tuple[float, float]
    core: float
    n_beyond: int
    farthest: float


def prepare(
    name: str,
    raw: np.ndarray,
    clean: np.ndarray,
    outlier: np.ndarray,
    frame_rate_hz: float,
    n_columns: int,
    most_outliers: int = 400,
) -> Prepared:
    """Reduce one series: raw, clean (n,) mm, NaN in gaps; outlier (n,) bool; at most
    `most_outliers` of them are kept, half of these the largest of stretches of equal length."""
    n = raw.size
    single = n <= SINGLE * n_columns
    n_columns = n if single else n_columns
    ranges, cleaned = columns(raw, n_columns), columns(clean, n_columns)
    known = cleaned.n_valid > 0
    weights = cleaned.n_valid[known]
    centre = float(np.average(cleaned.mean[known], weights=weights)) if known.any() else 0.0
    n_means = min(n_columns, int(n / frame_rate_hz / MEAN_S))
    means = None
    if n_means >= LEAST_MEANS:
        means = cleaned if n_means == n_columns else columns(clean, n_means)
    limits, core = axis_limits(ranges, cleaned)
    at = np.flatnonzero(outlier & np.isfinite(raw))
    shown = at[_largest(raw[at], at, cleaned, n, most_outliers)]
    n_beyond, farthest = _beyond(raw, ranges, limits, centre)
    return Prepared(
        name=name,
        n=n,
        n_missing=n - int(ranges.n_valid.sum()),
        n_outliers=at.size,
        centre=centre,
        single=single,
        raw=ranges.about(centre),
        clean=cleaned.about(centre),
        means=means and means.about(centre),
        mean_s=n / frame_rate_hz / n_means if n_means else np.nan,
        outliers=(shown, raw[shown] - centre),
        limits=(limits[0] - centre, limits[1] - centre),
        core=core,
        n_beyond=n_beyond,
        farthest=farthest - centre,
    )


def _largest(values: np.ndarray, at: np.ndarray, clean: Columns, n: int, most: int) -> np.ndarray:
    """Indices of the values (at samples `at`) that are farthest from the mean of their column."""
    expected = clean.mean[np.searchsorted(clean.first, at, side="right") - 1]
    deviation = np.nan_to_num(np.abs(values - expected), nan=np.inf)
    return standouts(deviation, at, n, most // 2, most - most // 2)


def _beyond(
    raw: np.ndarray, ranges: Columns, limits: tuple[float, float], centre: float
) -> tuple[int, float]:
    """How many samples lie outside of the limits, and the farthest from the centre."""
    with np.errstate(invalid="ignore"):
        over = np.flatnonzero((ranges.low < limits[0]) | (ranges.high > limits[1]))
        samples = [raw[ranges.first[k] : ranges.stop[k]] for k in over]
        outside = np.concatenate([s[(s < limits[0]) | (s > limits[1])] for s in samples] or [[]])
    outside = outside[np.isfinite(outside)]
    if not outside.size:
        return 0, np.nan
    return outside.size, float(outside[np.argmax(np.abs(outside - centre))])


def axis_limits(raw: Columns, clean: Columns) -> tuple[tuple[float, float], float]:
    """Limits that show all; or, where a few samples would squeeze the rest, the rest alone. And the
    range of that rest."""
    known = clean.n_valid > 0
    if not known.any():
        return (-LEAST_RANGE_MM / 2, LEAST_RANGE_MM / 2), 0.0
    least, greatest = float(np.nanmin(raw.low)), float(np.nanmax(raw.high))
    low = float(np.quantile(clean.low[known], CORE[0]))
    high = float(np.quantile(clean.high[known], CORE[1]))
    core = high - low
    if core > 0 and low - least > CLIP_FROM * core:
        edge = low - core / 2
        least = edge if np.mean(raw.low < edge) < CLIP_FEW else least
    if core > 0 and greatest - high > CLIP_FROM * core:
        edge = high + core / 2
        greatest = edge if np.mean(raw.high > edge) < CLIP_FEW else greatest
    missing = max(LEAST_RANGE_MM - (greatest - least), 0.0)
    pad = 0.06 * (greatest - least) + missing / 2
    return (least - pad, greatest + pad), core
