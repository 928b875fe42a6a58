"""Read recordings of any format: positions, labels, orientations of bodies.

The suffix of the path gives the format (`FORMATS`), of a text also what it begins with (`_layout`).

To add a text format, write a module in `text` with a function `layout(path)`, which reads the
header into a `Layout` and refuses what is none, and add its suffix to `FORMATS` as
`text_format(layout)`; where the suffix is taken, let `_layout` choose.
Frame numbers, times, gaps, zeros, decimals and segments are then treated as for all others. Another
binary format needs its own `Format`: a function that reads the `recording.Header` of a file, and
one that makes a `SegmentReader` of each, as `n3d` has them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from mocap_metrology.common.errors import Refusal, Unseen
from mocap_metrology.common.paths import is_file
from mocap_metrology.io import n3d
from mocap_metrology.io.c3d.read import computed_points
from mocap_metrology.io.c3d.read import readers as c3d_readers
from mocap_metrology.io.c3d.structure import Structure, inspect
from mocap_metrology.io.labels import (
    computed_labels,
    find_points,
    in_words,
    is_unlabelled,
    numbered,
    pair_of,
)
from mocap_metrology.io.recording import Choice, Header, Recording, SegmentReader, read_take
from mocap_metrology.io.text import first_principles, motive, nexus, poses, qualisys, table, trc
from mocap_metrology.io.text.layout import Layout, check_text, lines
from mocap_metrology.io.text.read import readers as text_readers
from mocap_metrology.io.units import Unit

Orientations = npt.NDArray[np.float64]
WHAT = (
    "an export of motion capture (Motive, Nexus, Qualisys, First Principles, TRC), a text of poses"
    " or columns with names"
)
HEAD = 20  # lines that show what a text is


@dataclass(frozen=True)
class Format:
    """How files are read: the header of one (path, accept_truncated); readers of the files of a
    take; orientations where there are such (headers, marker, frame_rate_hz, accept_truncated)."""

    header: Callable[[Path, bool], Header]
    readers: Callable[[Sequence[Any], Choice], list[SegmentReader]]
    orientation: Callable[[Sequence[Any], str, float | None, bool], Orientations] | None = None

    def headers(self, files: Sequence[Path], accept_truncated: bool) -> list[Header]:
        """Headers of files of this format."""
        every = []
        for path in files:
            with _readable(path):
                every.append(self.header(path, accept_truncated))
        return every


def text_format(layout: Callable[[Path], Layout]) -> Format:
    """The format of text files whose headers `layout` reads."""
    return Format(lambda path, _: layout(path), text_readers, poses.read_orientation)


@contextmanager
def _readable(path: Path) -> Iterator[None]:
    """Refuse a file that the system does not let be read."""
    try:
        yield
    except OSError as error:
        raise Refusal(f"{path.name}: cannot be read: {error.strerror or error}") from error


def _layout(path: Path) -> Layout:
    """Motive, First Principles and TRC by their first line, Qualisys by a field that counts, Vicon
    by its section; else poses or columns with names."""
    check_text(path, WHAT)
    head = [line.text for line in islice(lines(path), HEAD) if line.text.strip()]
    first = head[0].lstrip('"') if head else ""
    if first.startswith(motive.START):
        return motive.layout(path)
    if first.startswith(first_principles.START):
        return first_principles.layout(path)
    if first.startswith(trc.START):
        return trc.layout(path)
    if any(text.startswith("NO_OF_") for text in head):
        return qualisys.layout(path)
    if first.strip(' \t,;"') in nexus.OTHERS or nexus.find_section(path)[1]:
        return nexus.layout(path)
    nexus.refuse_old(path)
    return poses.layout(path) if path.suffix.lower() == ".txt" else table.layout(path)


C3D = Format(inspect, c3d_readers)
FORMATS = {
    ".trc": text_format(trc.layout),
    ".csv": text_format(_layout),
    ".tsv": text_format(_layout),
    ".txt": text_format(_layout),
    ".tum": text_format(table.layout),
    ".xls": text_format(first_principles.layout),
    ".n3d": Format(n3d.header, n3d.readers),
}

TABLES = (".csv", ".tsv", ".txt", ".tum")


def format_of(path: Path, columns: str | None = None) -> Format:
    """The format of a file by its suffix, C3D where no other has it; a table whose columns have the
    names `columns`, where these are stated."""
    if columns and path.suffix.lower() not in TABLES:
        raise Refusal(f"{path.name}: names of columns are for {', '.join(TABLES)} alone")
    if columns:
        return text_format(partial(table.layout, stated=columns))
    return FORMATS.get(path.suffix.lower(), C3D)


def read_recording(
    paths: Sequence[str | Path],
    markers: Sequence[str],
    frame_rate_hz: float | None = None,
    second_opinion: bool = True,
    accept_truncated: bool = False,
    unit: Unit | None = None,
    columns: str | None = None,
    only_seen: bool = False,
) -> Recording:
    """Positions of `markers`, of all where none is named, in one file or in the segments of one
    take, of one format.

    `frame_rate_hz` may give the rate more exactly than the files (within 0.1 %), or where they have
    none. `second_opinion` lets ezc3d read the same C3D files, where it can, and compares.
    `accept_truncated` takes what a cut-off file holds. `unit` is that of the coordinates, where the
    files name none or a wrong one. `columns`: names of the columns of a table that has none or
    wrong ones, as `t x y z qx qy qz qw`. `only_seen`: whether markers that are seen in no frame are
    left out with a note, not refused; those that are not named are.
    Refuses what cannot be read with certainty; the message starts with the file's name.
    """
    files = [Path(path) for path in paths]
    if not files:
        raise Refusal("no C3D file is given")
    suffixes = list(dict.fromkeys(path.suffix.lower() for path in files))
    formats = {format_of(path) for path in files}
    if len(formats) > 1 and not columns:
        endings = ", ".join(suffixes)
        raise Refusal(f"{files[0].name}: segments of one take differ in format: {endings}")
    of_file = format_of(files[0], columns)
    headers = of_file.headers(files, accept_truncated)
    if not markers:
        markers, only_seen = numbered(_markers(headers[0])), True

    how = frame_rate_hz, unit, second_opinion, accept_truncated
    with _readable(files[0]):
        try:
            return read_take(headers, of_file.readers, markers, *how)
        except Unseen as unseen:
            seen = [label for label in markers if label not in unseen.labels]
            if not (only_seen and seen):
                raise
            note = f"{files[0].name}: seen in no frame, and left out: {in_words(unseen.labels)}"
        recording = read_take(headers, of_file.readers, seen, *how)
    return replace(recording, notes=(*recording.notes, note))


def labels_of(
    path: str | Path, accept_truncated: bool = False, columns: str | None = None
) -> tuple[str, ...]:
    """Labels of a file, in its order; of solved bodies only where there is no marker."""
    return _markers(_header(path, accept_truncated, columns))


def _markers(header: Header) -> tuple[str, ...]:
    markers = tuple(one for k, one in enumerate(header.labels) if k not in header.bodies)
    return markers or header.labels


Kind = Literal["marker", "unlabelled", "body", "computed"]


def points_by_kind(
    path: str | Path, accept_truncated: bool = False, columns: str | None = None
) -> dict[Kind, tuple[str, ...]]:
    """Labels of a file as points are chosen (`A#1` where one stands twice) by what they are, in
    this order: markers, trajectories that nobody labelled, solved bodies, and what a model computed
    (angles, forces, moments, powers, axes of segments)."""
    header = _header(path, accept_truncated, columns)
    computed = computed_labels(header.labels)
    if isinstance(header, Structure):
        computed |= computed_points(header)
    by_kind: dict[Kind, list[str]] = {"marker": [], "unlabelled": [], "body": [], "computed": []}
    for k, label in enumerate(numbered(header.labels)):
        kind: Kind = "unlabelled" if is_unlabelled(label) else "marker"
        kind = "body" if k in header.bodies else "computed" if k in computed else kind
        by_kind[kind].append(label)
    return {kind: tuple(labels) for kind, labels in by_kind.items() if labels}


def bodies_of(
    path: str | Path, markers: Sequence[str] | None = None, columns: str | None = None
) -> tuple[str, ...]:
    """Labels of a file, or those of the chosen `markers` as they were asked for, that have an
    orientation beside their position."""
    if format_of(Path(path), columns).orientation is None:
        return ()
    header = _header(path, columns=columns)
    turned = header.rotations if isinstance(header, Layout) else {}
    if markers is None:
        return tuple(header.labels[k] for k in sorted(turned))
    places = find_points(header.labels, markers, header.name)
    return tuple(one for one, k in zip(markers, places, strict=True) if k in turned)


def orientation_of(
    paths: Sequence[str | Path],
    marker: str,
    frame_rate_hz: float | None = None,
    accept_truncated: bool = False,
    columns: str | None = None,
) -> Orientations:
    """Unit quaternions x, y, z, w (4, n) of one body, in the frames of `read_recording`."""
    files = [Path(path) for path in paths]
    of_file = format_of(files[0], columns)
    if of_file.orientation is None:
        raise Refusal(f"{files[0].name}: contains no orientations")
    headers = of_file.headers(files, accept_truncated)
    with _readable(files[0]):
        return of_file.orientation(headers, marker, frame_rate_hz, accept_truncated)


def missing_marker(
    paths: Sequence[str | Path], markers: Sequence[str], columns: str | None, bar: str | None = None
) -> str:
    """Which of the chosen `markers`, or of the ends of the `bar`, one of the files lacks, and what
    it has instead; empty where none does, and where a header cannot be read, which is another
    fault."""
    for path in filter(is_file, map(Path, paths)):
        try:
            header = _header(path, True, columns)
        except (Refusal, OSError):
            continue
        try:
            if markers:
                find_points(header.labels, markers, header.name)
            if bar:
                pair_of(bar, numbered(header.labels), header.name)
        except Refusal as refusal:
            return str(refusal)
    return ""


def _header(path: str | Path, accept_truncated: bool = False, columns: str | None = None) -> Header:
    return format_of(Path(path), columns).headers([Path(path)], accept_truncated)[0]
