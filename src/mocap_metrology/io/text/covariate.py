"""Temperature or whatever else was recorded beside a recording: a CSV file of two columns."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.spreadsheet import delimiter, with_point
from mocap_metrology.io.header import NUMBER
from mocap_metrology.io.text.layout import check_text, lines

WHAT = "a CSV file of time_s and one other column"


def read_covariate(path: str | Path) -> tuple[str, np.ndarray, np.ndarray]:
    """Name, time_s (n,) and values (n,) of a CSV file with two columns, `time_s` and another.

    UTF-8, else Latin-1. Empty lines and empty cells beyond the second mean nothing.
    """
    path = Path(path)
    try:
        check_text(path, WHAT, read="")
        told = [line for line in lines(path) if line.text.strip()]
        between = delimiter(told[0].text) if told else ","
        records = [(line.number, _cells(line.text, between)) for line in told]
    except OSError as error:
        raise Refusal(f"{path.name}: cannot be read: {error.strerror or error}") from error
    records = [(number, cells) for number, cells in records if any(cells)]
    columns = records[0][1] if records else []
    if len(columns) != 2 or columns[0] != "time_s" or not columns[1]:
        listed = ", ".join(columns)[:80]
        raise Refusal(
            f"{path.name}: columns {listed}; expected time_s and one other, with a comma, a"
            " semicolon or a tab between"
        )
    rows = _rows(path.name, records[1:])
    return columns[1], rows[:, 0], rows[:, 1]


def _rows(name: str, records: list[tuple[int, list[str]]]) -> np.ndarray:
    """(n, 2) numbers of lines with their numbers (from 1), the first column rising."""
    rows: list[list[float]] = []
    for number, cells in records:
        where = f"{name}: line {number}"
        if len(cells) != 2:
            raise Refusal(f"{where} has {len(cells)} cells, expected 2")
        values = [float(cell) if NUMBER.fullmatch(cell) else math.nan for cell in cells]
        if not all(map(math.isfinite, values)):
            raise Refusal(f"{where}: expected two numbers")
        if rows and values[0] <= rows[-1][0]:
            before = rows[-1][0]
            raise Refusal(f"{where}: time_s must increase, {values[0]:.10g} follows {before:.10g}")
        rows.append(values)
    if len(rows) < 2:
        raise Refusal(f"{name}: {len(rows)} lines of numbers; expected two or more")
    return np.array(rows)


def _cells(text: str, between: str) -> list[str]:
    """Two cells, and what else there is: a spreadsheet may add empty ones."""
    cells = [cell.strip(' \t"') for cell in text.split(between)]
    if between != ",":
        cells = [with_point(cell) for cell in cells]
    while len(cells) > 2 and not cells[-1]:
        cells.pop()
    return cells
