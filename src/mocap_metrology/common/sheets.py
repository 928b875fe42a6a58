"""Reading a sheet: one header line, tabs between cells, UTF-8; `#` begins a comment line. Commas or
semicolons are read too, as a spreadsheet writes them.

Rows are numbered as an editor or a spreadsheet shows them, comments and blank lines counted.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from mocap_metrology.common.faults import Faults, quoted, unknown
from mocap_metrology.common.paths import of_windows

DELIMITERS = ("\t", ";", ",")
OTHER_DELIMITERS = {"|": "bars", " ": "blanks"}
LONGEST = 100_000  # letters of a cell: a thousand paths
EMPTY = " \t;,"  # of a row that a spreadsheet saves without a cell
ERROR = re.compile(r'"?(#N/A|#[A-Z/0]+[!?])"?\s*[\t;,]')  # a first cell whose formula failed
END = re.compile(r"\r\n|\n|\r")
SEPARATOR = re.compile(r'"?sep=[\t;,]"?[\t;,]*', re.IGNORECASE)  # for a spreadsheet alone


@dataclass(frozen=True)
class Line:
    """One row of a sheet: its number, and its cells by column, those left out empty."""

    number: int
    cells: dict[str, str]


def read(
    path: str | Path, columns: Sequence[str], required: Sequence[str], others: bool = False
) -> list[Line]:
    """The rows of a sheet whose header is right; `Faults` when the sheet as such is wrong. others:
    whether it may have more columns than these."""
    sheet = str(path)
    lines = [
        (number, line)
        for number, line in enumerate(_lines(Path(path), sheet), start=1)
        if has_cells(line)
    ]
    if not lines:
        raise Faults([f"{sheet}: no header; expected columns {', '.join(columns)}"])
    faults: list[str] = []
    separator = delimiter(lines[0][1], columns)
    header = [column_named(cell, columns) for cell in _cells(*lines[0], separator, sheet, faults)]
    while header and not header[-1]:
        header.pop()
    known = [*columns, *header] if others else columns
    faults += _header_faults(header, lines[0][1], sheet, known, required)
    if faults:
        raise Faults(faults)
    rows = []
    for number, line in lines[1:]:
        cells = _cells(number, line, separator, sheet, faults)
        if any(cells[len(header) :]):
            inside = "" if separator == "\t" else f', and quotes round a cell with "{separator}"'
            expected = f"{len(header)}{inside}"
            faults.append(f"{sheet}, row {number}: {len(cells)} cells; expected {expected}")
        elif any(cells):
            values = dict(zip(header, cells, strict=False))
            rows.append(Line(number, dict.fromkeys(columns, "") | values))
    if faults:
        raise Faults(faults)
    return rows


def has_cells(line: str) -> bool:
    """Whether a line is the header or a row: neither blank, nor a comment, nor `sep=;`. A formula
    that failed (`#REF!`) is no comment."""
    if not line.strip(EMPTY) or SEPARATOR.fullmatch(line):
        return False
    text = line.lstrip(" ")
    return not text.lstrip('"').startswith("#") or bool(ERROR.match(text))


def _lines(path: Path, sheet: str) -> list[str]:
    try:
        raw = path.read_bytes()
    except FileNotFoundError:
        hint = f"{hint}; " if (hint := of_windows(sheet)) else ""
        expected = f"{hint}expected a sheet, or an empty value"
        raise Faults([f"{sheet}: no such file; {expected}"]) from None
    except OSError as error:
        raise Faults([f"{sheet}: {error.strerror}; expected a sheet"]) from None
    if raw[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise Faults([f"{sheet}: UTF-16; expected UTF-8 text with tabs between cells"])
    if b"\0" in raw or raw[:2] == b"PK":
        raise Faults([f"{sheet}: not a text file; expected UTF-8 text with tabs between cells"])
    try:
        text = decoded(raw)
    except UnicodeDecodeError as error:
        row = len(END.findall(raw[: error.start].decode("latin-1"))) + 1
        cell = re.split(rb"[\t;,\r\n]", raw[: error.start])[-1]
        cell += re.split(rb"[\t;,\r\n]", raw[error.start :])[0]
        what = f"{quoted(cell.decode('latin-1'))} is not UTF-8"
        expected = 'expected UTF-8 text, "CSV UTF-8" of a spreadsheet'
        raise Faults([f"{sheet}, row {row}: {what}; {expected}"]) from None
    return END.split(text)


def decoded(raw: bytes) -> str:
    """The text of a file, without the mark of its end (Ctrl-Z) of programs of the time of DOS."""
    return raw.rstrip(b"\x1a").decode("utf-8-sig")


def parts_of(text: str) -> tuple[str, ...]:
    """Parts of a cell separated by `;`: none of an empty cell, each without blanks around."""
    return tuple(part.strip() for part in text.split(";")) if text else ()


def column_named(name: str, columns: Sequence[str]) -> str:
    """The name of a column as it is, where it has other capitals."""
    return name.lower() if name.lower() in columns else name


def delimiter(header: str, known: Sequence[str]) -> str:
    """What separates most names of columns from each other; a tab where nothing does."""
    counts = {
        one: len({part.strip(' "').lower() for part in header.split(one)} & set(known))
        for one in DELIMITERS
    }
    return max(DELIMITERS, key=lambda one: counts[one])


def _cells(number: int, line: str, delimiter: str, sheet: str, faults: list[str]) -> list[str]:
    """Cells of a line, without blanks around; an opening quote must close on its line."""
    longest = max(map(len, line.split(delimiter)))
    if longest > LONGEST:
        expected = f"expected at most {LONGEST} in a cell"
        faults.append(f"{sheet}, row {number}: {longest} letters; {expected}")
        return []
    try:
        cells = next(csv.reader([line], delimiter=delimiter, strict=True))
    except csv.Error:
        expected = "expected a pair round the whole cell, in one line"
        faults.append(f"{sheet}, row {number}: a quote that its cell does not end with; {expected}")
        return []
    return [cell.strip() for cell in cells]


def _header_faults(
    header: list[str], line: str, sheet: str, known: Sequence[str], required: Sequence[str]
) -> list[str]:
    if len(header) == 1 and header[0] not in known:
        for delimiter, name in OTHER_DELIMITERS.items():
            if len({part.strip(' "') for part in line.split(delimiter)} & set(known)) > 1:
                return [f"{sheet}: cells are separated by {name}; expected tabs"]
    faults = []
    for index, column in enumerate(header):
        if not column:
            faults.append(f"{sheet}: column {index + 1} has no name; expected one in its header")
        elif column not in known:
            faults.append(f"{sheet}, column {quoted(column)}: {unknown(column, known)}")
        elif column in header[:index]:
            faults.append(f"{sheet}, column {column}: repeated; expected once")
    missing = [column for column in required if column not in header]
    if missing:
        faults.append(f"{sheet}: no column {', '.join(missing)}; expected a header with it")
    return faults
