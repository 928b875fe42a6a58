"""Allan deviations of several recordings: a panel a series, a curve a recording; by number of
cameras also their ratio to the first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import cycle

import numpy as np
import pandas as pd

from mocap_metrology.common.types import Record
from mocap_metrology.present.plot import curves as plot
from mocap_metrology.present.plot import figure as fig
from mocap_metrology.present.plot.figure import LOOKS, OTHER_LOOKS, Look, Picture
from mocap_metrology.present.text import captions

COLUMNS = 3
ROW_MM = 66.0  # a panel with its ratios
WITHIN, PAD = (0.005, 0.995), 0.06  # quantiles of the ratios that their axis holds, and beyond them
MOST_BANDS = 3  # curves in a panel up to which their intervals are drawn
LEAST_RANGE = 0.1
Allan = Mapping[str, Mapping[str, np.ndarray]]  # columns of allan_masked.parquet by recording
Panels = Mapping[str, pd.DataFrame]
Rows = Mapping[str, Record]
CAMERAS, RECORDING = "Number of cameras", "Recording"
NAMED_LOOKS = (*LOOKS.values(), *OTHER_LOOKS)  # so many recordings can be distinguished by name
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "h", "<", ">", "p", "8")
MAP, LIGHTEST, DARKEST = "inferno", 0.55, 0.0  # colours whose lightness falls evenly
MOST_MARKERS, MOST_DISTANCES = 3, 3  # with panels of their own


def series_curves(
    allan: Allan, series: str, labels: Mapping[str, str], band: bool = True
) -> pd.DataFrame:
    """Curves of one series of several recordings by the overlapping Allan deviation; labels: name
    of the curve by recording."""
    curves = [
        plot.adev_curves(allan[name], {series: label}, band) for name, label in labels.items()
    ]
    frame = pd.concat(curves, ignore_index=True)
    return frame[frame["thin"] == ""]


def ratio_picture(panels: Panels, looks: plot.Looks, texts: fig.Texts) -> Picture:
    """A panel a series, and under it the curves of that panel divided by its first curve, where
    both have the averaging time. Call it within `styled`."""
    rows, limits = -(-len(panels) // COLUMNS), plot.curve_limits(pd.concat(panels.values()))
    body = fig.new_figure(texts, 24.0 + rows * ROW_MM)
    grid = body.subplots(2 * rows, COLUMNS, sharex=True, squeeze=False, height_ratios=(5, 3) * rows)
    above, below = grid[::2].ravel(), grid[1::2].ravel()
    found = [ratios(curves) for curves in panels.values()]
    ends = pd.concat(found)["ratio"].quantile(list(WITHIN)).fillna(1.0)
    low, high = min(*ends, 1.0), max(*ends, 1.0)
    room = max(high - low, LEAST_RANGE) * PAD
    for k, (title, curves) in enumerate(panels.items()):
        fig.log_axes(above[k], limits)
        plot.draw_curves(above[k], curves, limits[1], looks)
        fig.panel_title(above[k], fig.short(title))
        below[k].set_ylim(max(low - room, 0.0), high + room)
        below[k].locator_params(axis="y", nbins=5)
        for order, (name, own) in enumerate(plot.groups_of(found[k], "curve")):
            every = plot.markers_every(len(own), order)
            below[k].plot(own["x"], own["ratio"], **looks[name].line(markevery=every))
        for axes in (above[k], below[k]):
            axes.tick_params(labelleft=k % COLUMNS == 0, which="both")
        if k % COLUMNS == 0:
            above[k].set_ylabel(plot.ADEV_AXES[1])
            below[k].set_ylabel(f"Ratio to\n{fig.short(curves['curve'].iloc[0])}")
        if k + COLUMNS >= len(panels):
            below[k].set_xlabel(plot.ADEV_AXES[0])
            below[k].tick_params(labelbottom=True)
    for axes in (*above[len(panels) :], *below[len(panels) :]):
        axes.axis("off")
    if len(panels) < above.size:
        fig.log_axes(above[len(panels)], limits)
        plot.slope_fan(above[len(panels)], limits)
    return fig.finished(body, above[: len(panels)], texts.caption)


def ratios(curves: pd.DataFrame) -> pd.DataFrame:
    """`curve`, `x` and `ratio` to the first curve, where both have that x and are positive."""
    first = curves[curves["curve"] == curves["curve"].iloc[0]].set_index("x")["y"]
    ratio = curves["y"] / curves["x"].map(first)
    both = curves.assign(ratio=ratio.where(np.isfinite(ratio) & (ratio > 0)))
    return both.loc[both["x"].isin(first.index), ["curve", "x", "ratio"]]


@fig.styled()
def family_figure(
    family: Family,
    allan: Allan,
    expected: Mapping[str, Sequence[str]],
    texts: fig.Texts,
    confidence: float | None = None,
) -> Picture:
    """Allan deviations of a family of recordings, as S Figures 8, 12 and 13.

    expected: series that should be there, by recording; a panel shows those that should have its
    series. Subsets of cameras are drawn with their ratio to the smallest one; up to three other
    recordings with their intervals, of that `confidence` (0 to 1).
    """
    shown, others = shown_series([name for names in expected.values() for name in names])
    subsets = family.by == CAMERAS and bool(family.looks)
    band = len(family.labels) <= MOST_BANDS and not subsets
    labels = {name: family.full_label(label) for name, label in family.labels.items()}
    looks = {family.full_label(label): look for label, look in family.looks.items()}
    panels = {}
    for series in shown:
        own = {name: label for name, label in labels.items() if series in expected[name]}
        panels[series] = series_curves(allan, series, own, band)
    words = f"{left_out(others)} {texts.caption}"
    if subsets:
        caption = f"{captions.ADEV} {captions.ADEV_RATIOS} {words}"
        return ratio_picture(panels, looks, texts._replace(caption=caption))
    names = [
        f"{series}: {' and '.join(plot.family_ends(curves))}"
        for series, curves in ({} if looks else panels).items()
        if curves["curve"].nunique() > plot.MOST_SINGLE and (curves["y"] > 0).any()
    ]
    note = captions.ADEV_ENDS.format(names="; ".join(names)) if names else ""
    texts = texts._replace(caption=f"{captions.ADEV} {note} {words}")
    return plot.curves_picture(panels, texts, confidence, looks=looks or None)


def compared(
    allan: Allan, series: Sequence[str], labels: Mapping[str, str], band: bool = True
) -> Panels:
    """A panel a series with the curves of named recordings; labels: by recording."""
    return {one: series_curves(allan, one, labels, band) for one in series}


@dataclass(frozen=True)
class Family:
    """Recordings that are shown together, in the order of the key.

    by: `CAMERAS` or `RECORDING`. labels: of each recording; looks: by label, none where
    there are too many to distinguish.
    """

    by: str
    labels: Mapping[str, str]
    looks: Mapping[str, Look]

    def full_label(self, label: str) -> str:
        """A label that is understood by itself."""
        return f"{label} cameras" if self.by == CAMERAS else label


def family_of(rows: Rows) -> Family:
    """Recordings by their number of cameras where they are subsets of one camera type, no two with
    as many; else by name. rows: of the sheet, by recording."""
    counts = {name: row["n_cameras"] for name, row in rows.items()}
    numbers, types = set(counts.values()), {row["camera_type"] for row in rows.values()}
    if None not in numbers and len(numbers) == len(rows) > 1 and len(types) == 1:
        labels = {name: str(counts[name]) for name in sorted(rows, key=lambda n: counts[n])}
        looks = {str(n): look for n, look in count_looks(list(numbers)).items()}
        return Family(CAMERAS, labels, looks if len(looks) <= len(MARKERS) else {})
    few = len(rows) <= len(NAMED_LOOKS)
    looks = dict(zip(rows, NAMED_LOOKS, strict=False)) if few else {}
    return Family(RECORDING, {name: name for name in rows}, looks)


def count_looks(counts: Sequence[int]) -> dict[int, Look]:
    """Looks of numbers of cameras: the more, the darker, in even steps; a marker each."""
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    counts = sorted(set(counts))
    shades = np.linspace(DARKEST, LIGHTEST, len(counts))[::-1]
    looks = zip(counts, shades, cycle(MARKERS), strict=False)
    return {n: Look(to_hex(colormaps[MAP](shade)), "-", marker) for n, shade, marker in looks}


def shown_series(names: Sequence[str]) -> tuple[list[str], list[str]]:
    """Series with a panel of their own (those of the first three markers, and the first three
    distances), and the others; both in their order."""
    panels = plot.facets(names, len(names))
    markers = [of for title, of in panels.items() if title.startswith("Marker")]
    distances = [of[:MOST_DISTANCES] for title, of in panels.items() if title.startswith("Dist")]
    own = {name for of in [*markers[:MOST_MARKERS], *distances] for name in of}
    names = list(dict.fromkeys(names))
    return [name for name in names if name in own], [name for name in names if name not in own]


def left_out(names: Sequence[str]) -> str:
    """A note on series that a figure does not show."""
    if not names:
        return ""
    text = ", ".join(names) if len(names) <= 6 else f"{len(names)} further series"
    return f"Not shown: {text}."
