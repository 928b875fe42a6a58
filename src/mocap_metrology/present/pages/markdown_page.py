"""The Markdown that `tables` and its fellows write, as HTML: headings, paragraphs, lists of one
level (`- ` or `* `), tables of pipes (`\\|` is a pipe in a cell), **bold**, `code`, and no more."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import groupby

from mocap_metrology.present.pages.html_page import heading, inline, table

BAR = re.compile(r"(?<!\\)\|")
RULE = re.compile(r"\|[-:| ]+\|")
LONG = 40  # letters in a cell: a sentence or a list, and not a name


def title_of(text: str) -> str:
    """The first heading, or nothing."""
    first = re.search(r"^# (.*)$", text, re.M)
    return first[1].strip() if first else ""


def body_of(text: str) -> str:
    """HTML of a Markdown text."""
    return "\n".join(_blocks(text.splitlines()))


def _kind(line: str) -> str:
    if not line.strip():
        return ""
    if line.startswith(("- ", "* ")):
        return "list"
    return {"#": "heading", "|": "table"}.get(line[0], "text")


def _blocks(lines: list[str]) -> Iterator[str]:
    for kind, block in groupby(lines, _kind):
        if kind == "heading":
            for line in block:
                sharps, _, text = line.partition(" ")
                yield heading(text.strip(), min(len(sharps), 3))
        elif kind == "table":
            yield _table(list(block))
        elif kind == "list":
            yield f"<ul>{''.join(f'<li>{inline(line[2:])}</li>' for line in block)}</ul>"
        elif kind == "text":
            yield f"<p>{inline(' '.join(block))}</p>"


def _table(lines: list[str]) -> str:
    head, *rows = [_cells(line) for line in lines if not RULE.fullmatch(line)]
    long = [k for k in range(len(head)) if any(len(row[k]) > LONG for row in rows)]
    return table(head, rows, long=long)


def _cells(line: str) -> list[str]:
    return [cell.strip().replace("\\|", "|") for cell in BAR.split(line.strip())[1:-1]]
