"""Points of a C3D file that were computed, not measured.

Software stores angles, powers and the axes of its models as points, and lists most of them in
parameters of POINT (ANGLES, POWERS, ...). A point that is computed has the residual 0 [C3D user
guide, "The residual value"]; where any point of the file has another residual, those that never
have one were not measured.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from mocap_metrology.io.c3d.parameters import Stored, ieee_from_dec, raw_dtype
from mocap_metrology.io.c3d.structure import Structure

SAMPLE = 2000  # frames whose residuals are looked at, evenly over the file


def computed_points(structure: Structure) -> frozenset[int]:
    """Places (from 0) of the points that were computed."""
    listed = {k for k, label in enumerate(structure.labels) if label in structure.listed}
    return frozenset(listed | _without_residual(structure))


def _without_residual(structure: Structure) -> set[int]:
    dtype = raw_dtype(structure.processor, structure.is_float)
    shape = structure.n_frames, structure.frame_bytes // dtype.itemsize
    every = np.memmap(structure.path, dtype, "r", structure.data_offset, shape)
    frames = every[:: max(structure.n_frames // SAMPLE, 1), : 4 * structure.n_points]
    words: npt.NDArray[Stored] = np.asarray(frames).reshape(len(frames), structure.n_points, 4)
    if structure.is_float and structure.processor == 85:
        words = ieee_from_dec(words)
    measured = (words[..., 3] > 0).any(axis=0)
    there = ((words[..., 3] == 0) & (words[..., :3] != 0).any(axis=2)).any(axis=0)
    return set(np.flatnonzero(there & ~measured).tolist()) if measured.any() else set()
