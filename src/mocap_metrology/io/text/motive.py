"""Motive CSV (OptiTrack), format versions 1.2x, exported with its header.

Layout after the Motive documentation, "Data Export: CSV": line 1 names and values in turn; an
empty line; rows of type, name, ID (and parent) of each column; what it holds (Position, Rotation,
quality); `Frame`, `Time (Seconds)`, axes. Positions of type Marker are measured, an empty cell is
a gap; a Rigid Body Marker or Bone Marker is where the solved body expects a marker. A Rigid Body or
Bone has a rotation (a quaternion, or angles in degrees as Rotation Type says) and a position, both
solved from its markers.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.labels import in_words
from mocap_metrology.io.text.layout import (
    BODY,
    Layout,
    Line,
    RotationColumns,
    Triple,
    declared,
    lines,
    named,
    rate,
    triples,
    without_padding,
)
from mocap_metrology.io.units import read_unit, unknown

WHAT = "a Motive export (CSV with its header)"
START = ("Format Version", "Take Name", "Capture Frame Rate")
MEASURED = ("marker", "labeled marker", "unlabeled marker", "unlabelled marker")
EXPECTED = ("rigid body marker", "bone marker", "marker constraint", "rigid body marker constraint")
BODIES = ("rigid body", "bone")
SOLVED_MARKER = "is the position that the solved body predicts for the marker, not a measured one"
PAIRS = (
    *START,
    "Take Notes",
    "Export Frame Rate",
    "Capture Start Time",
    "Capture Start Frame",
    "Total Frames in Take",
    "Total Exported Frames",
    "Rotation Type",
    "Length Units",
    "Coordinate Space",
)
NO_UNIT = (
    "line 1 has no Length Units, without which m and mm cannot be distinguished: export again "
    "with the header, or add Length Units,Meters (or what Units was set to)"
)
AXES_NOTE = "axes as in the file; by default, Y points up in Motive"


def layout(path: Path) -> Layout:
    """Read the header of a Motive CSV file; refuses what is none or contradicts itself."""
    delimiter = _delimiter(path)
    fields, rows, first = _header(path, delimiter)
    written = fields.get("Length Units", "")
    header = _columns(rows, path.name)
    labels, columns, remarks, rotations = _positions(
        header, fields.get("Rotation Type", ""), path.name
    )
    rates = [
        rate(fields.get(name, ""), path.name)
        for name in ("Export Frame Rate", "Capture Frame Rate")
    ]
    times = [i for i, cell in enumerate(rows[-1]) if cell.lower().startswith("time (")]
    return Layout(
        path=path,
        encoding="Motive text",
        labels=labels,
        columns=columns,
        frame_rate_hz=rates[0] or rates[1],
        unit=read_unit([written], "Length Units", path.name) if written else unknown(NO_UNIT),
        delimiter=delimiter,
        first=first,
        n_columns=len(rows[-1]),
        frame_column=0,
        time_column=times[0] if times else None,
        declared=declared(fields, "Total Exported Frames", path.name),
        declared_too_few=True,
        notes=(AXES_NOTE, *_left_out(header, columns)),
        remarks=remarks,
        rotations=rotations,
    )


def _left_out(header: _Columns, columns: Sequence[Triple]) -> list[str]:
    """What to say of positions that are neither read nor of a marker that is read as measured."""
    taken = {i for three in columns for i in three}
    every = enumerate(zip(header.types, header.names, header.held, strict=True))
    left = dict.fromkeys(
        f"{name} ({kind})"
        for i, (kind, name, held) in every
        if held == "position" and i not in taken and kind not in EXPECTED
    )
    return [f"positions of a type that is not known are not read: {in_words([*left])}"] * bool(left)


def _delimiter(path: Path) -> str:
    """What follows the first name; a spreadsheet may have saved it with semicolons or tabs."""
    first = next((line.text for line in lines(path) if line.text.strip()), "")
    match = re.match(rf'"?(?:{"|".join(START)})"?([,;\t])', first)
    return match[1] if match else ","


def _header(path: Path, delimiter: str) -> tuple[dict[str, str], list[list[str]], Line]:
    """What line 1 says, rows on the columns down to `Frame, Time ...`, the first line of numbers.

    Names and notes may be quoted, and notes then go on over several lines.
    """
    fields: dict[str, str] = {}
    rows: list[list[str]] = []
    following = lines(path)
    for cells in _records(following, delimiter, path.name):
        if not any(cells):
            continue
        if not fields:
            if cells[0] not in START:
                start = ",".join(cells)[:30]
                raise Refusal(f"{path.name}: is not {WHAT}: line 1 is {start!r}")
            fields = _pairs(cells)
            continue
        rows.append(cells)
        if cells[0].lower() == "frame":
            break
        if len(rows) > 10:
            raise Refusal(f"{path.name}: no row Frame, Time ... within 10 rows of its header")
    else:
        raise Refusal(f"{path.name}: cut off: within its header")
    first = next(following, None)
    if first is None:
        raise Refusal(f"{path.name}: has no frames: nothing follows the header")
    return fields, rows, first


def _records(following: Iterator[Line], delimiter: str, file: str) -> Iterator[list[str]]:
    """Cells of each record, for which no more lines are taken than it has."""
    try:
        texts = (f"{without_padding(line.text, delimiter)}\n" for line in following)
        for cells in csv.reader(texts, delimiter=delimiter):
            yield [cell.strip() for cell in cells]
    except csv.Error as error:
        raise Refusal(f"{file}: its header cannot be split into cells: {error}") from None


def _pairs(cells: Sequence[str]) -> dict[str, str]:
    """Names and values in turn. A comma in a take's notes shifts what follows, up to the next name
    that is known."""
    fields: dict[str, str] = {}
    at = 0
    while at + 1 < len(cells):
        name, value = cells[at : at + 2]
        shifted = name not in PAIRS and value in PAIRS
        if not shifted:
            fields.setdefault(name, value)
        at += 1 if shifted else 2
    return fields


@dataclass(frozen=True)
class _Columns:
    """Header of each column: type, name, what it holds, axis."""

    types: list[str]
    names: list[str]
    held: list[str]
    axes: list[str]

    def of(self, kinds: Sequence[str]) -> list[int]:
        """The columns in which positions of these types begin."""
        of_kind = (i for i, kind in enumerate(self.types) if kind in kinds)
        return [i for i in of_kind if self.hold(i, "position", "XYZ")]

    def hold(self, i: int, what: str, letters: str) -> bool:
        """Whether the columns from i on, of one type, hold `what`, one for each letter."""
        span, n = slice(i, i + len(letters)), len(letters)
        alike = self.types[span] == [self.types[i]] * n and self.held[span] == [what] * n
        return alike and self.axes[span] == list(letters)

    def rotation(self, position: int, rotation_type: str) -> RotationColumns | None:
        """The rotation of the body whose position begins there; `rotation_type`: of the header."""
        identity = (self.types[position], self.names[position])
        order = rotation_type.strip().upper()
        for i in range(len(self.axes)):
            if (self.types[i], self.names[i]) != identity:
                continue
            if self.hold(i, "rotation", "XYZW"):
                return RotationColumns(tuple(range(i, i + 4)), "quaternion")
            if sorted(order) == ["X", "Y", "Z"] and self.hold(i, "rotation", "XYZ"):
                return RotationColumns(tuple(i + "XYZ".index(letter) for letter in order), order)
        return None


def _columns(rows: list[list[str]], file: str) -> _Columns:
    width = len(rows[-1])
    above = [[*row, *[""] * width][:width] for row in rows[:-1]]
    known = (*MEASURED, *EXPECTED, *BODIES)
    types = next((row for row in above if any(c.lower() in known for c in row)), None)
    if types is None or types is above[-1] or len(above) < 3:
        raise Refusal(f"{file}: no row of types (Marker, Rigid Body, ...) in the header")
    names = next((r for r in above if r[1] == "Name"), above[above.index(types) + 1])
    lower = ([cell.lower() for cell in row] for row in (types, above[-1]))
    kinds, held = lower
    return _Columns(kinds, names, held, [cell.upper() for cell in rows[-1]])


def _positions(
    columns: _Columns, rotation_type: str, file: str
) -> tuple[tuple[str, ...], tuple[Triple, ...], dict[int, str], dict[int, RotationColumns]]:
    """Labels and columns of measured markers, of solved ones that have no measured namesake, and of
    bodies; remarks on what is not measured; orientations of the bodies."""
    measured, bodies = columns.of(MEASURED), columns.of(BODIES)
    seen = {columns.names[i] for i in measured}
    solved = [i for i in columns.of(EXPECTED) if columns.names[i] not in seen]
    chosen = [*measured, *solved, *bodies]
    if not chosen:
        raise Refusal(
            f"{file}: has no positions of markers or bodies: export it with Markers switched on"
        )
    for i in chosen:
        names = dict.fromkeys(columns.names[i : i + 3])
        if len(names) > 1:
            where = f"{file}: X, Y, Z in columns {i + 1} to {i + 3}"
            raise Refusal(f"{where} are of {' and '.join(map(repr, names))}; expected one")
    after = len(measured) + len(solved)
    remarks = dict.fromkeys(range(len(measured), after), SOLVED_MARKER)
    remarks |= dict.fromkeys(range(after, len(chosen)), BODY)
    rotations = {k: columns.rotation(i, rotation_type) for k, i in enumerate(bodies, start=after)}
    return (
        named([columns.names[i] for i in chosen]),
        triples(chosen),
        remarks,
        {k: rotation for k, rotation in rotations.items() if rotation is not None},
    )
