"""One trajectory reduced and drawn into axes: ranges, means, outliers, gaps, limits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from mocap_metrology.present.plot.decimate import columns, runs
from mocap_metrology.present.plot.figure import INK, Keywords

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SINGLE = 4  # samples a column up to which they are drawn one by one
MEAN_S, LEAST_MEANS = 1.0, 8
CLIP_FROM, CLIP_FEW = 2.0, 0.1  # an axis stops short of what lies so many times the range of the
CORE = (0.01, 0.99)  # rest (between these quantiles) off it, in less than this share of columns
LEAST_RANGE_MM = 1e-3  # of an axis
MOST_STEPS = 100_000  # differences that tell the noise of one frame
MARKED_SIGMA = 6.0  # outliers farther off than noise ever is are marked
RAW, CLEAN, MEAN, OUTLIER, GAP = "#949494", "#b4d3ee", "#10307a", "#cf4a2c", "#ececec"
CLEAN_EDGE = "#5f9bd1"  # darker, that a column of its own is seen
DOTS: Keywords = {"ls": "", "marker": "o", "ms": 2.2, "mew": 0}
FEW = 150  # samples up to which each is marked


@dataclass(frozen=True)
class Trace:
    """One trajectory about `centre`, the mean of its clean samples; values in mm.

    raw, clean: `columns` of it, of one sample each if `single`; means: columns of `mean_s`, None if
    the series is too short. outliers: sample numbers and raw values of those more than 6 standard
    deviations of one frame off, of `n_outliers`. limits: of the axis; core: range without what
    stands out; n_beyond: samples outside of the limits, farthest: the one that is (or NaN).
    """

    name: str
    n: int
    n_missing: int
    n_outliers: int
    centre: float
    single: bool
    raw: pd.DataFrame
    clean: pd.DataFrame
    means: pd.DataFrame | None
    mean_s: float
    outliers: tuple[np.ndarray, np.ndarray]
    limits: tuple[float, float]
    core: float
    n_beyond: int
    farthest: float


def trace(
    name: str,
    raw: np.ndarray,
    clean: np.ndarray,
    outlier: np.ndarray,
    frame_rate_hz: float,
    n_columns: int,
) -> Trace:
    """Reduce one series: raw, clean (n,) mm, NaN in gaps; outlier (n,) bool."""
    n, values = raw.size, ["low", "high", "mean"]
    single = n <= SINGLE * n_columns
    n_columns = n if single else n_columns
    parts = [columns(raw, n_columns), columns(clean, n_columns)]
    n_means = min(n_columns, int(n / frame_rate_hz / MEAN_S))
    if n_means >= LEAST_MEANS:
        parts.append(parts[1] if n_means == n_columns else columns(clean, n_means))
    known = parts[1].dropna()
    centre = float(np.average(known["mean"], weights=known["n_valid"])) if len(known) else 0.0
    ranges, cleaned, *means = (p.assign(**{v: p[v] - centre for v in values}) for p in parts)
    limits, core = axis_limits(ranges, cleaned)
    at = np.flatnonzero(outlier & np.isfinite(raw))
    expected = cleaned["mean"].to_numpy()[np.searchsorted(ranges["first"], at, side="right") - 1]
    off = np.nan_to_num(np.abs(raw[at] - centre - expected), nan=np.inf)
    marked = at[off > MARKED_SIGMA * _frame_sigma(clean)]
    over = ranges[(ranges["low"] < limits[0]) | (ranges["high"] > limits[1])]
    parted = [raw[a:b] - centre for a, b in zip(over["first"], over["stop"], strict=True)]
    off_axis = np.concatenate([*parted, np.zeros(0)])
    off_axis = off_axis[np.isfinite(off_axis)]
    off_axis = off_axis[(off_axis < limits[0]) | (off_axis > limits[1])]
    return Trace(
        name=name,
        n=n,
        n_missing=n - int(ranges["n_valid"].sum()),
        n_outliers=at.size,
        centre=centre,
        single=single,
        raw=ranges,
        clean=cleaned,
        means=means[0] if means else None,
        mean_s=n / frame_rate_hz / n_means if n_means else np.nan,
        outliers=(marked, raw[marked] - centre),
        limits=limits,
        core=core,
        n_beyond=off_axis.size,
        farthest=max(off_axis.tolist(), key=abs, default=np.nan),
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


def draw(
    axes: Axes,
    one: Trace,
    per_frame: float,
    scale: float,
    limits: tuple[float, float],
    offset: float = 0.0,
) -> None:
    """Gaps at the back, then raw, cleaned, outliers, mean, each labelled for the legend.

    per_frame: time units a frame; `scale * value + offset` is the place of a value within `limits`
    (mm); what lies beyond is marked at its edge. All but the mean becomes one image in an SVG
    (neighbours in zorder do), if there is much of it.
    """
    dense: Keywords = {"rasterized": one.n > FEW}
    gaps = runs((one.raw["n_valid"] == 0).to_numpy())
    for start, stop in gaps:
        ends = one.raw["first"].iloc[start], one.raw["stop"].iloc[stop - 1]
        box = (ends[0] * per_frame, (ends[1] - ends[0]) * per_frame)
        height = offset + min(scale * limits[0], scale * limits[1]), abs(scale) * np.ptp(limits)
        how: Keywords = {"facecolor": GAP, "edgecolor": GAP, "lw": 0.4, "zorder": 2.0}
        axes.broken_barh([box], height, label="no valid samples", **how, **dense)

    def place(values: pd.Series | np.ndarray) -> np.ndarray:
        return np.asarray(scale * np.clip(values, *limits) + offset)

    def line(rows: pd.DataFrame, label: str, **how: Any) -> None:
        time, known = (rows["first"] + rows["stop"]) / 2 * per_frame, rows["n_valid"] > 0
        axes.plot(time, place(rows["mean"]), label=label, **how)
        alone = known & ~known.shift(fill_value=False) & ~known.shift(-1, fill_value=False)
        dots = known if one.n <= FEW else alone  # where a line would not show
        axes.plot(time[dots], place(rows["mean"][dots]), **{**how, **DOTS, "ms": 1.8})

    def band(rows: pd.DataFrame, label: str, colour: str, edge: str, zorder: float) -> None:
        edges = np.append(rows["first"], rows["stop"].iloc[-1]) * per_frame
        how: Keywords = {"baseline": place(rows["low"]), "fill": True, "lw": 0.4, "zorder": zorder}
        axes.stairs(place(rows["high"]), edges, fc=colour, ec=edge, label=label, **how, **dense)

    if one.single:
        front: Keywords = {"color": MEAN, "lw": 0.8}
        if one.means is not None:
            front = {"color": CLEAN, "lw": 0.6}
        line(one.raw, "raw", color=RAW, lw=0.8, zorder=2.1, **dense)
        line(one.clean, "cleaned", zorder=2.2, **front, **dense)
    else:
        band(one.raw, "range of raw samples", RAW, RAW, 2.1)
        band(one.clean, "range of cleaned samples", CLEAN, CLEAN_EDGE, 2.2)
    if one.means is not None:
        line(one.means, f"mean over {one.mean_s:.3g} s", color=MEAN, lw=0.8, zorder=2.6)
    at, values = one.outliers
    inside = (values >= limits[0]) & (values <= limits[1])
    if inside.any():
        how = {**DOTS, "color": OUTLIER, "zorder": 2.3, **dense}
        how["label"] = f"outliers beyond {MARKED_SIGMA:g} σ"
        axes.plot((at[inside] + 0.5) * per_frame, place(values[inside]), **how)
    time = (one.raw["first"] + one.raw["stop"]) / 2 * per_frame
    signs: Keywords = {"ls": "", "ms": 3.4, "mew": 0, "color": INK, "clip_on": False, "zorder": 2.4}
    for over, limit, marker in (
        (one.raw["high"] > limits[1], limits[1], "^"),
        (one.raw["low"] < limits[0], limits[0], "v"),
    ):
        if over.any():  # else layout would make room for a sign at the origin
            edge = np.full(over.sum(), scale * limit + offset)
            signs |= {"marker": marker, "label": "beyond the axis"}
            axes.plot(time[over], edge, **signs, **dense)
