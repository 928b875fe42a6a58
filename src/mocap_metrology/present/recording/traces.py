"""One trajectory drawn into axes: ranges, mean, outliers, gaps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from mocap_metrology.present.drawing.decimate import Columns, runs
from mocap_metrology.present.drawing.legend import Entry
from mocap_metrology.present.drawing.style import INK
from mocap_metrology.present.recording.prepared import Prepared

if TYPE_CHECKING:
    from matplotlib.axes import Axes

RAW, CLEAN, MEAN, OUTLIER, GAP = "#949494", "#b4d3ee", "#10307a", "#cf4a2c", "#ececec"
CLEAN_EDGE = "#5f9bd1"  # darker, that a column of its own is seen
FEW = 150  # samples up to which each is marked
DOTS = {"marker": "o", "ms": 2.2, "mew": 0, "color": OUTLIER}
EDGES = {"ms": 3.4, "mew": 0, "color": INK}
UP, DOWN = "^", "v"


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
        """Gaps at the back, then raw, cleaned, outliers, mean. All but the mean becomes one image
        in an SVG (neighbours in zorder do), if there is much of it."""
        one = self.one
        dense = {"rasterized": one.n > FEW}
        self._gaps(axes, zorder=2.0, **dense)
        if one.single:
            front = {"color": CLEAN, "lw": 0.6} if one.means else {"color": MEAN, "lw": 0.8}
            self._line(axes, one.raw, color=RAW, lw=0.8, zorder=2.1, **dense)
            self._line(axes, one.clean, zorder=2.2, **front, **dense)
        else:
            colours = {"facecolor": RAW, "edgecolor": RAW}
            self._range(axes, one.raw, zorder=2.1, **colours, **dense)
            colours = {"facecolor": CLEAN, "edgecolor": CLEAN_EDGE}
            self._range(axes, one.clean, zorder=2.2, **colours, **dense)
        if one.means is not None:
            how = {"zorder": 2.25, "rasterized": True} if mean_as_image else {"zorder": 2.6}
            self._line(axes, one.means, color=MEAN, lw=0.8, **how)
        at, values = one.outliers
        inside = (values >= self.limits[0]) & (values <= self.limits[1])
        time = (at[inside] + 0.5) * self.per_frame
        dots = {**DOTS, "ms": dot_pt, **dense}
        axes.plot(time, self._place(values[inside]), ls="", zorder=2.3, **dots)
        self._beyond(axes, zorder=2.4, **dense)

    def _place(self, values: np.ndarray) -> np.ndarray:
        return self.scale * np.clip(values, *self.limits) + self.offset

    def _line(self, axes: Axes, columns: Columns, **how: Any) -> None:
        """Through the means of the columns; dots where a line would not show."""
        time = (columns.first + columns.stop) / 2 * self.per_frame
        known = columns.n_valid > 0
        axes.plot(time, self._place(columns.mean), **how)
        beside = np.append(known[1:], False) | np.append(False, known[:-1])
        dots = known if self.one.n <= FEW else known & ~beside
        how |= {"ls": "", "marker": "o", "ms": 1.8, "mew": 0}
        axes.plot(time[dots], self._place(columns.mean[dots]), **how)

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
        from matplotlib.collections import PolyCollection

        raw = self.one.raw
        low, high = (self.scale * limit + self.offset for limit in self.limits)
        boxes = [
            [(a, low), (b, low), (b, high), (a, high)]
            for start, stop in runs(raw.n_valid == 0)
            for a, b in [(raw.first[start] * self.per_frame, raw.stop[stop - 1] * self.per_frame)]
        ]
        axes.add_collection(
            PolyCollection(boxes, facecolor=GAP, edgecolor=GAP, lw=0.4, **how), autolim=False
        )

    def _beyond(self, axes: Axes, **how: Any) -> None:
        """Triangles at the edges wherever a column reaches over them."""
        raw = self.one.raw
        time = (raw.first + raw.stop) / 2 * self.per_frame
        low, high = self.limits
        with np.errstate(invalid="ignore"):
            for over, limit, marker in ((raw.high > high, high, UP), (raw.low < low, low, DOWN)):
                edge = np.full(np.count_nonzero(over), self.scale * limit + self.offset)
                signs = {"ls": "", "marker": marker, "clip_on": False, **EDGES, **how}
                axes.plot(time[over], edge, **signs)


def entries(series: Sequence[Prepared], limits: Sequence[tuple[float, float]]) -> list[Entry]:
    """What the signs in these traces mean; only of those that occur. limits: of each series."""
    drawable = [one for one in series if one.n_missing < one.n]
    if not drawable:
        return []
    first = drawable[0]
    if first.single:
        front = CLEAN if first.means else MEAN
        found = [
            Entry("raw", line={"color": RAW, "lw": 1.2}),
            Entry("cleaned", line={"color": front, "lw": 1.2}),
        ]
    else:
        found = [
            Entry("range of raw samples", patch={"color": RAW, "lw": 0}),
            Entry("range of cleaned samples", patch={"color": CLEAN, "lw": 0}),
        ]
    if first.means is not None:
        found.append(Entry(f"mean over {first.mean_s:.3g} s", line={"color": MEAN, "lw": 1.2}))
    if any(one.n_outliers for one in drawable):
        thinned = any(one.n_outliers > one.outliers[0].size for one in drawable)
        text = "outliers, the largest" if thinned else "outliers"
        found.append(Entry(text, dot={**DOTS, "ms": 3.0}))
    if any(reaches_beyond(one, edge) for one, edge in zip(series, limits, strict=True)):
        found.append(Entry("beyond the axis", dot={**EDGES, "marker": UP}))
    if any((one.raw.n_valid == 0).any() for one in drawable):
        found.append(Entry("no valid samples", patch={"color": GAP, "lw": 0}))
    return found


def reaches_beyond(one: Prepared, limits: tuple[float, float]) -> bool:
    """Whether any raw sample lies outside of the limits."""
    with np.errstate(invalid="ignore"):
        return bool(np.any((one.raw.high > limits[1]) | (one.raw.low < limits[0])))
