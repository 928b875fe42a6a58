"""Read a recording: one C3D file or several of one take, checked, in mm."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import sha256
from mocap_metrology.io.c3d.checks import check_alike, check_seen, frame_rate
from mocap_metrology.io.c3d.labels import find_points
from mocap_metrology.io.c3d.points import REASONS, mm_per_step, position_dtype, read_points
from mocap_metrology.io.c3d.resolution import float_step_mm, rounding_step_mm
from mocap_metrology.io.c3d.second_opinion import ask_ezc3d
from mocap_metrology.io.c3d.segments import Plan, plan_segments
from mocap_metrology.io.c3d.structure import Structure, inspect


@dataclass(frozen=True)
class Segment:
    """One file of a recording; `path` is its name without the folder.

    `second_opinion`: `agrees`, `none` (ezc3d could not tell; a note says why), `not asked (...)`.
    """

    path: str
    sha256: str
    first_frame: int
    n_frames: int
    frame_count_source: str
    gap_before: int
    second_opinion: str


@dataclass(frozen=True)
class Recording:
    """Positions of chosen markers.

    `labels` as they were asked for; `position_mm` (n_markers, 3, n_frames), C-contiguous, NaN where
    invalid or between segments; float32 where the file holds float32 in mm, else float64.
    `units`, `encoding`: of the files. `resolution_mm`: the smallest step the files can tell, the
    largest over segments; `resolution_kind`: `int16`, `float32`, `rounded`.
    `n_invalid`: frames by reason for each marker, gaps between segments not counted.
    """

    labels: tuple[str, ...]
    position_mm: np.ndarray
    frame_rate_hz: float
    units: str
    resolution_mm: float
    resolution_kind: str
    encoding: str
    n_invalid: tuple[dict[str, int], ...]
    n_gap_frames: int
    segments: tuple[Segment, ...]
    notes: tuple[str, ...]


def read_recording(
    paths: Sequence[str | Path],
    markers: Sequence[str],
    frame_rate_hz: float | None = None,
    second_opinion: bool = True,
    accept_truncated: bool = False,
) -> Recording:
    """Positions of `markers` in one file or in the segments of one take.

    `frame_rate_hz` may give the rate more exactly than the files (within 0.1 %), or where they have
    none. `second_opinion` lets ezc3d read the same files, where it can, and compares.
    `accept_truncated` takes what a cut-off file holds.
    Refuses what cannot be read with certainty; the message starts with the file's name.
    """
    if not paths:
        raise Refusal("no C3D file is given")
    given = [inspect(path, accept_truncated) for path in paths]
    check_alike(given)
    points = find_points(given[0].labels, markers, given[0].name)
    rate = frame_rate(given[0], frame_rate_hz)
    plan = plan_segments(given)
    ordered = [given[i] for i in plan.order]
    total = sum(s.n_frames for s in ordered) + sum(plan.gaps)
    if total < 2:
        raise Refusal(f"{given[0].name}: has 1 frame, expected at least 2 frames")
    labels = tuple(marker.strip() for marker in markers)
    dtype = np.result_type(*(position_dtype(s) for s in ordered))
    position = np.empty((len(points), 3, total), dtype)
    counts, opinions, notes = _fill(ordered, plan, points, labels, position, second_opinion)
    check_seen(labels, total - sum(plan.gaps), counts, given[0].name)
    resolution, kind = _resolution(ordered, plan, position)
    return Recording(
        labels=labels,
        position_mm=position,
        frame_rate_hz=rate,
        units="; ".join(dict.fromkeys(s.units for s in ordered)),
        resolution_mm=resolution,
        resolution_kind=kind,
        encoding="; ".join(dict.fromkeys(s.encoding for s in ordered)),
        n_invalid=counts,
        n_gap_frames=sum(plan.gaps),
        segments=_segments(ordered, plan, opinions),
        notes=(*plan.notes, *notes),
    )


def _segments(
    segments: Sequence[Structure], plan: Plan, opinions: Sequence[str]
) -> tuple[Segment, ...]:
    return tuple(
        Segment(s.name, sha256(s.path), s.first_frame, s.n_frames, s.frame_count_source, *rest)
        for s, *rest in zip(segments, plan.gaps, opinions, strict=True)
    )


def _places(segments: Sequence[Structure], plan: Plan) -> list[slice]:
    """Where each segment lies in the recording."""
    places, at = [], 0
    for segment, gap in zip(segments, plan.gaps, strict=True):
        places.append(slice(at + gap, at + gap + segment.n_frames))
        at = places[-1].stop
    return places


def _fill(
    segments: Sequence[Structure],
    plan: Plan,
    points: Sequence[int],
    labels: Sequence[str],
    position: np.ndarray,
    second_opinion: bool,
) -> tuple[tuple[dict[str, int], ...], list[str], list[str]]:
    """Read every segment to its place; counts of invalid frames, second opinions, remarks."""
    counts = tuple(dict.fromkeys(REASONS, 0) for _ in points)
    opinions, notes = [], []
    for segment, gap, place in zip(segments, plan.gaps, _places(segments, plan), strict=True):
        position[:, :, place.start - gap : place.start] = np.nan
        found, nan_residuals = read_points(segment, points, position[:, :, place])
        for total, added in zip(counts, found, strict=True):
            for reason, n in added.items():
                total[reason] += n
        opinion, note = "not asked (switched off)", ""
        if second_opinion:
            opinion, note = ask_ezc3d(segment, points, position[:, :, place])
        opinions.append(opinion)
        notes += [f"{segment.name}: {text}" for text in (*segment.notes, note) if text]
        notes += [
            f"{segment.name}: {label}: the fourth word is NaN in {n} frames, taken as valid"
            for label, n in zip(labels, nan_residuals, strict=True)
            if n
        ]
    return counts, opinions, notes


def _resolution(
    segments: Sequence[Structure], plan: Plan, position: np.ndarray
) -> tuple[float, str]:
    """Coarsest resolution of the segments in mm, and its kind."""
    found = []
    for segment, place in zip(segments, _places(segments, plan), strict=True):
        part, unit = position[:, :, place], segment.mm_per_unit
        if not segment.is_float:
            found.append((mm_per_step(segment), "int16"))
            continue
        step = rounding_step_mm(part, unit)
        found.append((step, "rounded") if step else (float_step_mm(part, unit), "float32"))
    return max(found, key=lambda item: -1.0 if math.isnan(item[0]) else item[0])
