"""Motive CSV (OptiTrack), format versions 1.2x, exported with its header.

Layout after the Motive documentation, "Data Export: CSV": line 1 names and values in turn; an
empty line; rows of type, name, ID (and parent) of each column; what it holds (Position, Rotation,
quality); `Frame`, `Time (Seconds)`, axes. Positions of type Marker are measured, an empty cell is
a gap; a Rigid Body Marker or Bone Marker is where the solved body expects a marker.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

from mocap_metrology.common.errors import Refusal
from mocap_metrology.formats.head import Line, check_text, lines
from mocap_metrology.formats.layout import Layout, count, named, rate, unit

WHAT = "a Motive export (CSV with its header)"
START = ("Format Version", "Take Name", "Capture Frame Rate")
MEASURED = ("marker", "labeled marker", "unlabeled marker", "unlabelled marker")
EXPECTED = ("rigid body marker", "bone marker", "marker constraint", "rigid body marker constraint")
AXES_NOTE = "axes as in the file, in which Motive by default lets Y point up"


def layout(path: Path) -> Layout:
    """Read the header of a Motive CSV file; refuses what is none or contradicts itself."""
    check_text(path, WHAT)
    fields, rows, first = _header(path)
    by_key = {name: _value(fields, name) for name in (*START, "Export Frame Rate", "Length Units")}
    units, mm_per_unit, notes = unit([by_key["Length Units"]], "Length Units", path.name)
    labels, columns, remarks = _markers(rows, path.name)
    total = _value(fields, "Total Exported Frames")
    times = [i for i, cell in enumerate(rows[-1]) if cell.lower().startswith("time (")]
    return Layout(
        path=path,
        format="Motive text",
        labels=labels,
        columns=columns,
        frame_rate_hz=rate(by_key["Export Frame Rate"]) or rate(by_key["Capture Frame Rate"]),
        units=units,
        mm_per_unit=mm_per_unit,
        delimiter=",",
        data_line=first.number,
        data_offset=first.start,
        n_columns=len(rows[-1]),
        frame_column=0,
        time_column=times[0] if times else None,
        declared=("Total Exported Frames", count(total, "Total Exported Frames", path.name))
        if total
        else None,
        declared_too_few=True,
        notes=(*notes, AXES_NOTE),
        remarks=remarks,
    )


def _header(path: Path) -> tuple[list[str], list[list[str]], Line]:
    """Cells of line 1, rows on the columns down to `Frame, Time ...`, the first line of numbers."""
    fields: list[str] = []
    rows: list[list[str]] = []
    for line in lines(path):
        if rows and rows[-1][0].lower() == "frame":
            return fields, rows, line
        cells = _cells(line, path.name)
        if not any(cells):
            continue
        if not fields:
            if cells[0] not in START:
                raise Refusal(f"{path.name}: is not {WHAT}: line 1 is {line.text[:30]!r}")
            fields = cells
            continue
        rows.append(cells)
        if len(rows) > 10:
            raise Refusal(f"{path.name}: no row Frame, Time ... within 10 rows of its header")
    done = rows and rows[-1][0].lower() == "frame"
    what = "has no frames: nothing follows the header" if done else "cut off: within its header"
    raise Refusal(f"{path.name}: {what}")


def _cells(line: Line, file: str) -> list[str]:
    """Cells of a line of the header, in which names and notes may be quoted."""
    try:
        return [cell.strip() for cell in next(csv.reader([line.text]), [])]
    except csv.Error as error:
        raise Refusal(f"{file}: line {line.number}: {error}") from None


def _value(fields: Sequence[str], name: str) -> str:
    """The cell after `name`: a comma in a take's notes shifts what follows."""
    return fields[fields.index(name) + 1] if name in fields[:-1] else ""


def _markers(
    rows: list[list[str]], file: str
) -> tuple[tuple[str, ...], tuple[tuple[int, int, int], ...], dict[int, str]]:
    """Labels, columns, and remarks on labels whose position is not measured."""
    axes = rows[-1]
    width = len(axes)
    rows = [[*row, *[""] * width][:width] for row in rows[:-1]]
    known = (*MEASURED, *EXPECTED, "rigid body", "bone")
    types = next((row for row in rows if any(c.lower() in known for c in row)), None)
    if types is None or len(rows) < 3:
        raise Refusal(f"{file}: no row of types (Marker, Rigid Body, ...) in the header")
    names = next((r for r in rows if r[1] == "Name"), rows[rows.index(types) + 1])
    found: dict[bool, list[tuple[str, tuple[int, int, int]]]] = {True: [], False: []}
    for i in range(1, width - 2):
        three = slice(i, i + 3)
        kind = types[i].lower()
        held = [cell.lower() for cell in rows[-1][three]]
        if kind not in (*MEASURED, *EXPECTED) or held != ["position"] * 3:
            continue
        if [cell.upper() for cell in axes[three]] == ["X", "Y", "Z"]:
            found[kind in MEASURED].append((names[i], (i, i + 1, i + 2)))
    measured = {name for name, _ in found[True]}
    chosen = found[True] + [one for one in found[False] if one[0] not in measured]
    if not chosen:
        raise Refusal(f"{file}: has no positions of markers: export it with Markers switched on")
    solved = "is where the solved body expects the marker, not where it was measured"
    remarks = dict.fromkeys(range(len(found[True]), len(chosen)), solved)
    return named([name for name, _ in chosen]), tuple(c for _, c in chosen), remarks
