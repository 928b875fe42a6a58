"""A page a recording, calibration, monitor, group and paper: verdict, figures, tables."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

from markdown_it import MarkdownIt
from markdown_it.token import Token
from markupsafe import Markup

from mocap_metrology.common.types import Record
from mocap_metrology.present.pages import comparison, site
from mocap_metrology.present.plot.figure import caption_of
from mocap_metrology.present.tables import Row, plain
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import significant

FIRST = ("verdict", "calibration", "track", "trajectory", "adev", "psd", "diagnosis")  # of figures
UNDRAWN = "It has no figure: of the twins of a setup, which look alike, only the first is drawn."
LETTERS = {"skurowski": "S", "jansen": "J"}  # as claims.csv names the papers
PLURAL = {"holds": "hold", "does not": "do not hold", "undecided": "undecided"}
CLAIM_COLUMNS = {"claim": "claim", "section": "section", "published": "published"}
CLAIM_COLUMNS |= {"regenerated": "regenerated", "verdict": "regenerated_word"}
UP = "../.."  # from a page to the folder of results

Figure = dict[str, str]  # address on a page, alt: words for those who do not see it, title, caption
IMPORTANT = {name.strip() for name in captions.FIRST_COLUMNS.split(",")}
INPUTS = ("name", "kind", "source", "file", "seed", "sha256")
TIMES = ("rule", "jobs", "total_s", "longest_s", "max_rss_mb")


class PaperTable(NamedTuple):
    """A table of a paper: its title there, its page from the folder of results, and how many of its
    numbers agree."""

    title: str
    page: str
    counts: str


def address(kind: str, name: str) -> str:
    """Path of the page of a subject (recording, calibration, monitor, group or paper) from the
    folder of results."""
    return f"details/{kind}s/{name}.html"


def figures_of(results: Path, images: Iterable[Path]) -> list[Figure]:
    """Images (SVG) with the title and the caption that they hold; the file's name without one."""
    figures = []
    for image in sorted(images, key=_order):
        title, caption = caption_of(image)
        name = image.stem.replace("_", " ")
        alt = f"{title}. {caption}" if title and caption else title or name
        shown = {"title": title or name, "caption": caption, "alt": alt}
        figures.append(shown | {"address": f"{UP}/{image.relative_to(results).as_posix()}"})
    return figures


def _order(image: Path) -> tuple[int, list[tuple[int, str]]]:
    first = FIRST.index(image.stem) if image.stem in FIRST else len(FIRST)
    return first, site.natural(str(image))


def page(
    title: str,
    figures: Sequence[Mapping[str, str]] = (),
    csv: Iterable[Path] = (),
    verdict: str = "",
    lines: Sequence[str] = (),
    tables: Sequence[Mapping[str, Any]] = (),
    up: Mapping[str, str] | None = None,
) -> str:
    """The page of a subject. csv: its tables, from the folder of results, of which those of groups
    and papers have a page; verdict: its word; lines: its evidence; tables: `title`, `note` and
    `table`; up: more links."""
    if verdict and not figures:
        lines = [*lines, UNDRAWN]
    files = []
    for path in sorted(csv, key=lambda path: site.natural(path.name)):
        to_read = f"{UP}/pages/{path.stem}.html" if path.parent.name == "tables" else ""
        files.append({"name": path.name, "address": f"{UP}/{path.as_posix()}", "page": to_read})
    up = {"summary": f"{UP}/summary.html"} | dict(up or {})
    shown = {"figures": figures, "files": files, "verdict": verdict, "lines": lines}
    return site.render("subject.html", title, **shown, tables=tables, up=up)


def of_paper(claims: Iterable[Record], paper: str) -> list[Record]:
    """The rows of claims.csv that are of a paper (`skurowski`, `jansen`)."""
    return [row for row in claims if row["paper"] == LETTERS[paper]]


def claim_table(claims: Sequence[Record]) -> site.Table:
    """Claims of a paper: its own numbers, the regenerated ones, and whether each claim holds."""
    rows = [[claim[key] for key in CLAIM_COLUMNS.values()] for claim in claims]
    return site.table([*CLAIM_COLUMNS], [[*row[:-1], site.word(row[-1])] for row in rows], (1,))


def claim_counts(claims: Iterable[Record]) -> str:
    """`22 hold, 14 do not hold, 12 undecided`; nothing without claims."""
    counts = Counter(str(row["regenerated_word"]) for row in claims)
    return ", ".join(f"{counts[kind]} {words}" for kind, words in PLURAL.items() if counts[kind])


def tables_of(paper: str, paths: Iterable[Path]) -> list[PaperTable]:
    """The tables of a paper among CSV files beside which their Markdown lies, in its order."""
    tables = []
    for path in sorted(paths, key=lambda path: site.natural(path.stem)):
        short = comparison.of_file(path) if comparison.paper_of(path.stem) == paper else None
        if short:
            title = title_of(path.with_suffix(".md").read_text(encoding="utf-8"))
            shown = title.removeprefix(f"{captions.PAPERS[paper]}, ")
            tables.append(PaperTable(shown, f"pages/{path.stem}.html", short.counts))
    return tables


def title_of(text: str) -> str:
    """The first heading, or nothing."""
    first = re.search(r"^# (.*)$", text, re.M)
    return first[1].strip() if first else ""


def table_page(
    text: str,
    name: str,
    csv: bool,
    short: comparison.Comparison | None = None,
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
    parts[::2] = [str(site.typeset(Markup(part))) for part in parts[::2]]
    return Markup("".join(parts))


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


def run_times(files: Mapping[str, Iterable[str | Path]]) -> list[Row]:
    """A row a rule: `TIMES`. files: what the jobs of each cost, see workflow/scripts/step.py."""
    import pandas as pd

    rows = []
    for rule, paths in sorted(files.items()):
        if jobs := [pd.read_csv(path, sep="\t") for path in paths]:
            s, mb = (pd.concat(jobs)[name].astype(float) for name in ("s", "max_rss"))
            values = (rule, len(jobs), round(math.fsum(s), 2), float(s.max()), float(mb.max()))
            rows.append(dict(zip(TIMES, values, strict=True)))
    return rows


def provenance_page(document: Record) -> str:
    """The page of provenance.json, which also has the configuration."""
    code = document["code"]
    line = f"mocap-metrology {code['version']}, commit {code['commit'] or 'not in a repository'}, "
    times = [
        [significant(v) if isinstance(v := row[name], float) else v for name in TIMES]
        for row in document["run_times"]
    ]
    inputs = [[row[name] for name in INPUTS] for row in document["inputs"]]
    tables = (
        ("Inputs", captions.INPUTS, INPUTS, inputs),
        ("Run times", captions.RUN_TIMES, TIMES, times),
        ("Tables", captions.CHECKSUMS, ("table", "sha256"), document["tables"].items()),
        ("Packages", "", ("package", "version"), document["packages"].items()),
    )
    shown = [
        {"title": title, "note": note, "table": site.table(head, rows)}
        for title, note, head, rows in tables
    ]
    lines = [f"{line}Python {code['python']}."]
    return page("Provenance", lines=lines, tables=shown, up={"summary": "summary.html"})
