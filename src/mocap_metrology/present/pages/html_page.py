"""Pages of HTML that need nothing but themselves: no script, no style sheet, no network.

Markdown becomes HTML as far as `tables` and its fellows write it: headings, paragraphs, lists of
one level (`- ` or `* `), tables of pipes (`\\|` is a pipe in a cell), **bold**, `code`.
"""

from __future__ import annotations

import base64
import re
from collections.abc import Iterable, Iterator, Sequence
from html import escape
from itertools import groupby

from mocap_metrology.present.drawing.style import UNKNOWN_WORD, VERDICT_WORDS

NUMERIC_SHARE = 0.6  # of its filled cells makes a column one of numbers
# Signs before a number: not detected, bounds, approximately, brackets of a published value.
NUMBER = re.compile(r"[<>≤≥~±(†*+\u2212-]*\s*\d")
CODE = re.compile(r"`([^`]+)`")
MINUS = "\N{MINUS SIGN}"
TYPESET = (  # of a line of Markdown: units, powers of ten, coefficients; no names of columns
    (re.compile(r"/s\^0\.5"), lambda m: "/\N{WORD JOINER}√s"),
    (re.compile(r"(?<=mm\^2) (?=Hz)"), lambda m: "\N{NO-BREAK SPACE}"),
    (re.compile(r"(?<=[\w)])\^(-?\d)(?![\d.])"), lambda m: _raised(m[1])),
    (re.compile(r"(?<![\w.])1e([-+]\d+)(?!\w)"), lambda m: f"10{_raised(m[1])}"),
    (
        re.compile(r"((?<![\w.])\d+(?:\.\d+)?|\))e([-+]\d+)(?!\w)"),
        lambda m: f"{m[1]}×10{_raised(m[2])}",
    ),
    (
        re.compile(r"(?<!\w)(h_-?\d|[qT]_c\d*|A_s|f_0|width_f)(?!\w)"),
        lambda m: "{}<sub>{}</sub>".format(*m[1].replace("-", MINUS).split("_")),
    ),
)
EMPTY = "–"  # a cell without a number
STYLE = """
.mm { font: 14px/1.45 system-ui, -apple-system, "Segoe UI", "DejaVu Sans", sans-serif;
  color: #1f2937; }
.mm h1 { font-size: 22px; font-weight: 650; line-height: 1.25; margin: 0 0 10px; color: #111827; }
.mm h2 { font-size: 17px; font-weight: 650; margin: 28px 0 6px; color: #111827; }
.mm h3 { font-size: 15px; font-weight: 650; margin: 20px 0 4px; color: #111827; }
.mm p, .mm ul { max-width: 80ch; margin: 6px 0; }
.mm h1, .mm h2, .mm h3, .mm p, .mm ul { position: sticky; left: 20px; width: fit-content; }
.mm ul { padding-left: 18px; list-style: disc; }
.mm a { color: #1d4ed8; text-decoration: underline; font-weight: inherit; }
.mm table { border-collapse: separate; border-spacing: 0; margin: 12px 0 20px; width: auto;
  font-size: 13px; line-height: 1.35; }
.mm th, .mm td { padding: 4px 10px; text-align: left; vertical-align: top; white-space: nowrap;
  border-bottom: 1px solid #e5e7eb; background: #fff; }
.mm thead th { position: sticky; top: 0; z-index: 2; background: #f3f4f6; color: #111827;
  border-bottom: 1px solid #6b7280; font-weight: 600; vertical-align: bottom; }
.mm tbody th { position: sticky; left: 0; z-index: 1; font-weight: 600; color: #111827; }
.mm thead th:first-child { left: 0; z-index: 3; }
.mm .n { text-align: right; font-variant-numeric: tabular-nums; }
.mm thead th, .mm .t { white-space: normal; }
.mm .t { min-width: 36ch; max-width: 64ch; }
.mm tbody tr:hover > * { background: #f9fafb; }
.mm .word { display: inline-block; padding: 1px 8px; border-radius: 9px; font-weight: 600; }
.mm .empty { color: #6b7280; }
.mm sup, .mm sub { font-size: 80%; line-height: 0; }
.mm code { font-family: ui-monospace, "DejaVu Sans Mono", monospace; font-size: 92%; }
"""


def page(title: str, body: str) -> str:
    """A whole document round a body that is HTML; `title` is plain text."""
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>\n"
        f"body {{ margin: 0; padding: 20px; background: #fff; }}{STYLE}</style>\n</head>\n"
        f'<body class="mm">\n{body}\n</body>\n</html>\n'
    )


