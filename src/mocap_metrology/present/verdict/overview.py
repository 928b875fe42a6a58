"""All recordings of a laboratory against the limits of good and usable, in one picture."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.assess.checks import COORDINATE
from mocap_metrology.present.plot.curves import log_limits
from mocap_metrology.present.plot.figure import (
    GREY,
    SMALL_PT,
    VERDICT_WORDS,
    Keywords,
    Picture,
    log_axis,
    new_figure,
    styled,
    words_picture,
)
from mocap_metrology.present.tables import Record
from mocap_metrology.present.verdict.figure import draw_bands

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST = 24  # recordings drawn
ROW_MM = 5.5
CAPTION = (
    "Standard uncertainty of one frame in the worst coordinate of each recording, about the mean "
    "of an hour or of a shorter recording, with its interval. The colour is that of the verdict, "
    "which other checks can lower, too."
)


def worst_frame(row: Record) -> tuple[float, float, float] | None:
    """Uncertainty of one frame in the worst coordinate with its interval, mm; None without one.

    row: contents of verdict.json.
    """
    series = [of for name, of in row["series"].items() if COORDINATE.fullmatch(name)]
    known = [of for of in series if of.get("frame_mm")]
    if not known:
        return None
    worst = max(known, key=lambda of: of["frame_mm"])
    value = worst["frame_mm"]
    return value, worst.get("frame_lower_mm") or value, worst.get("frame_upper_mm") or value


@styled()
def overview_figure(rows: Sequence[Record], title: str, source: str) -> Picture:
    """A row a recording, in the order given, at most `MOST`."""
    shown = [(row, point) for row in rows if (point := worst_frame(row))][:MOST]
    if not shown:
        return words_picture("No recording has an uncertainty of a frame.", title, source)
    figure = new_figure(title, source, 22.0 + ROW_MM * len(shown))
    axes = figure.subplots()
    limits = shown[0][0]["limits_mm"]
    ends = [np.array(point) for _, point in shown]
    low, high = log_limits([*ends, np.array([limits["good"] / 2, limits["usable"] * 2])])
    log_axis(axes, "x", (low, high))
    draw_bands(axes, (low, high), limits)
    for place, (row, point) in enumerate(shown):
        _draw(axes, place, row, point)
    axes.set(ylim=(len(shown) - 0.5, -0.5), xlabel="Standard uncertainty of one frame (mm)")
    axes.set_yticks(range(len(shown)), [row["recording"] for row, _ in shown], size=SMALL_PT)
    axes.tick_params(axis="y", length=0)
    axes.grid(visible=False, axis="y")
    hollow = " Hollow: a simulated stand-in (twin)."
    twins = any(row["source"] == "twin" for row, _ in shown)
    more = len(rows) - len(shown)
    remarks = [hollow if twins else "", f" {more} more are not shown." if more else ""]
    return Picture(figure, "".join([CAPTION, *remarks]))


def _draw(axes: Axes, place: int, row: Record, point: tuple[float, float, float]) -> None:
    colour = VERDICT_WORDS.get(row["word"], (GREY, ""))[0]
    value, lower, upper = point
    axes.hlines(place, lower, upper, color=colour, lw=1.2)
    twin = row["source"] == "twin"
    look: Keywords = {"marker": "o", "ms": 5, "mec": colour, "mfc": "white" if twin else colour}
    axes.plot([value], [place], ls="", **look)
