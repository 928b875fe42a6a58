"""Which reader a file has, by its suffix; and for `.csv` by what it begins with."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.c3d.labels import find_points
from mocap_metrology.io.c3d.recording import Recording, read_recording
from mocap_metrology.io.c3d.structure import inspect
from mocap_metrology.io.text import motive, nexus, pose_txt, qualisys, trc
from mocap_metrology.io.text.head import check_text, lines
from mocap_metrology.io.text.layout import Layout
from mocap_metrology.io.text.orientation import read_orientation
from mocap_metrology.io.text.recording import read_text


def csv_layout(path: Path) -> Layout:
    """Motive by the names in line 1, Nexus by its section Trajectories."""
    check_text(path, "a Motive or Vicon Nexus export")
    first = next((line.text for line in lines(path) if line.text.strip()), "")
    if first.lstrip('"').startswith(motive.START):
        return motive.layout(path)
    if nexus.section(path) is not None:
        return nexus.layout(path)
    nexus.refuse_old(path)
    raise Refusal(
        f"{path.name}: is neither a Motive export, whose line 1 starts with Format Version, nor a"
        " Vicon Nexus export with a section Trajectories"
    )


def txt_layout(path: Path) -> Layout:
    """Poses; an old Vicon export is named."""
    check_text(path, pose_txt.WHAT)
    nexus.refuse_old(path)
    return pose_txt.layout(path)


READERS: dict[str, Callable[[Path], Layout]] = {
    ".trc": trc.layout,
    ".csv": csv_layout,
    ".tsv": qualisys.layout,
    ".txt": txt_layout,
}


def read_any(
    paths: Sequence[str | Path],
    markers: Sequence[str],
    frame_rate_hz: float | None = None,
    second_opinion: bool = True,
    accept_truncated: bool = False,
) -> Recording:
    """Positions of `markers` in one file or in the segments of one take, of one format.

    Arguments and result as of `c3d.recording.read_recording`; a second opinion there is on
    C3D only. Text: `n_invalid` by `empty`, `zero`, `not_finite`; frames whose numbers are missing
    count as `n_gap_frames`; `resolution_kind` is `text` where the decimals limit it.
    """
    paths = [Path(path) for path in paths]
    suffixes = list(dict.fromkeys(path.suffix.lower() for path in paths))
    readers = {READERS.get(suffix) for suffix in suffixes}
    if len(readers) > 1:
        given = ", ".join(suffixes)
        raise Refusal(f"{paths[0].name}: segments of one take differ in format: {given}")
    reader = next(iter(readers), None)
    if reader is None:
        return read_recording(paths, markers, frame_rate_hz, second_opinion, accept_truncated)
    try:
        return read_text(paths, reader, markers, frame_rate_hz, accept_truncated)
    except OSError as error:
        raise Refusal(f"{paths[0].name}: cannot be read: {error.strerror or error}") from error


def labels_of(path: str | Path, accept_truncated: bool = False) -> tuple[str, ...]:
    """Labels of a file, in its order; of solved bodies only where there is no marker."""
    if Path(path).suffix.lower() not in READERS:
        return inspect(path, accept_truncated).labels
    layout = _layout(Path(path))
    markers = tuple(one for k, one in enumerate(layout.labels) if k not in layout.turned)
    return markers or layout.labels


def bodies_of(path: str | Path, markers: Sequence[str] | None = None) -> tuple[str, ...]:
    """Labels of a file, or those of the chosen `markers` as they were asked for, that have an
    orientation beside their position."""
    if Path(path).suffix.lower() not in READERS:
        return ()
    layout = _layout(Path(path))
    if markers is None:
        return tuple(layout.labels[k] for k in sorted(layout.turned))
    places = find_points(layout.labels, markers, layout.name)
    return tuple(one for one, k in zip(markers, places, strict=True) if k in layout.turned)


def orientation_of(
    paths: Sequence[str | Path],
    marker: str,
    frame_rate_hz: float | None = None,
    accept_truncated: bool = False,
) -> np.ndarray:
    """Unit quaternions x, y, z, w (4, n) of one body, in the frames of `read_any`."""
    paths = [Path(path) for path in paths]
    reader = READERS.get(paths[0].suffix.lower())
    if reader is None:
        raise Refusal(f"{paths[0].name}: holds no orientations")
    return read_orientation(paths, reader, marker, frame_rate_hz, accept_truncated)


def _layout(path: Path) -> Layout:
    try:
        return READERS[path.suffix.lower()](path)
    except OSError as error:
        raise Refusal(f"{path.name}: cannot be read: {error.strerror or error}") from error
