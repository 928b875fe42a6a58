"""Read a take from C3D files: positions of chosen points, mapped from the files chunk by chunk."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.c3d.frames import SATURATED, WRAP
from mocap_metrology.io.c3d.parameters import Stored, ieee_from_dec, raw_dtype
from mocap_metrology.io.c3d.second_opinion import ask_ezc3d
from mocap_metrology.io.c3d.structure import Structure
from mocap_metrology.io.recording import (
    Array,
    Choice,
    Contents,
    Counts,
    SegmentReader,
    exclude_sentinels,
    overlap,
)
from mocap_metrology.io.resolution import Resolution, float_resolution

CHUNK_BYTES = 2 << 20  # of the file; a chunk and its columns stay in the processor's cache
SAMPLE = 2000  # frames whose residuals are looked at, evenly over the file
REASONS = ("negative_residual", "zero", "not_finite")


def readers(files: Sequence[Structure], choice: Choice) -> list[SegmentReader]:
    """How each file is read; `n_invalid` by `negative_residual`, `zero`, `not_finite`, of integers
    also `saturated`."""
    return [
        SegmentReader(
            file=file,
            first_frame=file.first_frame,
            number=number,
            n_frames=file.n_frames,
            n_measured=file.n_frames,
            frame_count_source=file.frame_count_source,
            dtype=np.dtype(np.float32 if file.is_float and mm_per_step(file) == 1 else np.float64),
            read=partial(_read_segment, file, choice),
        )
        for file, number in zip(files, _numbers(files), strict=True)
    ]


def _numbers(segments: Sequence[Structure]) -> list[int]:
    """Numbers of the first frames of the segments of one take.

    Where TRIAL of every segment agrees with its frame count, it says them, with one base for all
    where one goes with every count. Otherwise the given order holds, and the header's first frame,
    which counts modulo 65536, gives the gaps. Where all segments start at the same number nothing
    does. Refuses segments that overlap, and headers whose first frame is at its 16-bit limit.
    """
    trials = [s.trial for s in segments if s.trial is not None]
    if len(trials) == len(segments) > 1:
        base = min(s.trial_base or WRAP for s in segments)
        if [trial.count(base) for trial in trials] == [s.n_frames for s in segments]:
            return [trial.first(base) for trial in trials]
        return [s.first_frame for s in segments]
    firsts = [s.header_first for s in segments]
    return firsts if len(set(firsts)) == 1 else _unwrapped(segments, firsts)


def _unwrapped(segments: Sequence[Structure], firsts: Sequence[int]) -> list[int]:
    frames = [range(s.header_first, s.header_first + s.n_frames) for s in segments]
    for k, s in enumerate(segments):
        if s.header_first == s.header_last and s.header_first in SATURATED and s.n_frames > 1:
            raise Refusal(
                f"{s.name}: its first frame is at the 16-bit limit {s.header_first} in the "
                "header and TRIAL does not state it, so the gap before this segment is unknown"
            )
        if s.header_first in firsts[:k]:
            twice = firsts.index(s.header_first)
            raise overlap(segments[twice].name, frames[twice], s.name, frames[k])
    numbers = [firsts[0]]
    for k, (one, other) in enumerate(pairwise(segments)):
        gap = (other.header_first - frames[k].stop) % WRAP
        if gap >= WRAP // 2:
            raise overlap(one.name, frames[k], other.name, frames[k + 1])
        numbers.append(numbers[-1] + one.n_frames + gap)
    return numbers


def _read_segment(structure: Structure, choice: Choice, out: Array) -> Contents:
    """Read one file into `out`, and compare it with ezc3d."""
    counts, nan_residuals = read_points(structure, choice.points, out)
    opinion, note = "not asked (switched off)", ""
    if choice.second_opinion:
        opinion, note = ask_ezc3d(structure, choice.points, out)
    notes = [note]
    notes += [
        f"{label}: the fourth word is NaN in {n} frames, taken as valid"
        for label, n in zip(choice.labels, nan_residuals, strict=True)
        if n
    ]
    if not structure.is_float:
        for label, position, count in zip(choice.labels, out, counts, strict=True):
            n = _exclude_saturated(position, mm_per_step(structure))
            if n:
                count["saturated"] = n
                notes.append(
                    f"{label}: {n} frames at the limit of 16-bit integers (saturated), taken as"
                    " missing"
                )
    notes += exclude_sentinels(out, choice.labels, counts, structure.unit.mm)
    if structure.is_float:
        resolution = float_resolution(out, structure.unit.mm)
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


def computed_points(structure: Structure) -> frozenset[int]:
    """Places (from 0) of the points that were computed, not measured.

    Software stores angles, powers and the axes of its models as points, and lists most of them in
    parameters of POINT (ANGLES, POWERS, ...). A point that is computed has the residual 0 [C3D user
    guide, "The residual value"]; where any point of the file has another residual, those that never
    have one were not measured.
    """
    listed = {k for k, label in enumerate(structure.labels) if label in structure.listed}
    dtype = raw_dtype(structure.processor, structure.is_float)
    shape = structure.n_frames, structure.frame_bytes // dtype.itemsize
    every = np.memmap(structure.path, dtype, "r", structure.data_offset, shape)
    frames = every[:: max(structure.n_frames // SAMPLE, 1), : 4 * structure.n_points]
    words: npt.NDArray[Stored] = np.asarray(frames).reshape(len(frames), structure.n_points, 4)
    if structure.is_float and structure.processor == 85:
        words = ieee_from_dec(words)
    measured = (words[..., 3] > 0).any(axis=0)
    there = ((words[..., 3] == 0) & (words[..., :3] != 0).any(axis=2)).any(axis=0)
    without = np.flatnonzero(there & ~measured).tolist() if measured.any() else []
    return frozenset([*listed, *without])
