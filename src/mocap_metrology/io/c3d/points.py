"""Coordinates of chosen points, mapped from the file chunk by chunk, and which are valid."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mocap_metrology.io.c3d.numbers import ieee_from_dec, raw_dtype
from mocap_metrology.io.c3d.structure import Structure

CHUNK_BYTES = 2 << 20  # of the file; a chunk and its columns stay in the processor's cache
REASONS = ("negative_residual", "zero", "not_finite")


def mm_per_step(structure: Structure) -> float:
    """What a stored coordinate is multiplied by: the unit, and for int16 also the scale."""
    return structure.mm_per_unit * (1.0 if structure.is_float else structure.scale)


def position_dtype(structure: Structure) -> np.dtype:
    """float32 where the file's floats already are mm, so nothing is computed; else float64."""
    return np.dtype(np.float32 if structure.is_float and mm_per_step(structure) == 1 else float)


def read_points(
    structure: Structure, points: Sequence[int], out: np.ndarray
) -> tuple[list[dict[str, int]], list[int]]:
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
            stored = chunk[:, 4 * point : 4 * point + 4]
            if structure.is_float and structure.processor == 85:
                stored = ieee_from_dec(stored)
            target = out[k, :, start : start + n]
            nan_residuals[k] += _fill(stored, mm_per_step(structure), target, counts[k])
    return counts, nan_residuals


def _fill(stored: np.ndarray, factor: float, target: np.ndarray, counts: dict[str, int]) -> int:
    """One point of one chunk: `stored` (n, 4) to `target` (3, n) in mm; counts are added to.

    Returns the number of NaN among the fourth words.
    """
    for axis in range(3):
        target[axis] = stored[:, axis]
    residual = np.ascontiguousarray(stored[:, 3])
    negative = residual < 0
    found = {"negative_residual": negative}
    at_zero = target[0] == 0
    if at_zero.any():
        found["zero"] = at_zero & (target[1] == 0) & (target[2] == 0) & ~negative
    with np.errstate(invalid="ignore", over="ignore"):
        sums = target.sum(axis=1)
    if not np.isfinite(sums).all():  # rarely: then the slow way
        found["not_finite"] = ~np.isfinite(target).all(axis=0) & ~negative
    for reason, mask in found.items():
        n = int(np.count_nonzero(mask))
        if n:
            counts[reason] += n
            target[:, mask] = np.nan
    if factor != 1:
        target *= factor
    return int(np.count_nonzero(np.isnan(residual))) if residual.dtype.kind == "f" else 0
