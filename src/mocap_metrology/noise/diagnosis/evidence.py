"""Where a diagnosis shows best: its largest event or most unusual window, its surest line, and the
noise before and after."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mocap_metrology.noise.diagnosis.events import Event
from mocap_metrology.noise.diagnosis.records import Diagnosis
from mocap_metrology.noise.diagnosis.sides import Sides, compare
from mocap_metrology.noise.series import AXES

ROUND_LEVEL_S = 5.0  # on either side of a change of level
HALVES_MISS = 0.01  # probability that some series is reported as changed and is not
SEEN = 1e-4  # share of the Allan variance from which rounding shows


@dataclass(frozen=True)
class View:
    """What shows best: `series` from first_s to last_s; kind: `burst`, `level`, or `window`, the
    one that noise explains least, at its averaging time, and the chance of such a one at most."""

    kind: str
    series: str
    first_s: float
    last_s: float
    tau_s: float = math.nan
    chance: float = math.nan

    @property
    def names(self) -> list[str]:
        """All coordinates of the marker, or the one series."""
        coordinate = self.series[0] in AXES
        return [f"{axis}{self.series[1:]}" for axis in AXES] if coordinate else [self.series]


def largest_event(diagnosis: Diagnosis) -> Event | None:
    """The largest burst, or else the surest change of level."""
    bursts = [e for e in diagnosis.events if e.kind == "burst"]
    if bursts:
        return max(bursts, key=lambda e: e.size_mm)
    return min(diagnosis.events, key=lambda e: e.p, default=None)


def view_of(diagnosis: Diagnosis, event: Event | None) -> View | None:
    """The part of the recording to draw: the event, or else the most unusual window, if there is
    one."""
    if event and event.kind == "burst":
        return View("burst", event.largest, event.time_s, event.stop_s)
    if event:
        first_s, last_s = event.time_s - ROUND_LEVEL_S, event.time_s + ROUND_LEVEL_S
        return View("level", event.largest, first_s, last_s)
    windows = [
        (float(d.x.max()), name, d) for name, every in diagnosis.dynamics.items() for d in every
    ]
    if not windows:
        return None
    x, name, d = max(windows, key=lambda window: window[0])
    start = int(np.argmax(d.x)) * d.hop_s
    chance = min(diagnosis.n_windows * math.exp(-x), 1.0)
    return View("window", name, start, start + d.window_s, d.tau_s, chance)


def series_of_surest_line(diagnosis: Diagnosis) -> str | None:
    """The series with the surest line; lines that show in the Allan deviation come first."""
    most = max(diagnosis.lines, key=lambda x: (bool(x.in_adev), x.line.gain), default=None)
    return most.series if most else None


def halves(diagnosis: Diagnosis, duration_s: float) -> tuple[Sides, ...]:
    """Noise of the second half of every series compared with the first."""
    tail, middle = HALVES_MISS / max(len(diagnosis.levels), 1), duration_s / 2
    return tuple(
        compare(name, one.between(0.0, middle), one.between(middle, duration_s), tail)
        for name, one in diagnosis.levels.items()
    )
