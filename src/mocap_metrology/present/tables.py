"""Tables: each as CSV with full digits and as Markdown with a caption, to read."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeGuard

import numpy as np

from mocap_metrology.common.files import write_csv, write_text
from mocap_metrology.present.text.numbers import (
    FOUR_DECIMALS,
    NINE_HOURS_S,
    as_printed,
    duration_text,
    readable,
)

if TYPE_CHECKING:
    import pandas as pd

Row = dict[str, Any]  # of a table: numbers, words, gaps
Record = Mapping[str, Any]  # a row as read from CSV, or what a JSON file holds
BESIDE = ("regenerated", "expected")  # columns with the decimals of `published`
NOISE_NUMBERS = (  # columns of noise.csv
    *("value", "std_error", "crlb", "lower_68", "upper_68", "lower_95", "upper_95"),
)
RESIDUALS = ("residual", "published_residual")  # differences, and no values of the quantity


def read(path: str | Path) -> pd.DataFrame:
    """A CSV file of results, numbers as they were written; only an empty cell is a gap, so that a
    recording may be called NA."""
    import pandas as pd

    return pd.read_csv(path, keep_default_na=False, na_values=[""])


def read_noise(path: str | Path) -> list[Row]:
    """Rows of a noise.csv with numbers as numbers; NaN where a number is missing."""
    table = read(path)
    words = table.columns.difference([*NOISE_NUMBERS, "detected"])
    table[words] = table[words].astype(object).fillna("")
    return [{str(k): v for k, v in row.items()} for row in table.to_dict("records")]


def write(path: str | Path, rows: Sequence[Row], title: str, caption: str) -> None:
    """Write `<path>.csv` and `<path>.md` (`path` may be either's); what a row lacks is empty."""
    head = dict.fromkeys(name for row in rows for name in row)
    whole = [{name: row.get(name) for name in head} for row in rows]
    write_with(path, whole, markdown(whole, title, caption))


def write_with(path: str | Path, rows: Sequence[Row], text: str, head: Sequence[str] = ()) -> None:
    """Write rows as `<path>.csv` and `text` as `<path>.md`; `head`: columns where no row is."""
    stem = str(path).removesuffix(".csv").removesuffix(".md")
    table = Path(f"{stem}.csv")
    if rows:
        write_csv(table, rows)
    else:
        write_text(table, ",".join(head) + "\n")
    write_text(f"{stem}.md", text)


def aligned(lines: Sequence[Sequence[object]]) -> list[str]:
    """Lines of a Markdown table, the first its head, columns of equal width."""
    cells = [[_shown(cell) for cell in line] for line in lines]
    width = [max(len(line[k]) for line in cells) for k in range(len(cells[0]))]
    shown = [_line(line, width) for line in cells]
    shown.insert(1, "|" + "|".join("-" * (w + 2) for w in width) + "|")
    return shown


def markdown(rows: Sequence[Row], title: str, caption: str) -> str:
    """A Markdown table, numbers as `numbers.readable` and `as_printed` write them, columns of equal
    width."""
    head = list(rows[0])
    lines = aligned([head, *([_cell(row, name) for name in head] for row in rows)])
    return "\n".join([f"# {title}", "", caption, "", *lines, ""])


def _cell(row: Row, name: str) -> object:
    """What a table to read shows of a row in a column: a number as text, all else as it is."""
    value = row[name]
    if not _is_number(value):
        return value
    quantity = str(row.get("quantity", ""))
    own = quantity if FOUR_DECIMALS.fullmatch(quantity) and name not in RESIDUALS else name
    if name == "published":
        return as_printed(float(value), own)
    published = row.get("published") if name in BESIDE else None
    if not (_is_number(published) or type(published) is int):
        published = None
    return readable(float(value), own, None if published is None else float(published))


def _is_number(value: object) -> TypeGuard[float]:
    return isinstance(value, (float, np.floating)) and not math.isnan(value)


def _line(cells: Sequence[str], width: Sequence[int]) -> str:
    return "| " + " | ".join(c.ljust(w) for c, w in zip(cells, width, strict=True)) + " |"


def _shown(value: object) -> str:
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    if isinstance(value, (float, np.floating)):
        return readable(float(value))
    return str(value).replace("|", "\\|").replace("\n", " ")


def source_sentence(sources: Mapping[str, str], duration_s: float | None = None) -> str:
    """What a caption says of where its recordings come from.

    sources: name -> `twin` or `measured`; duration_s: length of the twins, where it is of interest,
    said beside that of the recordings of S where they are shorter or longer.
    """
    twins = [name for name, source in sources.items() if source == "twin"]
    if not twins:
        return "All recordings are measured."
    of_length = _length(duration_s)
    if len(twins) == len(sources):
        made = "simulated, from published or configured numbers"
        return f"All recordings are twins{of_length}: {made}."
    return f"Simulated (twins{of_length}): {', '.join(twins)}; the others are measured."


def _length(duration_s: float | None) -> str:
    """` of 10 min (S: nine hours)`, or nothing where the length is not known."""
    if duration_s is None:
        return ""
    of_paper = "" if round(duration_s) == NINE_HOURS_S else f" (S: {duration_text(NINE_HOURS_S)})"
    return f" of {duration_text(duration_s)}{of_paper}"


def source_of(recording: Record | None) -> str:
    """`twin`, `measured`, or `cited` where no recording stands for the published row."""
    return "cited" if recording is None else "twin" if recording["twin"] else "measured"
