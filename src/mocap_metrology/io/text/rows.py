"""The numbers of a text recording: parsed a block at a time, with the line of whatever is wrong.

Every block's delimiters are counted before Arrow converts it (exactly rounded), as neither a row
that is too short nor one that is too long may pass for a gap.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
import pyarrow as pa
from pyarrow import csv as arrow_csv

from mocap_metrology.common.errors import Refusal, Truncated
from mocap_metrology.common.spreadsheet import fewer_digits
from mocap_metrology.io.header import NUMBER
from mocap_metrology.io.recording import Counts
from mocap_metrology.io.text.layout import END_OF_TEXT, NULLS, Layout, cells_of, decoded, lines

BLOCK_BYTES = 8 << 20
REASONS = ("empty", "zero", "not_finite")
INFINITE = re.compile(r"[+-]?inf(inity)?", re.I)
COMMA = re.compile(r"[+-]?\d*,\d+")
ROWS_ABOVE = 10_000  # rows that decide how a column is written

Floats = npt.NDArray[np.float64]


@dataclass
class Rows:
    """`frame`, `time` (n,) as written or None; `blocks` (3 n_points, n_i) in the file's unit, NaN
    where there is no measurement; `counts` of such by reason for each point; `head` the first
    block's lines; `cut_off`: why the end is."""

    n: int = 0
    frame: Floats | None = None
    time: Floats | None = None
    blocks: list[Floats] = field(default_factory=list)
    counts: list[Counts] = field(default_factory=list)
    head: list[str] = field(default_factory=list)
    cut_off: str = ""
    notes: list[str] = field(default_factory=list)


def read_rows(layout: Layout, points: Sequence[int], accept_truncated: bool) -> Rows:
    """Read all rows: frame, time and the coordinates of `points` (places of labels, from 0)."""
    rows = Rows(counts=[dict.fromkeys(REASONS, 0) for _ in points])
    leading = [c for c in (layout.frame_column, layout.time_column) if c is not None]
    wanted = [*leading, *(c for p in points for c in layout.columns[p])]
    n_wanted = len(wanted)
    if layout.full_rows:
        wanted += range(layout.n_columns)
    parsed = []
    for block, line in _blocks(layout, rows, accept_truncated):
        if not rows.head:
            rows.head = decoded(block).splitlines()
        point = _decimal_point(layout, rows.head)
        columns, done = _parse(layout, block, line, wanted, point, rows.n)
        parsed.append(columns[: len(leading)])
        rows.blocks.append(columns[len(leading) : n_wanted])
        _mark_invalid(layout, points, rows)
        rows.n += columns.shape[1]
        if done:
            break
    if rows.n == 0:
        raise Refusal(f"{layout.name}: has no frames: nothing follows the header")
    leading_values = np.concatenate(parsed, axis=1)
    if layout.frame_column is not None:
        rows.frame = leading_values[0]
    if layout.time_column is not None:
        rows.time = leading_values[-1] * layout.second
    return rows


def line_of(layout: Layout, row: int) -> int:
    """Number of the line of a row (from 0); slow, for messages."""
    for line in lines(layout.path, layout.first.start, layout.first.number):
        if not _is_blank(layout, line.text, 0):
            row -= 1
        if row < 0:
            return line.number
    return 0


def _is_blank(layout: Layout, line: str, row: int) -> bool:
    """Empty, or delimiters only where a frame number or time would stand, or, as row `row` (from
    0), after the last frame that is declared."""
    blank = _blanks(layout) + "\r\n"
    if row >= _first_blank(layout):
        blank += layout.delimiter
    return not line.strip(blank)


def _first_blank(layout: Layout) -> float:
    """The first row (from 0) that is no frame if it has delimiters only; without frame number and
    time such a row is a frame without measurement, unless all that are declared came before."""
    if {layout.frame_column, layout.time_column} != {None}:
        return 0
    return layout.declared[1] if layout.declared else math.inf


def _blocks(layout: Layout, rows: Rows, accept_truncated: bool) -> Iterator[tuple[bytes, int]]:
    """Whole lines, and the number of the first; the last line is looked at if it has no end."""
    rest, line = b"", layout.first.number
    with layout.path.open("rb") as stream:
        stream.seek(layout.first.start)
        while chunk := stream.read(BLOCK_BYTES):
            chunk = rest + chunk
            cut = chunk.rfind(b"\n") + 1
            block, rest = chunk[:cut], chunk[cut:]
            if block:
                yield _unblanked(layout, block), line
                line += block.count(b"\n")
    rest = _unblanked(layout, rest.rstrip(END_OF_TEXT) + b"\n")[:-1]
    if _is_blank(layout, decoded(rest), rows.n):
        return
    cut_off = _cut_off(layout, decoded(rest), rows.head) if rows.n else ""
    if cut_off:
        rows.cut_off = f"line {line} {cut_off}"
        if not accept_truncated:
            raise Truncated(f"{layout.name}: cut off: {rows.cut_off}")
        return
    if not rest.endswith(b"\r"):
        rows.notes.append(f"line {line}, the last, has no line end: is anything missing?")
    yield rest + b"\n", line


