"""One page that proves a diagnosis: events, their sides, lines, filters, resolution."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from mocap_metrology.noise.diagnosis.events import Event
from mocap_metrology.noise.diagnosis.levels import Sides, compare
from mocap_metrology.noise.diagnosis.recording import Diagnosis, Recording
from mocap_metrology.present.diagnosis.spectra import draw_deviations, draw_spectrum, filter_looks
from mocap_metrology.present.diagnosis.time import (
    View,
    draw_dynamic,
    draw_sides,
    draw_zoom,
    view_of,
)
from mocap_metrology.present.plot.figure import (
    Picture,
    legend_below,
    letters,
    new_figure,
    styled,
)
from mocap_metrology.present.text import captions

if TYPE_CHECKING:
    from matplotlib.axes import Axes

DYNAMIC_MM, CLOSE_MM, SPECTRA_MM = 36.0, 44.0, 58.0
MOST_LETTERS = 36  # of title and remark side by side
NO_EVENTS = "Events cannot be detected: the recording is too short, or its steps are too coarse."


@styled()
def diagnosis_figure(
    recording: Recording,
    found: Diagnosis,
    title: str,
    source: str = "",
    remarks: str = "",
) -> Picture:
    """Above, the dynamic Allan deviation of one series over time, events marked, and below it the
    largest event (or, without one, the most unusual window) beside the noise before and after (or
    in both halves); at the bottom the spectrum with its lines, and the Allan deviation, both as
    they are and as filters would leave them, without the events. Of a short recording, what there
    is of this. `source`: the line at the foot; `remarks`: what the caption adds.
    """
    event = _largest(found)
    view = view_of(found, event)
    spectral = _spectral(found) or (view.series if view else next(iter(recording.coordinates)))
    looks = filter_looks(found.filtered, spectral)
    sides_of, sides = _sides(recording, found, event)
    rows = _rows(view, any(math.isfinite(side.ratio) for side in sides))
    body = new_figure(title, source, 25.0 + sum(height + 12.0 for height in rows.values()))
    panels = body.subplot_mosaic("\n".join(rows), height_ratios=list(rows.values()))
    if view is not None:
        draw_dynamic(panels["a"], recording, found, view)
        draw_zoom(panels["b"], recording, found, event, view)
    if "c" in panels:
        draw_sides(panels["c"], sides_of, sides)
    draw_spectrum(panels["d"], recording, found, spectral, looks)
    draw_deviations(panels["e"], recording, found, spectral, looks)
    letters(panels.values())
    for name in set(panels) - {"a"}:
        _stack(panels[name])
    legend_below(body, panels.values())
    told = (captions.DIAGNOSIS, remarks, "" if view else NO_EVENTS)
    return Picture(body, " ".join(filter(None, told)))


def _rows(view: View | None, compared: bool) -> dict[str, float]:
    """Panels side by side, two columns, and their height in mm."""
    rows = {"aa": DYNAMIC_MM} if view else {}
    close = ("b" if view else "") + ("c" if compared else "")
    if close:
        rows[close if len(close) == 2 else 2 * close] = CLOSE_MM
    return rows | {"de": SPECTRA_MM}


def _stack(axes: Axes) -> None:
    """The title a line above the remark, where a panel of half the page has no room for both."""
    title, remark = axes.get_title(loc="left"), axes.get_title(loc="right")
    if len(title) + len(remark) > MOST_LETTERS:
        axes.set_title(f"{title}\n")


def _largest(found: Diagnosis) -> Event | None:
    """The largest burst, or else the surest change of level."""
    bursts = [e for e in found.events if e.kind == "burst"]
    if bursts:
        return max(bursts, key=lambda e: e.size_mm)
    return min(found.events, key=lambda e: e.p, default=None)


def _spectral(found: Diagnosis) -> str | None:
    """The series whose spectrum is shown: that of the surest line, of those seen in the ADEV."""
    most = max(found.lines, key=lambda x: (bool(x.in_adev), x.line.gain), default=None)
    return most.series if most else None


def _sides(
    recording: Recording, found: Diagnosis, event: Event | None
) -> tuple[str, tuple[Sides, ...]]:
    """What is compared, in words, and the comparison of every series."""
    if event and event.most_changed:
        return "Noise: after / before", event.sides
    middle, end = recording.duration_s / 2, recording.duration_s
    tail = 0.01 / max(len(found.levels), 1)
    halves = tuple(
        compare(name, own.between(0.0, middle), own.between(middle, end), tail)
        for name, own in found.levels.items()
    )
    return "Noise: 2nd half / 1st", halves
