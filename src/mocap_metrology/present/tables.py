"""Tables: each as CSV with full digits and as Markdown with a caption, to read."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeGuard

import numpy as np

from mocap_metrology.common.errors import printable
from mocap_metrology.common.files import write_csv, write_text
from mocap_metrology.common.types import Record
from mocap_metrology.noise.series import length_s
from mocap_metrology.present.text.numbers import NINE_HOURS_S, duration_words, significant

if TYPE_CHECKING:
    import pandas as pd

Row = dict[str, Any]  # of a table: numbers, words, gaps
Part = str | Sequence[Sequence[object]]  # of a document: a text, or a table with its head
BESIDE = ("regenerated", "expected")  # columns with the decimals of `published`
RESIDUALS = ("residual", "published_residual")  # differences, and no values of the quantity
DIGITS = 5  # significant ones of a number to read
SMALL, LARGE = 1e-4, 1e6  # beyond these a number is written with a power of ten
LEAST_P = 1e-6  # a probability below this is as good as none
NOTHING = 1e-9  # a percentage, or a number published as 0, below this is an error of rounding
# What S Table 4 prints with four decimals
FOUR_DECIMALS = re.compile(r"(mu|sigma)_(1|2|L|e|A1|A2|B|C)_mm|rho_12")
# What would be markup in Markdown: cells are text, some of it a user's
MARKUP = re.compile(r"[\\|`*\[\]]|<(?=[A-Za-z/!?])|&(?=[#A-Za-z])|(?<![^\W_])_")
PROBABILITY = re.compile(r"(.+_)?p")


def read(path: str | Path) -> pd.DataFrame:
    """A CSV file of results, numbers as they were written; only an empty cell is a gap, so that a
    recording may be called NA."""
    import pandas as pd

    return pd.read_csv(path, keep_default_na=False, na_values=[""])


def write(path: str | Path, rows: Sequence[Row], title: str, caption: str) -> None:
    """Write `<path>.csv` and `<path>.md` (`path` may be either's); what a row lacks is empty."""
    head = dict.fromkeys(name for row in rows for name in row)
    whole = [{name: row.get(name) for name in head} for row in rows]
    write_with(path, whole, markdown(whole, title, caption))


def write_with(path: str | Path, rows: Sequence[Row], text: str, head: Sequence[str] = ()) -> None:
    """Write rows as `<path>.csv` and `text` as `<path>.md`; `head`: columns where no row is."""
    stem = str(path).removesuffix(".csv").removesuffix(".md")
    if rows:
        write_csv(Path(f"{stem}.csv"), rows)
    else:
        write_text(f"{stem}.csv", ",".join(head) + "\n")
    write_text(f"{stem}.md", text)


def _aligned(lines: Sequence[Sequence[object]]) -> str:
    """A Markdown table, the first of the lines its head, columns of equal width."""
    cells = [[_text(cell) for cell in line] for line in lines]
    width = [max(map(len, column)) for column in zip(*cells, strict=True)]
    padded = [[c.ljust(w) for c, w in zip(line, width, strict=True)] for line in cells]
    rule = "|" + "|".join("-" * (w + 2) for w in width) + "|"
    head, *body = (f"| {' | '.join(line)} |" for line in padded)
    return "\n".join([head, rule, *body])


def in_columns(rows: Sequence[Sequence[str]]) -> list[str]:
    """Lines of a table in plain text, columns of equal width."""
    width = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [f"  {'  '.join(map(str.ljust, row, width))}".rstrip() for row in rows]


def document(title: str, *parts: Part) -> str:
    """Markdown of a title and its parts: texts, and tables whose first line is their head; empty
    ones are omitted."""
    texts = (part if isinstance(part, str) else _aligned(part) for part in parts if part)
    return "\n\n".join([f"# {title}", *texts]) + "\n"


def markdown(rows: Sequence[Row], title: str, caption: str, nothing: str = "") -> str:
    """A Markdown table, numbers as `readable` and `as_printed` write them; the words `nothing` in
    its place where there is no row."""
    if not rows:
        return document(title, nothing)
    head = list(rows[0])
    return document(title, caption, [head, *([shown(row, n) for n in head] for row in rows)])


def shown(row: Record, name: str) -> object:
    """What a table to read shows of a row in a column: a number as text, all else as it is."""
    value = row[name]
    if not _is_number(value):
        return value
    quantity = str(row.get("quantity", ""))
    column = quantity if FOUR_DECIMALS.fullmatch(quantity) and name not in RESIDUALS else name
    if name == "published":
        return as_printed(float(value), column)
    published: Any = row.get("published") if name in BESIDE else None
    known = _is_number(published) or type(published) is int
    return readable(float(value), column, float(published) if known else None)


def _is_number(value: object) -> TypeGuard[float]:
    return isinstance(value, (float, np.floating)) and not math.isnan(value)


def _text(value: object) -> str:
    if _is_number(value):
        return readable(float(value))
    if value is None or isinstance(value, (float, np.floating)):
        return ""
    return MARKUP.sub(r"\\\g<0>", printable(" ".join(str(value).split("\n"))))


def plain(cell: str) -> str:
    """The text of a cell of a Markdown table, as it was before it was written."""
    return re.sub(r"\\([\\|`*\[\]<&_])", r"\1", cell)


def origin_words(twin: str | None) -> str:
    """`simulated stand-in (twin) T40-10`, or `measured`."""
    return f"simulated stand-in (twin) {twin}" if twin else "measured"


def sources(
    rows: Mapping[str, Record], lengths_s: Mapping[str, float], paper: bool = True
) -> tuple[str, str]:
    """The line at the foot of a figure of these rows of the sheet, and what its caption adds: how
    many are measured, how many are twins of which length, and which.

    lengths_s: by recording; paper: whether the nine hours of S are to compare with.
    """
    twins = [name for name, row in rows.items() if row["twin"]]
    lengths: dict[str, list[str]] = {}
    for name in (name for name in twins if name in lengths_s):
        lengths.setdefault(duration_words(lengths_s[name]), []).append(name)
    measured = len(rows) - len(twins)
    kinds = [f"{measured} measured recording{'s' * (measured > 1)}"] if measured else []
    remarks = []
    if twins:
        many, of = "s" * (len(twins) > 1), f" of {' and '.join(lengths)}" if lengths else ""
        kinds.append(f"{len(twins)} simulated stand-in{many} (twin{many}){of}")
        remarks.append("Twins are simulated from published or configured numbers.")
    line = f"Source: {' and '.join(kinds)}."
    if paper and lengths and list(lengths) != [duration_words(NINE_HOURS_S)]:
        line += " The paper's recordings last nine hours."
    if twins and measured:
        remarks.append(f"Simulated: {', '.join(twins)}; the others are measured.")
    if len(lengths) > 1:
        each = "; ".join(f"{', '.join(names)}: {length}" for length, names in lengths.items())
        remarks.append(f"Length of the twins: {each}.")
    return line, " ".join(remarks)


def sources_of(origins: Mapping[str, Record]) -> tuple[str, str]:
    """The same of recordings of any group, by metadata of a table of each."""
    return sources(origins, {name: length_s(of) for name, of in origins.items()}, paper=False)


def source_sentence(sources: Mapping[str, str], duration_s: float | None = None) -> str:
    """The sentence of a caption on the origin of its recordings.

    sources: name -> `twin` or `measured`; duration_s: length of the twins, where it is of interest,
    stated beside that of the recordings of S if it differs.
    """
    twins = [name for name, source in sources.items() if source == "twin"]
    if not twins:
        return "All recordings are measured."
    length = "" if duration_s is None else f" of {duration_words(duration_s)}"
    if duration_s is not None and round(duration_s) != NINE_HOURS_S:
        length += f" (S: {duration_words(NINE_HOURS_S)})"
    if len(twins) == len(sources):
        origin = "simulated, from published or configured numbers"
        return f"All recordings are twins{length}: {origin}."
    return f"Simulated (twins{length}): {', '.join(twins)}; the others are measured."


def readable(value: float, name: str = "", published: float | None = None) -> str:
    """A number of the column, or of the quantity, of that name, for a table to read.

    Five significant digits, three below 1e-3, with a power of ten below 1e-4 and from 1e6 on; four
    decimals, zeros included, of what S Table 4 prints so; three digits of a percentage;
    probabilities below 1e-6 as `< 1e-6`. published: the number beside it; at least as many decimals
    are shown.
    """
    size, percent = abs(value), name.endswith("_percent")
    if not math.isfinite(value):
        return "" if math.isnan(value) else str(value)
    if PROBABILITY.fullmatch(name):
        return "< 10⁻⁶" if value < LEAST_P else f"{value:.3g}"
    if value == 0 or ((percent or published == 0) and size < NOTHING):
        return "0"
    if percent:
        return f"{value:.3g}" if size < 100 else f"{value:.0f}"
    if FOUR_DECIMALS.fullmatch(name) and size >= 1e-3:
        return f"{value:.4f}"
    if not SMALL <= size < LARGE:
        return significant(value) if value % 1 or size >= 1e15 else f"{value:.0f}"
    text = f"{value:.{DIGITS if size >= 1e-3 else 3}g}"
    if size >= 10**DIGITS:
        return f"{float(text):.0f}"
    decimals = len(as_printed(published or 0.0, name).partition(".")[2])
    more = decimals > len(text.partition(".")[2]) and abs(published or 0.0) >= SMALL
    return f"{value:.{decimals}f}" if more else text


def as_printed(value: float, name: str) -> str:
    """A published number with all its digits: three of a small coefficient, four decimals of what
    S Table 4 prints so."""
    if FOUR_DECIMALS.fullmatch(name):
        return f"{value:.4f}"
    small = 0 < abs(value) < SMALL and float(f"{value:.2e}") == value
    return significant(value) if small else f"{value:.7g}"
