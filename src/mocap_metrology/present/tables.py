"""Tables: each as CSV with full digits and as Markdown with a caption, to read."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mocap_metrology.common.files import write_csv, write_text

Row = dict[str, Any]


def write(path: str | Path, rows: Sequence[Row], title: str, caption: str) -> None:
    """Write `<path>.csv` and `<path>.md` (`path` has no suffix); what a row lacks is empty."""
    head = dict.fromkeys(name for row in rows for name in row)
    whole = [{name: row.get(name) for name in head} for row in rows]
    write_with(path, whole, markdown(whole, title, caption))


def write_with(path: str | Path, rows: Sequence[Row], text: str, head: Sequence[str] = ()) -> None:
    """Write rows as `<path>.csv` and `text` as `<path>.md`; `head`: columns where no row is."""
    path = Path(path)
    table = path.with_name(f"{path.name}.csv")
    if rows:
        write_csv(table, rows)
    else:
        write_text(table, ",".join(head) + "\n")
    write_text(path.with_name(f"{path.name}.md"), text)


def aligned(lines: Sequence[Sequence[Any]]) -> list[str]:
    """Lines of a Markdown table, the first its head, columns of equal width."""
    cells = [[_shown(cell) for cell in line] for line in lines]
    width = [max(len(line[k]) for line in cells) for k in range(len(cells[0]))]
    shown = [_line(line, width) for line in cells]
    shown.insert(1, "|" + "|".join("-" * (w + 2) for w in width) + "|")
    return shown


def markdown(rows: Sequence[Row], title: str, caption: str) -> str:
    """A Markdown table, numbers to seven significant digits, columns of equal width."""
    head = list(rows[0])
    lines = aligned([head, *([row[name] for name in head] for row in rows)])
    return "\n".join([f"# {title}", "", caption, "", *lines, ""])


def _line(cells: Sequence[str], width: Sequence[int]) -> str:
    return "| " + " | ".join(c.ljust(w) for c, w in zip(cells, width, strict=True)) + " |"


def _shown(value: Any) -> str:
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    if isinstance(value, (float, np.floating)):
        return f"{value:.7g}"
    return str(value).replace("|", "\\|").replace("\n", " ")


def source_sentence(sources: Mapping[str, str]) -> str:
    """What a caption says of where its recordings come from: name -> `twin` or `measured`."""
    twins = [name for name, source in sources.items() if source == "twin"]
    if not twins:
        return "All recordings are measured."
    if len(twins) == len(sources):
        return "All recordings are twins: simulated, from published or configured numbers."
    return f"Simulated (twins): {', '.join(twins)}; the others are measured."


def source_of(recording: Mapping[str, Any] | None) -> str:
    """`twin`, `measured`, or `cited` where no recording stands for the published row."""
    return "cited" if recording is None else "twin" if recording["twin"] else "measured"
