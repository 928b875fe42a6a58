"""Coefficients side by side: a group a number of cameras or recording, a slot a series.

A mark is a row of a tidy frame: `group`, `series`, `coefficient` (h_0, T_c, ...), `number` (of its
Gauss-Markov term), `style` (a key of `STYLES`), `value`, `lower`, `upper` (NaN: no bar); beside
others `camera_type` and `source`, where these differ.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from mocap_metrology.noise.fit.estimates import CLASSES, DEFAULT_ESTIMATOR, S_ESTIMATOR, unit_key
from mocap_metrology.present.plot import figure as fig
from mocap_metrology.present.plot.curves import Limits, looks_of
from mocap_metrology.present.plot.figure import FAINT, GREY, INK, OTHER_LOOKS, SMALL_PT, Keywords
from mocap_metrology.present.text.numbers import power_of_ten

EMPTY_SLOTS = 1.6  # between groups
FLOOR, BAND_DECADES = 1e-20, 2.5  # smaller values are in a band below it, so many decades high
ROOM = 5.0  # factor from the numbers to the ends of a logarithmic axis
LONGEST = 100.0  # factor below its number, after which a bar on a logarithmic axis is cut
DOWN, UP = 7, 6  # carets of matplotlib, with their tips at the value
MOST_LABELS, MOST_CHARACTERS = 45, 80  # of groups, side by side across a page
RED, GREEN = "#7b2d8b", "#0a6b3d"
PUBLISHED, PALE = "published", "published, below its least standard error"
S_VALUE, S_END = S_ESTIMATOR, f"{S_ESTIMATOR}: end of the range searched"
VALUE, LIMIT = f"{DEFAULT_ESTIMATOR}, 95 % interval", "not detected, 95 % limit"
CLASS_LIMITS = {name: f"95 % limit, {name} $T_c$" for name, *_ in CLASSES}
KEYS = ("camera_type", "group", "series", "number", "source")  # of a term
STYLES: dict[str, Keywords] = {
    PUBLISHED: {"marker": "o", "color": INK, "ms": 3.6, "mfc": "none", "mew": 0.8},
    PALE: {"marker": "o", "color": OTHER_LOOKS[1].colour, "ms": 3.6, "mfc": "none", "mew": 0.35},
    S_VALUE: {"marker": "s", "color": RED, "ms": 2.2, "mew": 0},
    S_END: {"marker": "x", "color": RED, "ms": 2.4, "mew": 0.5},
    VALUE: {"marker": "_", "color": GREEN, "ms": 4.2, "mew": 1.1},
    LIMIT: {"marker": "v", "color": GREEN, "ms": 2.8, "mfc": "white", "mew": 0.6},
}
LETTERS = r"$\mathrm{s}$", r"$\mathrm{m}$", r"$\ell$"  # of the classes
for _text, _letter in zip(CLASS_LIMITS.values(), LETTERS, strict=True):
    STYLES[_text] = {"marker": _letter, "color": GREEN, "ms": 3.8, "mew": 0.1}


def mark(
    row: Mapping[str, Any], style: str, value: float | None, ends: Sequence[float | None] = ()
) -> dict[str, Any]:
    """A mark of a row that has `series` and `parameter`."""
    lower, upper = ends or (None, None)
    name, number = row["parameter"].partition(" ")[0], row["parameter"][3:]
    of_row = {"series": row["series"], "coefficient": unit_key(name), "number": number}
    return of_row | {"style": style, "value": value, "lower": lower, "upper": upper}


def estimate_mark(
    row: Mapping[str, Any], numbers: Sequence[float | None], limit_class: str | None
) -> dict[str, Any]:
    """The mark of an estimate with its interval (value, lower, upper), or of its upper limit."""
    value, *ends = numbers
    if value is None or np.isnan(value):
        return mark(row, CLASS_LIMITS.get(limit_class or "", LIMIT), ends[1])
    return mark(row, VALUE, value, ends)


def frame_of(marks: Sequence[Mapping[str, Any]]) -> pd.DataFrame:
    """Marks that have a value, as a tidy frame."""
    columns = [*KEYS, "coefficient", "style", "value", "lower", "upper"]
    frame = pd.DataFrame(marks, columns=columns)
    frame = frame.astype(dict.fromkeys(("value", "lower", "upper"), float))
    return frame[frame["value"].notna()]


def label_marks(axes: fig.Axes, marks: pd.DataFrame, series: Sequence[str] = ()) -> None:
    """Legend entries of the styles in use; of `series`, where these have a look each."""
    looks = {name[0] if fig.coordinate_of(name) else "L": v for name, v in looks_of(series).items()}
    for name, look in looks.items():
        axes.plot([], [], ls="", mew=0, color=look.colour, marker=look.marker, label=name)
    used = set(marks["style"])
    for style, how in STYLES.items():
        if style in used and not (series and style == VALUE):
            axes.plot([], [], ls="", label=style, **how | ({"color": INK} if series else {}))
    if series and VALUE in used:
        bar: Keywords = {"marker": "|", "ms": 7.0, "mew": 0.8, "ls": "", "color": INK}
        axes.plot([], [], label="95 % interval", **bar)
    axes.plot([], [], ls="", color=INK, marker=UP, ms=3.4, mew=0, label="continues beyond")


def group_axis(axes: fig.Axes, labels: Sequence[object]) -> None:
    """A group for each label, every second one shaded."""
    axes.set_xlim(-0.5, max(len(labels), 1) - 0.5)
    for k in range(1, len(labels), 2):
        axes.axvspan(k - 0.5, k + 0.5, color=FAINT, alpha=0.4, lw=0, zorder=0)
    texts = [fig.short(str(label)) for label in labels]
    every = max(-(-len(labels) // MOST_LABELS), 1)
    axes.set_xticks(range(0, len(labels), every), texts[::every])
    axes.tick_params(axis="x", length=0, labelrotation=90 if upright(texts) else 0)
    axes.grid(visible=False, axis="x")


def upright(labels: Sequence[str]) -> bool:
    """Whether labels side by side would touch."""
    return len(labels) * max(map(len, labels), default=0) > MOST_CHARACTERS


def floor_axis(axes: fig.Axes, marks: pd.DataFrame, floor: float = FLOOR) -> None:
    """A logarithmic y axis round the marks; those below the floor in a labelled band."""
    from matplotlib.ticker import LogLocator

    values = marks["value"][np.isfinite(marks["value"]) & (marks["value"] >= 0)]
    above = values[values >= floor]
    low, high = (above.min() / ROOM, above.max() * ROOM) if len(above) else (1e-3, 1.0)
    if len(above) == len(values):
        fig.log_axis(axes, "y", (low, high))
        return
    fig.log_axis(axes, "y", (floor * 10**-BAND_DECADES, high))
    ticks = LogLocator(numticks=5).tick_values(floor, high)
    ticks = [t for t in ticks if 30 * floor <= t <= high]
    least = f"< {power_of_ten(round(np.log10(floor)))}"
    axes.set_yticks([in_band(floor), *ticks], [least, *(fig.log_label(t, False) for t in ticks)])
    axes.axhspan(floor * 10**-BAND_DECADES, floor, color="#bdbdbd", alpha=0.45, lw=0, zorder=0.5)


def in_band(floor: float) -> float:
    """The height at which values smaller than the floor are drawn."""
    return floor * float(10 ** (-BAND_DECADES / 2))


def shade_classes(axes: fig.Axes, limits: Limits) -> None:
    """Shade the classes of T_c (S 4.6) on an axis of these limits, and name them."""
    how: Keywords = {"size": SMALL_PT, "color": GREY, "ha": "center", "va": "bottom"}
    how |= {"bbox": {"facecolor": "white", "alpha": 0.7, "lw": 0, "pad": 1}}
    for name, low, high in CLASSES:
        low, high = max(low, limits[0]), min(high, limits[1])
        if low < high:
            alpha = 0.9 if name == "medium" else 0.5
            axes.axvspan(low, high, color=FAINT, alpha=alpha, lw=0, zorder=0)
            place = axes.get_xaxis_transform()
            axes.text(float(np.sqrt(low * high)), 0.02, name, transform=place, **how)


def draw(
    axes: fig.Axes,
    marks: pd.DataFrame,
    groups: Sequence[object],
    names: Sequence[str],
    floor: float = 0.0,
    coloured: bool = False,
) -> None:
    """The marks of a panel whose axes have their limits, in the look of their style, or `coloured`
    in that of their series. An arrow shows what lies above the axis, and where a bar is cut: at the
    axis and, on a logarithmic one, far below its value."""
    if marks.empty:
        return
    bottom, top = axes.get_ylim()
    x = marks["group"].map(list(groups).index).astype(float)
    slot = marks["series"].map(list(names).index) - (len(names) - 1) / 2
    x += slot / (len(names) + EMPTY_SLOTS)
    looks = looks_of(names)
    colours = marks["series"].map(lambda name: looks[name].colour)
    colours = colours if coloured else marks["style"].map(lambda style: STYLES[style]["color"])
    y = marks["value"].where(marks["value"] >= floor, in_band(floor))
    limit = (marks["style"] == LIMIT) | marks["style"].isin(CLASS_LIMITS.values())
    inside, over = y <= top, (y > top) & ~limit  # a limit up there holds no information
    bars = inside & marks["lower"].notna() & marks["upper"].notna()
    least = np.maximum(y / LONGEST if axes.get_yscale() == "log" else bottom, bottom)
    low, high = marks["lower"].clip(lower=least), marks["upper"].clip(upper=top)
    axes.vlines(x[bars], low[bars], high[bars], colors=colours[bars].tolist(), lw=0.6)
    for colour in colours.unique():
        mask = colours == colour
        for which, at, sign in (
            (bars & (marks["lower"] < low), low, DOWN),
            ((bars & (marks["upper"] > top)) | over, pd.Series(top, y.index), UP),
        ):
            if (mask & which).any():  # where an empty line is, the layout would look for it
                how: Keywords = {"ls": "", "ms": 3.4, "mew": 0, "clip_on": False}
                axes.plot(x[mask & which], at[mask & which], marker=sign, color=colour, **how)
    for (style, colour), mask in marks[inside].groupby(["style", colours[inside]], sort=False):
        how = {"ls": ""} | STYLES[str(style)] | {"color": colour}
        if coloured and style == VALUE:
            how |= {"marker": looks[mask["series"].iloc[0]].marker, "ms": 4.2, "mew": 0}
        axes.plot(x[mask.index], y[mask.index], **how)


def terms_of(marks: pd.DataFrame) -> pd.DataFrame:
    """Gauss-Markov terms that have both numbers, out of marks: the columns that tell them apart,
    then `T_c`, `q_c`, and ends of their intervals `T_c_lower`, ...; `styles` of both."""
    pick = marks[marks["coefficient"].isin(["T_c", "q_c"])]
    pick = pick[~pick["style"].str.contains("limit")]
    ends = {"lower": "_lower", "upper": "_upper", "style": "_style", "value": ""}
    T_c, q_c = (
        pick[pick["coefficient"] == name].rename(columns={k: name + v for k, v in ends.items()})
        for name in ("T_c", "q_c")
    )
    return T_c.drop(columns="coefficient").merge(q_c.drop(columns="coefficient"), on=list(KEYS))
