"""A table that was written in Markdown as parts of a page."""

from __future__ import annotations

import re
from itertools import pairwise

from markdown_it import MarkdownIt
from markdown_it.token import Token
from markupsafe import Markup

from mocap_metrology.present.pages.comparison import Comparison
from mocap_metrology.present.pages.site import Table, render, table, typeset
from mocap_metrology.present.tables import plain

# Of tables with many columns: those that are seen at first
IMPORTANT = (
    *(
        "recording",
        "calibration",
        "axis",
        "camera_type",
        "n_cameras",
        "series",
        "quantity",
        "parameter",
    ),
    *("estimator", "noise", "formula", "tau_s", "published", "regenerated", "value"),
    *("deviation_percent", "ratio", "inside", "consistent", "word", "verdict", "reason", "note"),
    *("mu_1_mm", "sigma_1_mm", "mu_2_mm", "sigma_2_mm", "mu_L_mm", "sigma_L_mm", "source"),
    *("added", "marker", "largest_factor", "largest_lower_95", "largest_upper_95", "mean_factor"),
    *(
        "law_factor",
        "camera_noise",
        "sigma_frame_mm",
        "frame_mm",
        "mean_1_s_mm",
        "dominating_noise",
    ),
    *("adev_1_mm", "adev_1s_mm", "adev_10s_mm", "adev_100s_mm", "adev_min_mm", "tau_min_s"),
    *("n_frames", "n_outliers", "share", "share_of_clean_gaussian_noise", "lower_5", "upper_95"),
)
MANY = 12  # columns from which only the important ones are seen at first


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
    return render(
        "text.html",
        title,
        short=short,
        parts_of_page=parts_of(text.replace(f"# {title}\n", "", 1) if short else text),
        csv={"name": f"{name}.csv", "address": f"../tables/{name}.csv"} if csv else None,
        up={"summary": "../summary.html"} | (up or {}),
    )


def parts_of(text: str) -> list[Markup | Table]:
    """HTML of a Markdown text, and its tables for the template that shows them. Cells are text, as
    a user's words may be in them; nothing in the text leads or loads from elsewhere."""
    reader = MarkdownIt("commonmark", {"html": False}).enable("table")
    reader.disable(["image", "link", "autolink", "reference"])
    parts: list[Markup | Table] = []
    within: list[Token] = []
    for token in reader.parse(text):
        if token.type == "table_open":
            parts += _html(reader, within)
            within = []
        within.append(token)
        if token.type == "table_close":
            parts.append(_table(within))
            within = []
    return [*parts, *_html(reader, within)]


def _html(reader: MarkdownIt, tokens: list[Token]) -> list[Markup]:
    html = str(reader.renderer.render(tokens, reader.options, {})).strip()
    return [typeset_html(html)] if html else []


def typeset_html(html: str) -> Markup:
    """HTML with its text typeset, tags as they are."""
    parts = re.split(r"(<code>.*?</code>|<[^>]+>)", html)
    return Markup("".join(p if k % 2 else str(typeset(Markup(p))) for k, p in enumerate(parts)))


def _table(tokens: list[Token]) -> Table:
    cells = [token for token in tokens if token.type in ("inline", "tr_open")]
    rows: list[list[str]] = []
    for token in cells:
        if token.type == "tr_open":
            rows.append([])
        else:
            rows[-1].append(plain(token.content))
    head, *body = rows
    for above, row in pairwise(body):  # rows may be sorted, so that none leans on the one above
        row[0] = row[0] or above[0]
    first = [name for name in head if name in IMPORTANT] if len(head) > MANY else []
    return table(head, body, first=first if len(first) > 2 else ())
