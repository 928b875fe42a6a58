"""Linear and logarithmic axes: limits, round ticks and their labels, units, a fan of slopes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.present.drawing.style import (
    FAINT,
    GREY,
    INK,
    SMALL_PT,
    Keywords,
    lines_mm,
    text_mm,
    tick_text,
)
from mocap_metrology.present.text.numbers import power_of_ten

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def round_ticks(low: float, high: float, most: int) -> np.ndarray:
    """At least two, and at most `most`, multiples of 1, 2 or 5 times a power of ten within the
    limits; where none of these steps gives that, every so many of the next finer ones."""
    step = 10.0 ** np.floor(np.log10((high - low) / most))
    finer = np.array([low, high])
    for factor in (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50):
        ticks: np.ndarray = np.arange(
            np.ceil(low / (step * factor)), np.floor(high / (step * factor)) + 1
        )
        ticks = ticks * (step * factor) + 0.0  # no -0
        if ticks.size < 2:
            odd = most > 2 and finer.size % 2  # then there is one in the middle
            return finer[:: finer.size // 2] if odd else finer[[0, -1]]
        if ticks.size <= most:
            return ticks
        finer = ticks
    return finer[[0, -1]]


def linear_axis(axes: Axes, which: str, limits: tuple[float, float], most: int) -> None:
    """Limits, at most so many ticks, a grid at them."""
    from matplotlib.ticker import FixedLocator, FuncFormatter

    getattr(axes, f"set_{which}lim")(limits)
    line = getattr(axes, f"{which}axis")
    line.set_major_locator(FixedLocator(round_ticks(*limits, most).tolist()))
    line.set_major_formatter(FuncFormatter(lambda value, _position: tick_text(value)))
    line.grid(visible=True)


LABEL_WIDTH_MM, LABEL_HEIGHT_MM = 7.5, 4.0
PAD = 0.1  # decades beyond the data
PLAIN = (-3, 3)  # decades written out as 0.001 ... 1000
FINE_MM = 9.0  # a decade this wide shows ticks at 2 ... 9
LONG_LABEL_PT, LONG_LABEL_MM = 7.0, 11.0  # of 5×10⁻³: a size for the y axis, a width for the x axis
Limits = tuple[float, float]


def log_limits(
    arrays: Iterable[np.ndarray], least_decades: float = 1.0, most_decades: float = np.inf
) -> Limits:
    """Limits around all positive finite values, `least_decades` apart; (0.1, 10) without any.

    `most_decades` caps how far down they go, for rounding errors of a constant series are positive
    too.
    """
    values = np.concatenate([np.zeros(0), *(np.asarray(a, float).ravel() for a in arrays)])
    values = values[np.isfinite(values) & (values > 0)]
    if not values.size:
        return 0.1, 10.0
    low, high = np.log10(values.min()), np.log10(values.max())
    low = max(low, high - most_decades)
    low, high = low - PAD, high + PAD
    missing = max(least_decades - (high - low), 0.0)
    return float(10 ** (low - missing / 2)), float(10 ** (high + missing / 2))


def decade_axis(
    axes: Axes, which: str, limits: Limits, length_mm: float, plain: bool | None = None
) -> None:
    """Make one axis logarithmic: grid and labels at decades, at every second one where crowded, and
    at 2 and 5 too where there are few; at two places at least. plain: labels are 0.01 and not 10⁻²;
    by default where the limits are near 1."""
    from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

    low, high = np.log10(limits)
    per_decade = length_mm / (high - low)
    if plain is None:
        plain = PLAIN[0] <= low and high < PLAIN[1] + 0.7
    major = labelled(limits, length_mm, which, plain)
    whole = np.arange(np.floor(low), np.floor(high) + 1)
    between = np.outer(10.0**whole, np.arange(1, 10)).ravel()
    minor = between if per_decade >= FINE_MM else 10.0**whole

    getattr(axes, f"set_{which}scale")("log")
    getattr(axes, f"set_{which}lim")(limits)
    line = getattr(axes, f"{which}axis")
    line.set_major_locator(FixedLocator(major.tolist()))
    line.set_minor_locator(NullLocator())
    line.set_major_formatter(FuncFormatter(lambda value, _position: decade_label(value, plain)))
    if which == "y" and not plain and not _decades_only(major):
        axes.tick_params(axis="y", labelsize=LONG_LABEL_PT, length=2.0, pad=2.0)
    line.grid(visible=True, which="major")
    _minor_ticks(axes, which, np.setdiff1d(_inside(minor, limits), major))


def labelled(limits: Limits, length_mm: float, which: str, plain: bool) -> np.ndarray:
    """Where an axis has its labels. Decades, every so many where crowded. Where there is no more
    than one (no more than two if they are written out), 2 and 5 too, if there is room; within less
    than that evenly, as on a linear axis; of what is too crowded the ends."""
    low, high = np.log10(limits)
    per_decade = length_mm / (high - low)
    room = LABEL_WIDTH_MM if which == "x" else LABEL_HEIGHT_MM
    between = LONG_LABEL_MM if which == "x" and not plain else room
    whole = np.arange(np.floor(low), np.floor(high) + 1)
    decades = _inside(10.0**whole, limits)
    step = max(int(np.ceil(room / per_decade)), 1)
    every: np.ndarray = decades[np.round(np.log10(decades)) % step == 0]
    if every.size > 2 or (every.size == 2 and not plain):
        return every
    few = _inside(np.outer(10.0**whole, [1, 2, 5]).ravel(), limits)
    if per_decade > 4 * between and few.size > 1:
        return few
    ticks = next((t for t in (every, decades, few) if t.size > 1), round_ticks(*limits, 4))
    crowded = np.diff(np.log10(ticks)).min() * per_decade < between
    return ticks[[0, -1]] if crowded else ticks


def _decades_only(ticks: np.ndarray) -> bool:
    exponents = np.log10(ticks)
    return bool(np.allclose(exponents, np.round(exponents), atol=1e-6))


def _minor_ticks(axes: Axes, which: str, ticks: np.ndarray) -> None:
    """All of them as the markers of one line: matplotlib's own are an artist each, and slow."""
    how: Keywords = {"ls": "", "ms": 1.5, "mew": 0.4, "color": GREY, "clip_on": False}
    zero = np.zeros(ticks.size)
    if which == "x":
        axes.plot(ticks, zero, marker=3, transform=axes.get_xaxis_transform(), **how)
    else:
        axes.plot(zero, ticks, marker=0, transform=axes.get_yaxis_transform(), **how)


