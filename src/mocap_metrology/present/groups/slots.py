"""Panels of coefficients against the number of cameras: a group a number, a slot a series."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mocap_metrology.noise.fit.estimates import CLASSES, DEFAULT_ESTIMATOR, S_ESTIMATOR
from mocap_metrology.noise.twins.published import SERIES
from mocap_metrology.present.drawing.axes import Limits, decade_axis
from mocap_metrology.present.drawing.legend import Entry
from mocap_metrology.present.drawing.style import WIDTH_MM, Sheet, label_axes, size_mm
from mocap_metrology.present.plot import figure as plot
from mocap_metrology.present.plot.figure import (
    FAINT,
    GREY,
    INK,
    LOOKS,
    OTHER_LOOKS,
    SMALL_PT,
    Keywords,
    Look,
    coordinate_of,
)
from mocap_metrology.present.tables import Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TYPES = ("T40", "Bonita", "Vantage")
LEFT_MM, GAP_MM, RIGHT_MM = 17.0, 9.0, 3.0
PANEL_MM = (WIDTH_MM - LEFT_MM - RIGHT_MM - 2 * GAP_MM) / 3
NAME_MM = 17.5  # right of wide panels, for what they are of
WIDE_MM = WIDTH_MM - LEFT_MM - NAME_MM
CLOSE_MM, GROUPS_MM = 1.5, 7.5  # between the panels of a block, and below it
EMPTY_SLOTS = 1.6  # between groups
FLOOR, BAND_DECADES = 1e-20, 2.5  # smaller values stand in a band below it, so many decades high
IN_BAND = FLOOR * 10 ** (-BAND_DECADES / 2)
ROOM = 5.0  # factor from the numbers to the ends of a logarithmic axis
PALE = 0.4  # opacity of published numbers below their least standard error
PUBLISHED: Keywords = {"markersize": 4.8, "markerfacecolor": "none", "mew": 0.8, "ls": ""}
REGENERATED: Keywords = {"markersize": 2.6, "mew": 0, "ls": ""}
AT_END: Keywords = {"marker": "x", "markersize": 2.8, "mew": 0.6, "ls": ""}
LIKELIHOOD: Keywords = {"marker": "_", "color": INK, "markersize": 5.6, "mew": 1.1, "ls": ""}
COLOURED: Keywords = {"markersize": 4.2, "mew": 0, "ls": ""}
OPEN: Keywords = {"markerfacecolor": "white", "mew": 0.7, "ls": ""}
LIMIT: Keywords = {"marker": "v", "color": INK, "markersize": 3.6, **OPEN}
# A limit of q_c is drawn as the letter of its class of T_c
LETTERS = {"short": r"$\mathrm{s}$", "medium": r"$\mathrm{m}$", "long": r"$\ell$"}
LETTER: Keywords = {"markersize": 4.8, "mew": 0.2, "ls": ""}
INTERVAL: Keywords = {"color": INK, "lw": 0.7}
DOWN, UP = 7, 6  # carets of matplotlib, their tips where they stand
CUT: Keywords = {"markersize": 3.4, "mew": 0, "ls": ""}  # arrow of a bar or number that goes on
LONGEST = 100.0  # factor below its number, after which a bar on a logarithmic axis is cut

MOST_LABELS, MOST_CHARACTERS = 45, 80  # of groups, side by side across a page

Scale = Callable[[np.ndarray], np.ndarray]


def look_of(series: str) -> Look:
    """Look of a series: by coordinate; the distance black."""
    found = coordinate_of(series)
    return LOOKS[found[0]] if found else OTHER_LOOKS[0]


def key_entries(arrow: int = DOWN) -> list[Entry]:
    """What colours, shapes and fillings mean; arrow: `DOWN` or `UP`, where the axis cuts."""
    entries = series_entries(("x1", "y1", "z1", "L"))
    look, grey = look_of("x1"), {"color": GREY}
    entries.append(Entry("published", dot=_dot(look, markerfacecolor="none") | grey))
    pale = _dot(look, markerfacecolor="none", alpha=PALE) | grey
    entries.append(Entry("published, less than its least standard error", dot=pale))
    entries.append(Entry(S_ESTIMATOR, dot=_dot(look, markersize=2.6, mew=0) | grey))
    end = {k: v for k, v in AT_END.items() if k != "ls"}
    entries.append(Entry(f"{S_ESTIMATOR}: end of the range searched", dot=end | grey))
    bar = {k: v for k, v in LIKELIHOOD.items() if k != "ls"}
    entries.append(Entry(f"{DEFAULT_ESTIMATOR}, 95 % interval", dot=bar))
    entries.append(Entry(f"{DEFAULT_ESTIMATOR}: not detected, 95 % limit", dot=_arrow()))
    entries.append(Entry("goes on beyond", dot=_cut() | {"marker": arrow}))
    return entries


def series_entries(names: Sequence[str]) -> list[Entry]:
    """An entry for each coordinate that there is, and for the distance."""
    looks: dict[str, Look] = {}
    for name in names:
        looks.setdefault(name[0] if coordinate_of(name) else "L", look_of(name))
    return [Entry(k, dot=_dot(look, markersize=3.5, mew=0)) for k, look in looks.items()]


def label_series(axes: Axes, names: Sequence[str]) -> None:
    """Legend entries of each coordinate that there is, and of the distances."""
    looks: dict[str, Look] = {}
    for name in names:
        looks.setdefault(name[0] if coordinate_of(name) else "L", look_of(name))
    for name, look in looks.items():
        axes.plot([], [], ls="", mew=0, color=look.colour, marker=look.marker, label=name)


def label_intervals(axes: Axes, estimator: str = "") -> None:
    """Legend entries of intervals of the default estimator; its name, where others are drawn."""
    bar: Keywords = {"marker": "|", "markersize": 7.0, "mew": 0.8, "ls": "", "color": INK}
    how = LIKELIHOOD if estimator else bar
    axes.plot([], [], label=f"{estimator} 95 % interval".strip(), **how)
    axes.plot([], [], color=INK, marker=DOWN, label="interval goes on", **CUT)


def label_limits(axes: Axes, classes: bool = False) -> None:
    """Legend entries of its upper limits of what it did not detect; classes: those of q_c."""
    if not classes:
        axes.plot([], [], label="not detected, 95 % limit", **LIMIT)
    for name, letter in LETTERS.items() if classes else ():
        axes.plot([], [], color=INK, marker=letter, label=f"95 % limit, {name} $T_c$", **LETTER)


def label_sources(axes: Axes) -> None:
    """Legend entries of published numbers and of those of S's estimator."""
    of_x: Keywords = {"color": GREY, "marker": LOOKS["x"].marker}
    axes.plot([], [], label="published", **of_x, **PUBLISHED)
    text = "published, below its least standard error"
    axes.plot([], [], alpha=PALE, label=text, **of_x, **PUBLISHED)
    axes.plot([], [], label=S_ESTIMATOR, **of_x, **REGENERATED)
    text = f"{S_ESTIMATOR}: end of the range searched"
    axes.plot([], [], color=GREY, label=text, **AT_END)


