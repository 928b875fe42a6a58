"""One picture of the verdict on a recording: uncertainties against the limits, and their causes."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.assess.checks import COORDINATE
from mocap_metrology.noise.fit.estimates import correlation_class
from mocap_metrology.present.drawing.axes import decade_axis, log_limits
from mocap_metrology.present.drawing.legend import Entry, strip, strip_height
from mocap_metrology.present.drawing.style import (
    BODY_PT,
    GREY,
    INK,
    SMALL_PT,
    WIDTH_MM,
    Keywords,
    Sheet,
    blank_sheet,
    lines_mm,
    shorten,
    size_mm,
    styled,
    text_mm,
    wrap,
)
from mocap_metrology.present.text.numbers import duration_words
from mocap_metrology.present.verdict.words import (
    FRAME,
    MEANS,
    NEAR,
    Found,
    marker_numbers,
    sentences,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_ROWS = 24
MOST_DECADES = 6.0  # of the axis: farther down there are rounding errors only
FARTHEST = 3.0  # an interval counts for the limits of the axis up to so many times the value
ROW_MM = 10.5
NAMES_MM, GAP_MM, RIGHT_MM, BARS_MM = 13.0, 8.0, 4.0, 56.0
BAND_COLOURS = {"good": "#eef5ea", "usable": "#fdf3d8", "bad": "#f9e3dc"}
MARKS: tuple[tuple[str, str | int, Keywords], ...] = (
    (FRAME, "frame", {"marker": "o", "color": INK, "mfc": INK, "ms": 4.2}),
    (NEAR, "near", {"marker": "o", "color": GREY, "mfc": "white", "ms": 4.0}),
    (MEANS[0], 0, {"marker": "s", "color": "#10307a", "mfc": "#10307a", "ms": 3.4}),
    (MEANS[1], 1, {"marker": "^", "color": "#cf4a2c", "mfc": "#cf4a2c", "ms": 3.8}),
    (MEANS[2], 2, {"marker": "D", "color": "#1b8aa8", "mfc": "#1b8aa8", "ms": 3.2}),
)
# Kinds of noise from fast to slow; correlated noise by the class of its correlation time (S 4.6)
KINDS = {
    "violet": "#9a86c9",
    "blue": "#8fb8de",
    "white": "#dadada",
    "periodic": "#3d3d3d",
    "correlated, short (below 1 s)": "#cdeaf0",
    "correlated, medium (1 to 10 s)": "#7fcbde",
    "correlated, unclassed (10 to 100 s)": "#2f93ae",
    "correlated, long (from 100 s)": "#14525f",
    "flicker": "#e6b34a",
    "random walk": "#cf4a2c",
    "drift": "#6b8e23",
    "warm-up": "#a9c46c",
}
CORRELATED = {kind.split()[1]: kind for kind in KINDS if kind.startswith("correlated")}
DARK = ("periodic", CORRELATED["unclassed"], CORRELATED["long"])  # white text on them
GAP = 1.2  # mm between words above the bands
T_C = re.compile(r"correlated \(T_c (\S+) s\)")


@styled()
def verdict_figure(found: Found) -> Figure:
    """Uncertainty of one frame and of means of every series against the limits of good and usable,
    and the shares of the kinds of noise in that of one frame; word and sentence above.

    found: contents of verdict.json.
    """
    names = _shown(found["series"])
    series = {name: found["series"][name] for name in names}
    words = _words(found)
    keys = _keys(series)
    points = {name: _points(values) for name, values in series.items()}
    limits = _limits(points, found)
    text_height = lines_mm(len(words), BODY_PT) + 3.0
    top = text_height + lines_mm(1, SMALL_PT) + 1.5
    height = ROW_MM * max(len(names), 1)
    key_height = strip_height(keys[0], WIDTH_MM - 4) + strip_height(keys[1], WIDTH_MM - 4)
    below = 12.0
    title = f"{found['recording']}: {found['word']}"
    note = _note(found, names, _cut(points, limits))
    sheet = blank_sheet(top + height + below + key_height + 3.0, title, note)
    canvas = sheet.canvas(2.0, 1.5, WIDTH_MM - 4, text_height)
    for k, line in enumerate(words):
        at = text_height - lines_mm(k, BODY_PT)
        canvas.text(0, at, line, size=BODY_PT, va="top")
    width = WIDTH_MM - NAMES_MM - RIGHT_MM - (GAP_MM + BARS_MM if keys[1] else 0.0)
    axes = sheet.axes(NAMES_MM, top, width, height)
    _bands(axes, limits, found)
    _uncertainties(axes, series, points, limits)
    if keys[1]:
        _bars(sheet.axes(NAMES_MM + width + GAP_MM, top, BARS_MM, height), series)
    _strips(sheet, top + height + below, keys)
    return sheet.figure


def _strips(sheet: Sheet, top: float, keys: tuple[list[Entry], list[Entry]]) -> None:
    for entries in keys:
        strip(sheet, 2.0, top, WIDTH_MM - 4, entries)
        top += strip_height(entries, WIDTH_MM - 4) + 1.0


def _shown(series: Mapping[str, Found]) -> list[str]:
    """All series, or the most uncertain ones, in their order."""
    known = sorted(series, key=lambda k: -(series[k]["frame_mm"] or 0.0))[:MOST_ROWS]
    return [name for name in series if name in known]


def _words(found: Found) -> list[str]:
    lines: list[str] = []
    for sentence in sentences(found):
        lines += wrap(sentence, BODY_PT, WIDTH_MM - 8)
    return lines


def _note(found: Found, names: Sequence[str], cut: bool) -> str:
    twin = found.get("twin")
    source = f"twin {twin}: simulated" if twin else "measured"
    left_out = len(found["series"]) - len(names)
    lasting = duration_words(found["duration_s"])
    judged = "the verdict is on one frame in the worst coordinate"
    if found["word"] != _band(found):
        judged = (
            f"the bands are of these alone, the word is by the {found['decided_by']['quantity']}"
        )
    parts = [
        f"Source: {source}. {lasting} at {found['frame_rate_hz']:g} Hz.",
        f"Standard uncertainties about the mean of {duration_words(found['horizon_s'])}, "
        f"lines: {100 * found['confidence']:.3g} % intervals; {judged}.",
    ]
    if numbers := marker_numbers(found):
        parts.insert(1, shorten(numbers, SMALL_PT, 2 * WIDTH_MM))
    if cut:
        parts.append("Arrows: on beyond the axis.")
    if any(T_C.fullmatch(kind) for k in names for kind in found["series"][k]["shares"]):
        parts.append("Times in the bars: correlation times, classes after S 4.6.")
    measured = [k for k in names if found["series"][k]["basis"] == "measured"]
    if len(measured) == len(names):
        parts.append("All measured, without a model, so there are no shares of kinds of noise.")
    elif measured:
        parts.append(f"Measured, without a model: {', '.join(measured)}.")
    if left_out > 0:
        parts.append(f"{left_out} series with smaller uncertainties are not shown.")
    return " ".join(parts)


def _band(found: Found) -> str:
    """The word that one frame in the worst coordinate alone would have."""
    own = [v["frame_mm"] for k, v in found["series"].items() if COORDINATE.fullmatch(k)]
    worst = max((v for v in own if v is not None), default=math.inf)
    limits = found["limits_mm"]
    return next((word for word in ("good", "usable") if worst <= limits[word]), "bad")


Points = list[tuple[float, float, float] | None]


def _points(values: Found) -> Points:
    """(value, lower, upper) of every mark, None where there is none; an end that is not known is
    the value."""
    found: Points = []
    for _, key, _ in MARKS:
        if isinstance(key, int):
            own = values["means"][key]
            point = [own[k] for k in ("uncertainty_mm", "lower_mm", "upper_mm")]
        else:
            stem = "frame" if key == "frame" else "sigma_frame"
            point = [values[f"{stem}{end}_mm"] for end in ("", "_lower", "_upper")]
        value, low, high = point
        known = value is not None and np.isfinite(value) and value > 0
        found.append((value, low or value, high or value) if known else None)
    return found


def _limits(points: Mapping[str, Points], found: Found) -> tuple[float, float]:
    """Of the axis: all bands are on it, and intervals as far as `FARTHEST`."""
    good, usable = (found["limits_mm"][k] for k in ("good", "usable"))
    ends = [
        np.clip(p, p[0] / FARTHEST, p[0] * FARTHEST) for row in points.values() for p in row if p
    ]
    around = np.array([good / 2, usable * 3])
    low, high = log_limits([*ends, around], most_decades=MOST_DECADES)
    return min(low, good / 2), high


def _cut(points: Mapping[str, Points], limits: tuple[float, float]) -> bool:
    there = [p for row in points.values() for p in row if p]
    return any(p[1] < limits[0] or p[2] > limits[1] for p in there)


def _bands(axes: Axes, limits: tuple[float, float], found: Found) -> None:
    """Bands of the words, each word above its own; beside it where the band is too narrow."""
    low, high = limits
    width, height = size_mm(axes)
    edges = (low, found["limits_mm"]["good"], found["limits_mm"]["usable"], high)
    at = width * np.log(np.divide(edges, low)) / np.log(high / low)
    for word, left, right in zip(BAND_COLOURS, edges, edges[1:], strict=False):
        axes.axvspan(left, right, color=BAND_COLOURS[word], lw=0, zorder=0)
    weights = ["bold" if word == found["word"] else "normal" for word in BAND_COLOURS]
    room = [
        text_mm(w, SMALL_PT, weight) / 2 + GAP
        for w, weight in zip(BAND_COLOURS, weights, strict=True)
    ]
    middle = (at[1:] + at[:-1]) / 2
    middle[0] = min(middle[0], middle[1] - room[1] - room[0])
    middle[2] = max(middle[2], middle[1] + room[1] + room[2])
    for word, centre, weight in zip(BAND_COLOURS, middle, weights, strict=True):
        axes.text(
            centre / width,
            1 + 1.2 / height,
            word,
            transform=axes.transAxes,
            ha="center",
            size=SMALL_PT,
            weight=weight,
            color=INK if weight == "bold" else GREY,
        )


def _uncertainties(
    axes: Axes,
    series: Mapping[str, Found],
    points: Mapping[str, Points],
    limits: tuple[float, float],
) -> None:
    low, high = limits
    width, height = size_mm(axes)
    decade_axis(axes, "x", limits, width)
    shown = [k for k in range(len(MARKS)) if any(marks[k] for marks in points.values())]
    step = 1 / (len(shown) + 1)  # of a row
    for row, (name, marks) in enumerate(points.items()):
        for place, k in enumerate(shown, start=1):
            look, point = MARKS[k][2], marks[k]
            if point is None:
                continue
            at = row - 0.5 + place * step
            axes.plot(np.clip(point[1:], low, high), [at, at], color=look["color"], lw=1.0)
            axes.plot([point[0]], [at], ls="", **look)
            arrow: Keywords = {"color": look["color"], "ms": 3.5, "ls": "", "clip_on": False}
            if point[1] < low:
                axes.plot([low], [at], marker="<", **arrow)
            if point[2] > high:
                axes.plot([high], [at], marker=">", **arrow)
        if not any(marks):
            axes.text(
                *(np.sqrt(low * high), row),
                series[name]["status"],
                size=SMALL_PT,
                color=GREY,
                ha="center",
                va="center",
            )
    _rows(axes, series)
    axes.set_yticks(range(len(series)), list(series))
    axes.tick_params(axis="y", length=0)
    axes.text(
        0.5,
        -8.0 / height,
        "Standard uncertainty (mm)",
        transform=axes.transAxes,
        ha="center",
        size=BODY_PT,
    )


def _rows(axes: Axes, series: Mapping[str, Found]) -> None:
    axes.set_ylim(len(series) - 0.5, -0.5)
    for k in range(1, len(series)):
        axes.axhline(k - 0.5, color="white", lw=1.2, zorder=0.5)


def kind_of(share: str) -> tuple[str, str]:
    """Key of `KINDS` of a name of a share, and what to write into its bar."""
    correlated = T_C.fullmatch(share)
    if correlated:
        T_c = correlated[1]
        return CORRELATED[correlation_class(float(T_c))], f"$T_c$ {T_c} s"
    if share.startswith("periodic"):
        return "periodic", share[len("periodic (") : -1]
    return share, ""


def _fitting(text: str, room_mm: float) -> str:
    """The text, or without its symbol, or nothing: what a bar has room for."""
    shorter = (text, text.removeprefix("$T_c$ "))
    return next((t for t in shorter if text_mm(t.replace("$", ""), SMALL_PT) <= room_mm), "")


def _bars(axes: Axes, series: Mapping[str, Found]) -> None:
    order = list(KINDS)
    width, height = size_mm(axes)
    for row, values in enumerate(series.values()):
        left = 0.0
        shares = sorted(values["shares"].items(), key=lambda s: order.index(kind_of(s[0])[0]))
        for name, share in shares:
            kind, text = kind_of(name)
            colour = KINDS[kind]
            axes.barh(row, share, left=left, height=0.62, color=colour, ec="white", lw=0.4)
            text = _fitting(text, share * width - 1.0)
            if text:
                axes.text(
                    left + share / 2,
                    row,
                    text,
                    size=SMALL_PT,
                    ha="center",
                    va="center_baseline",
                    color="white" if kind in DARK else INK,
                    parse_math=True,
                )
            left += share
        if not shares:
            axes.text(0.5, row, "measured", size=SMALL_PT, color=GREY, ha="center", va="center")
    axes.set_xlim(0, 1)
    axes.set_xticks([0, 0.5, 1], ["0", "50", "100"])
    axes.set_ylim(len(series) - 0.5, -0.5)
    axes.set_yticks([])
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    axes.text(
        0.5,
        -8.0 / height,
        "Share of the variance of one frame (%)",
        transform=axes.transAxes,
        ha="center",
        size=BODY_PT,
    )


def _keys(series: Mapping[str, Found]) -> tuple[list[Entry], list[Entry]]:
    there = [any(column) for column in zip(*map(_points, series.values()), strict=True)]
    marks = [
        Entry(text, line={"color": look["color"], "lw": 1.0}, dot=look)
        for (text, _, look), shown in zip(MARKS, there, strict=False)
        if shown
    ]
    used = {kind_of(name)[0] for values in series.values() for name in values["shares"]}
    kinds = [Entry(k, patch={"color": c, "lw": 0}) for k, c in KINDS.items() if k in used]
    return marks, kinds
