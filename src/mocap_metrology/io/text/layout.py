"""A text recording without its numbers: its lines and its header."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.header import READ, not_read, number, refuse_other, regular_size
from mocap_metrology.io.labels import complete_labels
from mocap_metrology.io.recording import Header

LONGEST_LINE = 1 << 20  # bytes; 30,000 markers
BOM = b"\xef\xbb\xbf"
END_OF_TEXT = b"\x1a"  # Ctrl-Z, behind the last line of programs of the time of DOS
BLANKS = " \t"
NULLS = (
    *("", "NULL", "null", "None", "NA", "N/A", "#N/A"),
    *("NaN", "nan", "NAN", "-nan", "-nan(ind)", "nan(ind)"),
)
BODY = "is a body: its position and orientation are solved from its markers, not measured"

Triple = tuple[int, int, int]


@dataclass(frozen=True)
class RotationColumns:
    """Place of the orientation of a body: `columns` (from 0) of a quaternion x, y, z, w, of a
    matrix row by row, or of three angles in degrees about the body's own axes (`XYZ`, in this
    order), as `kind` says: `quaternion`, `matrix`, `XYZ` ..."""

    columns: tuple[int, ...]
    kind: str


@dataclass(frozen=True)
class Line:
    """One line without its end; `number` from 1; `start` and `end` in bytes, its end included."""

    text: str
    number: int
    start: int
    end: int

    def cells(self, delimiter: str) -> list[str]:
        """Its cells, stripped."""
        return cells_of(self.text, delimiter)


@dataclass(frozen=True, kw_only=True)
class Layout(Header):
    """A text recording without its numbers.

    `columns`: places (from 0) of x, y, z of each label; `frame_column`, `time_column` (s) where
    there are such. `first`: the first line of numbers.
    `second`: of the unit of the times.
    `declared`: name and value of the field that counts frames; `declared_too_few`: whether it is
    known to be below the number of rows at times.
    `ends_blank`: an empty line ends the numbers. `full_rows`: every row has a number, or
    NaN, in all columns. `missing_below`: a smaller number is no measurement, nor is
    x = y = z = 0 with `zero_is_gap`;
    `zero_note`: what to say where there are such. `remarks`: what to say of a label, by its place,
    once it is chosen. `rotations`: orientations of labels that are bodies, by their place.
    """

    columns: tuple[Triple, ...]
    delimiter: str
    first: Line
    n_columns: int
    frame_column: int | None = None
    time_column: int | None = None
    declared: tuple[str, int] | None = None
    declared_too_few: bool = False
    ends_blank: bool = False
    full_rows: bool = False
    second: float = 1.0
    missing_below: float = -math.inf
    zero_is_gap: bool = False
    zero_note: str = ""
    remarks: Mapping[int, str] = field(default_factory=dict)
    rotations: Mapping[int, RotationColumns] = field(default_factory=dict)

    @property
    def bodies(self) -> frozenset[int]:
        """Places of labels that are bodies, with an orientation that is read or without."""
        return frozenset([*self.rotations, *(k for k, of in self.remarks.items() if of == BODY)])


def cells_of(line: str, delimiter: str) -> list[str]:
    """The cells of a line, stripped; the spaces round a number mean nothing. A delimiter of one
    space stands for any run of spaces and tabs, at either end too."""
    if delimiter == " ":
        return line.split()
    return [cell.strip() for cell in line.split(delimiter)]


def without_padding(line: str, delimiter: str) -> str:
    """A line without the blanks between a delimiter and a quote, which `csv.reader` would take for
    the start of a cell that has no quotes."""
    blank = BLANKS.replace(delimiter, "")
    return re.sub(rf'{re.escape(delimiter)}[{blank}]+(?=")', delimiter, line)


def quoted_cells(line: str, delimiter: str) -> list[str]:
    """The cells of a line of names, stripped; a name with a delimiter in it is in quotes, which
    come in pairs."""
    try:
        if delimiter != " " and line.count('"') % 2 == 0:
            text = without_padding(line, delimiter)
            return [cell.strip() for cell in next(csv.reader([text], delimiter=delimiter), [])]
    except csv.Error:  # a cell beyond the reader's limit
        pass
    return [cell.strip('"') for cell in cells_of(line, delimiter)]


def lines(path: Path, start: int = 0, number: int = 1) -> Iterator[Line]:
    """Lines from byte `start` on, the first being line `number`; UTF-8, else Latin-1."""
    with path.open("rb") as stream:
        stream.seek(start)
        while raw := stream.readline(LONGEST_LINE):
            if len(raw) == LONGEST_LINE:
                raise Refusal(f"{path.name}: line {number} is longer than {LONGEST_LINE} bytes")
            end, raw = start + len(raw), raw.rstrip(END_OF_TEXT)
            text = decoded(raw.removeprefix(BOM) if start == 0 else raw).rstrip("\r\n")
            if "\r" in text:  # some programs would read two lines
                raise Refusal(f"{path.name}: line {number} has a carriage return inside")
            yield Line(text, number, start, end)
            start, number = end, number + 1


def decoded(raw: bytes) -> str:
    """UTF-8 where it is, else Latin-1, in which every byte is a letter."""
    try:
        return raw.decode("utf-8")
    except UnicodeDecodeError:
        return raw.decode("latin-1")


def check_text(path: Path, expected: str, read: str = READ) -> None:
    """Refuse what is no text file: nothing, a folder, another format, another encoding. `read`:
    what to name instead."""
    size = regular_size(path, expected)
    with path.open("rb") as stream:
        block = stream.read(4096).rstrip(END_OF_TEXT)
    half_empty = len(block) > 3 and any(block[:200:2]) != any(block[1:200:2])  # as of Latin letters
    if half_empty or block[:2] in (b"\xff\xfe", b"\xfe\xff"):
        wide = 32 if b"\0\0" in block[:8] else 16
        raise Refusal(f"{path.name}: is UTF-{wide} text, expected UTF-8: save it as UTF-8")
    refuse_other(path, block, expected, read)
    if any(byte < 32 and byte not in b"\t\r\n\f" for byte in block):
        raise not_read(path.name, expected, "a binary format", read)
    if not block.removeprefix(BOM).strip() and size <= 4096:
        raise Refusal(f"{path.name}: contains only white space, expected {expected}")
    if b"\r" in block and b"\n" not in block and sum(map(bool, block.split(b"\r"))) > 2:
        raise Refusal(f"{path.name}: its lines end with CR alone, expected LF or CR LF")


def rate(text: str, file: str = "the file") -> float:
    """Frame rate in Hz, 0 where the text has none."""
    text = re.sub(r"\s*Hz$", "", text.strip(' \t"'), flags=re.I)
    if re.fullmatch("[1-9][0-9]{0,2},[0-9]{3}", text):
        plain = text.replace(",", "")
        meant = f"{text.replace(',', '.')} or {plain} Hz; write it without a comma"
        raise Refusal(f"{file}: its frame rate, {text}, may be {meant}")
    value = number(text)
    return value if value is not None and value > 0 else 0.0


def count(text: str, name: str, file: str) -> int:
    """A whole number of the header's field `name`."""
    value = number(text)
    if value is None or value < 0 or value != int(value):
        raise Refusal(f"{file}: {name} is {text.strip()[:40]!r}, expected a whole number")
    return int(value)


def declared(fields: Mapping[str, str], name: str, file: str) -> tuple[str, int] | None:
    """Name and value of the header's field that counts frames; None where it says nothing."""
    text = fields.get(name, "")
    return (name, count(text, name, file)) if text else None


def named(labels: Sequence[str]) -> tuple[str, ...]:
    """Labels stripped, and completed as those of C3D files are."""
    stripped = [label.strip() for label in labels]
    return complete_labels(stripped, len(stripped))


def triples(starts: Iterable[int]) -> tuple[Triple, ...]:
    """Columns of x, y, z that begin at `starts`."""
    return tuple((i, i + 1, i + 2) for i in starts)
