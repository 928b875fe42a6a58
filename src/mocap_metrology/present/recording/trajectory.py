"""Trajectories of a recording, raw and cleaned, from a handful of frames to hours of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.present.drawing.axes import TimeAxis, length_unit, linear_axis, time_axis
from mocap_metrology.present.drawing.legend import strip, strip_height
from mocap_metrology.present.drawing.style import (
    BODY_PT,
    GREY,
    IMAGE_DPI,
    MM,
    SMALL_PT,
    WIDTH_MM,
    Keywords,
    blank_sheet,
    label_axes,
    shorten,
    styled,
)
from mocap_metrology.present.recording import ridges
from mocap_metrology.present.recording.traces import GAP, Prepared, Trace, entries, prepare
from mocap_metrology.present.text.numbers import number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_PANELS = 20  # six markers and two distances; more are drawn as ridges
MOST_DOTS = 400  # outliers drawn in a panel
LEFT_MM, FACTS_MM, GAP_MM, LABELS_MM = 18.0, 40.0, 2.2, 9.0
PANEL_MM = WIDTH_MM - LEFT_MM - FACTS_MM
LINE_SPACING = 1.25


@styled()
def trajectory_figure(
    raw: Mapping[str, np.ndarray],
    clean: Mapping[str, np.ndarray],
    outliers: Mapping[str, np.ndarray],
    frame_rate_hz: float,
    title: str,
    note: str = "",
) -> Figure:
    """Every series of a recording against time, about its mean.

    raw, clean: name -> (n,) values in mm, NaN where missing; outliers: name -> (n,) bool. A panel a
    series: each column of pixels shows the range of all its samples, raw behind cleaned, and a line
    the mean over a column, over 1 s at least. Of more than 400 outliers the largest of each of 200
    stretches and the 200 largest of all are drawn. Where a few samples reach far beyond the rest,
    the axis stops short of them: triangles at its edge, and the farthest in numbers beside it. With
    more than 20 series, one row a marker (`ridges`).
    """
    many = len(raw) > MOST_PANELS
    pixels = round((ridges.column_mm(list(raw)) if many else PANEL_MM) * MM * IMAGE_DPI)
    dots = ridges.MOST_DOTS if many else MOST_DOTS
    series = [
        prepare(name, values, clean[name], outliers[name], frame_rate_hz, pixels, dots)
        for name, values in raw.items()
    ]
    time = time_axis(max((one.n for one in series), default=0), frame_rate_hz)
    if many:
        return ridges.ridges_figure(series, time, title, note)
    return _panels_figure(series, time, title, note)


def _panels_figure(series: Sequence[Prepared], time: TimeAxis, title: str, note: str) -> Figure:
    key = entries(series, [one.limits for one in series])
    top = strip_height(key, WIDTH_MM - LEFT_MM) + 3.0
    height = float(np.clip(140 / max(len(series), 1), 13.5, 45))
    sheet = blank_sheet(top + len(series) * (height + GAP_MM) + LABELS_MM, title, note)
    strip(sheet, LEFT_MM, 0.5, WIDTH_MM - LEFT_MM, key)
    unit = length_unit([np.ptp(one.limits) for one in series if one.n_missing < one.n])
    for k, one in enumerate(series):
        axes = sheet.axes(LEFT_MM, top + k * (height + GAP_MM), PANEL_MM, height)
        limits = (one.limits[0] * unit.per_mm, one.limits[1] * unit.per_mm)
        linear_axis(axes, "x", time.limits, most=10)
        linear_axis(axes, "y", limits, most=max(int(height / 5), 3))
        axes.tick_params(labelbottom=k == len(series) - 1)
        name = shorten(one.name, BODY_PT, height - 8.0)
        label_axes(axes, y=f"{name} ({unit.symbol})", y_mm=14.5)
        if one.n_missing == one.n:
            _nothing(axes)
        else:
            Trace(one, time.per_frame, unit.per_mm, one.limits).draw(axes)
            facts = "\n".join(_facts(one))
            axes.text(
                1 + 2.5 / PANEL_MM,
                0.5,
                facts,
                transform=axes.transAxes,
                size=SMALL_PT,
                va="center",
                linespacing=LINE_SPACING,
            )
        if k == len(series) - 1:
            label_axes(axes, x=time.label)
    return sheet.figure


def _nothing(axes: Axes) -> None:
    axes.set_facecolor(GAP)
    axes.set_yticks([])
    middle: Keywords = {"transform": axes.transAxes, "ha": "center", "va": "center"}
    axes.text(0.5, 0.5, "no valid samples", color=GREY, **middle)


def _facts(one: Prepared) -> list[str]:
    """What stands beside a panel."""
    valid = one.n - one.n_missing
    facts = [
        f"mean {number(one.centre, 3)} mm",
        f"outliers {number(one.n_outliers)} ({100 * one.n_outliers / valid:.2g} %)",
    ]
    if one.n_missing:
        facts.append(f"missing {number(one.n_missing)} ({100 * one.n_missing / one.n:.2g} %)")
    if one.n_beyond:
        facts.append(f"beyond {number(one.n_beyond)}, to {number(one.farthest, 2, sign=True)} mm")
    return facts
