"""A noise level that changes slowly: named, with an interval that holds, and without an event.

Recordings as in `events`. All cases except white noise that falls by 15 % have a fifth of `--runs`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.sentences import _kinds as kinds
from benchmarks.sentences import events

SLOW: dict[str, kinds.Kind] = {
    "falls by 15 %": kinds.levelled(kinds.white, lambda t: 1 - 0.15 * t),
    "Student t4, falls by 15 %": kinds.levelled(kinds.student(4.0), lambda t: 1 - 0.15 * t),
    "rises by 30 %": kinds.levelled(kinds.white, lambda t: 1 + 0.3 * t),
    "warms up": kinds.levelled(kinds.white, lambda t: 1 + 0.3 * np.exp(-6 * t)),
    "comes back": kinds.levelled(kinds.white, lambda t: 1 + 0.2 * np.sin(2 * np.pi * t)),
}


def rows(n: int) -> list[tuple[Any, ...]]:
    """(case, statistic, runs, reach, at 8b8d0af, measured)."""
    return slow(n, max(n // 5, 1))


def slow(n: int, few: int) -> list[tuple[Any, ...]]:
    told = []
    for name, kind in SLOW.items():
        runs = n if name == "falls by 15 %" else few
        found = [events.found_in(events.recorded(kind, [k])) for k in range(runs)]
        alarms = [bool(e) for e, _, _ in found]
        told.append(events.row(f"level {name}", "events", alarms, "<= 1 %"))
        named = [len(t) >= 6 for _, t, _ in found]
        told.append(events.row(f"level {name}", "level_changes in 6 series", named, ">= 90 %"))
        if name == "falls by 15 %":
            held = [one.lower < -0.15 < one.upper for _, t, _ in found for one in t]
            told.append(events.row(f"level {name}", "95 % interval holds", held, "90-99 %"))
    return told