def fragment(body: str) -> str:
    """A body with its style, to stand within another page."""
    return f'<div class="mm" style="overflow-x: auto">\n<style>{STYLE}</style>\n{body}\n</div>\n'


def heading(text: str, level: int = 1) -> str:
    """A heading; level 1 to 3."""
    return f"<h{level}>{escape(text)}</h{level}>"


def paragraph(text: str) -> str:
    """A paragraph of plain text, `code` and **bold** in it."""
    return f"<p>{inline(text)}</p>"


def word(text: str, count: int | None = None) -> str:
    """A verdict, or how many there are of it: said in a word, and in colour beside it."""
    ink, behind = VERDICT_WORDS.get(text, UNKNOWN_WORD)
    shown = escape(text if count is None else f"{count} {text}")
    return f'<span class="word" style="color:{ink};background:{behind}">{shown}</span>'


def link(address: str, text: str) -> str:
    """A name that leads to an address, or just the name where there is none."""
    return f'<a href="{escape(address)}">{escape(text)}</a>' if address else escape(text)


def download(name: str, content: bytes, text: str) -> str:
    """A paragraph with a link that saves `content`, which the page carries itself."""
    data = base64.b64encode(content).decode()
    href = f"data:text/csv;charset=utf-8;base64,{data}"
    return f'<p><a download="{escape(name)}" href="{href}">{escape(text)}</a></p>'


def table(
    head: Sequence[str],
    rows: Iterable[Sequence[object]],
    html: Sequence[int] = (),
    long: Sequence[int] = (),
    words: Sequence[int] = (),
) -> str:
    """A table whose head, and first column, stay in sight.

    Cells are plain text or numbers; those of the columns in `html` are HTML already, those in
    `long` may wrap. Columns of numbers are set to the right, and so are those of nothing but
    dashes, unless they are in `words`.
    """
    lines = [["" if cell is None else str(cell) for cell in row] for row in rows]
    text = {*html, *words}
    kinds = [
        "t" if k in long else "n" if k not in text and _numeric(line[k] for line in lines) else ""
        for k in range(len(head))
    ]
    top = "".join(
        _cell("th", _whole(name), kind, ' scope="col"') for name, kind in _zip(head, kinds)
    )
    body = []
    for line in lines:
        cells = []
        for k, (cell, kind) in enumerate(_zip(line, kinds)):
            tag, extra = ("th", ' scope="row"') if k == 0 else ("td", "")
            cells.append(_cell(tag, cell, kind, extra, k in html))
        body.append(f"<tr>{''.join(cells)}</tr>")
    inner = "\n".join(body)
    return f"<table>\n<thead><tr>{top}</tr></thead>\n<tbody>\n{inner}\n</tbody>\n</table>"


def _whole(name: str) -> str:
    """A column's name that does not break between a number and its unit."""
    return re.sub(r"(?<=\d) (?=(?:s|min|mm|Hz)\b)", "\N{NO-BREAK SPACE}", name)


def _zip(cells: Sequence[str], kinds: Sequence[str]) -> Iterable[tuple[str, str]]:
    return zip(cells, kinds, strict=True)


def _numeric(cells: Iterable[str]) -> bool:
    """Whether most of what is filled is numbers, or there are only dashes in place of them."""
    own = list(cells)
    filled = [cell for cell in own if cell not in ("", EMPTY)]
    if not filled:
        return EMPTY in own
    return sum(map(bool, map(NUMBER.match, filled))) >= NUMERIC_SHARE * len(filled)


def _cell(tag: str, text: str, kind: str, extra: str, html: bool = False) -> str:
    shown = text if html else inline(re.sub(r"^-(?=\d)", MINUS, text) if kind == "n" else text)
    kind = f' class="{kind}"' if kind else ""
    return f"<{tag}{kind}{extra}>{shown}</{tag}>"


def inline(text: str) -> str:
    """Text of a line of Markdown: **bold**, `code`, units and powers of ten typeset; names may
    break behind `_`, lists behind `;`."""
    parts = CODE.split(escape(text, quote=False))  # every second one is code
    return "".join(
        f"<code>{_breakable(part)}</code>" if k % 2 else _breakable(_typeset(part))
        for k, part in enumerate(parts)
    )


def _typeset(text: str) -> str:
    text = re.sub(r"\*\*(.+?)\*\*", r"<strong>\1</strong>", text)
    for pattern, made in TYPESET:
        text = pattern.sub(made, text)
    return text


def _raised(exponent: str) -> str:
    return f"<sup>{str(int(exponent)).replace('-', MINUS)}</sup>"


def _breakable(text: str) -> str:
    return re.sub(r"(?<=[a-z])_(?=[a-z])|(?<=\d);(?=\d)", r"\g<0><wbr>", text)


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
