"""A noise level that changes slowly: named, with an interval that holds, and without an event.

Recordings as in `events`. All cases except white noise that falls by 15 % have a fifth of `--runs`.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from benchmarks.sentences import Row, events
from benchmarks.sentences._kinds import Kind, levelled, student, white

SLOW: dict[str, Kind] = {
    "falls by 15 %": levelled(white, lambda t: 1 - 0.15 * t),
    "Student t4, falls by 15 %": levelled(student(4.0), lambda t: 1 - 0.15 * t),
    "rises by 30 %": levelled(white, lambda t: 1 + 0.3 * t),
    "warms up": levelled(white, lambda t: 1 + 0.3 * np.exp(-6 * t)),
    "comes back": levelled(white, lambda t: 1 + 0.2 * np.sin(2 * np.pi * t)),
}


def rows(n: int) -> Iterator[Row]:
    """Levels of each kind."""
    for name, kind in SLOW.items():
        runs, case = n if name == "falls by 15 %" else max(n // 5, 1), f"level {name}"
        found = [events.found_in(events.recorded(kind, [k])) for k in range(runs)]
        yield events.row(case, "events", [bool(e) for e, _, _ in found], "<= 1 %")
        named = [len(t) >= 6 for _, t, _ in found]
        yield events.row(case, "level_changes in 6 series", named, ">= 90 %")
        if name == "falls by 15 %":
            held = [one.lower < -0.15 < one.upper for _, t, _ in found for one in t]
            yield events.row(case, "95 % interval holds", held, "90-99 %")
