"""TRC files (Motion Analysis, OpenSim): tabs, three lines on the file, two on the columns.

A spreadsheet saves them with commas or semicolons, which then stand in every line.

Layout after the OpenSim documentation ("Marker (.trc) Files"): `PathFileType`; names of fields;
their values; `Frame#`, `Time` and a label over every third column; `X1 Y1 Z1 ...`; an empty line
or none; then frame, time in s, and three coordinates a label. An empty cell is a gap.

Writers in MATLAB call the second column `Times` and write 0 0 0 where a marker was not seen; there,
and only there, three exact zeros are a gap. Cortex, after virtual markers were taken out of a file,
goes on with their names in line 4, beyond NumMarkers and over no numbers.
"""

from __future__ import annotations

import itertools
import re
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.text.layout import (
    Layout,
    Line,
    check_text,
    count,
    declared,
    lines,
    named,
    rate,
    triples,
)
from mocap_metrology.io.units import read_unit

WHAT = "a TRC file"
START = "PathFileType"
TITLES = re.compile(r"(frame.*|time.*|#|s|sec.*|[xyz]\d*)", re.I)
MATLAB = "times"


def layout(path: Path) -> Layout:
    """Read the header of a TRC file; refuses what is none or contradicts itself."""
    check_text(path, WHAT)
    head = list(itertools.islice(lines(path), 8))
    if head[0].text.startswith('"'):  # a program that puts every cell in quotes
        head = [replace(line, text=line.text.replace('"', "")) for line in head]
    if not head[0].text.startswith(START):
        start = head[0].text[:30]
        raise Refusal(f"{path.name}: is not {WHAT}: line 1 is {start!r}, not PathFileType ...")
    if len(head) < 5:
        raise Refusal(f"{path.name}: cut off: {len(head)} lines, the header alone has 5")
    delimiter = head[0].text.removeprefix(START)[:1]
    delimiter = delimiter if delimiter in (",", ";") else "\t"
    fields = _fields(head[1], head[2], delimiter, path.name)
    first = _data(head, delimiter, path.name)
    labels, more = _labels(head[3], first, fields, delimiter, path.name)
    zeros = head[3].cells(delimiter)[1].lower() == MATLAB
    return Layout(
        path=path,
        encoding="TRC text",
        labels=labels,
        columns=triples(range(2, 2 + 3 * len(labels), 3)),
        frame_rate_hz=rate(fields.get("DataRate", ""), path.name),
        unit=read_unit([fields.get("Units", "")], "Units", path.name),
        delimiter=delimiter,
        first=first,
        n_columns=2 + 3 * len(labels),
        frame_column=0,
        time_column=1,
        declared=declared(fields, "NumFrames", path.name),
        zero_is_gap=zeros,
        zero_note="treated as gaps: its writer (Times in line 4) fills them with zeros",
        notes=more,
    )


def _fields(names: Line, values: Line, delimiter: str, file: str) -> dict[str, str]:
    """Line 3 under line 2. Some writers put spaces in place of tabs."""
    for mark in (delimiter, None):
        keys, texts = (
            [cell.strip() for cell in line.text.strip(f"{delimiter} ").split(mark)]
            for line in (names, values)
        )
        if len(keys) == len(texts) and "NumMarkers" in keys:
            return dict(zip(keys, texts, strict=True))
    counts = f"{len(values.text.split())} values for {len(names.text.split())} names"
    raise Refusal(f"{file}: line 3 does not match line 2: {counts}, NumMarkers among them")


def _labels(
    line: Line, first: Line, fields: dict[str, str], delimiter: str, file: str
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Labels, which stand over every third column or side by side, and what to say of them. Names
    may go on beyond NumMarkers if the first row of numbers does not."""
    cells = line.cells(delimiter)
    times = cells[1].lower() in ("time", MATLAB) if len(cells) > 1 else False
    if not times or not cells[0].lower().startswith("frame"):
        expected = "Frame#, Time and labels, separated by tabs"
        raise Refusal(f"{file}: line 4 is {line.text[:30]!r}, expected {expected}")
    n = count(fields["NumMarkers"], "NumMarkers", file)
    stated = [cell for cell in cells[2:] if cell]
    if n and len(stated) == n and _evenly(cells):
        return named(stated), ()
    if 0 < n < len(stated) and not any(first.cells(delimiter)[2 + 3 * n :]):
        thirds = cells[2 : 2 + 3 * n : 3]
        beyond = stated[n:]
        if thirds == stated[:n] or cells[2 : 2 + n] == stated[:n]:
            note = f"line 4 names {len(beyond)} markers more than NumMarkers ({beyond[0]} ...), "
            return named(stated[:n]), (note + "for which the file has no numbers: excluded",)
    width = min(n, len(cells))
    spread = [*cells[2 : 2 + 3 * n : 3], *[""] * width][:width]
    short = n > 0 and not spread[-1] and len(cells) <= 3 * n  # an empty last label has its cell
    if width in (0, len(cells)) or short or [cell for cell in spread if cell] != stated:
        raise Refusal(f"{file}: line 4 has {len(stated)} labels, NumMarkers states {n}")
    return named(spread), ()


def _evenly(cells: list[str]) -> bool:
    """Whether labels stand evenly, from the first column of coordinates on: over every third, side
    by side, or, as in an example of OpenSim, over every second."""
    places = [i for i, cell in enumerate(cells) if i > 1 and cell]
    steps = {later - one for one, later in pairwise(places)} or {3}
    return len(steps) == 1 and places[0] - 2 < min(steps) <= 3


def _data(head: list[Line], delimiter: str, file: str) -> Line:
    """The first line of numbers, after `X1 Y1 Z1` (left out by some) and empty lines."""
    for line in head[4:]:
        cells = [cell for cell in line.cells(delimiter) if cell]
        titles = all(TITLES.fullmatch(cell) for cell in cells) or cells[0].lower().startswith("x")
        if not titles:
            return line
    raise Refusal(f"{file}: has no frames: nothing follows the header")
