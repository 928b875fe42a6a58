"""Linear axes: time in the unit that reads best, lengths in mm or µm, round ticks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes

UNITS = (("s", 1.0, 180.0), ("min", 60.0, 3 * 3600.0), ("h", 3600.0, np.inf))
MICROMETRES_BELOW_MM = 2.0  # median range of the axes
THIN_SPACE = "\N{NARROW NO-BREAK SPACE}"


@dataclass(frozen=True)
class TimeAxis:
    """`per_frame`: time from frame to frame in the unit of the label."""

    label: str
    per_frame: float
    limits: tuple[float, float]


def time_axis(n_frames: int, frame_rate_hz: float) -> TimeAxis:
    """Seconds up to three minutes, minutes up to three hours, then hours."""
    duration = max(n_frames, 1) / frame_rate_hz
    symbol, seconds = next((u, s) for u, s, up_to in UNITS if duration <= up_to)
    return TimeAxis(f"Time ({symbol})", 1 / frame_rate_hz / seconds, (0.0, duration / seconds))


@dataclass(frozen=True)
class LengthUnit:
    symbol: str
    per_mm: float


def length_unit(ranges_mm: Sequence[float]) -> LengthUnit:
    """µm where the typical axis spans less than 2 mm, else mm."""
    if len(ranges_mm) and np.median(ranges_mm) >= MICROMETRES_BELOW_MM:
        return LengthUnit("mm", 1.0)
    return LengthUnit("µm", 1000.0)


def round_ticks(low: float, high: float, most: int) -> np.ndarray:
    """At least two, and at most `most`, multiples of 1, 2 or 5 times a power of ten within the
    limits; where none of these steps gives that, every so many of the next finer ones."""
    step = 10.0 ** np.floor(np.log10((high - low) / most))
    finer = np.array([low, high])
    for factor in (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50):
        ticks = np.arange(np.ceil(low / (step * factor)), np.floor(high / (step * factor)) + 1)
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
    line.set_major_locator(FixedLocator(round_ticks(*limits, most)))
    line.set_major_formatter(FuncFormatter(lambda value, _position: tick_text(value)))
    axes.grid(visible=True, axis=which)


def tick_text(value: float) -> str:
    """As short as it can be, with a minus sign and not a hyphen."""
    return f"{value + 0.0:.10g}".replace("-", "−")


def number(value: float, digits: int = 0, sign: bool = False) -> str:
    """13 195 or −5.20: thousands set apart, a real minus sign."""
    text = f"{value:{'+' if sign else ''},.{digits}f}"
    return text.replace(",", THIN_SPACE).replace("-", "−")
