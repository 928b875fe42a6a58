"""One picture of the verdict on a recording: uncertainties against the limits, and their causes."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.assess.checks import COORDINATE
from mocap_metrology.noise.fit.estimates import correlation_class
from mocap_metrology.present.plot.curves import log_limits
from mocap_metrology.present.plot.figure import (
    GREY,
    INK,
    SMALL_PT,
    Keywords,
    Picture,
    legend_below,
    log_axis,
    new_figure,
    styled,
    wrapped,
)
from mocap_metrology.present.tables import Record
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import duration_words, moment
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

MOST_ROWS = 24
MOST_DECADES = 6.0  # of the axis: farther down there are rounding errors only
FARTHEST = 3.0  # an interval counts for the limits of the axis up to so many times the value
ROW_MM = 9.5
CHECK_MM, LONGEST = 5.5, 60  # of a row of another check; letters of its name
LETTER = 0.024  # of the width of a bar of all
WIDE_MM, NARROW_MM, USABLE_MM = 155.0, 85.0, 11.0  # of the axes alone, or beside bars; of a word
OF_FRAME = ("uncertainty of one frame", "upper end of the interval of one frame")
BAND_COLOURS = {"good": "#eef5ea", "usable": "#fdf3d8", "bad": "#f9e3dc"}
MARKS: tuple[tuple[str, str | int, Keywords], ...] = (
    (FRAME, "frame", {"marker": "o", "color": INK, "mfc": INK, "ms": 4.2}),
    (NEAR, "near", {"marker": "o", "color": GREY, "mfc": "white", "ms": 4.0}),
    (MEANS[0], 0, {"marker": "s", "color": "#10307a", "mfc": "#10307a", "ms": 3.4}),
    (MEANS[1], 1, {"marker": "^", "color": "#b03a20", "mfc": "#b03a20", "ms": 3.8}),
    (MEANS[2], 2, {"marker": "D", "color": "#176f87", "mfc": "#176f87", "ms": 3.2}),
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
    "slow wander": "#b48a78",
}
CORRELATED = {kind.split()[1]: kind for kind in KINDS if kind.startswith("correlated")}
DARK = ("periodic", CORRELATED["unclassed"], CORRELATED["long"])  # white text on them
T_C = re.compile(r"correlated \(T_c (\S+) s\)")


@styled()
def verdict_figure(found: Found) -> Picture:
    """Uncertainty of one frame and of means of every series against the limits of good and usable,
    and the shares of the kinds of noise in that of one frame; above, the check that decided.

    found: contents of verdict.json.
    """
    names = _shown(found["series"])
    series = {name: found["series"][name] for name in names}
    points = {name: _points(values) for name, values in series.items()}
    limits = _limits(points, found)
    first, *others = sentences(found)
    checks = _other_checks(found)
    above = CHECK_MM * len(checks) + (CHECK_MM if checks else 0.0)
    high = ROW_MM * len(names)
    title = f"{found['recording']}: {found['word']}"
    body = new_figure(title, _source(found), 50.0 + high + above)
    how: Keywords = {"x": 0.01, "ha": "left", "fontsize": 8.5, "weight": "normal", "wrap": True}
    body.suptitle(wrapped(f"Deciding quantity: {found['decided_by']['quantity']}. {first}"), **how)
    bars = any(values["shares"] for values in series.values())
    widths = [1.6, 1.0][: 1 + bars]
    heights = [above, high + 15.0] if checks else [1.0]
    grid = body.add_gridspec(len(heights), len(widths), width_ratios=widths, height_ratios=heights)
    panels = [body.add_subplot(grid[-1, 0])]
    panels += [body.add_subplot(grid[-1, 1], sharey=panels[0])] if bars else []
    if checks:
        _checks(body.add_subplot(grid[0, :]), checks, found)
    log_axis(panels[0], "x", limits)
    decided = found["word"] if found["word"] == _band(found) else ""
    draw_bands(panels[0], limits, found["limits_mm"], NARROW_MM if bars else WIDE_MM, decided)
    _uncertainties(panels[0], points, limits)
    _rows(panels[0], series, points)
    _ring(panels[0], found, points)
    if bars:
        _bars(panels[1], series)
    legend_below(body, panels)
    note = _note(found, names, _cut(points, limits))
    return Picture(body, " ".join([captions.VERDICT, *others, note]))


def _other_checks(found: Found) -> list[Found]:
    """The check that decided and those that cap the word, besides those of one frame, and events,
    where the word is not good."""
    every = [found["decided_by"] | {"word": found["word"]}, *found.get("caps", [])]
    checks = [c for c in every if c["word"] != "good" and c["quantity"] not in OF_FRAME]
    events = [one for one in found.get("findings", []) if one["code"] == "event"]
    if events and found["word"] != "good":
        first = events[0]
        more = f" and {len(events) - 1} more" if events[1:] else ""
        named = f"event at {moment(first['value'])} ({first['series']}){more}"
        checks.append({"quantity": named, "series": "", "value": None, "limit": None, "word": ""})
    return checks


def _checks(axes: Axes, checks: Sequence[Found], found: Found) -> None:
    """A row a check: value over limit on a logarithmic scale, and both in words."""
    axes.set(xlim=(10**-5.0, 10**2.4), xscale="log", ylim=(len(checks) - 0.5, -0.5))
    axes.axvline(1.0, color=GREY, lw=0.8)
    inside: Keywords = {"transform": axes.get_yaxis_transform(), "va": "center", "size": SMALL_PT}
    for row, check in enumerate(checks):
        name = ", ".join(filter(None, [check["quantity"], check["series"]]))
        name = name if len(name) < LONGEST else f"{name[: LONGEST - 3]}..."
        axes.text(0.008, row, name, **inside)
        value, limit = check["value"], check["limit"]
        if check["word"]:
            axes.axhspan(row - 0.5, row + 0.5, color=BAND_COLOURS[check["word"]], lw=0, zorder=0)
        both = all(isinstance(x, int | float) and math.isfinite(x) for x in (value, limit))
        words = ""
        if both:
            share = check["quantity"].startswith("share")
            times, unit = (100, "%") if share else (1, check["unit"])
            words = f"{value * times:.3g}, limit {limit * times:.3g} {unit}".strip()
        if both and value > 0 and limit > 0:
            at = float(np.clip(value / limit, 0.1, 10.0))
            axes.plot([at], [row], marker="D", ms=4, color=INK, clip_on=False)
        elif check["word"] and not both and isinstance(value, str):
            words = value
        axes.text(0.992, row, words, ha="right", **inside)
    axes.set_yticks([])
    axes.set_xticks([0.1, 1.0, 10.0], ["1/10", "limit", "10 times"])
    axes.minorticks_off()
    axes.tick_params(axis="y", length=0)
    axes.tick_params(axis="x", labelsize=SMALL_PT)
    axes.grid(visible=False)


def _shown(series: Mapping[str, Found]) -> list[str]:
    """All series, or the most uncertain ones, in their order."""
    known = sorted(series, key=lambda k: -(series[k]["frame_mm"] or 0.0))[:MOST_ROWS]
    return [name for name in series if name in known]


def _source(found: Found) -> str:
    origin = f"simulated stand-in (twin) {found['twin']}" if found.get("twin") else "measured"
    lasting = duration_words(found["duration_s"])
    return f"Source: {origin}, {lasting} at {found['frame_rate_hz']:g} Hz."


def _note(found: Found, names: Sequence[str], cut: bool) -> str:
    """What the caption adds of this recording."""
    left_out = len(found["series"]) - len(names)
    judged = "the verdict refers to one frame in the worst coordinate"
    if found["word"] != _band(found):
        judged = (
            "the bands refer to these alone; the word depends on the "
            f"{found['decided_by']['quantity']}"
        )
    parts = [
        f"Standard uncertainties about the mean of {duration_words(found['horizon_s'])}, "
        f"lines: {100 * found['confidence']:.3g} % intervals; {judged}.",
    ]
    if numbers := marker_numbers(found):
        parts.append(numbers)
    if cut:
        parts.append("Arrows: the interval extends beyond the axis.")
    if any(T_C.fullmatch(kind) for k in names for kind in found["series"][k]["shares"]):
        parts.append("Times in the bars: correlation times, classes after S 4.6.")
    measured = [k for k in names if found["series"][k]["basis"] == "measured"]
    if len(measured) == len(names):
        parts.append(
            "All values are measured without a model, so the variance is not divided into "
            "kinds of noise."
        )
    elif measured:
        parts.append(f"Measured, without a model: {', '.join(measured)}.")
    if left_out > 0:
        parts.append(f"{left_out} series with smaller uncertainties are not shown.")
    return " ".join(parts)


def _band(found: Found) -> str:
    """The verdict for a single frame in the worst coordinate."""
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


def draw_bands(
    axes: Axes,
    limits: tuple[float, float],
    words_mm: Record,
    width_mm: float = WIDE_MM,
    bold: str = "",
) -> None:
    """Bands of the words, each word above its own, apart where the band between is narrow; one of
    them bold. words_mm: limits of `good` and `usable`."""
    low, high = limits
    good, usable = words_mm["good"], words_mm["usable"]
    for word, left, right in zip(
        BAND_COLOURS, (low, good, usable), (good, usable, high), strict=True
    ):
        axes.axvspan(left, right, color=BAND_COLOURS[word], lw=0, zorder=0)
    between = width_mm * math.log(usable / good) / math.log(high / low)
    aside = max(USABLE_MM - between, 0.0) / 2 / 25.4 * 72 + 3  # points
    places = ((good, -aside, "right"), (math.sqrt(good * usable), 0, "center"))
    for word, (at, shift, side) in zip(
        BAND_COLOURS, (*places, (usable, aside, "left")), strict=True
    ):
        axes.annotate(
            word,
            (at, 1.0),
            xytext=(shift, 3),
            xycoords=axes.get_xaxis_transform(),
            textcoords="offset points",
            ha=side,
            size=SMALL_PT,
            weight="bold" if word == bold else "normal",
            color=INK if word == bold else GREY,
        )


def _places(points: Mapping[str, Points]) -> dict[int, float]:
    """Number of each mark that occurs -> its place within a row, up and down from the middle."""
    shown = [k for k in range(len(MARKS)) if any(marks[k] for marks in points.values())]
    return {k: (n + 1) / (len(shown) + 1) - 0.5 for n, k in enumerate(shown)}


def _uncertainties(axes: Axes, points: Mapping[str, Points], limits: tuple[float, float]) -> None:
    """Every mark of every series with its interval; arrows where it continues beyond the axis."""
    low, high = limits
    for k, place in _places(points).items():
        text, _, look = MARKS[k]
        own = [(row + place, p) for row, marks in enumerate(points.values()) if (p := marks[k])]
        at = np.array([y for y, _ in own])
        value, lower, upper = np.array([p for _, p in own]).T
        ends = np.clip([lower, upper], low, high)
        axes.hlines(at, *ends, color=look["color"], lw=1.0)
        axes.plot(value, at, ls="", label=text, **look)
        arrow: Keywords = {"color": look["color"], "ms": 3.5, "ls": "", "clip_on": False}
        for beyond, edge, sign in ((lower < low, low, "<"), (upper > high, high, ">")):
            if beyond.any():
                axes.plot(np.full(int(beyond.sum()), edge), at[beyond], marker=sign, **arrow)


def _rows(axes: Axes, series: Mapping[str, Found], points: Mapping[str, Points]) -> None:
    """A name a row, white lines between, and words where nothing is known."""
    for row, (name, marks) in enumerate(points.items()):
        if row:
            axes.axhline(row - 0.5, color="white", lw=1.2, zorder=0.5)
        if not any(marks):
            middle = math.sqrt(math.prod(axes.get_xlim()))
            how: Keywords = {"size": SMALL_PT, "color": GREY, "ha": "center", "va": "center"}
            axes.text(middle, row, series[name]["status"], **how)
    axes.set(ylim=(max(len(series), 1) - 0.5, -0.5), xlabel="Standard uncertainty (mm)")
    axes.set_yticks(range(len(series)), list(series))
    axes.tick_params(axis="y", length=0)
    axes.grid(visible=False, axis="y")


def _ring(axes: Axes, found: Found, points: Mapping[str, Points]) -> None:
    """Round the point that decided, where it is one of these."""
    decided, name = found["decided_by"], found["decided_by"]["series"]
    if decided["quantity"] in OF_FRAME and (point := points.get(name, [None])[0]):
        row = list(points).index(name) + _places(points)[0]
        ring: Keywords = {"marker": "o", "ms": 9, "mfc": "none", "mec": INK, "mew": 1.0, "ls": ""}
        axes.plot([point[0]], [row], label="decides the verdict", **ring)


def kind_of(share: str) -> tuple[str, str]:
    """Key of `KINDS` of a name of a share, and what to write into its bar."""
    correlated = T_C.fullmatch(share)
    if correlated:
        T_c = correlated[1]
        return CORRELATED[correlation_class(float(T_c))], f"$T_c$ {T_c} s"
    if share.startswith("periodic"):
        return "periodic", share[len("periodic (") : -1]
    return share, ""


def _bars(axes: Axes, series: Mapping[str, Found]) -> None:
    """Shares of the kinds of noise, from fast to slow; correlation times where there is room."""
    ends = np.zeros(len(series))
    for kind, colour in KINDS.items():
        label: str | None = kind
        for row, values in enumerate(series.values()):
            for name, share in values["shares"].items():
                if kind_of(name)[0] != kind:
                    continue
                edge: Keywords = {"ec": "white", "lw": 0.4, "height": 0.62}
                axes.barh(row, share, left=ends[row], color=colour, label=label, **edge)
                label = None
                _write(axes, kind_of(name)[1], ends[row] + share / 2, row, share, kind)
                ends[row] += share
    for row, values in enumerate(series.values()):
        if not values["shares"]:
            how: Keywords = {"size": SMALL_PT, "color": GREY, "ha": "center", "va": "center"}
            axes.text(0.5, row, "measured", **how)
    axes.set(xlim=(0, 1), xlabel="Share of the variance of one frame (%)")
    axes.set_xticks([0, 0.5, 1], ["0", "50", "100"])
    axes.tick_params(axis="y", length=0, labelleft=False)
    axes.grid(visible=False)
    axes.spines[["top", "right", "left"]].set_visible(False)


def _write(axes: Axes, text: str, x: float, row: int, share: float, kind: str) -> None:
    """A text in a bar, without its symbol or not at all where the bar is short."""
    bare = text.removeprefix("$T_c$ ")
    text = text if share > (len(bare) + 4) * LETTER else bare
    if share > (len(bare) + 1) * LETTER:
        colour = "white" if kind in DARK else INK
        how: Keywords = {"size": SMALL_PT, "ha": "center", "va": "center_baseline"}
        axes.text(x, row, text, color=colour, **how)
