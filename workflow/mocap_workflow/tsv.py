"""Reading a sheet: one header line, tabs between cells, UTF-8; `#` begins a comment line.

Rows are numbered as an editor or a spreadsheet shows them, comments and blank lines counted.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mocap_workflow.faults import Faults, shown, unknown

OTHER_DELIMITERS = {",": "commas", ";": "semicolons", "|": "bars", " ": "blanks"}


@dataclass
class Row:
    """One row: its cells by column, and what is wrong with them."""

    number: int
    cells: dict[str, str]
    sheet: str
    what: str  # the column that names the row
    faults: list[str] = field(default_factory=list)
    wrong: set[str] = field(default_factory=set)

    def __getitem__(self, column: str) -> str:
        return self.cells.get(column, "")

    @property
    def name(self) -> str:
        return self[self.what]

    def blame(self, column: str, expected: str, value: str | None = None) -> None:
        """Note `sheet, row 3 (recording "A"), column n_cameras: "ten"; expected ...`."""
        whose = f" ({self.what} {shown(self.name)})" if self.name else ""
        value = shown(self[column] if value is None else value)
        self.wrong.add(column)
        self.faults.append(
            f"{self.sheet}, row {self.number}{whose}, column {column}: {value}; expected {expected}"
        )

    def parts(self, column: str) -> list[str]:
        """Parts of a cell separated by `;`: none for an empty cell, each without blanks around."""
        return [part.strip() for part in self[column].split(";")] if self[column] else []


def read(path: str | Path, schema: Mapping[str, Any]) -> list[Row]:
    """The rows of a sheet whose header is right; `Faults` when the sheet as such is wrong."""
    sheet = str(path)
    lines = [
        (number, line)
        for number, line in enumerate(_lines(Path(path), sheet), start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not lines:
        raise Faults([f"{sheet}: no header; expected columns {', '.join(schema['columns'])}"])
    faults: list[str] = []
    header = _cells(*lines[0], sheet, faults)
    while header and not header[-1]:
        header.pop()
    faults += _header_faults(header, lines[0][1], sheet, schema)
    if faults:
        raise Faults(faults)
    rows = []
    for number, line in lines[1:]:
        cells = _cells(number, line, sheet, faults)
        row = Row(number, dict(zip(header, cells, strict=False)), sheet, schema["what"])
        if any(cells[len(header) :]):
            faults.append(f"{sheet}, row {number}: {len(cells)} cells; expected {len(header)}")
        elif any(cells):
            rows.append(row)
    if faults:
        raise Faults(faults)
    return rows


def _lines(path: Path, sheet: str) -> list[str]:
    try:
        raw = path.read_bytes()
    except FileNotFoundError:
        raise Faults([f"{sheet}: no such file; expected a sheet, or an empty value"]) from None
    except OSError as error:
        raise Faults([f"{sheet}: {error.strerror}; expected a sheet"]) from None
    if raw[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise Faults([f"{sheet}: UTF-16; expected UTF-8 text with tabs between cells"])
    if b"\0" in raw or raw[:2] == b"PK":
        raise Faults([f"{sheet}: not a text file; expected UTF-8 text with tabs between cells"])
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        row = raw.count(b"\n", 0, error.start) + 1
        raise Faults([f"{sheet}, row {row}: not UTF-8; expected UTF-8 text"]) from None
    return re.split(r"\r\n|\n|\r", text)


def _cells(number: int, line: str, sheet: str, faults: list[str]) -> list[str]:
    """Cells of a line, without blanks around; an opening quote must close on its line."""
    try:
        cells = next(csv.reader([line], delimiter="\t", strict=True))
    except csv.Error:
        faults.append(f"{sheet}, row {number}: a quote that does not close; expected a pair")
        return []
    return [cell.strip() for cell in cells]


def _header_faults(
    header: list[str], line: str, sheet: str, schema: Mapping[str, Any]
) -> list[str]:
    known = list(schema["columns"])
    if len(header) == 1 and header[0] not in known:
        for delimiter, name in OTHER_DELIMITERS.items():
            if len({part.strip(' "') for part in line.split(delimiter)} & set(known)) > 1:
                return [f"{sheet}: cells are separated by {name}; expected tabs"]
    faults = []
    for index, column in enumerate(header):
        if not column:
            faults.append(f"{sheet}: column {index + 1} has no name; expected one in its header")
        elif column not in known:
            faults.append(f"{sheet}, column {shown(column)}: {unknown(column, known)}")
        elif column in header[:index]:
            faults.append(f"{sheet}, column {column}: there twice; expected once")
    missing = [column for column in schema["required"] if column not in header]
    if missing:
        faults.append(f"{sheet}: no column {', '.join(missing)}; expected a header with it")
    return faults


def check_patterns(rows: list[Row], schema: Mapping[str, Any]) -> None:
    """Blame cells that do not match the pattern of their column."""
    for row in rows:
        for column, rule in schema["columns"].items():
            if "pattern" in rule and not re.fullmatch(rule["pattern"], row[column]):
                row.blame(column, rule["expected"])


def check_names(rows: list[Row]) -> None:
    """Blame names used twice; upper and lower case are one name to some file systems."""
    first: dict[str, Row] = {}
    for row in rows:
        earlier = first.setdefault(row.name.casefold(), row)
        if earlier is not row and row.name:
            row.blame(row.what, f"a name of its own (row {earlier.number} has it)")


def check_listed(row: Row, column: str, expected: str) -> list[str]:
    """Parts of a list cell; blame an empty or a repeated one."""
    parts = row.parts(column)
    if "" in parts or len(set(parts)) < len(parts):
        row.blame(column, f"{expected}, none empty, none twice")
    return parts
