"""One page that proves a diagnosis: events, their sides, lines, filters, resolution."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from mocap_metrology.noise.diagnosis.events import Event
from mocap_metrology.noise.diagnosis.levels import Sides, compare
from mocap_metrology.noise.diagnosis.recording import Diagnosis, Recording
from mocap_metrology.present.diagnosis.spectra import (
    ROUNDING,
    draw_deviations,
    draw_spectrum,
    filter_looks,
    rounding_of,
)
from mocap_metrology.present.diagnosis.time import (
    COMPARED,
    EVENT,
    FRAME,
    SHADE,
    View,
    draw_dynamic,
    draw_sides,
    draw_zoom,
    look_of,
    view_of,
)
from mocap_metrology.present.drawing.legend import Entry, strip, strip_height
from mocap_metrology.present.drawing.style import (
    GREY,
    MARGIN_MM,
    WIDTH_MM,
    Keywords,
    blank_sheet,
    styled,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LEFT_MM, SECOND_MM, PANEL_MM, TITLE_MM, LABELS_MM = 16.5, 100.0, 66.0, 5.5, 11.5
DYNAMIC_MM, CLOSE_MM, SPECTRA_MM = 34.0, 42.0, 58.0
SHADED = "#ececec"  # as what is shaded looks on white
SHOWN = {"burst": "while it lasts", "level": "within 5 s", "window": "this window"}
NOISE = {
    "changed": "noise changed",
    "alike": "noise alike",
    "undecided": "undecided whether noise changed",
}
NO_EVENTS = "Events could not be looked for: the recording is too short, or its steps too coarse."


@styled()
def diagnosis_figure(
    recording: Recording,
    found: Diagnosis,
    title: str,
    note: str = "",
) -> Figure:
    """Above, the dynamic Allan deviation of one series over time, events marked, and below it the
    largest event (or, without one, the most unusual window) beside the noise before and after (or
    in both halves); at the bottom the spectrum with its lines, and the Allan deviation, both as
    they are and as filters would leave them, without the events. Of a short recording, what there
    is of this.
    """
    event = _largest(found)
    view = view_of(found, event)
    spectral = _spectral(found) or (view.series if view else next(iter(recording.coordinates)))
    looks = filter_looks(found.filtered, spectral)
    timed = view is not None
    sides = _sides(recording, found, event)
    compared = any(math.isfinite(side.ratio) for side in sides[1])
    entries = [
        *_entries_in_time(found, view, sides[1]),
        *_entries_of_spectra(found, looks, spectral),
    ]
    width = WIDTH_MM - 2 * MARGIN_MM
    tops = [TITLE_MM, 0.0, 0.0]
    tops[1] = tops[0] + (DYNAMIC_MM + LABELS_MM + TITLE_MM if timed else 0.0)
    tops[2] = tops[1] + (CLOSE_MM + LABELS_MM + TITLE_MM if timed or compared else 0.0)
    key_top = tops[2] + SPECTRA_MM + LABELS_MM
    note = note if timed else f"{note} {NO_EVENTS}".strip()
    sheet = blank_sheet(key_top + strip_height(entries, width) + 1.5, title, note)
    if view is not None:
        full = WIDTH_MM - LEFT_MM - 17.5
        bar = sheet.axes(LEFT_MM + full + 3.0, tops[0], 2.5, DYNAMIC_MM)
        draw_dynamic(sheet.axes(LEFT_MM, tops[0], full, DYNAMIC_MM), bar, recording, found, view)
        wide = PANEL_MM if compared else SECOND_MM + PANEL_MM - LEFT_MM
        draw_zoom(sheet.axes(LEFT_MM, tops[1], wide, CLOSE_MM), recording, found, event, view)
    if compared:
        at = SECOND_MM if timed else LEFT_MM
        draw_sides(sheet.axes(at, tops[1], PANEL_MM, CLOSE_MM), *sides)
    left = sheet.axes(LEFT_MM, tops[2], PANEL_MM, SPECTRA_MM)
    draw_spectrum(left, recording, found, spectral, looks)
    right = sheet.axes(SECOND_MM, tops[2], PANEL_MM, SPECTRA_MM)
    draw_deviations(right, recording, found, spectral, looks)
    strip(sheet, MARGIN_MM, key_top, width, entries)
    return sheet.figure


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
        return "Noise after over before", event.sides
    middle, end = recording.duration_s / 2, recording.duration_s
    tail = 0.01 / max(len(found.levels), 1)
    halves = tuple(
        compare(name, own.between(0.0, middle), own.between(middle, end), tail)
        for name, own in found.levels.items()
    )
    return "Noise, 2nd half over 1st", halves


def _entries_in_time(found: Diagnosis, view: View | None, sides: Sequence[Sides]) -> list[Entry]:
    entries = []
    if view:
        for name in view.names:
            look = look_of(name)
            how = {"color": look.colour, "ls": look.dashes, "lw": 0.9}
            entries.append(Entry(name[0], line=how))
        framed = {**FRAME, "facecolor": SHADED}
        entries.append(Entry(SHOWN[view.kind], patch=framed if view.kind == "window" else SHADE))
    if found.events:
        entries.append(Entry("event", dot=EVENT))
    words = [side.word for side in sides]
    for word, (colour, marker) in COMPARED.items():
        if word in words:
            dot = {"marker": marker, "ms": 4, "mew": 0, "color": colour}
            entries.append(Entry(NOISE[word], line={"color": colour, "lw": 1.4}, dot=dot))
    return entries


def _entries_of_spectra(
    found: Diagnosis, looks: Mapping[str, Keywords], spectral: str
) -> list[Entry]:
    entries = [
        Entry("as recorded" if name == "none" else name, line={"lw": 1.4, **look})
        for name, look in looks.items()
    ]
    if any(f.series == spectral and f.predicted for f in found.filtered):
        entries.append(Entry("curve: by the noise model", line={"color": GREY, "lw": 1.2}))
        dots = {"marker": "o", "ms": 3, "mew": 0, "color": GREY}
        entries.append(Entry("points: measured", dot=dots))
    if rounding_of(found, spectral):
        entries.append(Entry("rounding of the file", line=ROUNDING))
    return entries
