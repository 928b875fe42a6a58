"""Orientations of bodies frame by frame beside their positions, and a text of poses.

The text is a comment line, then the 3x4 matrix [R|t] of each frame, t in m. Layout of the Vive
tracker recordings of Gravert's Vive-Accuracy-Experiment: line 1 begins with # and names the rate
that was asked for (`Freq: 250`); then 12 numbers a line, row by row, with spaces or tabs between.
There is no time stamp. Several bodies have their names in the comment, `bodies: A;B`, and 12
numbers each, or 7 with `quaternion: wxyz` or `xyzw` there: x y z in m, then the quaternion in this
order.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.header import number
from mocap_metrology.io.labels import find_points
from mocap_metrology.io.recording import read_take
from mocap_metrology.io.text import table
from mocap_metrology.io.text.columns import BODY_LABEL
from mocap_metrology.io.text.layout import Layout, RotationColumns, lines, rate
from mocap_metrology.io.text.read import readers
from mocap_metrology.io.text.rows import Floats
from mocap_metrology.io.units import METRE, LengthUnit

POSITION = (3, 7, 11)
MATRIX = (0, 1, 2, 4, 5, 6, 8, 9, 10)
BODIES = re.compile(r"bodies:\s*([^:#]*?)(?=\s*(?:$|#|\w+:))")
QUATERNION = re.compile(r"quaternion:\s*(wxyz|xyzw)\b")
ORTHOGONAL = 1e-3  # how far R R^T, or the length of a quaternion, may be from 1
NO_LENGTH = LengthUnit("", 1.0, "given")
PARTS = 4  # series of three numbers: the position, and up to nine numbers of a rotation


def layout(path: Path) -> Layout:
    """Read the first lines of a text of poses; the position of a matrix is that of one marker,
    `tracker`. Columns with names are a table."""
    head = []
    for line in itertools.islice(lines(path), 20):
        if line.text.startswith("#"):
            head.append(line.text)
        elif line.text.strip():
            break
    else:
        raise Refusal(f"{path.name}: has no frames: nothing follows the comment")
    cells = line.cells(" ")
    said = " ".join(head)
    bodies = _bodies(said, path.name)
    order = QUATERNION.search(said)
    size = 7 if order else 12
    names = [word for text in head for word in text.split() if word in ("x", "qx", "tx")]
    if (
        names
        or (bodies == (BODY_LABEL,) and (order or len(cells) != 12))
        or number(cells[0]) is None
    ):
        return table.layout(path)
    if len(cells) != size * len(bodies):
        what = f"{len(cells)} numbers a line; expected {size} for each of {', '.join(bodies)}"
        raise Refusal(f"{path.name}: {what}")
    match = table.FREQUENCY.search(said)
    told = rate(match[1], path.name) if match else 0.0
    n, kind = len(bodies), "quaternion" if order else "matrix"
    x, y, z = (0, 1, 2) if order else POSITION
    turn = MATRIX if order is None else tuple(3 + order[1].index(axis) for axis in "xyzw")
    return Layout(
        path=path,
        encoding="pose text",
        labels=bodies,
        columns=tuple((x + size * k, y + size * k, z + size * k) for k in range(n)),
        frame_rate_hz=told,
        unit=METRE,
        delimiter=" ",
        first=line,
        n_columns=size * n,
        full_rows=True,
        notes=(table.REQUESTED.format(told),) if told else (),
        rotations={
            k: RotationColumns(tuple(column + size * k for column in turn), kind) for k in range(n)
        },
    )


def _bodies(said: str, file: str) -> tuple[str, ...]:
    """Names in the comment, the usual one without such."""
    match = BODIES.search(said)
    names = tuple(name.strip() for name in match[1].split(";")) if match else (BODY_LABEL,)
    if "" in names or len(set(names)) < len(names):
        raise Refusal(f"{file}: bodies: {';'.join(names)}; expected names, none repeated")
    return names


def read_orientation(
    headers: Sequence[Layout], marker: str, frame_rate_hz: float | None, accept_truncated: bool
) -> Floats:
    """Unit quaternions x, y, z, w (4, n) that turn the axes of a body into those of the room, in
    the frames of `readers`; their sign does not jump; NaN where the body was not seen.

    Refuses a marker without orientation, and numbers that are no rotation.
    """
    names = tuple(f"part {k}" for k in range(PARTS))
    kinds, files = set(), []
    for first in headers:
        place = find_points(first.labels, [marker], first.name)[0]
        if place not in first.rotations:
            raise Refusal(f"{first.name}: {marker!r} is a marker, which has no orientation")
        rotation = first.rotations[place]
        kinds.add(rotation.kind)
        cells = [*first.columns[place], *rotation.columns]
        cells += cells[-1:] * (3 * PARTS - len(cells))
        three = tuple((cells[i], cells[i + 1], cells[i + 2]) for i in range(0, 3 * PARTS, 3))
        files.append(replace(first, labels=names, columns=three, unit=NO_LENGTH, remarks={}))
    recording = read_take(files, readers, names, frame_rate_hz, None, False, accept_truncated)
    values = recording.position_mm.reshape(3 * PARTS, -1).astype(np.float64, copy=False)
    seen = np.isfinite(values).all(axis=0)
    if not seen.any():
        raise Refusal(f"{files[0].name}: {marker!r} has no orientation in any frame")
    xyzw = np.full((4, values.shape[1]), np.nan)
    xyzw[:, seen] = _quaternions(values[3:, seen], kinds.pop(), files[0].name, marker)
    return xyzw


def _quaternions(values: Floats, kind: str, file: str, marker: str) -> Floats:
    """(4, n) of the numbers of a rotation (9, n), of which a kind uses the first ones."""
    from scipy.spatial.transform import Rotation

    if kind == "matrix":
        numbers, made = values.T.reshape(-1, 3, 3), Rotation.from_matrix
        off = np.abs(numbers @ numbers.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
        wrong = (off > ORTHOGONAL) | (np.linalg.det(numbers) < 0)
    elif kind == "quaternion":
        numbers, made = values[:4].T, Rotation.from_quat
        wrong = np.abs(np.linalg.norm(numbers, axis=1) - 1) > ORTHOGONAL
    else:
        numbers, made = values[:3].T, partial(Rotation.from_euler, kind, degrees=True)
        wrong = np.abs(numbers).max(axis=1) > 360
    if wrong.any():
        what = "angles" if len(kind) == 3 else f"a {kind}"
        frame = int(np.argmax(wrong)) + 1
        raise Refusal(f"{file}: {marker!r}: {what} of no rotation, first in seen frame {frame}")
    return _without_jumps(made(numbers).as_quat()).T


def _without_jumps(quaternions: Floats) -> Floats:
    """(n, 4) with signs that make each nearer to the one before than its negative is."""
    jumps = np.where((quaternions[1:] * quaternions[:-1]).sum(axis=1) < 0, -1.0, 1.0)
    quaternions[1:] *= np.cumprod(jumps)[:, None]
    return quaternions