def group_axis(axes: Axes, labels: Sequence[object]) -> None:
    """A group for each label (of `draw`), every second one shaded."""
    axes.set_xlim(-0.5, max(len(labels), 1) - 0.5)
    for k in range(1, len(labels), 2):
        axes.axvspan(k - 0.5, k + 0.5, color=FAINT, alpha=0.4, lw=0, zorder=0)
    texts = [plot.short(str(label)) for label in labels]
    every = -(-len(labels) // MOST_LABELS)
    axes.set_xticks(range(0, len(labels), every or 1), texts[:: every or 1])
    axes.tick_params(axis="x", length=0, labelrotation=90 if upright(texts) else 0)
    axes.grid(visible=False, axis="x")


def upright(labels: Sequence[str]) -> bool:
    """Whether labels side by side would touch."""
    return len(labels) * max(map(len, labels), default=0) > MOST_CHARACTERS


def floor_axis(axes: Axes, limits: Limits) -> None:
    """A logarithmic y axis; where it goes below FLOOR, a band that says so."""
    from matplotlib.ticker import FixedLocator, FuncFormatter, LogFormatterMathtext, LogLocator

    plot.log_axis(axes, "y", limits)
    if limits[0] < FLOOR:
        axes.axhspan(limits[0], FLOOR, color="#bdbdbd", alpha=0.45, lw=0, zorder=0.5)
        decades = LogLocator(numticks=5).tick_values(100 * FLOOR, limits[1])
        shown = [float(v) for v in decades if 100 * FLOOR < v < limits[1]]
        powers = LogFormatterMathtext()
        powers.set_axis(axes.yaxis)
        axes.yaxis.set_major_locator(FixedLocator([IN_BAND, *shown]))
        axes.yaxis.set_major_formatter(
            FuncFormatter(lambda v, at: powers(v, at) if v > FLOOR else r"$<10^{-20}$")
        )


def _arrow() -> Keywords:
    return {k: v for k, v in LIMIT.items() if k != "ls"}


def _cut() -> Keywords:
    return {"marker": DOWN, "color": INK, "markersize": CUT["markersize"], "mew": 0}


def _dot(look: Look, **how: object) -> Keywords:
    return {"color": look.colour, "marker": look.marker, "markersize": 4.8, "mew": 0.8} | how


def panel_axes(sheet: Sheet, column: int, top: float, height: float) -> Axes:
    """Axes of one panel of three in a row."""
    return sheet.axes(LEFT_MM + column * (PANEL_MM + GAP_MM), top, PANEL_MM, height)


def block_mm(row_mm: float) -> float:
    """Height of a block of `block_axes`, with the labels of its groups."""
    return len(TYPES) * (row_mm + CLOSE_MM) - CLOSE_MM + GROUPS_MM


def block_axes(sheet: Sheet, top: float, row_mm: float, label: str) -> list[Axes]:
    """A wide panel for each camera type, one below the other, named on the right; `label` is that
    of their vertical axes."""
    found = []
    for k, name in enumerate(TYPES):
        axes = sheet.axes(LEFT_MM, top + k * (row_mm + CLOSE_MM), WIDE_MM, row_mm)
        how: Keywords = {"transform": axes.transAxes, "va": "top", "weight": "bold"}
        axes.text(1 + 1.5 / WIDE_MM, 1.0, name, **how)
        label_axes(axes, y=label if k == 1 else "", y_mm=14.0)
        found.append(axes)
    return found


def camera_axis(axes: Axes, cameras: Sequence[int | str], labels: bool) -> None:
    """A group for each number of cameras, every second one shaded."""
    from matplotlib.ticker import FixedLocator, FuncFormatter

    count = max(len(cameras), 1)
    axes.set_xlim(-0.5, count - 0.5)
    for k in range(1, count, 2):
        axes.axvspan(k - 0.5, k + 0.5, color=FAINT, alpha=0.4, lw=0, zorder=0)
    axes.xaxis.set_major_locator(FixedLocator(range(len(cameras))))
    names = dict(enumerate(cameras))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda v, _p: str(names.get(round(v), ""))))
    axes.tick_params(axis="x", length=0, labelbottom=labels)


