"""A sentence of the diagnosis, and how it says numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mocap_metrology.common.words import three


@dataclass(frozen=True)
class Sentence:
    """kind: event, periodic, resolution, filter, low_pass, warm_up, drift, outliers, gaps, filled,
    moving, misfit, level, tails; severity: info or warning; words: a sentence; numbers: those in
    it, units in their names."""

    kind: str
    severity: str
    series: tuple[str, ...]
    words: str
    numbers: dict[str, Any] = field(default_factory=dict)


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


def percent(share: float) -> str:
    return f"{100 * share:.3g} %" if share >= 1e-5 else "less than 0.001 %"


def span(values: Iterable[float], shown: Callable[[float], str]) -> str:
    """`3 %` or `3 % to 5 %`."""
    known = np.asarray(list(values), float)
    low, high = shown(float(known.min())), shown(float(known.max()))
    return low if low == high else f"{low} to {high}"


def signed(share: float) -> str:
    return f"{100 * share:+.2g} %"
