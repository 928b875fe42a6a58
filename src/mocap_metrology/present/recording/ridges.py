"""Trajectories of many markers: a column a coordinate, a row a marker, one scale for all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.present.drawing.axes import TimeAxis, length_unit, linear_axis
from mocap_metrology.present.drawing.legend import strip, strip_height
from mocap_metrology.present.drawing.style import (
    GREY,
    SMALL_PT,
    WIDTH_MM,
    blank_sheet,
    coordinate_of,
    head,
    label_axes,
    plain,
    shorten,
    text_mm,
)
from mocap_metrology.present.recording.traces import Prepared, Trace, entries
from mocap_metrology.present.text.numbers import number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LEFT_MM, RIGHT_MM, GAP_MM, HEAD_MM, LABELS_MM = 13.0, 3.0, 6.0, 5.5, 10.0
OTHERS_LEFT_MM = (0.0, 12.0)  # more room for longer names
MOST_DOTS, DOT_PT = 40, 1.5  # outliers drawn in a row
ROWS_MM, ROW_MM = 190.0, (2.2, 9.0)
TYPICAL, ROW_OF_CORE = 0.9, 1.6  # a row is so many times this quantile of the series' ranges


def groups_of(names: Sequence[str]) -> dict[str, list[str]]:
    """Names by coordinate, and under "" those that are none."""
    found: dict[str, list[str]] = {}
    for name in names:
        axis, _marker = coordinate_of(name) or ("", 0)
        found.setdefault(axis, []).append(name)
    return {axis: found[axis] for axis in ("x", "y", "z", "") if axis in found}


def column_mm(names: Sequence[str]) -> float:
    """Width of each column of panels."""
    groups = groups_of(names)
    free = WIDTH_MM - LEFT_MM - RIGHT_MM - GAP_MM * (len(groups) - 1)
    return (free - _others_left_mm(groups)) / len(groups)


def _others_left_mm(groups: Mapping[str, Sequence[str]]) -> float:
    """Room that the names of distances need beyond the usual."""
    if "" not in groups or len(groups) == 1:
        return 0.0
    longest = max(text_mm(plain(name), SMALL_PT) for name in groups[""])
    return float(np.clip(longest + 2 - GAP_MM, *OTHERS_LEFT_MM))


def ridges_figure(series: Sequence[Prepared], time: TimeAxis, title: str, note: str) -> Figure:
    """Figure of all series; a row is as high as nine in ten of them need."""
    named = {one.name: one for one in series}
    groups = groups_of(list(named))
    ranges = [one.core for one in series if one.core > 0]
    step = ROW_OF_CORE * float(np.quantile(ranges, TYPICAL)) if ranges else 1.0
    half = (-0.48 * step, 0.48 * step)
    key = entries(series, [half] * len(series))
    top = strip_height(key, WIDTH_MM - LEFT_MM) + HEAD_MM + 1.0
    n_rows = max(len(names) for names in groups.values())
    row = float(np.clip(ROWS_MM / n_rows, *ROW_MM))
    sheet = blank_sheet(top + n_rows * row + LABELS_MM, title, note)
    strip(sheet, LEFT_MM, 0.5, WIDTH_MM - LEFT_MM, key)
    width, left = column_mm(list(named)), LEFT_MM
    unit = length_unit([step])
    for k, (axis, names) in enumerate(groups.items()):
        left += 0.0 if axis else _others_left_mm(groups)
        axes = sheet.axes(left, top, width, len(names) * row)
        left += width + GAP_MM
        linear_axis(axes, "x", time.limits, most=6)
        axes.set_ylim(len(names) - 0.5, -0.5)
        for place, name in enumerate(names):
            _row(axes, named[name], place, time.per_frame, step, half)
        _row_names(axes, names, row, bool(axis))
        outliers = sum(named[name].n_outliers for name in names)
        head(axes, axis or "L", f"{number(outliers)} outliers")
        label_axes(axes, x=time.label)
        if k == 0:
            size = f"{float(f'{step * unit.per_mm:.2g}'):g} {unit.symbol}"
            label_axes(axes, y=f"Marker; a row is {size} high", y_mm=10.0)
    return sheet.figure


def _row(
    axes: Axes,
    one: Prepared,
    place: int,
    per_frame: float,
    step: float,
    half: tuple[float, float],
) -> None:
    if one.n_missing < one.n:
        Trace(one, per_frame, -1 / step, half, place).draw(axes, dot_pt=DOT_PT, mean_as_image=True)
    else:
        axes.text(
            float(np.mean(axes.get_xlim())),
            place,
            "no valid samples",
            ha="center",
            va="center_baseline",
            size=min(SMALL_PT, 6.0),
            color=GREY,
        )


def _row_names(axes: Axes, names: Sequence[str], row: float, numbered: bool) -> None:
    """As many as fit: each, or every second, fifth, ..."""
    from matplotlib.ticker import FixedFormatter, FixedLocator

    every = next(k for k in (1, 2, 5, 10, 20, 50) if k * row >= 2.9 or k == 50)
    shown = [k for k in range(len(names)) if k == 0 or (k + 1) % every == 0 or every == 1]
    texts = [
        found[1] if numbered and (found := coordinate_of(n)) else shorten(n, SMALL_PT, 12)
        for n in names
    ]
    axes.yaxis.set_major_locator(FixedLocator(shown))
    axes.yaxis.set_major_formatter(FixedFormatter([str(texts[k]) for k in shown]))
    axes.tick_params(axis="y", length=0, labelsize=SMALL_PT, pad=2)
