"""Panels of a diagnosis over time: all of it, and close up the worst part.

All of it: dynamic Allan deviation, noise on both sides of an event. Close up: the largest event, or
the window that noise explains least.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.diagnosis.dynamic import Dynamic
from mocap_metrology.noise.diagnosis.events import LEAST_S, Event
from mocap_metrology.noise.diagnosis.levels import Sides
from mocap_metrology.noise.diagnosis.recording import Diagnosis, Recording
from mocap_metrology.present.plot.figure import (
    FAINT,
    GREY,
    INK,
    LOOKS,
    OTHER_LOOKS,
    Keywords,
    Look,
    coordinate_of,
    panel_title,
    ratio_axis,
    say,
)
from mocap_metrology.present.plot.units import LengthUnit, length_unit, time_axis
from mocap_metrology.present.text.diagnosis import outcome
from mocap_metrology.present.text.numbers import moment, number, significant

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap

LEAST_S_SHOWN, MOST_S_SHOWN = 3.0, 60.0
SHADE: Keywords = {"facecolor": FAINT, "alpha": 0.45, "lw": 0}
SHOWN = {"burst": "while it lasts", "level": "within 5 s", "window": "this window"}
LIKELY = 0.5  # chance from which noise explains a window


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
                best, start = float(d.x[k]), k * d.hop_s
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
    panel_title(axes, *_head(recording, found, event, view, cut))
    end_s = (cut.end - cut.begin) / rate
    span = view.first_s - start, min(view.last_s - start, end_s)
    time = np.arange(cut.end - cut.begin) / rate
    for name, values in cut.values.items():
        look = look_of(name)
        how: Keywords = {"color": look.colour, "ls": look.dashes, "lw": 0.7}
        axes.plot(time, values * unit.per_mm, label=name, **how)
    axes.axvspan(*span, label=SHOWN[view.kind], **SHADE)
    axes.set_xlim(0.0, end_s)
    axes.set_xlabel(f"Time (s) from {moment(start)}" if cut.begin else "Time (s)")
    axes.set_ylabel(f"{', '.join(view.names)} ({unit.symbol})")


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
        size = f"{significant(event.size_mm * unit.per_mm)} {unit.symbol}"
        title = "The event" if len(found.events) == 1 else "The largest event"
        unknown = event.outcome == "unknown"
        word = "too close to an end to compare" if unknown else outcome(event)
        return title, f"{size} in {view.series}, {word}"
    if view.kind == "level":
        return "Where the noise changes", ""
    title = "Most unusual window"
    if recording.duration_s >= LEAST_S:
        likely = view.chance >= LIKELY
        return title, "explained by noise" if likely else f"chance ≤ {100 * view.chance:.2g} %"
    first = max(round(view.first_s * recording.frame_rate_hz) - cut.begin, 0)
    last = first + round((view.last_s - view.first_s) * recording.frame_rate_hz)
    inside = {k: v[first:last] for k, v in cut.values.items() if np.isfinite(v[first:last]).any()}
    spans = {k: float(np.nanmax(v) - np.nanmin(v)) for k, v in inside.items()}
    most = max(spans, key=lambda k: spans[k], default="")
    size = f"{significant(spans[most] * unit.per_mm)} {unit.symbol}" if most else ""
    return title, f"{most} spans {size}" if most else ""


COLUMNS = 600  # of the image
COLOUR_LIMIT = 1.0  # octaves of the deviation that the colours span, either way
FEW_EVENTS = 20  # beyond, their marks are small
EVENT: Keywords = {"marker": "v", "ms": 4.5, "mew": 0, "color": INK, "ls": "", "clip_on": False}
FRAME: Keywords = {"facecolor": "none", "edgecolor": INK, "lw": 1.2}
# A ratio by what it shows: colour, sign of its middle, and words
COMPARED = {
    "changed": ("#b03a20", "s", "noise changed"),
    "alike": ("#10307a", "o", "noise alike"),
    "undecided": (GREY, "D", "undecided whether noise changed"),
}


def _colours() -> Colormap:
    from matplotlib.colors import LinearSegmentedColormap

    colours = ["#10307a", "#ffffff", "#cf4a2c"]
    return LinearSegmentedColormap.from_list("ratio", colours).with_extremes(bad=FAINT)


def draw_dynamic(axes: Axes, recording: Recording, found: Diagnosis, view: View) -> None:
    """Ratio of the dynamic Allan deviation to that of the noise, over time and averaging time, of
    the series that is shown close up; its most unusual window is framed."""
    series = view.series
    axis = time_axis(recording.n_frames, recording.frame_rate_hz)
    per_s = axis.per_frame * recording.frame_rate_hz
    own = found.dynamics.get(series) or []
    remark = _events_remark(found, recording.duration_s)
    panel_title(axes, f"Dynamic Allan deviation of {series}", remark)
    axes.set(xlim=axis.limits, xlabel=axis.label, ylabel="τ (s)")
    axes.grid(visible=False)
    if not own:
        axes.set_yticks([])
        say(axes, "no windows")
        return
    image = np.array([_row(d, recording.duration_s) for d in own])
    shown = axes.imshow(
        np.ma.masked_invalid(image), origin="lower", aspect="auto", interpolation="nearest",
        extent=(*axis.limits, -0.5, len(own) - 0.5), cmap=_colours(),
        vmin=-COLOUR_LIMIT, vmax=COLOUR_LIMIT,
    )  # fmt: skip
    axes.set_yticks(range(0, len(own), 2), [f"{d.tau_s:.2g}" for d in own[::2]])
    small = {} if len(found.events) <= FEW_EVENTS else {"ms": 2.0}
    if found.events:
        at = [event.time_s * per_s for event in found.events]
        axes.plot(at, [len(own) - 0.5] * len(at), label="event", **{**EVENT, **small})
    if view.kind == "window":
        _frame(axes, own, view, per_s)
    bar = axes.figure.colorbar(shown, ax=axes, ticks=[-1, 0, 1], pad=0.01, aspect=12)
    bar.set_ticklabels(["½", "1", "2"])
    bar.set_label("ADEV / median")


def _frame(axes: Axes, own: Sequence[Dynamic], view: View, per_s: float) -> None:
    from matplotlib.patches import Rectangle

    row = next(k for k, d in enumerate(own) if d.tau_s == view.tau_s)
    width = (view.last_s - view.first_s) * per_s
    corner = (view.first_s * per_s, row - 0.5)
    axes.add_patch(Rectangle(corner, width, 1.0, zorder=3, clip_on=False, **FRAME))


def _events_remark(found: Diagnosis, duration_s: float) -> str:
    if not found.events and duration_s < LEAST_S:
        return "too short to decide on events"
    if not found.events:
        return f"no event in {number(found.n_windows)} windows of all series"
    n = len(found.events)
    return f"{n} event{'s' if n > 1 else ''} in {number(found.n_windows)} windows of all series"


def _row(d: Dynamic, duration_s: float) -> np.ndarray:
    """(COLUMNS,) log2 of the ratio of deviations, of variances averaged over the windows that begin
    in a column; a column without one repeats the window it lies in."""
    middle = np.arange(d.ratio.size) * d.hop_s + d.window_s / 2
    ratio = d.ratio
    place = np.minimum((middle / duration_s * COLUMNS).astype(int), COLUMNS - 1)
    known = np.isfinite(ratio)
    count = np.bincount(place[known], minlength=COLUMNS)
    total = np.bincount(place[known], ratio[known], minlength=COLUMNS)
    centre = (np.arange(COLUMNS) + 0.5) / COLUMNS * duration_s
    nearest = np.abs(middle[:, None] - centre).argmin(axis=0) if middle.size < COLUMNS * 2 else None
    mean = np.where(count > 0, total / np.maximum(count, 1), np.nan)
    if nearest is not None:
        mean = np.where(count > 0, mean, ratio[nearest])
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.maximum(np.log2(mean) / 2, -2.0)


def draw_sides(axes: Axes, title: str, sides: Sequence[Sides]) -> None:
    """Ratio of the standard deviations of fast noise of every series, with 99 % intervals over all
    series together, coloured by what they show."""
    known = [s for s in sides if math.isfinite(s.ratio)]
    panel_title(axes, title, _outcome(known))
    reach = 1.15 * max(abs(math.log(v)) for s in known for v in (s.lower, s.upper))
    reach = min(max(reach, math.log(1.02)), math.log(20))
    ratio_axis(axes, (math.exp(-reach), math.exp(reach)))
    axes.axhline(1.0, color=INK, lw=0.8)
    for word, (colour, marker, text) in COMPARED.items():
        own = [(k, side) for k, side in enumerate(known) if side.word == word]
        if own:
            at, of_word = [k for k, _ in own], [side for _, side in own]
            axes.vlines(
                at, [s.lower for s in of_word], [s.upper for s in of_word], color=colour, lw=1.4
            )
            dots: Keywords = {"ls": "", "marker": marker, "ms": 4, "mew": 0, "color": colour}
            axes.plot(at, [s.ratio for s in of_word], label=text, **dots)
    axes.set(xlim=(-0.6, len(known) - 0.4), xlabel="Series", ylabel="Ratio of SD, 99 %")
    step = -(-len(known) // 10)
    axes.set_xticks(range(0, len(known), step), [s.series for s in known[::step]])
    axes.grid(visible=False, axis="x")


def _outcome(known: Sequence[Sides]) -> str:
    """What all these ratios show, in two or three words."""
    words = [side.word for side in known]
    for word in ("changed", "undecided"):
        if word in words:
            all_of_them = words.count(word) == len(words)
            return word if all_of_them else f"{words.count(word)} of {len(words)} {word}"
    return "alike" if words else ""
