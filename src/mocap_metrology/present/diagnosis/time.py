"""Panels of a diagnosis over time: dynamic Allan deviation, one event, noise on both sides."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.diagnosis.dynamic import Dynamic
from mocap_metrology.noise.diagnosis.events import LEAST_S, Event
from mocap_metrology.noise.diagnosis.recording import Diagnosis, Recording
from mocap_metrology.noise.diagnosis.sides import Sides
from mocap_metrology.present.drawing.linear import length_unit, linear_axis, number, time_axis
from mocap_metrology.present.drawing.names import coordinate_of
from mocap_metrology.present.drawing.style import (
    FAINT,
    INK,
    LOOKS,
    OTHER_LOOKS,
    SMALL_PT,
    head,
    label_axes,
    say,
)
from mocap_metrology.present.numbers import three_digits

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap

COLUMNS = 600  # of the image
COLOUR_LIMIT = 1.0  # octaves of the deviation that the colours span, either way
FEW_EVENTS = 20  # beyond, their marks are small
EVENT = {"marker": "v", "ms": 4.5, "mew": 0, "color": INK, "clip_on": False}
LEAST_ZOOM_S, MOST_ZOOM_S = 3.0, 60.0
CHANGED, SAME = "#cf4a2c", "#10307a"


def _colours() -> Colormap:
    from matplotlib.colors import LinearSegmentedColormap

    colours = ["#10307a", "#ffffff", "#cf4a2c"]
    return LinearSegmentedColormap.from_list("ratio", colours).with_extremes(bad=FAINT)


def draw_dynamic(
    axes: Axes, bar: Axes, recording: Recording, found: Diagnosis, series: str
) -> None:
    """Ratio of the dynamic Allan deviation to that of the noise, over time and averaging time."""
    axis = time_axis(recording.n_frames, recording.frame_rate_hz)
    per_s = axis.per_frame * recording.frame_rate_hz
    own = found.dynamics.get(series) or []
    head(axes, f"Dynamic Allan deviation of {series}", _events_remark(found, recording.duration_s))
    linear_axis(axes, "x", axis.limits, 8)
    axes.grid(visible=False)
    label_axes(axes, x=axis.label, y="τ (s)", y_mm=12.5)
    if not own:
        bar.axis("off")
        axes.set_yticks([])
        say(axes, "nothing to tell")
        return
    image = np.array([_row(d, recording.duration_s) for d in own])
    shown = axes.imshow(
        np.ma.masked_invalid(image), origin="lower", aspect="auto", interpolation="nearest",
        extent=(*axis.limits, -0.5, len(own) - 0.5), cmap=_colours(),
        vmin=-COLOUR_LIMIT, vmax=COLOUR_LIMIT,
    )  # fmt: skip
    axes.set_ylim(-0.5, len(own) - 0.5)
    axes.set_yticks(range(0, len(own), 2), [f"{d.tau_s:.2g}" for d in own[::2]])
    mark = {**EVENT, "ms": EVENT["ms"] if len(found.events) <= FEW_EVENTS else 2.0}
    for event in found.events:
        axes.plot([event.time_s * per_s], [len(own) - 0.5], ls="", **mark)
    axes.figure.colorbar(shown, cax=bar, ticks=[-1, 0, 1])
    bar.set_yticklabels(["½", "1", "2"])
    bar.tick_params(length=2, width=0.6)
    bar.set_ylabel("of its usual value", size=SMALL_PT)
    bar.yaxis.set_label_coords(4.2, 0.5)


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
    middle = d.start_s + d.window_s / 2
    ratio = d.avar / d.baseline
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


def draw_zoom(axes: Axes, recording: Recording, found: Diagnosis, event: Event | None) -> None:
    """The coordinates of the marker that was moved most; without an event the window that noise
    explains least."""
    if event and event.kind == "burst":
        first, last, series = event.time_s, event.stop_s, event.largest
        title, remark = "The largest event", f"{three_digits(event.size_mm)} mm, {event.word}"
        if len(found.events) == 1:
            title = "The event"
    elif event:
        first, last, series = event.time_s - 5, event.time_s + 5, event.largest
        title, remark = "Where the noise changes", ""
    else:
        window = _most_unusual(found)
        if window is None:
            axes.axis("off")
            return
        first, last, series, chance = window
        title, remark = "Most unusual window", f"chance {_chance(chance)}"
    head(axes, title, remark)
    _traces(axes, recording, found, series, first, last)


def _chance(p: float) -> str:
    return "1" if p >= 0.995 else f"{p:.2g}"


def _most_unusual(found: Diagnosis) -> tuple[float, float, str, float] | None:
    best = None
    for name, own in found.dynamics.items():
        for d in own:
            k = int(np.argmax(d.x))
            if best is None or d.x[k] > best[0]:
                best = (float(d.x[k]), float(d.start_s[k]), float(d.start_s[k] + d.window_s), name)
    if best is None:
        return None
    return best[1], best[2], best[3], min(found.n_windows * math.exp(-best[0]), 1.0)


def _traces(
    axes: Axes, recording: Recording, found: Diagnosis, series: str, first: float, last: float
) -> None:
    rate = recording.frame_rate_hz
    span = min(max(1.6 * (last - first), LEAST_ZOOM_S), MOST_ZOOM_S)
    start = max(first - 0.25 * min(span, LEAST_ZOOM_S * 2), 0.0)
    begin, end = round(start * rate), min(round((start + span) * rate) + 1, recording.n_frames)
    place = coordinate_of(series)
    names = [f"{axis}{place[1]}" for axis in "xyz"] if place else [series]
    parts = {name: found.quiet[name][begin:end].astype(float) for name in names}
    quiet = max(round(first * rate) - begin, 8)
    about = {
        k: v - np.nanmedian(v[:quiet]) for k, v in parts.items() if np.isfinite(v[:quiet]).any()
    }
    ranges = [float(np.nanmax(v) - np.nanmin(v)) for v in about.values()]
    unit = length_unit([max(ranges, default=0.0)] if ranges else [])
    time = np.arange(begin, end) / rate - start
    axes.axvspan(first - start, min(last - start, time[-1]), color=FAINT, alpha=0.45, lw=0)
    low, high = 0.0, 0.0
    for name, values in about.items():
        found_place = coordinate_of(name)
        look = LOOKS[found_place[0]] if found_place else OTHER_LOOKS[0]
        axes.plot(time, values * unit.per_mm, color=look.colour, ls=look.dashes, lw=0.7)
        low = min(low, float(np.nanmin(values)) * unit.per_mm)
        high = max(high, float(np.nanmax(values)) * unit.per_mm)
    pad = 0.06 * (high - low) or 1.0
    linear_axis(axes, "x", (0.0, (end - begin) / rate), 6)
    linear_axis(axes, "y", (low - pad, high + pad), 5)
    who = ", ".join(names)
    label_axes(
        axes,
        x=f"Time from {start:.1f} s (s)" if start else "Time (s)",
        y=f"{who} ({unit.symbol})",
        y_mm=12.5,
    )


def draw_sides(axes: Axes, title: str, sides: Sequence[Sides]) -> None:
    """Ratio of the standard deviations of fast noise of every series, with 99 % intervals over all
    series together."""
    known = [s for s in sides if math.isfinite(s.ratio)]
    changed = sum(s.changed for s in known)
    remark = f"{changed} of {len(known)} changed" if changed else "alike" if known else ""
    head(axes, title, remark)
    if not known:
        axes.set_xticks([])
        axes.set_yticks([])
        say(axes, "too short to compare")
        return
    reach = 1.15 * max(abs(math.log(v)) for s in known for v in (s.lower, s.upper))
    reach = min(max(reach, math.log(1.02)), math.log(20))
    limits = (math.exp(-reach), math.exp(reach))
    linear_axis(axes, "y", limits, 6) if reach < math.log(1.5) else _log_axis(axes, limits)
    axes.axhline(1.0, color=INK, lw=0.8)
    for k, side in enumerate(known):
        colour = CHANGED if side.changed else SAME
        axes.plot([k, k], [side.lower, side.upper], color=colour, lw=1.4)
        axes.plot([k], [side.ratio], ls="", marker="o", ms=4, mew=0, color=colour)
    axes.set_xlim(-0.6, len(known) - 0.4)
    step = -(-len(known) // 10)
    axes.set_xticks(range(0, len(known), step), [s.series for s in known[::step]])
    label_axes(axes, x="Series", y="Ratio of sd, 99 %", y_mm=11.5)


def _log_axis(axes: Axes, limits: tuple[float, float]) -> None:
    from matplotlib.ticker import FixedLocator, NullFormatter, NullLocator

    axes.set_yscale("log")
    axes.set_ylim(limits)
    near = (0.8, 1.25) if limits[1] < 4 else ()  # they would touch the 1
    ticks = [
        t
        for t in sorted((0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, *near))
        if limits[0] <= t <= limits[1]
    ]
    axes.yaxis.set_major_locator(FixedLocator(ticks))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.set_yticklabels([f"{t:g}" for t in ticks])
    axes.grid(visible=True, axis="y")
