"""One picture of the verdict on a recording: uncertainties against the limits, and their causes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd

from mocap_metrology.common.types import Record
from mocap_metrology.noise.assess.checks import COORDINATE
from mocap_metrology.present.plot import figure
from mocap_metrology.present.plot.curves import log_limits
from mocap_metrology.present.plot.figure import GREY, INK, SMALL_PT, Keywords
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import moment, with_unit
from mocap_metrology.present.text.sentence import render
from mocap_metrology.present.verdict import words

FARTHEST = 3.0  # an interval counts for the limits of the axis up to so many times the value
ROW_MM, CHECK_MM = 9.5, 5.5
LETTER = 0.024  # of the width of a bar of all
OF_FRAME = ("frame", "constant", "no_samples", "few_samples")  # codes of checks
OF_MEAN = ("uncertainty_mm", "lower_mm", "upper_mm")
SAID = ("duration_s", "frame_rate_hz", "horizon_s", "confidence", "decided_by")
MARKS: tuple[tuple[str, Keywords], ...] = (
    (words.FRAME, {"marker": "o", "color": INK, "mfc": INK, "ms": 4.2}),
    (words.NEAR, {"marker": "o", "color": GREY, "mfc": "white", "ms": 4.0}),
    (words.MEANS[0], {"marker": "s", "color": "#10307a", "mfc": "#10307a", "ms": 3.4}),
    (words.MEANS[1], {"marker": "^", "color": "#b03a20", "mfc": "#b03a20", "ms": 3.8}),
    (words.MEANS[2], {"marker": "D", "color": "#176f87", "mfc": "#176f87", "ms": 3.2}),
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
MOST = 24  # recordings drawn
BARS = "Error of the length of a bar (mm)"
NAME_MM = 5.5
ROOM = 5.0  # times the limits, that the axis reaches at least: for the words of the bands
BAND_COLOURS = {"good": "#eef5ea", "usable": "#fdf3d8", "bad": "#f9e3dc"}


@figure.styled()
def verdict_figure(verdict: Record) -> figure.Picture:
    """The figure of `captions.VERDICT`, and above it the checks that decided. verdict: contents of
    verdict.json."""
    series = verdict["series"]
    names = words.shown_series(verdict)
    kinds, checks = _kinds(verdict, names), _other_checks(verdict)
    first, *others = words.sentences(verdict)
    heights = {"checks": CHECK_MM * (len(checks) + 1), "marks": ROW_MM * len(names) + 15.0}
    heights = heights if checks else {"marks": heights["marks"]}
    columns = ["marks", "kinds"] if len(kinds) else ["marks"]
    mosaic: list[Any] = [["checks"] * len(columns)] * bool(checks) + [columns]
    said = {name: verdict[name] for name in SAID}
    source = [render("verdict.source", twin=verdict.get("twin"), **said), *words.left_out(verdict)]
    texts = figure.Texts(f"{verdict['recording']}: {verdict['word']}", " ".join(source))
    body = figure.new_figure(texts, 35.0 + sum(heights.values()))
    head = f"Deciding quantity: {verdict['decided_by']['quantity']}. {first}"
    how: Keywords = {"x": 0.01, "ha": "left", "fontsize": 8.5, "weight": "normal", "wrap": True}
    body.suptitle(figure.wrapped(head), **how)
    ratios: Keywords = {"height_ratios": list(heights.values())}
    panels = body.subplot_mosaic(mosaic, width_ratios=[1.6, 1.0][: len(columns)], **ratios)
    if checks:
        _draw_checks(panels["checks"], checks)
    of_frame = verdict["decided_by"]["code"] in OF_FRAME
    _draw_marks(panels["marks"], verdict, names, verdict["word"] if of_frame else "")
    if len(kinds):
        _draw_kinds(panels["kinds"], kinds, names)
    figure.legend_below(body, [panels[name] for name in columns])
    facts: Keywords = {"of_frame": of_frame, "markers": words.marker_numbers(verdict)}
    facts |= {"times": kinds["label"].isin(list(CORRELATED.values())).any(), "n": len(names)}
    facts["measured"] = [name for name in names if series[name]["basis"] == "measured"]
    note = render("verdict.note", **said, **facts)
    return figure.Picture(body, " ".join([captions.VERDICT, *others, note]))


def _other_checks(verdict: Record) -> list[Record]:
    """The check that decided and those that cap the word, besides those of one frame, and events,
    where the word is not good."""
    every = [verdict["decided_by"] | {"word": verdict["word"]}, *verdict["caps"]]
    of_frame = (*OF_FRAME, "upper_end")
    checks = [one for one in every if one["word"] != "good" and one["code"] not in of_frame]
    events = [one for one in verdict.get("findings", []) if one["code"] == "event"]
    if events and verdict["word"] != "good":
        more = f" and {len(events) - 1} more" if events[1:] else ""
        name = f"event at {moment(events[0]['value'])} ({events[0]['series']}){more}"
        checks.append({"quantity": name, "series": "", "value": "", "limit": "", "word": ""})
    return checks


def _draw_checks(axes: figure.Axes, checks: list[Record]) -> None:
    """A row a check: value over limit on a logarithmic scale, and both in words."""
    inside: Keywords = {"transform": axes.get_yaxis_transform(), "va": "center", "size": SMALL_PT}
    for row, check in enumerate(checks):
        value, limit = check["value"], check["limit"]
        told = value if isinstance(value, str) else ""
        if all(isinstance(x, int | float) and math.isfinite(x) for x in (value, limit)):
            times, unit = (100, "%") if check["quantity"][:5] == "share" else (1, check["unit"])
            told = f"{value * times:.3g}, limit {limit * times:.3g} {unit}".strip()
            if value > 0 and limit > 0:
                ratio = np.clip(value / limit, 0.1, 10.0)
                axes.plot([ratio], [row], marker="D", ms=4, color=INK, clip_on=False)
        name = ", ".join(filter(None, [check["quantity"], check["series"]]))
        axes.text(0.008, row, figure.clipped(name, 60), **inside)
        axes.text(0.992, row, told, ha="right", **inside)
        colour = BAND_COLOURS.get(check["word"], "white")
        axes.axhspan(row - 0.5, row + 0.5, color=colour, lw=0, zorder=0)
    axes.axvline(1.0, color=GREY, lw=0.8)
    axes.set(xlim=(10**-5.0, 10**2.4), xscale="log", ylim=(len(checks) - 0.5, -0.5), yticks=[])
    axes.set_xticks([0.1, 1.0, 10.0], ["1/10", "limit", "10 times"], size=SMALL_PT)
    axes.minorticks_off()
    axes.grid(visible=False)


def _marks(verdict: Record, names: list[str]) -> pd.DataFrame:
    """Rows `name`, `mark` (place in `MARKS`), `value`, `lower`, `upper` (mm) of what is known."""
    rows = []
    for name in names:
        values = verdict["series"][name]
        every = [[values[f"{stem}{end}_mm"] for end in ("", "_lower", "_upper")]
                 for stem in ("frame", "sigma_frame")]  # fmt: skip
        every += [[mean[key] for key in OF_MEAN] for mean in values["means"]]
        rows += [(name, mark, *three) for mark, three in enumerate(every)]
    marks = pd.DataFrame(rows, columns=["name", "mark", "value", "lower", "upper"])
    marks = marks.astype({"value": float, "lower": float, "upper": float})
    for end in ("lower", "upper"):
        marks[end] = marks[end].where(marks[end] > 0, marks["value"])
    return marks[marks["value"] > 0]


def _draw_marks(axes: figure.Axes, verdict: Record, names: list[str], bold: str) -> None:
    """A row a series: every mark with its interval, a ring round the one that decided, and words
    where nothing is known."""
    marks, limits_mm = _marks(verdict, names), verdict["limits_mm"]
    near = marks["value"] / FARTHEST, marks["value"] * FARTHEST
    ends = [marks[end].clip(*near).to_numpy() for end in ("lower", "upper")]
    limits = axis_limits(ends, limits_mm)
    figure.log_axis(axes, "x", limits)
    draw_bands(axes, limits, limits_mm, bold)
    shown = sorted(marks["mark"].unique())
    decided = verdict["decided_by"]
    for place, (mark, rows) in enumerate(marks.groupby("mark"), start=1):
        label, look = MARKS[int(str(mark))]
        at = rows["name"].map(names.index) + place / (len(shown) + 1) - 0.5
        axes.hlines(at, rows["lower"], rows["upper"], color=look["color"], lw=1.0)
        axes.plot(rows["value"], at, ls="", label=label, **look)
    ring = marks[(marks["mark"] == 0) & (marks["name"] == decided["series"])]
    if len(ring) and decided["code"] in (*OF_FRAME, "upper_end"):
        how: Keywords = {"marker": "o", "ms": 9, "mfc": "none", "mec": INK, "ls": ""}
        row = names.index(decided["series"]) + 1 / (len(shown) + 1) - 0.5
        axes.plot(ring["value"], [row], label="decides the verdict", **how)
    for row, name in enumerate(names):
        axes.axhline(row - 0.5, color="white", lw=1.2, zorder=0.5)
        if name not in set(marks["name"]):
            how = {"size": SMALL_PT, "color": GREY, "ha": "center", "va": "center"}
            axes.text(math.sqrt(math.prod(limits)), row, verdict["series"][name]["status"], **how)
    axes.set_xlabel("Standard uncertainty (mm)")
    figure.name_axis(axes, names, "y")


def _kinds(verdict: Record, names: list[str]) -> pd.DataFrame:
    """Rows `row`, `label` (of `KINDS`), `share`, `start` of its bar, `text`; from fast to slow."""
    rows = []
    for row, name in enumerate(names):
        for one in verdict["series"][name].get("kinds", []):
            label = CORRELATED.get(one["class"], one["kind"])
            text = with_unit(one["T_c_s"], "s") if one["T_c_s"] else ""
            text = with_unit(one["f_hz"], "Hz") if one["f_hz"] else text
            text = text if one["share"] > (len(text) + 1) * LETTER else ""
            rows.append((row, label, one["share"], text))
    kinds = pd.DataFrame(rows, columns=["row", "label", "share", "text"]).astype({"share": float})
    kinds["label"] = pd.Categorical(kinds["label"], list(KINDS))
    kinds = kinds.sort_values(["row", "label"], kind="stable")
    kinds["start"] = kinds.groupby("row")["share"].cumsum() - kinds["share"]
    return kinds


def _draw_kinds(axes: figure.Axes, kinds: pd.DataFrame, names: list[str]) -> None:
    """Stacked bars; correlation times and frequencies where there is room."""
    for label, rows in kinds.groupby("label", observed=True):
        edge: Keywords = {"color": KINDS[str(label)], "label": label, "ec": "white", "lw": 0.4}
        bars = axes.barh(rows["row"], rows["share"], 0.62, rows["start"], **edge)
        colour = "white" if label in DARK else INK
        axes.bar_label(bars, rows["text"], label_type="center", size=SMALL_PT, color=colour)
    for row in set(range(len(names))) - set(kinds["row"]):
        axes.text(0.5, row, "measured", size=SMALL_PT, color=GREY, ha="center", va="center")
    axes.set(xlim=(0, 1), xlabel="Share of the variance of one frame (%)")
    axes.set(ylim=(len(names) - 0.5, -0.5), yticks=[])
    axes.set_xticks([0, 0.5, 1], ["0", "50", "100"])
    axes.grid(visible=False)
    axes.spines[["top", "right", "left"]].set_visible(False)


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


def draw_bands(
    axes: figure.Axes, limits: tuple[float, float], words_mm: Record, bold: str = ""
) -> None:
    """Bands of the words with the words above, one of them bold. words_mm: limits of `good` and
    `usable`."""
    good, usable = words_mm["good"], words_mm["usable"]
    ends = limits[0], good, usable, limits[1]
    places = (limits[0], "left"), (math.sqrt(good * usable), "center"), (limits[1], "right")
    bands = zip(BAND_COLOURS.items(), pairwise(ends), places, strict=True)
    for (word, colour), span, (at, side) in bands:
        axes.axvspan(*span, color=colour, lw=0, zorder=0)
        where: Keywords = {"xycoords": axes.get_xaxis_transform(), "ha": side, "size": SMALL_PT}
        where |= {"xytext": (0, 3), "textcoords": "offset points"}
        look = ("bold", INK) if word == bold else ("normal", GREY)
        axes.annotate(word, (at, 1.0), weight=look[0], color=look[1], **where)


def wrong_length(row: Record) -> tuple[float, float, float] | None:
    """What the word of a certified bar is of, thrice, mm; None of other recordings."""
    bar = row.get("bar")
    return (bar["size_mm"],) * 3 if bar and bar["certificate"] else None


@figure.styled()
def overview_figure(rows: Sequence[Record], texts: figure.Texts) -> figure.Picture:
    """A row a recording, in the order given, at most `MOST` at rest and as many of bars."""
    points = (("Standard uncertainty of one frame (mm)", worst_frame), (BARS, wrong_length))
    panels = [
        (label, shown)
        for label, point in points
        if (shown := [(row, at) for row in rows if (at := point(row))][:MOST])
    ]
    if not panels:
        return figure.words_picture("No recording has an uncertainty of a frame.", texts)
    counts = [len(shown) for _, shown in panels]
    body = figure.new_figure(texts, 22.0 * len(panels) + NAME_MM * sum(counts))
    places = body.subplots(len(panels), 1, squeeze=False, height_ratios=counts)[:, 0]
    for axes, (label, shown) in zip(places, panels, strict=True):
        _against_limits(axes, shown)
        axes.set_xlabel(label)
    twins = any(row["source"] == "twin" for _, shown in panels for row, _ in shown)
    more = len(rows) - sum(counts)
    bars = f" {captions.OVERVIEW_BARS}" if panels[-1][0] == BARS else ""
    hollow = " Hollow: a simulated stand-in (twin)." if twins else ""
    left_out = f" Not shown, as without that number: {more}." if more else ""
    return figure.Picture(body, f"{captions.OVERVIEW}{bars}{hollow}{left_out}")


def _against_limits(
    axes: figure.Axes, shown: Sequence[tuple[Record, tuple[float, float, float]]]
) -> None:
    words_mm = shown[0][0]["limits_mm"]
    limits = axis_limits([np.array(point) for _, point in shown], words_mm)
    figure.log_axis(axes, "x", limits)
    draw_bands(axes, limits, words_mm)
    for place, (row, (value, lower, upper)) in enumerate(shown):
        colour = figure.VERDICT_WORDS.get(row["word"], (figure.GREY, ""))[0]
        face = "white" if row["source"] == "twin" else colour
        axes.hlines(place, lower, upper, color=colour, lw=1.2)
        axes.plot([value], [place], marker="o", ms=5, mec=colour, mfc=face)
    figure.name_axis(axes, [row["recording"] for row, _ in shown], "y", size=figure.SMALL_PT)