def _inside(ticks: np.ndarray, limits: Limits) -> np.ndarray:
    return ticks[(ticks >= limits[0] * (1 - 1e-9)) & (ticks <= limits[1] * (1 + 1e-9))]


def decade_label(value: float, plain: bool) -> str:
    """0.05 if `plain`; else 10⁻² of a decade and 5×10⁻² of what lies between."""
    if plain:
        return f"{value:g}"
    exponent = int(np.floor(np.log10(value) + 1e-9))
    digits = f"{value / 10.0**exponent:.4g}"
    return power_of_ten(exponent) if digits == "1" else f"{digits}×{power_of_ten(exponent)}"


def slope_fan(
    axes: Axes,
    box: tuple[float, float, float, float],
    decade_mm: tuple[float, float],
    slopes: Sequence[tuple[float, str]],
) -> None:
    """Lines of the given slopes from one point, as steep as in panels of `decade_mm` mm a decade.

    axes: a canvas in mm; box: left, bottom, width, height on it; slopes: (slope, text), steepest
    rise first. Texts stand at the ends, spread where they would touch; the highest is at the box's
    top.
    """
    left, bottom, width, height = box
    line = lines_mm(1, SMALL_PT)
    steep = decade_mm[1] / decade_mm[0]
    rises = np.array([slope for slope, _ in slopes]) * steep
    widest = max(text_mm(text, SMALL_PT) for _, text in slopes)
    reach = min(max(width - widest - 4.0, 5.0), (height - line) / max(np.ptp(rises), 1e-9))
    ends = rises * reach
    places = _spread(ends, line)
    highest, lowest = max(places[0], ends[0]) + line / 2, min(places[-1], ends[-1]) - line / 2
    spare = max(height - (highest - lowest), 0.0)
    middle = bottom + (height + spare - highest - lowest) / 2
    text_at = left + reach + 4.0
    for (_slope, text), end, place in zip(slopes, ends, places, strict=True):
        axes.plot([left, left + reach], [middle, middle + end], color=GREY, lw=0.8)
        axes.plot(
            [left + reach + 0.5, text_at - 0.8],
            [middle + end, middle + place],
            color=FAINT,
            lw=0.6,
        )
        axes.text(text_at, middle + place, text, size=SMALL_PT, va="center_baseline", color=INK)


def _spread(ends: np.ndarray, gap: float) -> np.ndarray:
    """Descending places at least `gap` apart, about as high as `ends` on the whole."""
    places = np.array(ends, dtype=np.float64)
    for i in range(1, places.size):
        places[i] = min(places[i], places[i - 1] - gap)
    moved: np.ndarray = places + (np.mean(ends) - np.mean(places))
    return moved
