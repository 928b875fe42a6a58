"""All recordings of a laboratory against the limits of good and usable, in one picture."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.assess.checks import COORDINATE
from mocap_metrology.present.plot import figure
from mocap_metrology.present.plot.curves import log_limits
from mocap_metrology.present.tables import Record
from mocap_metrology.present.text import captions

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST = 24  # recordings drawn
ROW_MM = 5.5
ROOM = 5.0  # times the limits, that the axis reaches at least: for the words of the bands
BAND_COLOURS = {"good": "#eef5ea", "usable": "#fdf3d8", "bad": "#f9e3dc"}


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


def axis_limits(values_mm: Sequence[np.ndarray], words_mm: Record) -> tuple[float, float]:
    """Limits of an axis that holds these values and every band, at most six decades."""
    bands = words_mm["good"] / ROOM, words_mm["usable"] * ROOM
    low, high = log_limits([*values_mm, np.array(bands)], most_decades=6.0)
    return min(low, bands[0]), high


def draw_bands(axes: Axes, limits: tuple[float, float], words_mm: Record, bold: str = "") -> None:
    """Bands of the words with the words above, one of them bold. words_mm: limits of `good` and
    `usable`."""
    good, usable = words_mm["good"], words_mm["usable"]
    ends = limits[0], good, usable, limits[1]
    places = (limits[0], "left"), (math.sqrt(good * usable), "center"), (limits[1], "right")
    for k, ((word, colour), (at, side)) in enumerate(
        zip(BAND_COLOURS.items(), places, strict=True)
    ):
        axes.axvspan(ends[k], ends[k + 1], color=colour, lw=0, zorder=0)
        look: figure.Keywords = {"weight": "normal", "color": figure.GREY}
        look = {"weight": "bold", "color": figure.INK} if word == bold else look
        where: figure.Keywords = {"xycoords": axes.get_xaxis_transform(), "ha": side}
        where |= {"xytext": (0, 3), "textcoords": "offset points", "size": figure.SMALL_PT}
        axes.annotate(word, (at, 1.0), **where, **look)


@figure.styled()
def overview_figure(rows: Sequence[Record], title: str, source: str) -> figure.Picture:
    """A row a recording, in the order given, at most `MOST`."""
    shown = [(row, point) for row in rows if (point := worst_frame(row))][:MOST]
    if not shown:
        none = "No recording has an uncertainty of a frame."
        return figure.words_picture(none, title, source)
    body = figure.new_figure(title, source, 22.0 + ROW_MM * len(shown))
    axes = body.subplots()
    words_mm = shown[0][0]["limits_mm"]
    limits = axis_limits([np.array(point) for _, point in shown], words_mm)
    figure.log_axis(axes, "x", limits)
    draw_bands(axes, limits, words_mm)
    for place, (row, (value, lower, upper)) in enumerate(shown):
        colour = figure.VERDICT_WORDS.get(row["word"], (figure.GREY, ""))[0]
        face = "white" if row["source"] == "twin" else colour
        axes.hlines(place, lower, upper, color=colour, lw=1.2)
        axes.plot([value], [place], marker="o", ms=5, mec=colour, mfc=face)
    axes.set(ylim=(len(shown) - 0.5, -0.5), xlabel="Standard uncertainty of one frame (mm)")
    axes.set_yticks(range(len(shown)), [row["recording"] for row, _ in shown], size=figure.SMALL_PT)
    axes.tick_params(axis="y", length=0)
    axes.grid(visible=False, axis="y")
    twins = any(row["source"] == "twin" for row, _ in shown)
    more = len(rows) - len(shown)
    hollow = " Hollow: a simulated stand-in (twin)." if twins else ""
    left_out = f" Not shown, as without that number: {more}." if more else ""
    return figure.Picture(body, f"{captions.OVERVIEW}{hollow}{left_out}")
