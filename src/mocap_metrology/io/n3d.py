"""NDI N3D: positions of an Optotrak as its software writes them beside its exports.

Layout as read by kineticstoolkit and by Optotrak readers in MATLAB (motorbehaviour's, BodyMech's
readNDF), which agree: a header of 256 bytes, little-endian (a byte 32; int16 markers; int16 numbers
of each; int32 frames; float32 rate in Hz; text of 60, 60 and 30 characters; int16 cutoff; time and
date), then each frame as float32, x y z in mm a marker. A marker that was not seen has -3.697e28.
It has no names of markers: they are Marker_1, Marker_2 ... as in the exports.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from mocap_metrology.common.errors import Refusal, Truncated
from mocap_metrology.io.header import refuse_other, regular_size
from mocap_metrology.io.recording import (
    Array,
    Choice,
    Contents,
    Counts,
    Header,
    SegmentReader,
)
from mocap_metrology.io.resolution import float_resolution
from mocap_metrology.io.units import MILLIMETRE

WHAT = "an N3D file"
HEADER_BYTES = 256
FIELDS = struct.Struct("<Bhhif")
MISSING_BELOW = -3e28
REASONS = ("missing", "zero", "not_finite")


@dataclass(frozen=True, kw_only=True)
class N3d(Header):
    """The header of a file; `n_frames` of those that it declares are there."""

    n_frames: int


def header(path: Path, accept_truncated: bool = False) -> N3d:
    """Read the header; refuses what is none, or another size of the file than it declares."""
    size = regular_size(path, WHAT)
    with path.open("rb") as stream:
        block = stream.read(HEADER_BYTES)
    refuse_other(path, block, WHAT)
    if len(block) < HEADER_BYTES:
        raise Refusal(f"{path.name}: cut off: {size} bytes, the header alone has {HEADER_BYTES}")
    mark, n_points, n_numbers, n_frames, rate_hz = FIELDS.unpack(block[: FIELDS.size])
    plausible = n_points > 0 and n_frames > 0 and math.isfinite(rate_hz) and 0 < rate_hz < 1e6
    if mark != 32 or not plausible:
        raise Refusal(
            f"{path.name}: is not {WHAT}: its first byte is {mark} (expected 32), it declares"
            f" {n_points} markers, {n_frames} frames, {rate_hz:g} Hz"
        )
    if n_numbers != 3:
        raise Refusal(f"{path.name}: has {n_numbers} numbers a marker, expected 3 (x, y, z)")
    there, rest = divmod(size - HEADER_BYTES, 4 * 3 * n_points)
    if there > n_frames or (there == n_frames and rest):
        more = size - HEADER_BYTES - 12 * n_points * n_frames
        raise Refusal(f"{path.name}: {more} bytes follow the {n_frames} frames of its header")
    notes: tuple[str, ...] = ()
    if there < n_frames:
        why = f"cut off: {there} of the {n_frames} frames that its header states"
        if not accept_truncated or there == 0:
            raise Truncated(f"{path.name}: {why}")
        notes = (f"{why}; used as it is",)
    return N3d(
        path=path,
        labels=tuple(f"Marker_{k}" for k in range(1, n_points + 1)),
        unit=MILLIMETRE,
        frame_rate_hz=float(rate_hz),
        encoding="N3D",
        notes=notes,
        n_frames=there,
    )


def readers(files: Sequence[N3d], choice: Choice) -> list[SegmentReader]:
    """How each file is read; `n_invalid` by `missing`, `zero`, `not_finite`."""
    return [
        SegmentReader(
            file=file,
            first_frame=1,
            number=1,
            n_frames=file.n_frames,
            n_measured=file.n_frames,
            frame_count_source="header",
            dtype=np.dtype(np.float32 if file.unit.mm == 1 else np.float64),
            read=partial(_read_segment, file, choice),
        )
        for file in files
    ]


def _read_segment(file: N3d, choice: Choice, out: Array) -> Contents:
    """Read one file into `out`; what is not measured becomes NaN and is counted."""
    shape = (file.n_frames, len(file.labels), 3)
    stored = np.memmap(file.path, "<f4", "r", HEADER_BYTES, shape)
    counts: list[Counts] = []
    for target, point in zip(out, choice.points, strict=True):
        target[:] = stored[:, point].T
        missing = (target < MISSING_BELOW).any(axis=0)
        zero = (target == 0).all(axis=0)
        infinite = ~np.isfinite(target).all(axis=0) & ~missing
        sums = (int(mask.sum()) for mask in (missing, zero, infinite))
        counts.append(dict(zip(REASONS, sums, strict=True)))
        target[:, missing | zero | infinite] = np.nan
        target *= file.unit.mm
    return Contents(counts, float_resolution(out, file.unit.mm), "not asked (N3D)", [])
