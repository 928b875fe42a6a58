"""A page a recording, calibration, group and paper: verdict, figures that explain it, tables."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from mocap_metrology.present.pages.comparison import of_file, paper_of
from mocap_metrology.present.pages.document import title_of
from mocap_metrology.present.pages.site import Table, link, natural, render, table, word
from mocap_metrology.present.plot.figure import caption_of
from mocap_metrology.present.tables import Record

FIRST = ("verdict", "calibration", "track", "trajectory", "adev", "psd", "diagnosis")  # of figures
PAPERS = {"skurowski": "Skurowski & Pawlyta 2019", "jansen": "Jansen et al. 2019"}
UNDRAWN = "It has no figure: of the twins of a setup, which look alike, only the first is drawn."
LETTERS = {"skurowski": "S", "jansen": "J"}  # as claims.csv names the papers
PLURAL = {"holds": "hold", "does not": "do not hold", "undecided": "undecided"}
CLAIM_HEAD = ("claim", "section", "published", "regenerated", "verdict")
UP = "../.."  # from a page to the folder of results


@dataclass(frozen=True)
class Figure:
    """An image by its address on a page, with words for those who do not see it."""

    address: str
    alt: str
    title: str
    caption: str


@dataclass(frozen=True)
class File:
    """A table: its CSV, and the page on which it is read, if there is one."""

    name: str
    address: str
    page: str = ""


def address(kind: str, name: str) -> str:
    """Where the page of a recording, calibration, group or paper is, from the folder of results."""
    return f"details/{kind}s/{name}.html"


def figures_of(results: Path, images: Iterable[Path]) -> list[Figure]:
    """Images with the title and the caption that their PNG holds; the file's name without one."""
    found = []
    for image in sorted(images, key=_order):
        title, caption = caption_of(image.with_suffix(".png"))
        where = f"{UP}/{image.relative_to(results).as_posix()}"
        name = image.stem.replace("_", " ")
        alt = f"{title}. {caption}" if title and caption else title or name
        found.append(Figure(where, alt, title or name, caption))
    return found


def _order(image: Path) -> tuple[int, list[tuple[int, str]]]:
    first = FIRST.index(image.stem) if image.stem in FIRST else len(FIRST)
    return first, natural(str(image))


def files_of(results: Path, tables: Iterable[Path]) -> list[File]:
    """Tables of a subject; those of groups and papers have a page."""
    found = []
    for path in sorted(tables, key=lambda path: natural(path.name)):
        page = f"{UP}/pages/{path.stem}.html" if path.parent.name == "tables" else ""
        where = PurePosixPath(UP, path.relative_to(results).as_posix())
        found.append(File(path.name, str(where), page))
    return found


def page(
    title: str,
    figures: Sequence[Figure],
    files: Sequence[File],
    verdict: str = "",
    lines: Sequence[str] = (),
    tables: Sequence[dict[str, object]] = (),
    up: dict[str, str] | None = None,
) -> str:
    """The page of a subject. verdict: its word; lines: its evidence; up: more links."""
    if verdict and not figures:
        lines = [*lines, UNDRAWN]
    return render(
        "subject.html",
        title,
        figures=figures,
        files=files,
        verdict=verdict,
        lines=lines,
        tables=tables,
        up={"summary": f"{UP}/summary.html"} | (up or {}),
    )


def paper_link(paper: str) -> dict[str, str]:
    """From the page of a table to that of its paper."""
    return {PAPERS[paper]: f"../{address('paper', paper)}"}


def of_paper(claims: Iterable[Record], paper: str) -> list[Record]:
    """The rows of claims.csv that are of a paper (`skurowski`, `jansen`)."""
    return [row for row in claims if row["paper"] == LETTERS[paper]]


def claim_table(rows: Sequence[Record]) -> Table:
    """Claims of a paper: its own numbers, the regenerated ones, and whether each claim holds."""
    cells = [
        (r["claim"], r["section"], r["published"], r["regenerated"], word(r["regenerated_word"]))
        for r in rows
    ]
    return table(CLAIM_HEAD, cells, words=(1,))


@dataclass(frozen=True)
class PaperTable:
    """A table of a paper: its title there, its page from the folder of results, and how many of its
    numbers agree."""

    title: str
    page: str
    counts: str


def tables_of(paper: str, paths: Iterable[Path]) -> list[PaperTable]:
    """The tables of a paper among CSV files beside which their Markdown lies, in its order."""
    found = []
    for path in sorted(paths, key=lambda path: natural(path.stem)):
        short = of_file(path) if paper_of(path.stem) == paper else None
        if short:
            title = title_of(path.with_suffix(".md").read_text(encoding="utf-8"))
            shown = title.removeprefix(f"{PAPERS[paper]}, ")
            found.append(PaperTable(shown, f"pages/{path.stem}.html", short.counts))
    return found


def table_of_tables(found: Iterable[PaperTable]) -> Table:
    """How the tables of a paper compare, on its page."""
    cells = [(link(f"{UP}/{one.page}", one.title), one.counts) for one in found]
    return table(("table", "numbers"), cells, words=(0, 1))


def claim_counts(rows: Iterable[Record]) -> str:
    """`22 hold, 14 do not hold, 12 undecided`; nothing without claims."""
    counts = Counter(str(row["regenerated_word"]) for row in rows)
    return ", ".join(f"{counts[kind]} {words}" for kind, words in PLURAL.items() if counts[kind])


def files_named(name: str, named: Sequence[str], paths: Sequence[Path]) -> list[Path]:
    """Files `<name>_...` of a group or paper: where several of these names begin a file's, it is
    of the longest (`lab` and `lab_2`)."""
    return [
        path
        for path in paths
        if name == max((n for n in named if path.stem.startswith(f"{n}_")), key=len, default="")
    ]
