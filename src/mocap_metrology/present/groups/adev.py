"""Allan deviations of several recordings: a panel a series, a curve a recording; by number of
cameras also their ratio to the first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from mocap_metrology.present.groups.members import CAMERAS, Family, left_out, shown_series
from mocap_metrology.present.plot import curves as plot
from mocap_metrology.present.plot import figure as fig
from mocap_metrology.present.plot.curves import Limits, Looks, groups_of
from mocap_metrology.present.plot.figure import Picture
from mocap_metrology.present.text import captions

COLUMNS = 3
ROW_MM = 66.0  # a panel with its ratios
WITHIN, PAD = (0.005, 0.995), 0.06  # quantiles of the ratios that their axis holds, and beyond them
MOST_BANDS = 3  # curves in a panel up to which their intervals are drawn
LEAST_RANGE = 0.1
Allan = Mapping[str, Mapping[str, np.ndarray]]  # columns of allan_masked.parquet by recording
Panels = Mapping[str, pd.DataFrame]


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


def ratio_picture(panels: Panels, looks: Looks, texts: tuple[str, str, str]) -> Picture:
    """A panel a series, and under it the curves of that panel divided by its first curve.

    panels: curves by title, the smallest subset first; texts: title, source line and caption. The
    ratio is computed where both have the averaging time. Call it within `styled`.
    """
    rows, limits = -(-len(panels) // COLUMNS), plot.curve_limits(pd.concat(panels.values()))
    body = fig.new_figure(*texts[:2], 24.0 + rows * ROW_MM)
    grid = body.subplots(2 * rows, COLUMNS, sharex=True, squeeze=False, height_ratios=(5, 3) * rows)
    above, below = grid[::2].ravel(), grid[1::2].ravel()
    found = [ratios(curves) for curves in panels.values()]
    extent = _extent(pd.concat(found)["ratio"])
    for k, (title, curves) in enumerate(panels.items()):
        fig.log_axes(above[k], limits)
        plot.draw_curves(above[k], curves, limits[1], looks)
        fig.panel_title(above[k], fig.short(title))
        below[k].set_ylim(extent)
        below[k].locator_params(axis="y", nbins=5)
        for order, (name, own) in enumerate(groups_of(found[k], "curve")):
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
        plot.slope_fan(above[len(panels)], limits, plot.ALLAN_SLOPES)
    return fig.finished(body, above[: len(panels)], texts[2])


def ratios(curves: pd.DataFrame) -> pd.DataFrame:
    """`curve`, `x` and `ratio` to the first curve, where both have that x and are positive."""
    first = curves[curves["curve"] == curves["curve"].iloc[0]].set_index("x")["y"]
    ratio = curves["y"] / curves["x"].map(first)
    both = curves.assign(ratio=ratio.where(np.isfinite(ratio) & (ratio > 0)))
    return both.loc[both["x"].isin(first.index), ["curve", "x", "ratio"]]


def _extent(ratio: pd.Series) -> Limits:
    """Limits of the linear axis of ratios, with 1 inside."""
    low, high = (float(np.nan_to_num(ratio.quantile(share), nan=1.0)) for share in WITHIN)
    low, high = min(low, 1.0), max(high, 1.0)
    room = max(high - low, LEAST_RANGE) * PAD
    return max(low - room, 0.0), high + room


@fig.styled()
def family_figure(
    family: Family,
    allan: Allan,
    expected: Mapping[str, Sequence[str]],
    title: str,
    source: str,
    remarks: str,
    confidence: float | None = None,
) -> Picture:
    """Allan deviations of a family of recordings, as S Figures 8, 12 and 13.

    allan: columns of allan_masked.parquet, and expected: series that should be there, both by
    recording; a panel shows those that should have its series. Subsets of cameras are drawn with
    their ratio to the smallest one; up to three other recordings with their intervals, of that
    `confidence` (0 to 1). source: the line at the foot; remarks: what the caption adds.
    """
    shown, others = shown_series([name for names in expected.values() for name in names])
    subsets = family.by == CAMERAS and bool(family.looks)
    band = len(family.labels) <= MOST_BANDS and not subsets
    labels = {name: family.said(label) for name, label in family.labels.items()}
    looks = {family.said(label): look for label, look in family.looks.items()}
    panels = {}
    for series in shown:
        own = {name: label for name, label in labels.items() if series in expected[name]}
        panels[series] = series_curves(allan, series, own, band)
    words = f"{left_out(others)} {remarks}"
    if subsets:
        caption = f"{captions.ADEV} {captions.ADEV_RATIOS} {words}"
        return ratio_picture(panels, looks, (title, source, caption))
    names = [
        f"{series}: {' and '.join(plot.family_ends(curves))}"
        for series, curves in ({} if looks else panels).items()
        if curves["curve"].nunique() > plot.MOST_SINGLE and (curves["y"] > 0).any()
    ]
    note = captions.ADEV_ENDS.format(names="; ".join(names)) if names else ""
    texts = title, source, f"{captions.ADEV} {note} {words}"
    return panels_picture(panels, looks or None, texts, confidence)


def compared(
    allan: Allan, series: Sequence[str], labels: Mapping[str, str], band: bool = True
) -> Panels:
    """A panel a series with the curves of named recordings; labels: by recording."""
    return {one: series_curves(allan, one, labels, band) for one in series}


def panels_picture(
    panels: Panels,
    looks: Looks | None,
    texts: tuple[str, str, str],
    confidence: float | None,
    lettered: bool = False,
) -> Picture:
    """The figure of such panels on common axes, with the slopes beside; call it within `styled`."""
    band = "interval" if confidence is None else f"{100 * confidence:.3g} % interval"
    picture = plot.curves_picture(
        panels, plot.ADEV_AXES, plot.ALLAN_SLOPES, texts, band, looks=looks
    )
    if lettered:
        fig.letters(picture.body.axes[: len(panels)])
    return picture
