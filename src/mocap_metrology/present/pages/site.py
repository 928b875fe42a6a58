"""Pages of HTML from the templates of `present/html`.

A page contains its style and its script (sorting, searching, zooming) and loads nothing from hosts.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

from mocap_metrology.common.errors import printable
from mocap_metrology.present.plot.figure import UNKNOWN_WORD, VERDICT_WORDS
from mocap_metrology.present.text.numbers import MINUS

WORDS = VERDICT_WORDS | {  # of verdicts, claims and monitors
    **dict.fromkeys(("holds", "agrees", "pass"), VERDICT_WORDS["good"]),
    "note": VERDICT_WORDS["usable"],
    **dict.fromkeys(("does not", "differs", "alert", "failure"), VERDICT_WORDS["bad"]),
    "unknown": UNKNOWN_WORD,
}
EMPTY = "–"  # a cell without a number
SHORT, MANY = 9, 12  # columns that a table shows at first, of more than many
WIDE = 40  # characters from which a cell may wrap
NUMERIC_SHARE = 0.6  # of its filled cells makes a column one of numbers
# Signs before a number: not detected, bounds, approximately, brackets of a published value.
NUMBER = re.compile(r"[<>≤≥~±(†*+\u2212-]*\s*\d")
UNITS = (  # powers and coefficients; no names of columns
    (re.compile(r"/s\^0\.5"), "/√s"),
    (re.compile(r"(?<=[\w)])\^(-?\d)(?![\d.])"), r"<sup>\1</sup>"),
    (re.compile(r"(?<!\w)(h|[qT]|A|f|width)_(-?\d|c\d*|s|0|f)(?!\w)"), r"\1<sub>\2</sub>"),
    (re.compile(r"(?<=[a-z])_(?=[a-z])|(?<=\d);(?=\d)"), r"\g<0><wbr>"),
    (re.compile(r"(?<=<su[bp]>)-"), MINUS),
)
CODE = re.compile(r"(<code>.*?</code>)")

Cell = str | Markup


@dataclass(frozen=True)
class Table:
    """What `parts.html` shows as a table: `kinds` are n of numbers, t of text that may wrap; the
    columns in `first` are seen at first, the others behind a button."""

    head: Sequence[Cell]
    kinds: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    first: Collection[int]


@lru_cache(maxsize=1)
def environment() -> Environment:
    """The templates, with everything escaped that is not markup already."""
    templates = Environment(
        loader=PackageLoader("mocap_metrology.present", "html"),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=lambda value: _printable(value) if isinstance(value, str) else value,
        trim_blocks=True,
    )
    templates.globals |= {"words": WORDS, "word": word, "link": link}
    return templates


def render(template: str, title: str, **values: object) -> str:
    """A whole page."""
    style, script = (
        Markup(environment().get_template(name).render()) for name in ("style.css", "page.js")
    )
    values = {"up": {}, "title": title, "style": style, "script": script} | values
    return environment().get_template(template).render(values)


def word(text: str, count: int | None = None) -> Markup:
    """A verdict, or how many there are of it: in a word, and in colour beside it."""
    shown = text if count is None else f"{count} {text}"
    kind = text.replace(" ", "-") if text in WORDS else "unknown"
    return Markup('<span class="word is-{}">{}</span>').format(kind, shown)


def link(address: str, text: str) -> Markup:
    """A name that leads to an address, or just the name where there is none."""
    shown = _printable(text)
    return Markup('<a href="{}">{}</a>').format(address, shown) if address else escape(shown)


def _printable(text: str) -> str:
    """Text without letters that control a terminal or turn the direction of others; markup as it
    is."""
    return text if isinstance(text, Markup) else printable(text)


def typeset(text: str) -> Markup:
    """Text with powers and coefficients of units; names may break at `_`, lists behind `;`; code
    stays."""
    parts = CODE.split(str(escape(_printable(text))))
    for pattern, replacement in UNITS:
        parts[::2] = [pattern.sub(replacement, part) for part in parts[::2]]
    return Markup("".join(parts))


def table(
    head: Sequence[str],
    rows: Iterable[Sequence[object]],
    words: Collection[int] = (),
    first: Collection[str] = (),
) -> Table:
    """A table of plain text, numbers and markup; columns of numbers are set to the right, also
    those of nothing but dashes unless they are in `words`; first: names of the columns that are
    seen at first, else the first `SHORT` of more than `MANY`."""
    lines = [["" if cell is None else cell for cell in row] for row in rows]
    kinds = [_kind([line[k] for line in lines], k in words) for k in range(len(head))]
    shown = [[_cell(cell, kind) for cell, kind in zip(line, kinds, strict=True)] for line in lines]
    names = first or head[: SHORT if len(head) > MANY else None]
    seen = {k for k, name in enumerate(head) if name in names}
    return Table([typeset(name) for name in head], kinds, shown, seen)


def _cell(cell: object, kind: str) -> Markup:
    if isinstance(cell, Markup):
        return cell
    text = str(cell)
    return typeset(re.sub(r"(^|…)-(?=\d)", rf"\1{MINUS}", text) if kind == "n" else text)


def _kind(cells: Sequence[object], is_text: bool) -> str:
    texts = [re.sub(r"<[^>]+>", "", str(cell)) for cell in cells]
    filled = [text for text in texts if text not in ("", EMPTY)]
    if any(len(text) > WIDE for text in filled):
        return "t"
    if is_text or not (filled or EMPTY in texts):
        return ""
    numbers = sum(bool(NUMBER.match(text)) for text in filled)
    return "n" if numbers >= NUMERIC_SHARE * len(filled) else ""


def natural(name: str) -> list[tuple[int, str]]:
    """Key of an order in which noise-2 comes before noise-10."""
    parts = re.split(r"(\d+)", name)
    return [(int(part), "") if k % 2 else (-1, part.casefold()) for k, part in enumerate(parts)]
