"""Read a take from C3D files: positions of chosen points, mapped from the files chunk by chunk."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path

import numpy as np
import numpy.typing as npt

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.c3d.frames import SATURATED, WRAP
from mocap_metrology.io.c3d.parameters import Stored, ieee_from_dec, raw_dtype
from mocap_metrology.io.c3d.second_opinion import ask_ezc3d
from mocap_metrology.io.c3d.structure import Structure, inspect
from mocap_metrology.io.recording import (
    Array,
    Choice,
    Contents,
    Counts,
    Plan,
    Recording,
    SegmentReader,
    assemble,
    check_gaps,
    choose,
    exclude_sentinels,
    overlap,
    plan_as_given,
    plan_by_numbers,
)
from mocap_metrology.io.resolution import Resolution, float_resolution
from mocap_metrology.io.units import Unit

CHUNK_BYTES = 2 << 20  # of the file; a chunk and its columns stay in the processor's cache
REASONS = ("negative_residual", "zero", "not_finite")


def read_c3d(
    paths: Sequence[Path],
    markers: Sequence[str],
    frame_rate_hz: float | None = None,
    second_opinion: bool = True,
    accept_truncated: bool = False,
    unit: Unit | None = None,
) -> Recording:
    """Positions of `markers` in one C3D file or in the segments of one take.

    Arguments as of `io.read.read_recording`. `n_invalid` by `negative_residual`, `zero`,
    `not_finite`, of integers also `saturated`.
    """
    if not paths:
        raise Refusal("no C3D file is given")
    headers = [inspect(path, accept_truncated) for path in paths]
    files = [replace(file, unit=file.unit.stated(unit, file.name)) for file in headers]
    choice = choose(files, markers, frame_rate_hz)
    plan = plan_segments(files)
    readers = [_segment_reader(files[i], choice, second_opinion) for i in plan.order]
    return assemble(readers, plan, choice, files[0].name)


def plan_segments(segments: Sequence[Structure]) -> Plan:
    """Order and gaps of the segments of one take.

    Where TRIAL of every segment agrees with its frame count, it says both. Otherwise the given
    order holds, and the header's first frame, which counts modulo 65536, gives the gaps. Where all
    segments start at the same number nothing does, and no gap is assumed.
    Refuses segments that overlap, and headers whose first frame is at its 16-bit limit.
    """
    if len(segments) > 1 and all(s.trial is not None for s in segments):
        return plan_by_numbers(segments, _trial_firsts(segments))
    firsts = [s.header_first for s in segments]
    if len(set(firsts)) == 1:
        return plan_as_given(firsts)
    gaps = _header_gaps(segments)
    check_gaps(segments, range(len(segments)), gaps)
    return Plan(tuple(range(len(segments))), (0, *gaps))


def _trial_firsts(segments: Sequence[Structure]) -> list[int]:
    """First frames by TRIAL, with one base for all where one goes with every count."""
    bases = [WRAP - 1, WRAP] if any(s.trial_base == WRAP - 1 for s in segments) else [WRAP]
    for base in bases:
        if all(s.trial is not None and s.trial.count(base) == s.n_frames for s in segments):
            return [s.trial.first(base) for s in segments if s.trial is not None]
    return [s.first_frame for s in segments]


def _header_gaps(segments: Sequence[Structure]) -> list[int]:
    firsts = [s.header_first for s in segments]
    for s in segments:
        if s.header_first == s.header_last and s.header_first in SATURATED and s.n_frames > 1:
            raise Refusal(
                f"{s.name}: its first frame is at the 16-bit limit {s.header_first} in the "
                "header and TRIAL does not state it, so the gap before this segment is unknown"
            )
    if len(set(firsts)) < len(firsts):
        twice = next(i for i, first in enumerate(firsts) if first in firsts[:i])
        a = firsts.index(firsts[twice])
        raise overlap(segments[a], firsts[a], segments[twice], firsts[twice])
    gaps = []
    for one, other in pairwise(segments):
        gap = (other.header_first - one.header_first - one.n_frames) % WRAP
        if gap >= WRAP // 2:
            raise overlap(one, one.header_first, other, other.header_first)
        gaps.append(gap)
    return gaps


def _segment_reader(structure: Structure, choice: Choice, second_opinion: bool) -> SegmentReader:
    return SegmentReader(
        path=structure.path,
        unit=structure.unit,
        encoding=structure.encoding,
        first_frame=structure.first_frame,
        n_frames=structure.n_frames,
        n_measured=structure.n_frames,
        frame_count_source=structure.frame_count_source,
        dtype=position_dtype(structure),
        read=partial(_read_segment, structure, choice, second_opinion),
    )


def _read_segment(
    structure: Structure, choice: Choice, second_opinion: bool, out: Array
) -> Contents:
    """Read one file into `out`, and compare it with ezc3d."""
    counts, nan_residuals = read_points(structure, choice.points, out)
    opinion, note = "not asked (switched off)", ""
    if second_opinion:
        opinion, note = ask_ezc3d(structure, choice.points, out)
    said = (*structure.notes, structure.unit.remark, note)
    notes = [f"{structure.name}: {text}" for text in said if text]
    notes += [
        f"{structure.name}: {label}: the fourth word is NaN in {n} frames, taken as valid"
        for label, n in zip(choice.labels, nan_residuals, strict=True)
        if n
    ]
    if not structure.is_float:
        for label, position, count in zip(choice.labels, out, counts, strict=True):
            n = _exclude_saturated(position, mm_per_step(structure))
            if n:
                count["saturated"] = n
                notes.append(
                    f"{structure.name}: {label}: {n} frames at the limit of 16-bit integers "
                    "(saturated), taken as missing"
                )
    unit_mm = structure.unit.mm
    notes += exclude_sentinels(out, choice.labels, counts, unit_mm, structure.name)
    if structure.is_float:
        resolution = float_resolution(out, unit_mm)
    else:
        resolution = Resolution(mm_per_step(structure), "int16")
    return Contents(counts, resolution, opinion, notes)


def _exclude_saturated(position: Array, step_mm: float) -> int:
    """Make positions (3, n_frames) NaN where a stored coordinate is at the limit of its range, as
    whatever lies beyond is stored so, too. Returns their number. (To ezc3d they are valid, so this
    follows its second opinion.)"""
    limits = np.iinfo(np.int16)
    beyond = (position <= limits.min * step_mm) | (position >= limits.max * step_mm)
    saturated = beyond.any(axis=0)
    position[:, saturated] = np.nan
    return int(np.count_nonzero(saturated))


def mm_per_step(structure: Structure) -> float:
    """What a stored coordinate is multiplied by: the unit, and for int16 also the scale."""
    return structure.unit.mm * (1.0 if structure.is_float else structure.scale)


def position_dtype(structure: Structure) -> np.dtype[np.floating]:
    """float32 where the file's floats already are mm, so nothing is computed; else float64."""
    in_mm = structure.is_float and mm_per_step(structure) == 1
    return np.dtype(np.float32) if in_mm else np.dtype(np.float64)


