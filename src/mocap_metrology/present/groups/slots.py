"""Panels of coefficients against the number of cameras: a group a number, a slot a series."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mocap_metrology.noise.fit.estimates import CLASSES, DEFAULT_ESTIMATOR, S_ESTIMATOR
from mocap_metrology.noise.twins.published import SERIES
from mocap_metrology.present.plot import figure as plot
from mocap_metrology.present.plot.curves import Limits
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
EMPTY_SLOTS = 1.6  # between groups
FLOOR, BAND_DECADES = 1e-20, 2.5  # smaller values are in a band below it, so many decades high
ROOM = 5.0  # factor from the numbers to the ends of a logarithmic axis
SOURCES = {"regenerated": "#7b2d8b", "likelihood": "#0a6b3d"}  # colours; published: black
PUBLISHED: Keywords = {
    **{"marker": "o", "color": INK, "markersize": 4.4, "markerfacecolor": "none", "mew": 0.9},
    "ls": "",
}
UNSUPPORTED: Keywords = PUBLISHED | {"color": OTHER_LOOKS[1].colour, "mew": 0.4}
_REGENERATED: Keywords = {"color": SOURCES["regenerated"], "ls": ""}
REGENERATED: Keywords = {"marker": "s", "markersize": 2.6, "mew": 0, **_REGENERATED}
AT_END: Keywords = {"marker": "x", "markersize": 2.8, "mew": 0.6, **_REGENERATED}
LIKELIHOOD: Keywords = {
    **{"marker": "_", "color": SOURCES["likelihood"], "markersize": 5.6, "mew": 1.2, "ls": ""}
}
COLOURED: Keywords = {"markersize": 4.2, "mew": 0, "ls": ""}
OPEN: Keywords = {"markerfacecolor": "white", "mew": 0.7, "ls": ""}
LIMIT: Keywords = {"marker": "v", "color": INK, "markersize": 3.6, **OPEN}
# A limit of q_c is drawn as the letter of its class of T_c
LETTERS = {"short": r"$\mathrm{s}$", "medium": r"$\mathrm{m}$", "long": r"$\ell$"}
LETTER: Keywords = {"markersize": 4.8, "mew": 0.2, "ls": ""}
INTERVAL: Keywords = {"color": INK, "lw": 0.7}
DOWN, UP = 7, 6  # carets of matplotlib, with their tips at the value
CUT: Keywords = {"markersize": 3.4, "mew": 0, "ls": ""}  # arrow of a bar or number beyond the axis
LONGEST = 100.0  # factor below its number, after which a bar on a logarithmic axis is cut

SLOT_PT = 6.0  # of the letters of series below their slots
MOST_LABELS, MOST_CHARACTERS = 45, 80  # of groups, side by side across a page

Scale = Callable[[np.ndarray], np.ndarray]


def look_of(series: str) -> Look:
    """Look of a series: by coordinate; the distance black."""
    found = coordinate_of(series)
    return LOOKS[found[0]] if found else OTHER_LOOKS[0]


def label_series(axes: Axes, names: Sequence[str]) -> None:
    """Legend entries of each coordinate that there is, and of the distances."""
    looks: dict[str, Look] = {}
    for name in names:
        looks.setdefault(name[0] if coordinate_of(name) else "L", look_of(name))
    for name, look in looks.items():
        axes.plot([], [], ls="", mew=0, color=look.colour, marker=look.marker, label=name)


def label_intervals(axes: Axes) -> None:
    """Legend entries of intervals."""
    bar: Keywords = {"marker": "|", "markersize": 7.0, "mew": 0.8, "ls": "", "color": INK}
    axes.plot([], [], label="95 % interval", **bar)
    axes.plot([], [], color=INK, marker=DOWN, label="interval continues", **CUT)


def label_limits(axes: Axes, classes: bool = False, **how: Any) -> None:
    """Legend entries of upper limits of what was not detected; classes: those of q_c."""
    if not classes:
        axes.plot([], [], label="not detected, 95 % limit", **LIMIT | how)
    for name, letter in LETTERS.items() if classes else ():
        look = LETTER | {"color": INK, "marker": letter} | how
        axes.plot([], [], label=f"95 % limit, {name} $T_c$", **look)


def label_sources(axes: Axes, classes: bool = False) -> None:
    """Legend entries of published numbers, of those of S's estimator, and of the default ones."""
    for text, how in (
        ("published", PUBLISHED),
        ("published, below its least standard error", UNSUPPORTED),
        (S_ESTIMATOR, REGENERATED),
        (f"{S_ESTIMATOR}: end of the range searched", AT_END),
        (f"{DEFAULT_ESTIMATOR}, 95 % interval", LIKELIHOOD),
    ):
        axes.plot([], [], label=text, **how)
    label_limits(axes, classes, color=SOURCES[DEFAULT_ESTIMATOR])
    axes.plot([], [], color=INK, marker=UP, label="continues beyond", **CUT)


