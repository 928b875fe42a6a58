"""Panel of a diagnosis close up: the largest event, or the window that noise explains least."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.diagnosis.events import LEAST_S, Event
from mocap_metrology.noise.diagnosis.recording import Diagnosis, Recording
from mocap_metrology.present.drawing.linear import LengthUnit, length_unit, linear_axis
from mocap_metrology.present.drawing.names import coordinate_of
from mocap_metrology.present.drawing.style import (
    FAINT,
    LOOKS,
    OTHER_LOOKS,
    Look,
    head,
    label_axes,
)
from mocap_metrology.present.numbers import three_digits

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LEAST_S_SHOWN, MOST_S_SHOWN = 3.0, 60.0
SHADE = {"facecolor": FAINT, "alpha": 0.45, "lw": 0}
LIKELY = 0.5  # chance from which noise explains a window
MINUTES_FROM_S = 180.0  # moments are in s up to here, as the axis of the whole recording


@dataclass(frozen=True)
class View:
    """What is shown: `series` from first_s to last_s; kind: `burst`, `level`, or `window`, the one
    that noise explains least, at its averaging time, and the chance of such a one at most."""

    kind: str
    series: str
    first_s: float
    last_s: float
    tau_s: float = math.nan
    chance: float = math.nan

    @property
    def names(self) -> list[str]:
        """All coordinates of the marker, or the one series."""
        place = coordinate_of(self.series)
        return [f"{axis}{place[1]}" for axis in "xyz"] if place else [self.series]


@dataclass(frozen=True)
class _Cut:
    """Values in mm about their median before first_s, from frame `begin` to before `end`."""

    begin: int
    end: int
    values: dict[str, np.ndarray]

    @property
    def unit(self) -> LengthUnit:
        ranges = [float(np.nanmax(v) - np.nanmin(v)) for v in self.values.values()]
        return length_unit([max(ranges)] if ranges else [])


def view_of(found: Diagnosis, event: Event | None) -> View | None:
    """Of the event, or else of the most unusual window, if there are windows."""
    if event and event.kind == "burst":
        return View("burst", event.largest, event.time_s, event.stop_s)
    if event:
        return View("level", event.largest, event.time_s - 5, event.time_s + 5)
    best, view = -math.inf, None
    for name, own in found.dynamics.items():
        for d in own:
            k = int(np.argmax(d.x))
            if d.x[k] > best:
                best, start = float(d.x[k]), float(d.start_s[k])
                chance = min(found.n_windows * math.exp(-best), 1.0)
                view = View("window", name, start, start + d.window_s, d.tau_s, chance)
    return view


def look_of(name: str) -> Look:
    """How a series is drawn here."""
    place = coordinate_of(name)
    return LOOKS[place[0]] if place else OTHER_LOOKS[0]


def draw_zoom(
    axes: Axes, recording: Recording, found: Diagnosis, event: Event | None, view: View
) -> None:
    """The coordinates of the marker that was moved most, or of that of the window."""
    rate = recording.frame_rate_hz
    cut = _cut(recording, found, view)
    start, unit = cut.begin / rate, cut.unit
    head(axes, *_head(recording, found, event, view, cut))
    end_s = (cut.end - cut.begin) / rate
    axes.axvspan(view.first_s - start, min(view.last_s - start, end_s), **SHADE)
    time = np.arange(cut.end - cut.begin) / rate
    low, high = 0.0, 0.0
    for name, values in cut.values.items():
        look = look_of(name)
        axes.plot(time, values * unit.per_mm, color=look.colour, ls=look.dashes, lw=0.7)
        low = min(low, float(np.nanmin(values)) * unit.per_mm)
        high = max(high, float(np.nanmax(values)) * unit.per_mm)
    pad = 0.06 * (high - low) or 1.0
    linear_axis(axes, "x", (0.0, end_s), 6)
    linear_axis(axes, "y", (low - pad, high + pad), 5)
    where = f"Time (s) from {moment(start)}" if cut.begin else "Time (s)"
    label_axes(axes, x=where, y=f"{', '.join(view.names)} ({unit.symbol})", y_mm=12.5)


def _cut(recording: Recording, found: Diagnosis, view: View) -> _Cut:
    rate, duration = recording.frame_rate_hz, view.last_s - view.first_s
    span = min(max(1.6 * duration, LEAST_S_SHOWN), MOST_S_SHOWN)
    start = max(view.first_s - 0.25 * min(span, LEAST_S_SHOWN * 2), 0.0)
    begin, end = round(start * rate), min(round((start + span) * rate) + 1, recording.n_frames)
    parts = {name: found.quiet[name][begin:end].astype(float) for name in view.names}
    quiet = max(round(view.first_s * rate) - begin, 8)
    known = {k: v for k, v in parts.items() if np.isfinite(v[:quiet]).any()}
    return _Cut(begin, end, {k: v - np.nanmedian(v[:quiet]) for k, v in known.items()})


def _head(
    recording: Recording, found: Diagnosis, event: Event | None, view: View, cut: _Cut
) -> tuple[str, str]:
    """Title and remark. Of a recording that is too short to decide on events, what is seen in the
    window; of others, whether noise explains it."""
    unit = cut.unit
    if view.kind == "burst" and event:
        size = f"{three_digits(event.size_mm * unit.per_mm)} {unit.symbol}"
        title = "The event" if len(found.events) == 1 else "The largest event"
        word = "too near an end to compare" if event.word == "unknown" else event.word
        return title, f"{size} in {view.series}, {word}"
    if view.kind == "level":
        return "Where the noise changes", ""
    title = "Most unusual window"
    if recording.duration_s >= LEAST_S:
        likely = view.chance >= LIKELY
        return title, "noise explains it" if likely else f"chance ≤ {100 * view.chance:.2g} %"
    first = max(round(view.first_s * recording.frame_rate_hz) - cut.begin, 0)
    last = first + round((view.last_s - view.first_s) * recording.frame_rate_hz)
    inside = {k: v[first:last] for k, v in cut.values.items() if np.isfinite(v[first:last]).any()}
    spans = {k: float(np.nanmax(v) - np.nanmin(v)) for k, v in inside.items()}
    most = max(spans, key=lambda k: spans[k], default="")
    size = f"{three_digits(spans[most] * unit.per_mm)} {unit.symbol}" if most else ""
    return title, f"{most} spans {size}" if most else ""


def moment(seconds: float) -> str:
    """`98.5 s`, `4 min 58.5 s`, `4 h 29 min 58.5 s`."""
    tenths = round(10 * seconds)
    if tenths < 10 * MINUTES_FROM_S:
        return f"{tenths / 10:.1f} s"
    minutes, rest = divmod(tenths, 600)
    hours, minutes = divmod(minutes, 60)
    return f"{f'{hours} h ' if hours else ''}{minutes} min {rest / 10:.1f} s"
