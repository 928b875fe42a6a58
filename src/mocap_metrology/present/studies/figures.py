"""Figures of the studies of J's claims: error against the circumstance, a line for each method."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.present.plot.curves import log_limits
from mocap_metrology.present.plot.figure import (
    GREY,
    LOOKS,
    OTHER_LOOKS,
    SMALL_PT,
    Keywords,
    Look,
    Picture,
    legend_below,
    letters,
    log_axis,
    new_figure,
    styled,
)
from mocap_metrology.present.studies.document import WORDS, method_text
from mocap_metrology.present.studies.points import Shown
from mocap_metrology.present.tables import Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PAPER = "Jansen et al. 2019"
LINES = (*LOOKS.values(), *OTHER_LOOKS)
ROOM = 1.25  # factor between the first and last value and the edge of the axis
ASIDE, ASIDE_KINDS = 0.014, 0.04  # of the axis, from the bars of one method to those of the next
WAYS = (("paper", "kabsch"), ("paper", "final"), ("paper-lm", "final"))
UNITS = {"mm": "Position error (mm)", "deg": "Rotation error (°)"}
CAPTION = (
    "Median error of the slave's pose against the {parameter}, with the 95 % interval of the "
    "median (order statistics), {n} recordings at each point; the values of different methods are "
    "drawn beside each other. {more}"
)
MORE = {
    "reconstruction": "batch needs no reconstruction and is the same in all columns. ",
    "lasers": "0 is drawn at a third of the next value; paper, final is in the table alone. ",
}


@dataclass(frozen=True)
class Panels:
    """A column of panels: title, and rows of each line by its label."""

    title: str
    lines: dict[str, list[Row]]


def columns_of(shown: Shown, rows: Sequence[Row]) -> list[Panels]:
    """What is compared in one panel, by study."""
    if shown.name == "reconstruction":
        batch = _of(rows, "batch", "final")
        return [
            Panels(
                ", ".join(WORDS.get(word, word) for word in way),
                {**_lines(_of(rows, *way), "variant"), "batch": batch},
            )
            for way in WAYS
        ]
    if shown.name == "weights":
        names = dict.fromkeys(str(row["estimator"]) for row in rows)
        return [Panels(f"{n}, Kabsch", _lines(_of(rows, n, "kabsch"), "variant")) for n in names]
    if shown.name == "lasers":
        own = [row for row in rows if (row["estimator"], row["stage"]) != ("paper", "final")]
        places = dict.fromkeys(row["board_m"] for row in own)
        return [
            Panels(f"board at {m:g} m", _lines([r for r in own if r["board_m"] == m]))
            for m in places
        ]
    kept = [row for row in rows if (row["estimator"], row["stage"]) != ("paper-lm", "kabsch")]
    return [Panels("", _lines(kept))]


def _of(rows: Sequence[Row], estimator: str, stage: str) -> list[Row]:
    return [row for row in rows if (row["estimator"], row["stage"]) == (estimator, stage)]


def _lines(rows: Sequence[Row], by: str = "") -> dict[str, list[Row]]:
    """Rows by the text of their method, or of one of its parts."""
    found: dict[str, list[Row]] = {}
    for row in rows:
        text = WORDS.get(str(row[by]), str(row[by])) if by else method_text(row)
        found.setdefault(text, []).append(row)
    return found


@styled()
def study_figure(shown: Shown, rows: Sequence[Row], source: str) -> Picture:
    """Errors of position and rotation, both axes logarithmic; recordings without a pose are
    counted in the panel."""
    columns = columns_of(shown, rows)
    title = f"{PAPER}, study {shown.number}: {shown.title}"
    alone = len(columns) == 1
    body = new_figure(title, source, 92.0 if alone else 138.0)
    shape = (1, 2) if alone else (2, len(columns))
    grid = body.subplots(*shape, squeeze=False, sharex=True, sharey=False if alone else "row")
    pairs = [
        (grid[0, k] if alone else grid[k, j], unit, column)
        for k, unit in enumerate(UNITS)
        for j, column in enumerate(columns)
    ]
    looks = _looks(columns)
    for axes, unit, column in pairs:
        _draw(axes, column, unit, looks)
        if alone or axes in grid[0]:
            axes.set_title(column.title)
        if alone or axes in grid[:, 0]:
            axes.set_ylabel(UNITS[unit])
    _x_axes(grid, shown, rows)
    for unit in UNITS:
        same = [axes for axes, of, _ in pairs if of == unit]
        log_axis(same[0], "y", _limits(columns, unit))
        for axes in same[1:]:
            axes.label_outer()
    letters(grid.ravel())
    legend_below(body, grid.ravel())
    n = max(row["n"] for row in rows)
    more = MORE.get(shown.name, "") + _failed(rows)
    return Picture(body, CAPTION.format(parameter=shown.parameter, n=n, more=more))


def _looks(columns: Sequence[Panels]) -> dict[str, Look]:
    """Of each line, the same in all panels."""
    names = dict.fromkeys(name for column in columns for name in column.lines)
    return dict(zip(names, LINES, strict=False))


def _positions(rows: Sequence[Row]) -> dict[object, float]:
    """Where the values are on the x axis: numbers at themselves (0 at a third of the next), kinds
    beside each other."""
    values = list(dict.fromkeys(row["value"] for row in rows))
    if isinstance(values[0], str):
        return {value: float(k + 1) for k, value in enumerate(values)}
    least = min(value for value in values if value > 0)
    return {value: float(value) if value > 0 else least / 3 for value in values}


def _draw(axes: Axes, column: Panels, unit: str, looks: dict[str, Look]) -> None:
    places = _positions([row for rows in column.lines.values() for row in rows])
    kinds = isinstance(next(iter(places)), str)
    span = len(places) if kinds else math.log(max(places.values()) / min(places.values()))
    for k, (name, rows) in enumerate(column.lines.items()):
        aside = (ASIDE_KINDS if kinds else ASIDE) * span * (k - (len(column.lines) - 1) / 2)
        at = np.array([places[row["value"]] for row in rows])
        x = at + aside if kinds else at * np.exp(aside)
        y, low, high = (
            np.array([row[f"{key}_{unit}"] for row in rows], dtype=float)
            for key in ("median", "lower", "upper")
        )
        bars = np.nan_to_num([y - low, high - y])
        how: Keywords = looks[name].line(ms=4.0, lw=0.9, elinewidth=0.9, capsize=1.6)
        axes.errorbar(x, y, yerr=bars, label=name, **(how | ({"ls": ""} if kinds else {})))
    _count_failures(axes, column, places)


def _count_failures(axes: Axes, column: Panels, places: dict[object, float]) -> None:
    """At values where recordings have no pose: how many of all, over the methods."""
    for value, place in places.items():
        own = [row for rows in column.lines.values() for row in rows if row["value"] == value]
        failed, n = sum(row["failed"] for row in own), sum(row["n"] for row in own)
        if failed:
            text = "refused" if failed == n else f"{failed} of {n} failed"
            how: Keywords = {"color": GREY, "fontsize": SMALL_PT, "rotation": 90}
            how |= {"ha": "center", "va": "top"}
            axes.text(place, 0.97, text, transform=axes.get_xaxis_transform(), **how)


def _limits(columns: Sequence[Panels], unit: str) -> tuple[float, float]:
    keys = [f"{key}_{unit}" for key in ("median", "lower", "upper")]
    rows = [row for column in columns for own in column.lines.values() for row in own]
    return log_limits(np.array([row[key] for row in rows], dtype=float) for key in keys)


def _x_axes(grid: np.ndarray, shown: Shown, rows: Sequence[Row]) -> None:
    """The values that were studied, and no others."""
    places = _positions(rows)
    labels = [value if isinstance(value, str) else f"{value:g}" for value in places]
    first, last = min(places.values()), max(places.values())
    for axes in grid.ravel():
        if isinstance(next(iter(places)), str):
            axes.set_xlim(0.5, len(places) + 0.5)
        else:
            axes.set(xscale="log", xlim=(first / ROOM, last * ROOM))
        axes.set_xticks(list(places.values()), labels)
        axes.set_xticks([], minor=True)
    unit = f" ({shown.unit})" if shown.unit else ""
    name = shown.parameter[0].upper() + shown.parameter[1:]
    for axes in grid[-1]:
        axes.set_xlabel(f"{name}{unit}", fontsize=SMALL_PT if len(grid[-1]) > 2 else None)


def _failed(rows: Sequence[Row]) -> str:
    """A sentence on recordings without a pose."""
    failed, n = sum(row["failed"] for row in rows), sum(row["n"] for row in rows)
    if not failed:
        return "No recording was without a pose."
    return (
        f"Of {n} estimates {failed} found no pose; they count as worse than all others, and where"
        " they are the majority there is no median."
    )
