"""One trajectory prepared and drawn into axes: ranges, means, outliers, gaps, limits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from mocap_metrology.present.plot.decimate import Columns, columns, runs, standouts
from mocap_metrology.present.plot.figure import INK, Keywords

if TYPE_CHECKING:
    from matplotlib.axes import Axes

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

    @property
    def thinned(self) -> bool:
        """Whether some outliers are not shown."""
        return self.n_outliers > self.outliers[0].size


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
        beyond = (s[(s < limits[0]) | (s > limits[1])] for s in samples)
        outside = np.concatenate([raw[:0], *beyond])
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


RAW, CLEAN, MEAN, OUTLIER, GAP = "#949494", "#b4d3ee", "#10307a", "#cf4a2c", "#ececec"
CLEAN_EDGE = "#5f9bd1"  # darker, that a column of its own is seen
FEW = 150  # samples up to which each is marked
DOTS: Keywords = {"ls": "", "marker": "o", "ms": 2.2, "mew": 0}
EDGES: Keywords = {"ls": "", "ms": 3.4, "mew": 0, "color": INK, "clip_on": False}


@dataclass(frozen=True)
class Trace:
    """A prepared series to draw: `per_frame` time units a frame; `scale * value + offset` is its
    place, for values within `limits` (mm); what lies beyond is marked at its edge."""

    one: Prepared
    per_frame: float
    scale: float
    limits: tuple[float, float]
    offset: float = 0.0

    def draw(self, axes: Axes, dot_pt: float = DOTS["ms"], mean_as_image: bool = False) -> None:
        """Gaps at the back, then raw, cleaned, outliers, mean, each labelled for the legend. All
        but the mean becomes one image in an SVG (neighbours in zorder do), if there is much of it.
        """
        one = self.one
        dense = {"rasterized": one.n > FEW}
        self._gaps(axes, zorder=2.0, **dense)
        if one.single:
            front = {"color": CLEAN, "lw": 0.6} if one.means else {"color": MEAN, "lw": 0.8}
            self._line(axes, one.raw, label="raw", color=RAW, lw=0.8, zorder=2.1, **dense)
            self._line(axes, one.clean, label="cleaned", zorder=2.2, **front, **dense)
        else:
            grey = {"facecolor": RAW, "edgecolor": RAW, "label": "range of raw samples"}
            self._range(axes, one.raw, zorder=2.1, **grey, **dense)
            blue = {"facecolor": CLEAN, "edgecolor": CLEAN_EDGE}
            self._range(
                axes, one.clean, zorder=2.2, label="range of cleaned samples", **blue, **dense
            )
        if one.means is not None:
            how = {"zorder": 2.25, "rasterized": True} if mean_as_image else {"zorder": 2.6}
            label = f"mean over {one.mean_s:.3g} s"
            self._line(axes, one.means, label=label, color=MEAN, lw=0.8, **how)
        at, values = one.outliers
        inside = (values >= self.limits[0]) & (values <= self.limits[1])
        time = (at[inside] + 0.5) * self.per_frame
        dots: Keywords = {**DOTS, "ms": dot_pt, "color": OUTLIER, "zorder": 2.3, **dense}
        if inside.any():
            axes.plot(time, self._place(values[inside]), label="outliers", **dots)
        self._beyond(axes, zorder=2.4, **dense)

    def _place(self, values: np.ndarray) -> np.ndarray:
        place: np.ndarray = self.scale * np.clip(values, *self.limits) + self.offset
        return place

    def _line(self, axes: Axes, columns: Columns, label: str, **how: Any) -> None:
        """Through the means of the columns; dots where a line would not show."""
        time = (columns.first + columns.stop) / 2 * self.per_frame
        known = columns.n_valid > 0
        axes.plot(time, self._place(columns.mean), label=label, **how)
        beside = np.append(known[1:], False) | np.append(False, known[:-1])
        dots = known if self.one.n <= FEW else known & ~beside
        axes.plot(time[dots], self._place(columns.mean[dots]), **{**how, **DOTS, "ms": 1.8})

    def _range(self, axes: Axes, columns: Columns, **how: Any) -> None:
        """From the least to the greatest sample of every column, the whole column wide."""
        from matplotlib.collections import PolyCollection

        polygons = []
        for start, stop in runs(columns.n_valid > 0):
            edges = np.append(columns.first[start:stop], columns.stop[stop - 1]) * self.per_frame
            time = np.repeat(edges, 2)[1:-1]
            low = np.repeat(self._place(columns.low[start:stop]), 2)
            high = np.repeat(self._place(columns.high[start:stop]), 2)
            polygon = [np.concatenate([time, time[::-1]]), np.concatenate([high, low[::-1]])]
            polygons.append(np.column_stack(polygon))
        axes.add_collection(PolyCollection(polygons, lw=0.4, **how), autolim=False)

    def _gaps(self, axes: Axes, **how: Any) -> None:
        raw = self.one.raw
        edges = [self.scale * limit + self.offset for limit in self.limits]
        gaps = [(raw.first[a], raw.stop[b - 1] - raw.first[a]) for a, b in runs(raw.n_valid == 0)]
        if gaps:
            spans = (np.array(gaps) * self.per_frame).tolist()
            colour: Keywords = {"facecolor": GAP, "edgecolor": GAP, "lw": 0.4}
            height = (min(edges), abs(edges[1] - edges[0]))
            axes.broken_barh(spans, height, label="no valid samples", **colour, **how)

    def _beyond(self, axes: Axes, **how: Any) -> None:
        """Triangles at the edges wherever a column reaches over them."""
        raw = self.one.raw
        time = (raw.first + raw.stop) / 2 * self.per_frame
        low, high = self.limits
        with np.errstate(invalid="ignore"):
            for over, limit, marker in ((raw.high > high, high, "^"), (raw.low < low, low, "v")):
                if over.any():  # else layout would make room for a sign at the origin
                    edge = np.full(np.count_nonzero(over), self.scale * limit + self.offset)
                    signs = {"marker": marker, "label": "beyond the axis", **EDGES, **how}
                    axes.plot(time[over], edge, **signs)