def _unblanked(layout: Layout, block: bytes) -> bytes:
    """Nothing but blanks in a cell or line is nothing; runs that separate become one space, a line
    end that was changed twice one line end, and a number in quotes a number."""
    mark = layout.delimiter.encode()
    if b"\r\r" in block:
        block = re.sub(rb"\r+\n", b"\n", block)
    if layout.delimiter == " ":
        block = re.sub(rb"(?m)^ | (?=\r?$)", b"", re.sub(rb"[ \t]{2,}|\t", b" ", block))
    elif any(
        bytes([blank]) + end in block
        for blank in _blanks(layout).encode()
        for end in (mark, b"\r", b"\n")
    ):
        block = _stripped(layout, block)
    if b'"' in block:
        block = re.sub(
            rb'(?<![^\n%b])"([^"\n%b]*)"(?=[\r\n%b])' % (mark, mark, mark), rb"\1", block
        )
    return block


def _blanks(layout: Layout) -> str:
    """Blanks that separate nothing."""
    return " " if layout.delimiter == "\t" else " \t"


def _stripped(layout: Layout, block: bytes) -> bytes:
    """Without blanks round cells: Arrow takes them off numbers, not off what stands for none."""
    mark, blank = re.escape(layout.delimiter).encode(), f"[{_blanks(layout)}]".encode()
    ends = rb"(?m)(?<!%b)%b+(?=%b|\r?$)|(?:^|(?<=%b))%b+" % (blank, blank, mark, mark, blank)
    return re.sub(ends, b"", block)


def _cut_off(layout: Layout, last: str, above: Sequence[str]) -> str:
    """What shows that a last line without its end is cut off; empty where nothing does.

    Too few cells, or a last number with fewer digits behind its point (or in its exponent) than
    all above it: a cut within a number leaves a wrong one.
    """
    cells = cells_of(last, layout.delimiter)
    if len(cells) < layout.n_columns:
        return f"ends after {len(cells)} of {layout.n_columns} cells"
    column = len(cells) - 1
    rows = (cells_of(line, layout.delimiter) for line in above[:ROWS_ABOVE])
    if fewer_digits(cells[-1], [row[column] for row in rows if column < len(row)]):
        return f"ends in {cells[-1][:30]!r}, every earlier number has more digits"
    return ""


def _decimal_point(layout: Layout, head: Sequence[str]) -> str:
    """What most numbers of the first rows have inside, a comma or a point."""
    cells = [cell for line in head[:100] for cell in cells_of(line, layout.delimiter)]
    commas = sum(COMMA.fullmatch(cell) is not None for cell in cells)
    return "," if commas > sum("." in cell for cell in cells) else "."


def _parse(
    layout: Layout, block: bytes, line: int, wanted: Sequence[int], point: str, row: int
) -> tuple[Floats, bool]:
    """(n_wanted, n) numbers of a block, NaN where empty; and whether the numbers end in it. line,
    row: of its first line, the latter from 0."""
    block, width, done = _padded(layout, block, line, row)
    if not block:
        return np.empty((len(wanted), 0)), done
    beyond = [f"f{i}" for i in range(layout.n_columns, width)]
    chosen = [f"f{i}" for i in wanted]
    try:
        table = _table(block, layout.delimiter, chosen, beyond, point)
    except pa.ArrowException:
        block = _stripped(layout, block)
        try:
            table = _table(block, layout.delimiter, chosen, beyond, point)
        except pa.ArrowException as error:
            raise _wrong_cell(layout, line, wanted, point, str(error)) from None
    if any(table[name].null_count < table.num_rows for name in beyond):
        raise _wrong_cell(layout, line, wanted, point, "too many cells")
    if table.num_rows != block.count(b"\n"):
        raise _wrong_cell(layout, line, wanted, point, "carriage returns inside a line")
    values = np.empty((len(wanted), table.num_rows))
    for target, name in zip(values, chosen, strict=True):
        target[:] = table[name].to_numpy()
    return values, done


def _table(
    block: bytes, delimiter: str, numbers: list[str], texts: list[str], point: str
) -> pa.Table:
    """Arrow's reading of some columns (f0, f1, ...) of even rows."""
    kinds = dict.fromkeys(numbers, pa.float64()) | dict.fromkeys(texts, pa.string())
    return arrow_csv.read_csv(
        pa.BufferReader(block),
        arrow_csv.ReadOptions(use_threads=False, autogenerate_column_names=True),
        arrow_csv.ParseOptions(delimiter=delimiter, quote_char=False, ignore_empty_lines=False),
        arrow_csv.ConvertOptions(
            include_columns=[*dict.fromkeys(numbers), *texts],
            column_types=kinds,
            null_values=list(NULLS),
            strings_can_be_null=True,
            decimal_point=point,
        ),
    )


