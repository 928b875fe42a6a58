"""Figure of a facility over its takes: a strip a series."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mocap_metrology.present.plot import figure as plot
from mocap_metrology.present.plot.units import length_unit
from mocap_metrology.present.text.sentence import render

if TYPE_CHECKING:
    from matplotlib.axes import Axes

STRIP_MM, HEAD_MM = 27.0, 28.0
BAND = "#1a809d"
# Colour and marker of a word, in the order in which they are drawn
LOOKS = {
    "learning": (plot.GREY, "o"),
    "provisional": ("#5b7fc4", "o"),
    "pass": ("#0d2a6b", "o"),
    "note": ("#b7791f", "s"),
    "alert": ("#c2410c", "^"),
    "failure": ("#991b1b", "X"),
}
OPEN = ("learning", "provisional")  # of which most are in the baseline
NUMBERS = ("value_mm", "mean_mm", "lower_mm", "upper_mm")

Columns = dict[str, np.ndarray]


@plot.styled()
def chart(rows: Sequence[Mapping[str, Any]], title: str, source: str) -> plot.Picture:
    """Values, baseline and tolerance of each series over the dates; rows: of `words.table`."""
    from matplotlib.dates import AutoDateLocator, ConciseDateFormatter, date2num

    names = list(dict.fromkeys(row["series"] for row in rows))
    body = plot.new_figure(title, source, HEAD_MM + STRIP_MM * max(len(names), 1))
    if not names:
        plot.say(body.subplots(), "no take")
        return plot.Picture(body, render("chart.caption"))
    strips = body.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0]
    for axes, name in zip(strips, names, strict=True):
        own = [row for row in rows if row["series"] == name]
        columns = {key: np.array([row[key] for row in own]) for key in own[0] if key not in NUMBERS}
        columns |= {key: np.array([row[key] for row in own], dtype=float) for key in NUMBERS}
        columns["day"] = np.asarray(date2num(columns["date"].astype("datetime64[s]")))
        _strip(axes, name, columns)
    locator = AutoDateLocator(minticks=2, maxticks=6)
    strips[-1].xaxis.set_major_locator(locator)
    strips[-1].set_xticks(locator())  # once: they are costly, and the same in all strips
    strips[-1].xaxis.set_major_formatter(ConciseDateFormatter(locator))
    said = {row["word"] for row in rows}
    for word in (word for word in LOOKS if word in said):
        colour, marker = LOOKS[word]
        how: plot.Keywords = {"edgecolor": colour, "marker": marker, "label": word}
        strips[-1].scatter([], [], s=16, facecolor="white" if word in OPEN else colour, **how)
    plot.legend_below(body, strips)
    return plot.Picture(body, render("chart.caption"))


def _strip(axes: Axes, name: str, own: Columns) -> None:
    """One series. A place or length is drawn about the first mean of its baseline."""
    starts = [0, *np.flatnonzero(own["restart"] == "yes").tolist()]
    about = 0.0
    for start, end in zip(starts, [*starts[1:], own["day"].size], strict=True):
        if name not in ("jitter", "wander"):
            known = [*own["mean_mm"][start:end], *own["value_mm"][start:end]]
            about = float(np.round(next((v for v in known if np.isfinite(v)), 0.0), 1))
        for key in NUMBERS:
            own[key][start:end] -= about
    shown = np.concatenate([own["value_mm"], own["lower_mm"][-1:], own["upper_mm"][-1:]])
    shown = shown[np.isfinite(shown)]
    unit = length_unit([np.ptp(shown)] if shown.size else [])
    value, mean, lower, upper = (unit.per_mm * own[key] for key in NUMBERS)
    day, word = own["day"], own["word"]
    for start, end in zip(starts, [*starts[1:], day.size], strict=True):
        at = slice(start, end)
        axes.fill_between(day[at], lower[at], upper[at], color=BAND, alpha=0.15, lw=0)
        axes.plot(day[at], mean[at], color=BAND, lw=0.9)
        for edge in (lower, upper):
            wide = np.where(own["capable"][at] == "no", edge[at], np.nan)
            axes.plot(day[at], wide, color=BAND, lw=0.8, ls="--")
        if start:
            axes.axvline(day[start], color=plot.INK, lw=0.8)
    size = float(np.clip(300 / np.sqrt(day.size), 3, 16))
    axes.scatter(day[word == ""], value[word == ""], s=2, color=plot.GREY)
    learnt = own["in_baseline"] == "yes"
    for name_, (colour, marker) in LOOKS.items():
        for face, of in (("white", learnt), (colour, ~learnt)):
            if (chosen := (word == name_) & of).any():
                how: plot.Keywords = {"s": size, "marker": marker, "linewidths": 0.8, "zorder": 3}
                axes.scatter(day[chosen], value[chosen], facecolor=face, edgecolor=colour, **how)
    plot.panel_title(axes, plot.literal(name), f"zero at {about:.1f} mm" if about else "")
    axes.set_ylabel(unit.symbol)
    if shown.size and np.ptp(shown) > 0:
        room = 0.08 * np.ptp(shown)
        low, high = shown.min() - room, shown.max() + room
        axes.set_ylim(unit.per_mm * low, unit.per_mm * high)