def read_points(
    structure: Structure, points: Sequence[int], out: Array
) -> tuple[list[Counts], list[int]]:
    """Fill `out` (n_points, 3, n_frames) with positions in mm, NaN where invalid.

    `points` are places of points in the file, from 0. A position is invalid, for the first reason
    that holds: its fourth word is negative (no measurement); x = y = z = 0 (what some systems
    write for no measurement); a coordinate is NaN or infinite.
    Returns the number of invalid frames by reason for each point, and for each point the number of
    frames whose fourth word is NaN (taken as valid).
    """
    dtype = raw_dtype(structure.processor, structure.is_float)
    words = structure.frame_bytes // dtype.itemsize
    n_chunk = max(1, CHUNK_BYTES // structure.frame_bytes)
    counts = [dict.fromkeys(REASONS, 0) for _ in points]
    nan_residuals = [0] * len(points)
    for start in range(0, structure.n_frames, n_chunk):
        n = min(n_chunk, structure.n_frames - start)
        offset = structure.data_offset + start * structure.frame_bytes
        # A new map for each chunk: what was read does not stay in this process's memory.
        chunk = np.memmap(structure.path, dtype, "r", offset, (n, words))
        for k, point in enumerate(points):
            stored: npt.NDArray[Stored] = chunk[:, 4 * point : 4 * point + 4]
            if structure.is_float and structure.processor == 85:
                stored = ieee_from_dec(stored)
            target = out[k, :, start : start + n]
            nan_residuals[k] += _fill(stored, mm_per_step(structure), target, counts[k])
    return counts, nan_residuals


def _fill(stored: npt.NDArray[Stored], factor: float, target: Array, counts: Counts) -> int:
    """One point of one chunk: `stored` (n, 4) to `target` (3, n) in mm; counts are added to.

    Returns the number of NaN among the fourth words.
    """
    for axis in range(3):
        target[axis] = stored[:, axis]
    residual = np.ascontiguousarray(stored[:, 3])
    negative = residual < 0
    masks = {"negative_residual": negative}
    at_zero = target[0] == 0
    if at_zero.any():
        masks["zero"] = at_zero & (target[1] == 0) & (target[2] == 0) & ~negative
    with np.errstate(invalid="ignore", over="ignore"):
        sums = target.sum(axis=1)
    if not np.isfinite(sums).all():  # rarely: then the slow way
        masks["not_finite"] = ~np.isfinite(target).all(axis=0) & ~negative
    for reason, mask in masks.items():
        n = int(np.count_nonzero(mask))
        if n:
            counts[reason] += n
            target[:, mask] = np.nan
    if factor != 1:
        target *= factor
    return int(np.count_nonzero(np.isnan(residual))) if residual.dtype.kind == "f" else 0
