"""Qualisys TSV: motion data exported from Track Manager with its header.

A spreadsheet saves it with commas or semicolons, which then stand in every line.

Layout after the QTM manual, "Motion data (.tsv)": a name and its values a line (NO_OF_FRAMES,
FREQUENCY, DATA_INCLUDED, MARKER_NAMES, ...); then, as the export was set, a line of column names;
then frame and time in s where they were asked for, and three coordinates a label in mm. A gap is
empty, NULL or three zeros, as the export was set. With DATA_INCLUDED 6D: for each of BODY_NAMES
x, y, z, three angles, a residual, and the rotation matrix column by column (so that its first
column is Rot[0] to Rot[2]), an empty cell between two bodies.
"""

from __future__ import annotations

import re
from pathlib import Path

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.header import number
from mocap_metrology.io.text.layout import (
    BODY,
    NULLS,
    Layout,
    Line,
    RotationColumns,
    count,
    lines,
    named,
    rate,
    triples,
)
from mocap_metrology.io.units import MILLIMETRE

WHAT = "a Qualisys export (TSV with its header)"
FIELD = re.compile(r"[A-Z][A-Z0-9_]{2,}")
PER_BODY = 16
ROT = (7, 10, 13, 8, 11, 14, 9, 12, 15)  # of a body's columns: its matrix row by row
TYPES = {
    "mixed": "TRAJECTORY_TYPES is Mixed: parts of it were gap-filled and have no noise",
    "gap-filled": "TRAJECTORY_TYPES is Gap-filled: it was gap-filled and has no noise",
    "virtual": "TRAJECTORY_TYPES is Virtual: it was computed from other markers",
}


def layout(path: Path) -> Layout:
    """Read the header of a Qualisys TSV file; refuses what is none or contradicts itself."""
    fields, titles, first, delimiter = _header(path)
    included = fields.get("DATA_INCLUDED", ["3D"])[0].upper()
    if included not in ("3D", "6D"):
        data = fields["DATA_INCLUDED"][0][:40]
        raise Refusal(f"{path.name}: DATA_INCLUDED is {data!r}, expected 3D or 6D")
    of_bodies = included == "6D"
    labels = _labels(fields, of_bodies, path.name)
    step = PER_BODY + 1 if of_bodies else 3
    what = f"{len(labels)} {'bodies' if of_bodies else 'markers'}"
    cells, width = first.cells(delimiter), step * len(labels) - of_bodies
    leading = _leading(titles, cells, width, f"{path.name}: line {first.number}", what)
    declared = count(fields["NO_OF_FRAMES"][0], "NO_OF_FRAMES", path.name)
    starts = range(len(leading), len(leading) + step * len(labels), step)
    return Layout(
        path=path,
        encoding="Qualisys text",
        labels=labels,
        columns=triples(starts),
        frame_rate_hz=rate(fields.get("FREQUENCY", [""])[0], path.name),
        unit=MILLIMETRE,
        delimiter=delimiter,
        first=first,
        n_columns=len(leading) + width,
        frame_column=leading.index("frame") if "frame" in leading else None,
        time_column=leading.index("time") if "time" in leading else None,
        declared=("NO_OF_FRAMES", declared),
        zero_is_gap=True,
        remarks=dict.fromkeys(range(len(labels)), BODY) if of_bodies else _types(fields),
        rotations={
            k: RotationColumns(tuple(i + j for j in ROT), "matrix") for k, i in enumerate(starts)
        }
        if of_bodies
        else {},
    )


def _types(fields: dict[str, list[str]]) -> dict[int, str]:
    """Entry of TRAJECTORY_TYPES for a label, where it is not Measured."""
    told = enumerate(fields.get("TRAJECTORY_TYPES", []))
    return {k: TYPES[kind.strip().lower()] for k, kind in told if kind.strip().lower() in TYPES}


def _header(path: Path) -> tuple[dict[str, list[str]], list[str], Line, str]:
    """Fields with their values, names of columns (or none), the first line of numbers, and what
    separates cells."""
    fields: dict[str, list[str]] = {}
    titles: list[str] = []
    delimiter = "\t"
    for line in lines(path):
        if not fields and (match := re.match(r"[A-Z_]+([,;])", line.text)):
            delimiter = match[1]
        cells = line.cells(delimiter)
        filled = [cell for cell in cells if cell]
        if not line.text.strip("\r\n "):
            continue
        if not fields and (not filled or not FIELD.fullmatch(filled[0])):
            break
        measured = bool(filled) and (number(filled[0]) is not None or filled[0] in NULLS)
        named_field = filled and not measured and FIELD.fullmatch(cells[0])
        if named_field and not titles and cells[0] not in fields:
            fields[cells[0]] = [*cells[1:], ""]
        elif filled and cells[0] in fields:  # EVENT, one line each
            continue
        elif not titles and filled and not measured:
            titles = cells
        elif "NO_OF_FRAMES" in fields:
            return fields, titles, line, delimiter
        else:
            break
    if "NO_OF_FRAMES" in fields:
        raise Refusal(f"{path.name}: has no frames: nothing follows the header")
    raise Refusal(f"{path.name}: is not {WHAT}: it has no line NO_OF_FRAMES before its numbers")


def _labels(fields: dict[str, list[str]], of_bodies: bool, file: str) -> tuple[str, ...]:
    """MARKER_NAMES or BODY_NAMES, as many as there are said to be."""
    name, number_of, what = ("MARKER_NAMES", "NO_OF_MARKERS", "marker")
    if of_bodies:
        name, number_of, what = ("BODY_NAMES", "NO_OF_BODIES", "body")
    labels = list(fields.get(name, []))
    while labels and not labels[-1]:
        labels.pop()
    if not labels:
        raise Refusal(f"{file}: {name} is missing or empty, so no {what} has a label")
    if number_of not in fields:
        raise Refusal(f"{file}: {number_of} is missing, so {name} cannot be checked")
    n = count(fields[number_of][0], number_of, file)
    if n != len(labels):
        raise Refusal(f"{file}: {name} are {len(labels)}, {number_of} states {n}")
    return named(labels)


def _leading(titles: list[str], cells: list[str], width: int, where: str, what: str) -> list[str]:
    """Cells before the `width` cells of coordinates: nothing, `frame`, `time`, or both."""
    leading = [title.lower() for title in titles[:2] if title.lower() in ("frame", "time")]
    if leading:
        return leading
    empty = next((i for i, cell in enumerate(reversed(cells)) if cell), len(cells))
    extra = len(cells) - (empty % 3 == 1) - width  # a tab may end each line
    if extra not in (0, 1, 2):
        raise Refusal(
            f"{where} has {len(cells)} cells, expected {width} for {what}, and frame and time"
            " before them or not"
        )
    whole = "." not in cells[0] and "," not in cells[0]
    return [[], ["frame"] if whole else ["time"], ["frame", "time"]][extra]
