"""Pose of a tracker as text: a comment line, then the 3x4 matrix [R|t] of each frame, t in m.

Layout of the Vive tracker recordings of Gravert's Vive-Accuracy-Experiment: line 1 begins with #
and names the rate that was asked for (`Freq: 250`); then 12 numbers a line, row by row, with
spaces or tabs between. There is no time stamp.
"""

from __future__ import annotations

import itertools
import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.text.head import check_text, lines
from mocap_metrology.io.text.layout import Layout, Turned, number, rate
from mocap_metrology.io.text.orientation import ORTHOGONAL, without_jumps
from mocap_metrology.io.text.rows import line_of, read_rows

WHAT = "a text of poses (12 numbers a line)"
LABEL = "tracker"
POSITION = (3, 7, 11)
ROTATION = ((0, 1, 2), (4, 5, 6), (8, 9, 10))


@dataclass(frozen=True)
class Poses:
    """`position_mm` (3, n) and `orientation_xyzw` (4, n), a unit quaternion whose sign does not
    jump; both NaN where a frame has no pose. `frame_rate_hz` 0 where the file tells none."""

    position_mm: np.ndarray
    orientation_xyzw: np.ndarray
    frame_rate_hz: float
    notes: tuple[str, ...]


def layout(path: Path) -> Layout:
    """Read the first lines; the position is that of one marker, `tracker`."""
    check_text(path, WHAT)
    comment, told = "", 0.0
    for line in itertools.islice(lines(path), 20):
        if line.text.startswith("#"):
            comment += line.text
        elif line.text.strip():
            break
    else:
        raise Refusal(f"{path.name}: has no frames: nothing follows the comment")
    cells = line.cells(" ")
    if len(cells) != 12 or number(cells[0]) is None:
        start = line.text[:30]
        raise Refusal(f"{path.name}: is not {WHAT}: line {line.number} is {start!r}")
    if found := re.search(r"Freq:\s*([0-9.]+)", comment):
        told = rate(found[1])
    notes = (f"{told:g} Hz is the rate asked for; rows have no time",) if told else ()
    return Layout(
        path=path,
        format="pose text",
        labels=(LABEL,),
        columns=(POSITION,),
        frame_rate_hz=told,
        units="m",
        mm_per_unit=1000.0,
        delimiter=" ",
        data_line=line.number,
        data_offset=line.start,
        n_columns=12,
        notes=notes,
        turned={0: Turned(tuple(i for three in ROTATION for i in three), "matrix")},
    )


def read_pose_txt(path: str | Path, accept_truncated: bool = False) -> Poses:
    """Positions and orientations; refuses a matrix that is no rotation, with its line."""
    from scipy.spatial.transform import Rotation

    of_position = layout(Path(path))
    whole = replace(of_position, labels=("R 1", "R 2", "R 3", LABEL), columns=(*ROTATION, POSITION))
    rows = read_rows(whole, range(4), accept_truncated)
    values = np.concatenate(rows.blocks, axis=1)
    matrix = values[:9].T.reshape(-1, 3, 3)
    known = np.isfinite(matrix).all(axis=(1, 2))
    matrix = np.where(known[:, None, None], matrix, np.eye(3))
    off = np.abs(matrix @ matrix.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
    wrong = (off > ORTHOGONAL) | (np.linalg.det(matrix) < 0)
    if wrong.any():
        line = line_of(whole, int(np.argmax(wrong)))
        raise Refusal(f"{whole.name}: line {line}: columns 1-3, 5-7, 9-11 are no rotation")
    quaternion = without_jumps(Rotation.from_matrix(matrix).as_quat())
    quaternion[~known] = np.nan
    notes = (*of_position.notes, *rows.notes)
    return Poses(values[9:] * 1000.0, quaternion.T, of_position.frame_rate_hz, notes)