def group_axis(axes: Axes, labels: Sequence[object], series: Sequence[str] = ()) -> None:
    """A group for each label (of `draw`), every second one shaded; `series`: letters below the
    slots."""
    axes.set_xlim(-0.5, max(len(labels), 1) - 0.5)
    for k in range(1, len(labels), 2):
        axes.axvspan(k - 0.5, k + 0.5, color=FAINT, alpha=0.4, lw=0, zorder=0)
    texts = [plot.short(str(label)) for label in labels]
    every = -(-len(labels) // MOST_LABELS)
    axes.set_xticks(range(0, len(labels), every or 1), texts[:: every or 1])
    axes.tick_params(axis="x", length=0, labelrotation=90 if upright(texts) else 0)
    axes.grid(visible=False, axis="x")
    if series:
        places = [(k + x, n[0]) for k in range(len(labels)) for n, x in offsets(series).items()]
        axes.set_xticks([x for x, _ in places], [letter for _, letter in places], minor=True)
        axes.xaxis.remove_overlapping_locs = False  # the middle slot is over its number
        axes.tick_params(axis="x", which="minor", length=0, labelsize=SLOT_PT, pad=1)
        axes.tick_params(axis="x", which="major", pad=9)


def upright(labels: Sequence[str]) -> bool:
    """Whether labels side by side would touch."""
    return len(labels) * max(map(len, labels), default=0) > MOST_CHARACTERS


def floor_axis(axes: Axes, limits: Limits, ticks: int = 5, floor: float = FLOOR) -> None:
    """A logarithmic y axis of so many ticks at most; below the floor a labelled band."""
    from matplotlib.ticker import FixedLocator, FuncFormatter, LogFormatterMathtext, LogLocator

    plot.log_axis(axes, "y", limits)
    if limits[0] < floor:
        axes.axhspan(limits[0], floor, color="#bdbdbd", alpha=0.45, lw=0, zorder=0.5)
        decades = LogLocator(numticks=ticks).tick_values(100 * floor, limits[1])
        room = in_band(floor) * (limits[1] / limits[0]) ** 0.2  # for the label of the band
        shown = [float(v) for v in decades if room < v < limits[1]]
        powers = LogFormatterMathtext()
        powers.set_axis(axes.yaxis)
        least = rf"$<10^{{{np.log10(floor):.0f}}}$"
        axes.yaxis.set_major_locator(FixedLocator([in_band(floor), *shown]))
        axes.yaxis.set_major_formatter(
            FuncFormatter(lambda v, at: powers(v, at) if v > floor else least)
        )


def in_band(floor: float = FLOOR) -> float:
    """Where smaller values than the floor are drawn: in the middle of the band below it."""
    return floor * float(10 ** (-BAND_DECADES / 2))


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


def floor_limits(rows: Sequence[Row], floor: float = FLOOR) -> Limits:
    """Logarithmic limits round the numbers and upper limits shown; below the floor a band."""
    ends = [row[f"{DEFAULT_ESTIMATOR}_upper_95"] for row in rows if row[DEFAULT_ESTIMATOR] is None]
    limits = np.array([v for v in ends if v is not None], dtype=np.float64)
    values = np.concatenate([column_values(rows), limits])
    values = values[np.isfinite(values) & (values >= 0)]
    above = values[values >= floor]
    if not above.size:
        return floor * 10**-BAND_DECADES, floor * 1e3
    low, high = above.min() / ROOM, above.max() * ROOM
    if above.size < values.size:
        low = floor * 10**-BAND_DECADES
    return float(low), float(high)


def raised(values: np.ndarray, floor: float = FLOOR) -> np.ndarray:
    """Values to draw on a logarithmic axis: those below the floor in the middle of the band."""
    return np.where(values < floor, in_band(floor), values)


def draw(
    axes: Axes,
    rows: Sequence[Row],
    cameras: Sequence[int | str],
    scale: Scale,
    names: Sequence[str] = SERIES,
    coloured: bool = False,
) -> None:
    """Published, regenerated and default numbers of the rows of one camera type; `scale` turns
    numbers into what the axis shows; `names`: series, a slot each. Every source has its own colour,
    or, `coloured`, the default numbers alone are drawn, in the look of their series. An arrow shows
    what lies above the axis, and where a bar is cut."""
    group = {n: k for k, n in enumerate(cameras)}
    slot = offsets(names)
    if coloured:
        for look in dict.fromkeys(look_of(series) for series in names):
            own = [row for row in rows if look_of(row["series"]) == look]
            how = COLOURED | {"color": look.colour, "marker": look.marker}
            _draw_default(axes, _places(own, group, slot), own, scale, how)
        return
    x, published, found = (
        _places(rows, group, slot),
        *(_values(rows, column) for column in ("published", "regenerated")),
    )
    pale, ended = (
        np.array([of(row) for row in rows], dtype=bool)
        for of in (lambda row: row["supported"] is False, at_end)
    )
    _plot(axes, x[pale], published[pale], scale, **UNSUPPORTED)
    _plot(axes, x[~pale], published[~pale], scale, **PUBLISHED)
    _plot(axes, x[~ended], found[~ended], scale, **REGENERATED)
    _plot(axes, x[ended], found[ended], scale, **AT_END)
    _draw_default(axes, x, rows, scale, LIKELIHOOD)


def _places(rows: Sequence[Row], group: Mapping[Any, int], slot: Mapping[str, float]) -> np.ndarray:
    return np.array([group[row["n_cameras"]] + slot[row["series"]] for row in rows])


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
    above = scale(np.nan_to_num(high)) > axes.get_ylim()[1]  # without information there
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
