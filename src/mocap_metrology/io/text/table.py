"""Tables with a name over each column: markers or poses, as text or CSV.

The names are the last line before the numbers, with or without #, or the last two, where axes
stand under labels (`A,A,A` or `A,,` over `X,Y,Z`), a line of units below or not. Names that the
user states hold in place of them. Rows are separated by tabs, semicolons, commas or spaces.
`columns` has the grammar of the names. Nothing is told by its place: numbers without names are
refused.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from itertools import islice
from pathlib import Path

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.header import READ, number
from mocap_metrology.io.text.columns import BRACKETS, SECONDS, Columns, find_columns
from mocap_metrology.io.text.layout import (
    NULLS,
    Layout,
    Line,
    check_text,
    lines,
    named,
    quoted_cells,
    rate,
)
from mocap_metrology.io.units import KNOWN, METRE, MM

WHAT = "a table with a name over each column"
DELIMITERS = ("\t", ";", ",", " ")
MOST_LINES = 60  # before the numbers
MOST_TITLES = 4  # of them without #
ROWS = 10_000  # rows that give the frame rate
SLOWEST_HZ = 1.0  # slower than any system: times in another unit than s, or a count of frames
AXES = ("x", "y", "z")
UNITS = {*MM, *SECONDS, "-"}
PART_OF_TIME = re.compile("[mun]?(s|secs?)")
FREQUENCY = re.compile(r"Freq:\s*([0-9.]+)")
REQUESTED = "{:g} Hz is the rate that was requested; rows have no time"
SWAPPED, MEANT = list("xyzwjik"), list("xyzwijk")
HOW = "name its columns in a line above them, or state them, as t x y z qx qy qz qw"


class NoTable(Refusal):
    """A file whose lines are no table with a name over each column, and what is read instead."""

    def __init__(self, why: str) -> None:
        super().__init__(f"{why}; {READ}")


def layout(path: Path, stated: str | None = None) -> Layout:
    """Read the names of the columns, or take those of `stated`, and the frame rate by the times.

    Refuses numbers without names, and names that are not as many as the columns.
    """
    check_text(path, WHAT)
    head, first, delimiter = _head(path)
    cells = first.cells(delimiter)
    if stated is None:
        names, number_of = _names(head, delimiter, len(cells), path.name)
        where = f"{path.name}: line {number_of}"
    else:
        names, where = re.split(r"[\s,;]+", stated.strip(" \t,;")), f"{path.name}: columns as given"
    if not names:
        raise NoTable(f"{path.name}: line {first.number} has numbers without names: {HOW}")
    if len(names) != len(cells) and not (len(names) == len(cells) - 1 and not cells[-1]):
        commas = delimiter == "," and sum(map(bool, cells)) > len(names)
        raise NoTable(
            f"{where}: {len(names)} names of columns, but {len(cells)} cells in line {first.number}"
            + "; are these decimal commas?" * commas
        )
    rows = [line.cells(delimiter) for line in islice(_rows(path, first), ROWS)]
    if len(rows) > 1 and len(rows[-1]) < len(names):  # cut off, as is found when it is read
        rows.pop()
    index = [number(row[0]) for row in rows]
    if not names[0] and None not in index:  # what a table of pandas is indexed by
        kind = "frame" if all(value == int(value or 0) for value in index) else "time"
        names = [kind if kind not in names else "", *names[1:]]
    told, notes = _frequency(head), []
    if told and stated is None and names == SWAPPED:
        names = MEANT
        notes.append("its header names the quaternion w j i k, its writer means w i j k")
    columns = find_columns(names, where)
    if columns is None:
        units = f"; units are {KNOWN}" if any(BRACKETS.fullmatch(name) for name in names) else ""
        raise NoTable(f"{where}: no columns x, y, z of a marker in {', '.join(names)[:200]}{units}")
    _expect_a_row_a_frame(path.name, columns, names, rows)
    measured = _rate(path, first, columns, names, rows) if columns.time is not None else 0.0
    if told and not measured:
        notes.append(REQUESTED.format(told))
    return Layout(
        path=path,
        encoding="pose text" if columns.rotations else "table of markers",
        labels=named(columns.labels),
        columns=columns.positions,
        frame_rate_hz=measured or told,
        unit=METRE if told and columns.unit.source == "unknown" else columns.unit,
        delimiter=delimiter,
        first=first,
        n_columns=len(names),
        frame_column=columns.frame,
        time_column=columns.time,
        second=columns.second,
        full_rows=delimiter == " ",
        notes=tuple(notes),
        rotations=columns.rotations,
    )


def _head(path: Path) -> tuple[list[Line], Line, str]:
    """Lines that are not empty before the first row of numbers, this row, what separates it."""
    head: list[Line] = []
    for line in islice(lines(path), MOST_LINES):
        for delimiter in DELIMITERS:
            cells = line.cells(delimiter)
            n_numbers = sum(number(cell) is not None for cell in cells)
            n_words = sum(cell not in NULLS for cell in cells) - n_numbers
            if len(cells) > 2 and n_numbers > n_words:
                return head, line, delimiter
        if line.text.strip(" \t,;") and not line.text.startswith("sep="):  # Excel's
            head.append(line)
    last = f"line {head[-1].number} is {head[-1].text[:40]!r}" if head else "they are empty"
    raise NoTable(f"{path.name}: no row of three or more numbers in its first lines; {last}")


def _rows(path: Path, first: Line) -> Iterator[Line]:
    """Rows of numbers that are not empty."""
    return (line for line in lines(path, first.start, first.number) if line.text.strip(" \t,;"))


def _frequency(head: Sequence[Line]) -> float:
    """The rate in Hz that a comment of the Vive recordings names; 0 without."""
    match = FREQUENCY.search(" ".join(line.text for line in head if line.text.startswith("#")))
    return rate(match[1]) if match else 0.0


def _names(head: Sequence[Line], delimiter: str, n_cells: int, file: str) -> tuple[list[str], int]:
    """A name for each column, none where there are none, and the line of the last."""
    plain = [line for line in head if line.text[0] not in "#%"]
    if len(plain) > MOST_TITLES:
        raise NoTable(f"{file}: {len(plain)} lines before its numbers, which are not understood")
    if not plain:
        return _commented(head, delimiter, n_cells)
    rows = [quoted_cells(line.text, delimiter) for line in plain]
    short = [line for line, row in zip(plain, rows, strict=True) if len(row) < 3]
    if short:
        raise NoTable(f"{file}: line {short[0].number} is not understood before a table")
    return _titles(rows), plain[-1].number


def _commented(head: Sequence[Line], delimiter: str, n_cells: int) -> tuple[list[str], int]:
    """The last comment with a word or a cell for each column, and its line."""
    for line in reversed(head):
        text = line.text.strip("#% \t").split("Freq:")[0]
        for cells in (quoted_cells(text, delimiter), text.split()):
            if len(cells) in (n_cells, n_cells - 1):
                return cells, line.number
    return [], 0


def _titles(rows: list[list[str]]) -> list[str]:
    """One name for each column of lines of names: labels, axes below them, units below these."""
    width = max(map(len, rows))
    rows = [row + [""] * (width - len(row)) for row in rows]
    units = rows.pop() if len(rows) > 1 and _all_in(rows[-1], UNITS) else [""] * width
    index = rows.pop() if len(rows) > 2 and not any(rows[-1][1:]) else [""] * width
    names = rows.pop()
    if rows and sum(cell.lower() in AXES for cell in names) > 2:
        label = ""
        for k, over in enumerate(rows[-1]):
            label = over or label
            if names[k].lower() in AXES:
                names[k] = f"{label} {names[k]}".strip()
            else:
                names[k] = names[k] or over
    names[0] = index[0] or names[0]
    units = [unit.strip("[]()") for unit in units]
    names = [f"{name} [{unit}]" if unit else name for name, unit in zip(names, units, strict=True)]
    while names and not names[-1]:
        names.pop()
    return names


def _all_in(cells: Sequence[str], known: Collection[str]) -> bool:
    """Whether there are cells, and all of them are known."""
    told = [cell.strip("[]()").lower() for cell in cells if cell]
    return bool(told) and all(cell in known for cell in told)


def _expect_a_row_a_frame(
    file: str, of_table: Columns, names: Sequence[str], rows: Sequence[Sequence[str]]
) -> None:
    """Refuse a table with a row for each marker of a frame, by its first rows: there are several of
    the first frame or time, and another column has no values but their different ones."""
    place = of_table.time if of_table.frame is None else of_table.frame
    columns = list(zip(*rows, strict=False))  # those that all rows have
    if len(of_table.labels) > 1 or place is None or place >= len(columns):
        return
    known = {place, *of_table.positions[0]}
    first = [i for i, value in enumerate(columns[place]) if value == columns[place][0]]
    for k, column in enumerate(columns):
        values = {column[i] for i in first}
        other = k not in known and not PART_OF_TIME.fullmatch(names[k])
        if other and 1 < len(values) == len(first) < len(column) and values == set(column):
            raise Refusal(
                f"{file}: a row for each {names[k]!r} of a frame; expected one row for each frame,"
                " with columns A_x,A_y,A_z,B_x,... of all its markers"
            )


def _rate(
    path: Path, first: Line, columns: Columns, names: Sequence[str], rows: Sequence[Sequence[str]]
) -> float:
    """Frame rate in Hz by the times of the first rows; a longer step is one of missing frames."""
    place = columns.time or 0
    times = [number(row[place]) if place < len(row) else None for row in rows]
    if None in times:
        row = times.index(None)
        line = next(islice(_rows(path, first), row, None))
        cell = rows[row][place][:30] if place < len(rows[row]) else ""
        where = f"{path.name}: line {line.number}, column {place + 1}"
        raise Refusal(f"{where}: {cell!r} is not a number, expected a time in s")
    time = np.array(times, float) * columns.second
    steps = np.diff(time)
    if not len(steps):
        return 0.0
    if (steps <= 0).any():
        row = int(np.argmax(steps <= 0))
        line = next(islice(_rows(path, first), row + 1, None))
        raise Refusal(
            f"{path.name}: line {line.number}: time {rows[row + 1][place]} follows"
            f" {rows[row][place]}, expected a larger one"
        )
    frames = np.maximum(np.round(steps / np.median(steps)), 1).sum()
    hz = float(f"{frames / (time[-1] - time[0]):.6g}")
    if hz <= SLOWEST_HZ and not re.search(r"[\[(_/]\s*s", names[place]):
        meant = next((u for u in ("ms", "us", "ns") if hz >= SLOWEST_HZ * SECONDS[u]), "s")
        raise Refusal(
            f"{path.name}: its times in s would be a frame rate of {hz:g} Hz: name their unit, as"
            f" in {names[place]}_{meant} or {names[place]}_s"
        )
    return hz
