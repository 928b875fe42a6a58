"""A sentence of the diagnosis, and how sentences say numbers."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from mocap_metrology.common.words import three

FAST_MM_H = 10_000.0
MINUTES_S = 120.0  # times from which minutes are said
Severity = Literal["info", "warning"]


@dataclass(frozen=True)
class Sentence:
    """kind: event, periodic, resolution, filter, low_pass, warm_up, drift, outliers, gaps, filled,
    moving, misfit, level, tails; severity: info or warning; words: a sentence; numbers: those in
    it, units in their names."""

    kind: str
    severity: Severity
    series: tuple[str, ...]
    words: str
    numbers: Mapping[str, object] = field(default_factory=dict)


def severity(matters: bool) -> Severity:
    """`warning` of what matters."""
    return "warning" if matters else "info"


def duration_words(seconds: float) -> str:
    """`an hour`, `10 min`, `5.2 s`."""
    if abs(seconds / 3600 - 1) < 0.005:
        return "an hour"
    if seconds >= 5400:
        return f"{seconds / 3600:.3g} h"
    return f"{seconds / 60:.3g} min" if seconds >= 120 else f"{seconds:.3g} s"


def minutes_words(seconds: float) -> str:
    """`90 s`, `18 minutes`, `2.5 h`."""
    if seconds < MINUTES_S:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} minutes" if seconds < 2 * 3600 else f"{three(seconds / 3600)} h"


def time_words(seconds: float) -> str:
    """150.2 s, or 2:30:12.0 beyond ten minutes."""
    seconds = round(seconds, 1)
    if seconds < 600:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(seconds, 60)
    hours, minutes = divmod(int(minutes), 60)
    return f"{hours}:{minutes:02d}:{rest:04.1f}"


def mm(value: float) -> str:
    """Three digits, in µm below 0.1 mm."""
    if value != value:
        return "an unknown length"
    if abs(value) < 0.1:
        return f"{three(1000 * value)} µm"
    return f"{three(value)} mm"


def digits(mm: float) -> str:
    """Three digits, zeros too, so that a value and its interval have as many: 0.0260, 693."""
    rounded = float(f"{mm:.3g}")
    if not math.isfinite(rounded) or rounded == 0:
        return f"{mm:g}"
    return f"{rounded:.{max(2 - math.floor(math.log10(abs(rounded))), 0)}f}"


def length(mm: float) -> str:
    """Three digits, in m from a metre on."""
    return f"{three(mm / 1000)} m" if mm >= 1000 else f"{three(mm)} mm"


def speed(mm_per_h: float) -> str:
    """`+360 mm/h`, and `+928 m/h` from 10 m/h on: of what moves, not of what wanders."""
    if abs(mm_per_h) >= FAST_MM_H:
        return f"{three(mm_per_h / 1000, '+')} m/h"
    return f"{three(mm_per_h, '+')} mm/h"


def percent(share: float) -> str:
    return f"{100 * share:.3g} %" if share >= 1e-5 else "less than 0.001 %"


def span(values: Iterable[float], shown: Callable[[float], str]) -> str:
    """`3 %` or `3 % to 5 %`."""
    known = np.asarray(list(values), float)
    low, high = shown(float(known.min())), shown(float(known.max()))
    return low if low == high else f"{low} to {high}"


def signed(share: float) -> str:
    return f"{100 * share:+.2g} %"