def shade_classes(axes: Axes, limits: Limits) -> None:
    """Shade the classes of T_c (S 4.6) on an axis of these limits, and name them."""
    for name, low, high in CLASSES:
        low, high = max(low, limits[0]), min(high, limits[1])
        if low >= high:
            continue
        axes.axvspan(low, high, color=FAINT, alpha=0.9 if name == "medium" else 0.5, lw=0, zorder=0)
        how: Keywords = {"size": SMALL_PT, "color": GREY, "ha": "center", "va": "bottom"}
        how |= {"bbox": {"facecolor": "white", "alpha": 0.7, "lw": 0, "pad": 1}}
        place = axes.get_xaxis_transform()
        axes.text(float(np.sqrt(low * high)), 0.02, name, transform=place, **how)


def column_values(rows: Sequence[Row]) -> np.ndarray:
    """All numbers that a panel of these rows shows, without interval ends and limits."""
    values = [row[k] for row in rows for k in ("published", "regenerated", DEFAULT_ESTIMATOR)]
    return np.array([v for v in values if v is not None], dtype=np.float64)


def floor_limits(rows: Sequence[Row]) -> Limits:
    """Logarithmic limits round the numbers and upper limits shown; a band below FLOOR if any."""
    ends = [row[f"{DEFAULT_ESTIMATOR}_upper_95"] for row in rows if row[DEFAULT_ESTIMATOR] is None]
    limits = np.array([v for v in ends if v is not None], dtype=np.float64)
    values = np.concatenate([column_values(rows), limits])
    values = values[np.isfinite(values) & (values >= 0)]
    above = values[values >= FLOOR]
    if not above.size:
        return FLOOR * 10**-BAND_DECADES, FLOOR * 1e3
    low, high = above.min() / ROOM, above.max() * ROOM
    if above.size < values.size:
        low = FLOOR * 10**-BAND_DECADES
    return float(low), float(high)


def log_axis(axes: Axes, limits: Limits, height: float, labels: bool) -> None:
    """Decades; where the axis goes below FLOOR, a band that says so."""
    from matplotlib.ticker import FixedLocator

    decade_axis(axes, "y", limits, height)
    if limits[0] < FLOOR:
        axes.axhspan(limits[0], FLOOR, color="#bdbdbd", alpha=0.45, lw=0, zorder=0.5)
        ticks = np.asarray(axes.get_yticks())
        axes.yaxis.set_major_locator(
            FixedLocator(ticks[ticks > FLOOR * 10].tolist())
        )  # room for its label
        if labels:
            how: Keywords = {"size": SMALL_PT - 1, "color": GREY, "ha": "right", "va": "center"}
            place = axes.get_yaxis_transform()
            axes.text(-1.5 / size_mm(axes)[0], IN_BAND, "< 10⁻²⁰", transform=place, **how)
    axes.tick_params(labelleft=labels)


def raised(values: np.ndarray) -> np.ndarray:
    """Values to draw on a logarithmic axis: those below FLOOR at the middle of the band."""
    return np.where(values < FLOOR, IN_BAND, values)


