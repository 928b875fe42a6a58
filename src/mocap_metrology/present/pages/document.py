"""A table that was written in Markdown as parts of a page."""

from __future__ import annotations

import re
from itertools import pairwise

from markdown_it import MarkdownIt
from markdown_it.token import Token
from markupsafe import Markup

from mocap_metrology.present.pages import site
from mocap_metrology.present.pages.comparison import Comparison
from mocap_metrology.present.tables import plain
from mocap_metrology.present.text import captions

IMPORTANT = {name.strip() for name in captions.FIRST_COLUMNS.split(",")}


def title_of(text: str) -> str:
    """The first heading, or nothing."""
    first = re.search(r"^# (.*)$", text, re.M)
    return first[1].strip() if first else ""


def page(
    text: str,
    name: str,
    csv: bool,
    short: Comparison | None = None,
    up: dict[str, str] | None = None,
) -> str:
    """The page of a table: its Markdown, and a link to its CSV, which lies in ../tables. short: of
    a table of a paper, what is read before that; up: more links."""
    title = title_of(text) or name
    return site.render(
        "text.html",
        title,
        short=short,
        parts_of_page=parts_of(text.replace(f"# {title}\n", "", 1) if short else text),
        csv=f"{name}.csv" if csv else "",
        up={"summary": "../summary.html"} | (up or {}),
    )


def parts_of(text: str) -> list[Markup | site.Table]:
    """HTML of a Markdown text, and its tables for the template that shows them. Cells are text, as
    a user's words may be in them; nothing in the text leads or loads from elsewhere."""
    reader = MarkdownIt("commonmark", {"html": False}).enable("table")
    reader.disable(["image", "link", "autolink", "reference"])
    parts: list[Markup | site.Table] = []
    tokens: list[Token] = []
    for token in [*reader.parse(text), None]:
        if token is None or token.type == "table_open":
            html = str(reader.renderer.render(tokens, reader.options, {})).strip()
            parts += [_typeset(html)] if html else []
            tokens = []
        if token is not None:
            tokens.append(token)
        if token is not None and token.type == "table_close":
            parts.append(_table(tokens))
            tokens = []
    return parts


def _typeset(html: str) -> Markup:
    """HTML with its text typeset, tags as they are."""
    parts = re.split(r"(<code>.*?</code>|<[^>]+>)", html)
    return Markup(
        "".join(p if k % 2 else str(site.typeset(Markup(p))) for k, p in enumerate(parts))
    )


def _table(tokens: list[Token]) -> site.Table:
    rows: list[list[str]] = []
    for token in tokens:
        if token.type == "tr_open":
            rows.append([])
        elif token.type == "inline":
            rows[-1].append(plain(token.content))
    head, *body = rows
    for above, row in pairwise(body):  # rows may be sorted, so that none leans on the one above
        row[0] = row[0] or above[0]
    first = [name for name in head if name in IMPORTANT] if len(head) > site.MANY else []
    return site.table(head, body, first=first if len(first) > 2 else ())
