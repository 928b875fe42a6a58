"""Allan deviations of several recordings: a panel a series, a curve a recording; by number of
cameras also their ratio to the first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.present.drawing.axes import (
    Limits,
    decade_axis,
    linear_axis,
    log_limits,
    slope_fan,
)
from mocap_metrology.present.drawing.curves import Curve, Key, Panel, curves_figure, draw_panel
from mocap_metrology.present.drawing.legend import Entry, strip, strip_height
from mocap_metrology.present.drawing.style import (
    GREY,
    MARGIN_MM,
    SMALL_PT,
    WIDTH_MM,
    Keywords,
    Look,
    Sheet,
    blank_sheet,
    head,
    label_axes,
    lines_mm,
    styled,
)
from mocap_metrology.present.groups.members import (
    CAMERAS,
    MOST_BANDS,
    Family,
    curve_of,
    left_out,
    shown_series,
)
from mocap_metrology.present.plot.curves import ALLAN_SLOPES
from mocap_metrology.present.recording.recording_figures import (
    ALLAN_DECADES,
    FARTHEST_BAND,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLUMNS = 3
LEFT_MM, GAP_MM, RIGHT_MM = 16.5, 7.0, 3.0
PANEL_MM = (WIDTH_MM - LEFT_MM - RIGHT_MM - GAP_MM * (COLUMNS - 1)) / COLUMNS
TITLE_MM, ADEV_MM, BETWEEN_MM, RATIO_MM, BELOW_MM, LABELS_MM = 5.5, 40.0, 1.5, 24.0, 3.0, 11.0
ROW_MM = TITLE_MM + ADEV_MM + BETWEEN_MM + RATIO_MM + BELOW_MM
FAN_MM = 44.0, 34.0  # width and height of the slopes, where a cell is free
WITHIN, PAD = (0.5, 99.5), 0.06  # percentiles of the ratios that their axis holds, and beyond them
LEAST_RANGE = 0.1
NOTE = "Below each panel: Allan deviations relative to those of the smallest subset."


def ratio_figure(
    panels: Sequence[Panel],
    limits: tuple[Limits, Limits],
    title: str,
    note: str = "",
) -> Figure:
    """A panel a series, and under it the curves of that panel divided by its first curve.

    panels: of curves with looks, the smallest subset first; limits: of averaging time in s and
    Allan deviation in mm. The ratio is taken where both have the averaging time.
    """
    rows = -(-len(panels) // COLUMNS)
    looks = {curve.name: panel.look(curve.name) for panel in panels for curve in panel.curves}
    entries = [Entry(name, look=look) for name, look in looks.items()]
    width, key_top = WIDTH_MM - 2 * MARGIN_MM, rows * ROW_MM - BELOW_MM + LABELS_MM
    body = key_top + strip_height(entries, width) + 1.5
    sheet = blank_sheet(body, title, f"{NOTE} {note}".strip())
    for k, panel in enumerate(panels):
        axes = sheet.axes(*_corner(k), PANEL_MM, ADEV_MM)
        decade_axis(axes, "x", limits[0], PANEL_MM)
        decade_axis(axes, "y", limits[1], ADEV_MM)
        axes.tick_params(labelbottom=False, labelleft=k % COLUMNS == 0)
        draw_panel(axes, panel, limits[1])
        head(axes, panel.title)
        label_axes(axes, y="Allan deviation (mm)" if k % COLUMNS == 0 else "", y_mm=13.5)
    found = [ratios(panel.curves) for panel in panels]
    extent = _extent([r for of_panel in found for _, r in of_panel.values()])
    for k, of_panel in enumerate(found):
        left, top = _corner(k)
        axes = sheet.axes(left, top + ADEV_MM + BETWEEN_MM, PANEL_MM, RATIO_MM)
        _draw_ratios(axes, of_panel, looks, (limits[0], extent))
        lowest = k + COLUMNS >= len(panels)
        axes.tick_params(labelbottom=lowest, labelleft=k % COLUMNS == 0)
        label_axes(axes, x="Averaging time τ (s)" if lowest else "")
        y = f"Ratio to\n{next(iter(looks), '')}" if k % COLUMNS == 0 else ""
        label_axes(axes, y=y, y_mm=12.0)
    if len(panels) % COLUMNS:
        _slopes(sheet, _corner(len(panels)), limits)
    strip(sheet, MARGIN_MM, key_top, width, entries)
    return sheet.figure


def _corner(k: int) -> tuple[float, float]:
    row, column = divmod(k, COLUMNS)
    return LEFT_MM + column * (PANEL_MM + GAP_MM), TITLE_MM + row * ROW_MM


def ratios(curves: Sequence[Curve]) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Averaging times and ratio to the first curve, by name of the curve."""
    if not curves:
        return {}
    first, found = curves[0], {}
    for curve in curves:
        x, own, reference = np.intersect1d(curve.x, first.x, return_indices=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = curve.y[own] / first.y[reference]
        found[curve.name] = x, np.where(np.isfinite(ratio) & (ratio > 0), ratio, np.nan)
    return found


def _extent(values: Sequence[np.ndarray]) -> Limits:
    """Limits of the linear axis of ratios, with 1 inside."""
    known = np.concatenate([v[np.isfinite(v)] for v in values] or [np.ones(1)])
    low, high = np.percentile(known, WITHIN) if known.size else (1.0, 1.0)
    low, high = min(low, 1.0), max(high, 1.0)
    room = max(high - low, LEAST_RANGE) * PAD
    return max(float(low - room), 0.0), float(high + room)


def _draw_ratios(
    axes: Axes,
    found: Mapping[str, tuple[np.ndarray, np.ndarray]],
    looks: Mapping[str, Look],
    limits: tuple[Limits, Limits],
) -> None:
    decade_axis(axes, "x", limits[0], PANEL_MM)
    linear_axis(axes, "y", limits[1], 5)
    for order, (name, (x, ratio)) in enumerate(found.items()):
        look, every = looks[name], max(x.size // 8, 1)
        marks = 1 if x.size <= 15 else (every * order // 3 % every, every)
        how: Keywords = {"color": look.colour, "ls": look.dashes, "marker": look.marker, "lw": 1.2}
        axes.plot(x, ratio, markevery=marks, markerfacecolor="white", **how)


def _slopes(sheet: Sheet, corner: tuple[float, float], limits: tuple[Limits, Limits]) -> None:
    width, height = FAN_MM
    canvas = sheet.canvas(corner[0] + 2.0, corner[1] + LABELS_MM, width, height)
    across, up = (float(np.log10(high / low)) for low, high in limits)
    decade_mm = PANEL_MM / across, ADEV_MM / up
    line = lines_mm(1, SMALL_PT)
    how: Keywords = {"size": SMALL_PT, "va": "center_baseline", "color": GREY}
    canvas.text(0.0, height - line / 2, "slopes of Allan deviation", **how)
    slope_fan(canvas, (0.0, 0.0, width, height - line - 1.5), decade_mm, ALLAN_SLOPES)


Allan = Mapping[str, Mapping[str, np.ndarray]]


@styled()
def family_figure(
    family: Family,
    allan: Allan,
    expected: Mapping[str, Sequence[str]],
    title: str,
    note: str = "",
    confidence: float | None = None,
) -> Figure:
    """Allan deviations of a family of recordings, as S Figures 8, 12 and 13.

    allan: columns of allan_masked.parquet, and expected: series that should be there, both by
    recording; a panel shows those that should have its series. Subsets of cameras are drawn with
    their ratio to the smallest one; up to three other recordings with their intervals, of that
    `confidence` (0 to 1).
    """
    shown, others = shown_series([name for names in expected.values() for name in names])
    subsets = family.by == CAMERAS and bool(family.looks)
    band = len(family.labels) <= MOST_BANDS and not subsets
    labels = {name: family.said(label) for name, label in family.labels.items()}
    looks = {family.said(label): look for label, look in family.looks.items()}
    panels = [
        Panel(
            series,
            [
                curve_of(allan[name], series, label, band)
                for name, label in labels.items()
                if series in expected[name]
            ],
            looks,
        )
        for series in shown
    ]
    if subsets:
        limits = adev_limits([curve for panel in panels for curve in panel.curves])
        return ratio_figure(panels, limits, title, f"{left_out(others)} {note}")
    ends = "" if family.looks else "Over each panel its lowest and its highest recording."
    return panels_figure(panels, title, f"{ends} {left_out(others)} {note}", confidence)


@styled()
def compared_figure(
    allan: Mapping[str, tuple[Mapping[str, np.ndarray], Look]],
    series: Sequence[str],
    title: str,
    note: str = "",
    confidence: float | None = None,
) -> Figure:
    """Named recordings with given looks, a panel a series, with intervals of that confidence;
    allan: columns of allan_masked.parquet and look, by the name in the key."""
    looks = {name: look for name, (_, look) in allan.items()}
    panels = [
        Panel(one, [curve_of(columns, one, n, True) for n, (columns, _) in allan.items()], looks)
        for one in series
    ]
    return panels_figure(panels, title, note, confidence)


def panels_figure(
    panels: Sequence[Panel], title: str, note: str, confidence: float | None = None
) -> Figure:
    """The figure of such panels on common axes, with the key of slopes."""
    curves = [curve for panel in panels for curve in panel.curves]
    band = "interval" if confidence is None else f"{100 * confidence:.3g} % interval"
    return curves_figure(
        panels,
        ("Averaging time τ (s)", "Allan deviation (mm)"),
        adev_limits(curves),
        Key(ALLAN_SLOPES, "Allan deviation", band),
        title,
        note,
    )


def adev_limits(curves: Sequence[Curve]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Limits of averaging time and deviation round the curves and their intervals."""
    bands = [
        np.clip(bound, curve.y / FARTHEST_BAND, curve.y * FARTHEST_BAND)
        for curve in curves
        for bound in curve.band or ()
    ]
    return (
        log_limits([curve.x for curve in curves]),
        log_limits([curve.y for curve in curves] + bands, 1.0, ALLAN_DECADES),
    )
