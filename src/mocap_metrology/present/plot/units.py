"""Units of axes: seconds to hours, micrometres and millimetres."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

UNITS = (("s", 1.0, 180.0), ("min", 60.0, 3 * 3600.0), ("h", 3600.0, np.inf))
MICROMETRES_BELOW_MM = 2.0  # median range of the axes


class TimeAxis(NamedTuple):
    """`per_frame`: time from frame to frame in the unit of the label."""

    label: str
    per_frame: float
    limits: tuple[float, float]


class LengthUnit(NamedTuple):
    """Its symbol, and how many of it are a mm."""

    symbol: str
    per_mm: float


def time_axis(n_frames: int, frame_rate_hz: float) -> TimeAxis:
    """Seconds up to three minutes, minutes up to three hours, then hours."""
    duration = max(n_frames, 1) / frame_rate_hz
    symbol, seconds = next((u, s) for u, s, up_to in UNITS if duration <= up_to)
    return TimeAxis(f"Time ({symbol})", 1 / frame_rate_hz / seconds, (0.0, duration / seconds))


def length_unit(ranges_mm: Sequence[float]) -> LengthUnit:
    """µm where the typical axis spans less than 2 mm, else mm."""
    coarse = len(ranges_mm) and np.median(ranges_mm) >= MICROMETRES_BELOW_MM
    return LengthUnit("mm", 1.0) if coarse else LengthUnit("µm", 1000.0)