def draw(
    axes: Axes,
    rows: Sequence[Row],
    cameras: Sequence[int | str],
    scale: Scale,
    names: Sequence[str] = SERIES,
    coloured: bool = False,
) -> None:
    """Published, regenerated and default numbers of the rows of one camera type; `scale` turns
    numbers into what the axis shows; `names`: series, a slot each. The default numbers are black
    bars, or `coloured`: with the look of their series. What lies above the axis, and what a bar is
    cut of, is told by an arrow."""
    group = {n: k for k, n in enumerate(cameras)}
    slot = offsets(names)
    for look in dict.fromkeys(look_of(series) for series in names):
        own = [row for row in rows if look_of(row["series"]) == look]
        if not own:
            continue
        x = np.array([group[row["n_cameras"]] + slot[row["series"]] for row in own])
        shape = {"color": look.colour, "marker": look.marker}
        pale = np.array([row["supported"] is False for row in own])
        published = _values(own, "published")
        for which, alpha in ((pale, PALE), (~pale, 1.0)):
            values = np.where(which, published, np.nan)
            _plot(axes, x, values, scale, alpha=alpha, **shape, **PUBLISHED)
        found, ended = _values(own, "regenerated"), np.array([at_end(row) for row in own])
        _plot(axes, x, np.where(ended, np.nan, found), scale, **shape, **REGENERATED)
        _plot(axes, x, np.where(ended, found, np.nan), scale, **shape | AT_END)
        _draw_default(axes, x, own, scale, COLOURED | shape if coloured else LIKELIHOOD)


def at_end(row: Row) -> bool:
    """Whether S's estimator ended at a limit of its search, which is no estimate."""
    return row.get("regenerated_status") == "at_bound"


def offsets(names: Sequence[str]) -> dict[str, float]:
    """Where the slot of each series is, from the middle of its group and in groups."""
    pitch = 1 / (len(names) + EMPTY_SLOTS)
    return {name: (j - (len(names) - 1) / 2) * pitch for j, name in enumerate(names)}


def _draw_default(
    axes: Axes, x: np.ndarray, rows: Sequence[Row], scale: Scale, how: Keywords
) -> None:
    value = _values(rows, DEFAULT_ESTIMATOR)
    low, high = (_values(rows, f"{DEFAULT_ESTIMATOR}_{end}") for end in ("lower_95", "upper_95"))
    known = np.isfinite(value) & np.isfinite(low) & np.isfinite(high)
    if known.any():
        _bars(axes, x[known], [v[known] for v in (value, low, high)], scale, how["color"])
    _plot(axes, x, value, scale, **how)
    above = scale(np.nan_to_num(high)) > axes.get_ylim()[1]  # says nothing there
    limits = np.where(np.isnan(value) & ~above, high, np.nan)
    kinds = np.array([row.get("limit_class") or "" for row in rows])
    for kind in sorted(set(kinds)):
        shape = LETTER | {"marker": LETTERS[kind]} if kind else LIMIT
        own = np.where(kinds == kind, limits, np.nan)
        _plot(axes, x, own, scale, **shape | {"color": how["color"]})


def _bars(
    axes: Axes, x: np.ndarray, numbers: Sequence[np.ndarray], scale: Scale, colour: str
) -> None:
    """From the lower to the upper ends, cut at the axis and, on a logarithmic one, far below."""
    value, low, high = (np.maximum(v, 0) for v in numbers)
    if axes.get_yscale() == "log":
        low = np.maximum(low, value / LONGEST)
    bottom, top = axes.get_ylim()
    shown, (low, high) = scale(value), (scale(v) for v in (low, high))
    down = (low > scale(np.maximum(numbers[1], 0))) | (low < bottom)
    low, over = np.maximum(low, bottom), (high > top) & (shown <= top)
    high = np.where(shown <= top, np.minimum(high, top), low)
    axes.vlines(x, low, high, **INTERVAL | {"color": colour})
    for which, y, marker in ((down, low, DOWN), (over, high, UP)):
        if which.any():  # where an empty line is, the layout would look for it
            axes.plot(x[which], y[which], marker=marker, color=colour, **CUT, clip_on=False)


def _plot(axes: Axes, x: np.ndarray, y: np.ndarray, scale: Scale, **how: Any) -> None:
    x, y = x[np.isfinite(y)], scale(y[np.isfinite(y)])
    top = axes.get_ylim()[1]
    for beyond, look in ((False, how), (True, CUT | {"marker": UP, "color": how["color"]})):
        own = (y > top) == beyond
        if own.any():
            axes.plot(x[own], np.minimum(y[own], top), **look, clip_on=not beyond)


def _values(rows: Sequence[Row], column: str) -> np.ndarray:
    return np.array([np.nan if r[column] is None else r[column] for r in rows], dtype=np.float64)
