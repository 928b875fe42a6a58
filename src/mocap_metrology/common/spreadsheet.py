"""CSV files as spreadsheets save them: where the decimal mark is a comma, semicolons or tabs are
between cells."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

from mocap_metrology.common.errors import Refusal, printable

NUMBER = re.compile(r"\s*[+-]?\d*,\d*([eE][+-]?\d+)?\s*", re.ASCII)
WRITTEN = re.compile(r"[+-]?\d*(?:[.,](\d*))?(?:[eE][+-]?(\d*))?", re.ASCII)
ENOUGH_ABOVE = 20  # rows that a program wrote alike; fewer may be of a hand
CONTROL = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u2028\u2029]")  # not \t, \n, \r

# At the start of a cell, or behind what may separate cells too; a number is none
FORMULA = re.compile(r"(^|[;\t\r\n]\s*)(?=[=@\t\r]|[+-](?![\d.]*([eE][+-]?\d+)?($|;)))")


def delimiter(header: str) -> str:
    """What is between the cells of a header: `;` or a tab where there is no comma, else `,`."""
    return next((one for one in ";\t" if one in header and "," not in header), ",")


def with_point(cell: str) -> str:
    """A number with a decimal comma as one with a point; any other cell as it is."""
    return cell.replace(",", ".") if NUMBER.fullmatch(cell) else cell


def number(cell: str) -> float:
    """A number as files have it; ValueError for what only Python takes for one, as 1_0 or ٣."""
    if not cell.isascii() or "_" in cell:
        raise ValueError(f"{cell[:30]!r} is not a number")
    return float(cell)


def fewer_digits(last: str, above: Sequence[str]) -> bool:
    """Whether a number has fewer digits behind its point, or in its exponent, than every one above
    it: where the text ends in it, it is cut off."""
    of_last, others = _digits(last), [digits for digits in map(_digits, above) if digits]
    if not (of_last and others):
        return False
    return any(of_last[k] < min(digits[k] for digits in others) for k in (0, 1))


def _digits(cell: str) -> tuple[int, int] | None:
    """How many digits a number has behind its point and in its exponent; None if it is none."""
    match = WRITTEN.fullmatch(cell)
    return (len(match[1] or ""), len(match[2] or "")) if match and cell else None


def as_text(value: object) -> object:
    """A value as CSV has it: before what a spreadsheet would run as a formula, in the whole cell or
    in the parts into which it may split it, stands `'`, which it takes for text. Letters that
    control a terminal are written as their codes; NaN and None are empty."""
    if isinstance(value, str):
        return _of_text(value)
    return "" if value is None or value != value else value


@lru_cache(maxsize=1 << 14)
def _of_text(text: str) -> str:
    """Cells repeat: names, units, words."""
    return printable(FORMULA.sub(r"\1'", text))


def rows(text: str) -> list[list[str]]:
    """Cells of each line of a table, its header first; numbers have points; a line of blank cells
    has none. The mark of the end that programs of the time of DOS write (Ctrl-Z) is no text.
    ValueError where a line is not to be split, or the last one is cut off within its number."""
    text = text.rstrip("\x1a")
    if odd := CONTROL.search(text):
        line = len(re.findall(r"\r\n|\r|\n", text[: odd.start()])) + 1
        raise ValueError(f"line {line} has a control character, {odd[0]!r}")
    lines = text.splitlines()
    between = delimiter(lines[0]) if lines else ","
    try:
        read = csv.reader(lines, delimiter=between, strict=True)
        filled = [row if any(cell.strip() for cell in row) else [] for row in read]
    except csv.Error as error:
        raise ValueError(error) from None
    if not text.endswith(("\n", "\r")) and filled and (last := filled[-1]):
        above = [row[-1] for row in filled[1:-1] if len(row) == len(last)]
        if len(above) >= ENOUGH_ABOVE and fewer_digits(last[-1], above):
            raise ValueError(f"it ends in {last[-1][:30]!r}, every earlier number has more digits")
    if between == ",":
        return filled
    return [[with_point(cell) for cell in row] for row in filled]


def columns(path: str | Path, expected: str) -> dict[str, list[str]]:
    """Cells of each column of a table by its name. `Refusal` where there is no table, for a line
    with more cells than there are names, and for a name that is repeated."""
    name = Path(path).name
    try:
        table = rows(Path(path).read_text(encoding="utf-8-sig"))
    except (OSError, ValueError) as error:
        raise Refusal(f"{name}: cannot be read ({error}); expected {expected}") from None
    first = next((k for k, row in enumerate(table) if row), 0)
    check_width(table[first:], name, first + 1)
    header, *body = [row for row in table if row] or [[]]
    names = [cell.strip() for cell in header]
    if repeated := {one for one in names if one and names.count(one) > 1}:
        raise Refusal(f"{name}: column {min(repeated)} is repeated; expected {expected}")
    padded = [row + [""] * len(names) for row in body]
    return {one: [row[k] for row in padded] for k, one in enumerate(names)}


def check_width(rows: Sequence[Sequence[str]], name: str, first: int = 1) -> None:
    """Refuse a line with more cells than the header, line `first`, as where two lines were
    joined."""
    for number, row in enumerate(rows, start=first):
        if any(cell.strip() for cell in row[len(rows[0]) :]):
            said = f"line {number} has {len(row)} cells, expected {len(rows[0])}"
            raise Refusal(f"{name}: {said}")
