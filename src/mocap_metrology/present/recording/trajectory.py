"""Trajectories of a recording, raw and cleaned, from a handful of frames to hours of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.present.plot.figure import (
    GREY,
    SMALL_PT,
    Keywords,
    Picture,
    coordinate_of,
    legend_below,
    new_figure,
    panel_title,
    say,
    short,
    styled,
    words_picture,
)
from mocap_metrology.present.plot.units import TimeAxis, length_unit, time_axis
from mocap_metrology.present.recording.traces import GAP, Prepared, Trace, prepare
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import number, significant

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import SubFigure

MOST_PANELS = 20  # six markers and two distances; more are drawn as rows
COLUMNS = 660  # of samples in a panel, or over all panels side by side; as many as pixels
MOST_DOTS, MOST_DOTS_OF_ROW = 400, 40  # outliers drawn
PANELS_MM, PANEL_MM = 140.0, (13.5, 45.0)
LABEL_AT = -0.09  # of the width of the axes
ROWS_MM, ROW_MM, NAME_MM = 190.0, (2.2, 9.0), 2.9
TYPICAL, ROW_OF_CORE = 0.9, 1.6  # a row is so many times this quantile of the series' ranges


@styled()
def trajectory_figure(
    raw: Mapping[str, np.ndarray],
    clean: Mapping[str, np.ndarray],
    outliers: Mapping[str, np.ndarray],
    frame_rate_hz: float,
    title: str,
    source: str = "",
    remarks: str = "",
) -> Picture:
    """Every series of a recording against time, about its mean.

    raw, clean: name -> (n,) values in mm, NaN where missing; outliers: name -> (n,) bool. A panel a
    series: each column of pixels shows the range of all its samples, raw behind cleaned, and a line
    the mean over a column, over 1 s at least. Of more than 400 outliers the largest of each of 200
    stretches and the 200 largest of all are drawn. Where a few samples reach far beyond the rest,
    the axis stops short of them: triangles at its edge, and the farthest in numbers beside it. With
    more than 20 series, one row a marker and a column of axes a coordinate, all to one scale.
    `source`: the line at the foot; `remarks`: what the caption adds.
    """
    if not raw:
        return words_picture("No series.", title, source)
    many = len(raw) > MOST_PANELS
    n_columns = COLUMNS // len(_by_coordinate(raw)) if many else COLUMNS
    dots = MOST_DOTS_OF_ROW if many else MOST_DOTS
    series = [
        prepare(name, values, clean[name], outliers[name], frame_rate_hz, n_columns, dots)
        for name, values in raw.items()
    ]
    time = time_axis(max(one.n for one in series), frame_rate_hz)
    body = (_rows if many else _panels)(series, time, title, source)
    legend_below(body, body.axes)
    thinned = captions.FEWER_OUTLIERS if any(one.thinned for one in series) else ""
    return Picture(body, " ".join(filter(None, [captions.TRAJECTORY, thinned, remarks])))


def _panels(series: Sequence[Prepared], time: TimeAxis, title: str, source: str) -> SubFigure:
    """A panel a series, numbers beside it."""
    height = float(np.clip(PANELS_MM / len(series), *PANEL_MM))
    body = new_figure(title, source, 30.0 + len(series) * (height + 2.0))
    grid = body.subplots(len(series), 1, sharex=True, squeeze=False)[:, 0]
    unit = length_unit([np.ptp(one.limits) for one in series if one.n_missing < one.n])
    for axes, one in zip(grid, series, strict=True):
        axes.set(xlim=time.limits, ylim=np.multiply(one.limits, unit.per_mm))
        axes.set_ylabel(f"{short(one.name, 8)} ({unit.symbol})")
        axes.yaxis.set_label_coords(LABEL_AT, 0.5)  # faster than `align_ylabels` by half a second
        if one.n_missing == one.n:
            axes.set(facecolor=GAP, yticks=[])
            say(axes, "no valid samples")
            continue
        Trace(one, time.per_frame, unit.per_mm, one.limits).draw(axes)
        beside = "\n".join(_numbers(one))
        axes.text(1.02, 0.5, beside, transform=axes.transAxes, size=SMALL_PT, va="center")
    grid[-1].set_xlabel(time.label)
    return body


def _numbers(one: Prepared) -> list[str]:
    """Text beside a panel."""
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


def _by_coordinate(names: Iterable[str]) -> dict[str, list[str]]:
    """Names by coordinate, and under "" those that are none."""
    found: dict[str, list[str]] = {axis: [] for axis in ("x", "y", "z", "")}
    for name in names:
        found[(coordinate_of(name) or ("", 0))[0]].append(name)
    return {axis: own for axis, own in found.items() if own}


def _rows(series: Sequence[Prepared], time: TimeAxis, title: str, source: str) -> SubFigure:
    """A row a marker, as high as nine in ten of the series need."""
    named = {one.name: one for one in series}
    groups = _by_coordinate(named)
    ranges = [one.core for one in series if one.core > 0]
    step = ROW_OF_CORE * float(np.quantile(ranges, TYPICAL)) if ranges else 1.0
    n_rows = max(len(names) for names in groups.values())
    row_mm = float(np.clip(ROWS_MM / n_rows, *ROW_MM))
    body = new_figure(title, source, 35.0 + n_rows * row_mm)
    grid = body.subplots(1, len(groups), sharex=True, squeeze=False)[0]
    for axes, (axis, names) in zip(grid, groups.items(), strict=True):
        axes.set(xlim=time.limits, ylim=(n_rows - 0.5, -0.5), xlabel=time.label)
        if len(names) < n_rows:
            _end_after(axes, len(names))
        for place, name in enumerate(names):
            _row(axes, named[name], place, time.per_frame, step)
        every = next(k for k in (1, 2, 5, 10, 20, 50) if k * row_mm >= NAME_MM or k == 50)
        shown = [k for k in range(len(names)) if k == 0 or (k + 1) % every == 0 or every == 1]
        labels = [names[k].removeprefix(axis) if axis else short(names[k], 8) for k in shown]
        axes.set_yticks(shown, labels, fontsize=SMALL_PT)
        axes.tick_params(axis="y", length=0)
        n_outliers = sum(named[name].n_outliers for name in names)
        panel_title(axes, axis or "L", f"{number(n_outliers)} outliers")
    unit = length_unit([step])
    grid[0].set_ylabel(f"Marker; a row is {significant(step * unit.per_mm, 2)} {unit.symbol} high")
    return body


def _row(axes: Axes, one: Prepared, place: int, per_frame: float, step: float) -> None:
    if one.n_missing < one.n:
        half = (-0.48 * step, 0.48 * step)
        Trace(one, per_frame, -1 / step, half, place).draw(axes, dot_pt=1.5, mean_as_image=True)
    else:
        middle = float(np.mean(axes.get_xlim()))
        how: Keywords = {"ha": "center", "va": "center_baseline", "fontsize": 6.0, "color": GREY}
        axes.text(middle, place, "no valid samples", **how)


def _end_after(axes: Axes, n_rows: int) -> None:
    """The x axis below the last of fewer rows than the axes have room for."""
    axes.grid(visible=False)
    axes.spines["bottom"].set_position(("data", n_rows - 0.5))
    for side in ("left", "right"):
        axes.spines[side].set_bounds(-0.5, n_rows - 0.5)