def _padded(layout: Layout, block: bytes, line: int, row: int) -> tuple[bytes, int, bool]:
    """The block with as many cells in each row, how many, and whether the numbers end in it.

    Cells may be missing at the end of a row, where the last markers are not seen; empty lines go.
    """
    letters = np.frombuffer(block, np.uint8)
    ends = np.flatnonzero(letters == 10)
    marks = np.flatnonzero(letters == ord(layout.delimiter))
    counts = np.diff(np.searchsorted(marks, ends), prepend=0)
    starts = np.concatenate([[0], ends[:-1] + 1])
    length = ends - starts - ((letters[ends - 1] == 13) & (ends > starts))
    blank = length == 0
    blank |= (length == counts) & (row + np.arange(len(counts)) >= _first_blank(layout))
    done = layout.ends_blank and bool(blank.any())
    if done:
        n = int(np.argmax(blank))
        _check_section(layout, block[starts[n] :], line + n)
        block, counts, blank = block[: starts[n]], counts[:n], blank[:n]
    if not len(counts) or blank.all():
        return b"", 0, done
    width = int(max(counts.max() + 1, layout.n_columns))
    if width > layout.n_columns + 100:
        n = int(np.argmax(counts))
        raise Refusal(
            f"{layout.name}: line {line + n} has {width} cells, expected {layout.n_columns}"
        )
    if layout.full_rows:
        _check_full(layout, line, counts, blank)
    if counts.min() + 1 == width and not blank.any():
        return block, width, done
    mark = layout.delimiter.encode()
    padded = [
        text.rstrip(b"\r") + mark * (width - 1 - n)
        for text, n, gone in zip(block.split(b"\n"), counts.tolist(), blank.tolist(), strict=False)
        if not gone
    ]
    return b"\n".join(padded) + b"\n", width, done


def _check_section(layout: Layout, rest: bytes, line: int) -> None:
    """Refuse numbers that go on below the empty line `line`: another section has a title first."""
    mark = layout.delimiter.encode()
    below = rest.lstrip(b"\r\n \t" + mark)
    number = line + rest[: len(rest) - len(below)].count(b"\n")
    text = decoded(below.split(b"\n", 1)[0].rstrip(b"\r" + mark))
    if NUMBER.fullmatch(text) or layout.delimiter in text:
        said = f"line {line} is empty, and numbers go on in line {number}"
        raise Refusal(f"{layout.name}: {said}; remove the empty line, or export again")


def _check_full(
    layout: Layout, line: int, counts: npt.NDArray[np.integer], blank: npt.NDArray[np.bool_]
) -> None:
    """Refuse a row with too few cells, which is no gap."""
    short = (counts + 1 < layout.n_columns) & ~blank
    if short.any():
        n = int(np.argmax(short))
        cells = f"{int(counts[n]) + 1} cells, expected {layout.n_columns}"
        raise Refusal(f"{layout.name}: line {line + n} has {cells}")


def _wrong_cell(
    layout: Layout, first: int, wanted: Sequence[int], point: str, error: str
) -> Refusal:
    """The refusal that names line and column of the first cell that is no number."""
    for line in lines(layout.path, layout.first.start, layout.first.number):
        if line.number < first:
            continue
        cells = line.cells(layout.delimiter)
        beyond = [cell for cell in cells[layout.n_columns :] if cell not in NULLS]
        if beyond:
            hint = "; are these decimal commas?" if layout.delimiter == "," else ""
            said = f"has {len(cells)} cells, expected {layout.n_columns}{hint}"
            return Refusal(f"{layout.name}: line {line.number} {said}")
        for column in sorted(wanted):
            cell = re.sub('^"(.*)"$', r"\1", cells[column]) if column < len(cells) else ""
            plain = cell.replace(",", ".", 1) if point == "," and "." not in cell else cell
            fits = NUMBER.fullmatch(plain) or INFINITE.fullmatch(plain)
            mixed = point == "," and "." in cell
            if cell in NULLS or (fits and not mixed):
                continue
            why = "has a point where other numbers have a comma" if fits else "is not a number"
            what = f"{cell[:30]!r} {why}"
            return Refusal(f"{layout.name}: line {line.number}, column {column + 1}: {what}")
    return Refusal(f"{layout.name}: from line {first} on: {error.splitlines()[0][:200]}")


def _mark_invalid(layout: Layout, points: Sequence[int], rows: Rows) -> None:
    """Which positions of the last block are measured; the others become NaN and are counted."""
    for k, point in enumerate(points):
        three = rows.blocks[-1][3 * k : 3 * k + 3]
        three[three < layout.missing_below] = np.nan
        missing = np.isnan(three)
        empty = missing.all(axis=0)
        part = missing.any(axis=0) & ~empty
        if part.any():
            row = int(np.argmax(part))
            n = 3 - int(missing[:, row].sum())
            line = line_of(layout, rows.n + row)
            label = layout.labels[point]
            raise Refusal(f"{layout.name}: line {line}: {label!r} has {n} of 3 coordinates")
        infinite = np.isinf(three).any(axis=0)
        counts = rows.counts[k]
        counts["empty"] += int(empty.sum())
        counts["not_finite"] += int(infinite.sum())
        three[:, infinite] = np.nan
        if layout.zero_is_gap:
            zero = (three == 0).all(axis=0)
            counts["zero"] += int(zero.sum())
            three[:, zero] = np.nan
