"""Log-log axes: limits, decade grid, labels, and a fan of slopes to compare curves with."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.present.drawing.style import FAINT, GREY, INK, SMALL_PT, lines_mm, text_mm

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SUPERSCRIPT = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
LABEL_WIDTH_MM, LABEL_HEIGHT_MM = 7.5, 4.0
PAD = 0.1  # decades beyond the data
PLAIN = (-3, 3)  # decades written out as 0.001 ... 1000
FINE_MM = 9.0  # a decade this wide shows ticks at 2 ... 9
Limits = tuple[float, float]


def log_limits(
    arrays: Iterable[np.ndarray], least_decades: float = 1.0, most_decades: float = np.inf
) -> Limits:
    """Limits around all positive finite values, `least_decades` apart; (0.1, 10) without any.

    `most_decades` caps how far down they go, for rounding errors of a constant series are positive
    too.
    """
    values = np.concatenate([np.asarray(a, dtype=np.float64).ravel() for a in arrays] or [[]])
    values = values[np.isfinite(values) & (values > 0)]
    if not values.size:
        return 0.1, 10.0
    low, high = np.log10(values.min()), np.log10(values.max())
    low = max(low, high - most_decades)
    low, high = low - PAD, high + PAD
    missing = max(least_decades - (high - low), 0.0)
    return float(10 ** (low - missing / 2)), float(10 ** (high + missing / 2))


def decade_axis(axes: Axes, which: str, limits: Limits, length_mm: float) -> None:
    """Make one axis logarithmic: grid and labels at decades, at every second one where crowded, and
    at 2 and 5 too where there are few."""
    from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

    low, high = np.log10(limits)
    per_decade = length_mm / (high - low)
    room = LABEL_WIDTH_MM if which == "x" else LABEL_HEIGHT_MM
    step = max(int(np.ceil(room / per_decade)), 1)
    decades = np.arange(np.ceil(low - 1e-9), np.floor(high + 1e-9) + 1)
    major = 10.0 ** decades[decades % step == 0]
    whole = np.arange(np.floor(low), np.floor(high) + 1)
    between = np.outer(10.0**whole, np.arange(2, 10)).ravel()
    if len(decades) < 3 and per_decade > 4 * room:
        major = np.sort(np.append(major, np.outer(10.0**whole, [2, 5]).ravel()))
    minor = between if per_decade >= FINE_MM else 10.0**decades
    written_out = PLAIN[0] <= low and high < PLAIN[1] + 0.7

    def label(value: float, _position: int) -> str:
        return decade_label(value, written_out)

    getattr(axes, f"set_{which}scale")("log")
    getattr(axes, f"set_{which}lim")(limits)
    line = getattr(axes, f"{which}axis")
    line.set_major_locator(FixedLocator(_inside(major, limits)))
    line.set_minor_locator(NullLocator())
    line.set_major_formatter(FuncFormatter(label))
    axes.grid(visible=True, which="major", axis=which)
    _minor_ticks(axes, which, np.setdiff1d(_inside(minor, limits), major))


def _minor_ticks(axes: Axes, which: str, ticks: np.ndarray) -> None:
    """All of them as the markers of one line: matplotlib's own are an artist each, and slow."""
    how = {"ls": "", "ms": 1.5, "mew": 0.4, "color": GREY, "clip_on": False}
    zero = np.zeros(ticks.size)
    if which == "x":
        axes.plot(ticks, zero, marker=3, transform=axes.get_xaxis_transform(), **how)
    else:
        axes.plot(zero, ticks, marker=0, transform=axes.get_yaxis_transform(), **how)


def _inside(ticks: np.ndarray, limits: Limits) -> np.ndarray:
    return ticks[(ticks >= limits[0] * (1 - 1e-9)) & (ticks <= limits[1] * (1 + 1e-9))]


def decade_label(value: float, written_out: bool) -> str:
    """Of a number with one significant digit: 0.05 written out; else 10⁻² of a decade, and the bare
    digit between two."""
    if written_out:
        return f"{value:g}"
    exponent = int(np.floor(np.log10(value) + 1e-9))
    digit = round(value / 10.0**exponent)
    return "10" + str(exponent).translate(SUPERSCRIPT) if digit == 1 else str(digit)


def slope_fan(
    axes: Axes,
    box: tuple[float, float, float, float],
    decade_mm: tuple[float, float],
    slopes: Sequence[tuple[float, str]],
) -> None:
    """Lines of the given slopes from one point, as steep as in panels of `decade_mm` mm a decade.

    axes: a canvas in mm; box: left, bottom, width, height on it; slopes: (slope, text), steepest
    rise first. Texts stand at the ends, spread where they would touch.
    """
    left, bottom, width, height = box
    line = lines_mm(1, SMALL_PT)
    steep = decade_mm[1] / decade_mm[0]
    rises = np.array([slope for slope, _ in slopes]) * steep
    widest = max(text_mm(text, SMALL_PT) for _, text in slopes)
    reach = min(max(width - widest - 4.0, 5.0), (height - line) / max(np.ptp(rises), 1e-9))
    ends = rises * reach
    places = _spread(ends, line)
    middle = bottom + height / 2 - (places[0] + places[-1]) / 2
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
    return places + (np.mean(ends) - np.mean(places))
