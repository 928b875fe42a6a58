"""Orientations of bodies in text recordings, frame by frame beside their positions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.c3d.labels import find_points
from mocap_metrology.io.text.layout import Layout
from mocap_metrology.io.text.recording import read_text

ORTHOGONAL = 1e-3  # how far R R^T, or the length of a quaternion, may be from 1
PARTS = 4  # series of three numbers: the position, and up to nine numbers of a rotation


def read_orientation(
    paths: Sequence[Path],
    reader: Callable[[Path], Layout],
    marker: str,
    frame_rate_hz: float | None = None,
    accept_truncated: bool = False,
) -> np.ndarray:
    """Unit quaternions x, y, z, w (4, n) that turn the axes of a body into those of the room, in
    the frames of `read_text`; their sign does not jump; NaN where the body was not seen.

    Refuses a marker without orientation, and numbers that are no rotation.
    """
    names = [f"part {k}" for k in range(PARTS)]
    kinds = set()

    def parts(path: Path) -> Layout:
        layout = reader(path)
        place = find_points(layout.labels, [marker], layout.name)[0]
        if place not in layout.turned:
            raise Refusal(f"{layout.name}: {marker!r} is a marker, which has no orientation")
        turn = layout.turned[place]
        kinds.add(turn.kind)
        cells = [*layout.columns[place], *turn.columns]
        cells += cells[-1:] * (3 * PARTS - len(cells))
        three = tuple(tuple(cells[i : i + 3]) for i in range(0, 3 * PARTS, 3))
        return replace(layout, labels=tuple(names), columns=three, mm_per_unit=1.0, remarks={})

    recording = read_text(paths, parts, names, frame_rate_hz, accept_truncated)
    values = recording.position_mm.reshape(3 * PARTS, -1)
    seen = np.isfinite(values).all(axis=0)
    if not seen.any():
        raise Refusal(f"{paths[0].name}: {marker!r} has no orientation in any frame")
    found = np.full((4, values.shape[1]), np.nan)
    found[:, seen] = _quaternions(values[3:, seen], kinds.pop(), paths[0].name, marker)
    return found


def _quaternions(values: np.ndarray, kind: str, file: str, marker: str) -> np.ndarray:
    """(4, n) of the numbers of a rotation (9, n), of which a kind uses the first ones."""
    from scipy.spatial.transform import Rotation

    if kind == "matrix":
        matrix = values.T.reshape(-1, 3, 3)
        off = np.abs(matrix @ matrix.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
        wrong = (off > ORTHOGONAL) | (np.linalg.det(matrix) < 0)
        turn = Rotation.from_matrix(np.where(wrong[:, None, None], np.eye(3), matrix))
    elif kind == "quaternion":
        length = np.linalg.norm(values[:4], axis=0)
        wrong = np.abs(length - 1) > ORTHOGONAL
        turn = Rotation.from_quat(np.where(wrong, [[0.0], [0.0], [0.0], [1.0]], values[:4]).T)
    else:
        wrong = np.abs(values[:3]).max(axis=0) > 360
        turn = Rotation.from_euler(kind, values[:3].T, degrees=True)
    if wrong.any():
        what = "angles" if len(kind) == 3 else f"a {kind}"
        frame = int(np.argmax(wrong)) + 1
        raise Refusal(f"{file}: {marker!r}: {what} of no rotation, first in seen frame {frame}")
    return without_jumps(turn.as_quat()).T


def without_jumps(quaternions: np.ndarray) -> np.ndarray:
    """(n, 4) with signs that make each nearer to the one before than its negative is."""
    jumps = np.where((quaternions[1:] * quaternions[:-1]).sum(axis=1) < 0, -1.0, 1.0)
    quaternions[1:] *= np.cumprod(jumps)[:, None]
    return quaternions
