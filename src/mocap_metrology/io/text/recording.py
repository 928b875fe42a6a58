"""Read a text recording: one file or several of one take, checked as C3D files are, in mm."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import sha256
from mocap_metrology.io.c3d.checks import check_alike, check_seen, frame_rate
from mocap_metrology.io.c3d.labels import find_points
from mocap_metrology.io.c3d.recording import Recording, Segment
from mocap_metrology.io.c3d.segments import Plan, plan_by_numbers
from mocap_metrology.io.text.layout import Layout
from mocap_metrology.io.text.places import Places, find_places
from mocap_metrology.io.text.resolution import text_step_mm
from mocap_metrology.io.text.rows import REASONS, Rows, read_rows

NO_OPINION = "not asked (text)"


def read_text(
    paths: Sequence[Path],
    reader: Callable[[Path], Layout],
    markers: Sequence[str],
    frame_rate_hz: float | None,
    accept_truncated: bool,
) -> Recording:
    """Positions of `markers` in text files whose headers `reader` reads; see `read_any`."""
    given = [reader(path) for path in paths]
    check_alike(given)
    points = find_points(given[0].labels, markers, given[0].name)
    rate = frame_rate(given[0], frame_rate_hz)
    rows = [read_rows(layout, points, accept_truncated) for layout in given]
    places = [
        find_places(layout, found, rate, accept_truncated)
        for layout, found in zip(given, rows, strict=True)
    ]
    plan = plan_by_numbers(places, [place.first_frame for place in places])
    given, rows, places = ([some[i] for i in plan.order] for some in (given, rows, places))
    labels = tuple(marker.strip() for marker in markers)
    total = sum(place.n_frames for place in places) + sum(plan.gaps)
    if total < 2:
        raise Refusal(f"{given[0].name}: has 1 frame, expected at least 2 frames")
    n_rows = sum(found.n for found in rows)
    counts = _counts(rows, len(points))
    check_seen(labels, n_rows, counts, given[0].name)
    position, resolution, kind = _positions(given, points, rows, places, plan, total)
    return Recording(
        labels=labels,
        position_mm=position,
        frame_rate_hz=rate,
        units="; ".join(dict.fromkeys(layout.units for layout in given)),
        resolution_mm=resolution,
        resolution_kind=kind,
        encoding="; ".join(dict.fromkeys(layout.format for layout in given)),
        n_invalid=counts,
        n_gap_frames=total - n_rows,
        segments=_segments(given, places, plan),
        notes=(*plan.notes, *_notes(given, points, labels, rows, places)),
    )


def _counts(rows: Sequence[Rows], n_points: int) -> tuple[dict[str, int], ...]:
    """Invalid frames by reason for each point, over all files."""
    return tuple(
        {reason: sum(found.counts[k][reason] for found in rows) for reason in REASONS}
        for k in range(n_points)
    )


def _positions(
    given: Sequence[Layout],
    points: Sequence[int],
    rows: Sequence[Rows],
    places: Sequence[Places],
    plan: Plan,
    total: int,
) -> tuple[np.ndarray, float, str]:
    """(n_points, 3, total) in mm, NaN in gaps; the coarsest resolution and its kind.

    Blocks are let go as they are copied, so that memory holds the recording once.
    """
    position = np.empty((len(points), 3, total))
    at, steps = 0, []
    for layout, found, place, gap in zip(given, rows, places, plan.gaps, strict=True):
        position[:, :, at : at + gap] = np.nan
        at += gap
        part = position[:, :, at : at + place.n_frames]
        at += place.n_frames
        head = found.blocks[0]
        _fill(part, found, place, layout.mm_per_unit)
        found.blocks.append(head)
        steps.append(text_step_mm(layout, points, found, part))
        found.blocks.clear()
    return position, *max(steps)


def _fill(part: np.ndarray, rows: Rows, place: Places, mm_per_unit: float) -> None:
    if place.place is not None:
        part[:] = np.nan
    start = 0
    while rows.blocks:
        block = rows.blocks.pop(0)
        block = block.reshape(len(part), 3, -1)
        stop = start + block.shape[2]
        where = slice(start, stop) if place.place is None else place.place[start:stop]
        part[:, :, where] = block * mm_per_unit
        start = stop


def _segments(given: Sequence[Layout], places: Sequence[Places], plan: Plan) -> tuple[Segment, ...]:
    return tuple(
        Segment(
            path=layout.name,
            sha256=sha256(layout.path),
            first_frame=place.first_frame,
            n_frames=place.n_frames,
            frame_count_source=layout.declared[0] if layout.declared else "rows",
            gap_before=gap,
            second_opinion=NO_OPINION,
        )
        for layout, place, gap in zip(given, places, plan.gaps, strict=True)
    )


def _notes(
    given: Sequence[Layout],
    points: Sequence[int],
    labels: Sequence[str],
    rows: Sequence[Rows],
    places: Sequence[Places],
) -> list[str]:
    notes = []
    for layout, found, place in zip(given, rows, places, strict=True):
        notes += [f"{layout.name}: {text}" for text in (*layout.notes, *place.notes)]
        for k, (label, point) in enumerate(zip(labels, points, strict=True)):
            where, measured, gaps = f"{layout.name}: {label}", found.at_zero[k], found.counts[k]
            if point in layout.remarks:
                notes.append(f"{where}: {layout.remarks[point]}")
            if measured:
                notes.append(f"{where}: x = y = z = 0 in {measured} frames, taken as measured")
            if gaps["zero"] and layout.zero_note:
                notes.append(f"{where}: x = y = z = 0 in {gaps['zero']} frames, {layout.zero_note}")
    return notes
