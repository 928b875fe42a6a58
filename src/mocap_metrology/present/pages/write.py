"""Pages of all results of a run: of each table, recording, calibration, group and paper, and the
summary that is read first."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from mocap_metrology.present.pages import comparison, details, document, front, site, summary
from mocap_metrology.present.plot.figure import Picture, caption_of
from mocap_metrology.present.tables import Record
from mocap_metrology.present.verdict import words
from mocap_metrology.present.verdict.overview import overview_figure


@dataclass(frozen=True)
class Results:
    """What there is in a folder of results.

    recordings, calibrations: rows of the sheets, accepted; cameras, changes: JSON files by group;
    claims: rows of claims.csv; papers: those that have results; subjects: names with a page, by
    kind; files: figures and tables.
    """

    folder: Path
    recordings: list[Record]
    calibrations: list[Record]
    cameras: Mapping[str, str]
    changes: Mapping[str, str]
    claims: list[Record]
    papers: Sequence[str]
    subjects: Mapping[str, Sequence[str]]
    files: list[Path]

    def document(self, kind: str, name: str) -> Any:
        """verdict.json of a recording or pose.json of a calibration."""
        file = {"recording": "verdict.json", "calibration": "pose.json"}[kind]
        return _read(self.folder / f"{kind}s" / name / file)

    @cached_property
    def named(self) -> list[str]:
        """What files of groups and papers are named by."""
        return [*self.subjects["group"], *self.papers]

    def of(self, name: str, suffix: str) -> list[Path]:
        """Files of a group or paper."""
        every = [path for path in self.files if path.suffix == suffix]
        return details.files_named(name, self.named, every)

    def within(self, folder: Path, suffix: str) -> list[Path]:
        """Files of a recording or calibration."""
        return [p for p in self.files if folder in p.parents and p.suffix == suffix]


def _read(path: str | Path) -> Any:
    return json.loads(Path(path).read_text(encoding="utf-8"))


def table_pages(tables: Iterable[Path], papers: Sequence[str]) -> dict[str, str]:
    """A page of each table in Markdown, by file name; of a paper's, first what it compares."""
    pages = {}
    for source in tables:
        if source.suffix == ".md":
            table = source.with_suffix(".csv")
            short = comparison.of_file(table) if table.is_file() else None
            paper = comparison.paper_of(source.stem)
            up = details.paper_link(paper) if paper in papers else {}
            text = source.read_text(encoding="utf-8")
            page = document.page(text, source.stem, table.is_file(), short, up)
            pages[f"{source.stem}.html"] = page
    return pages


def detail_pages(results: Results) -> dict[Path, str]:
    """A page of each recording, calibration, group and paper, by its path in the folder."""
    pages = {}
    for kind, name, title, images, files, more in _subjects(results):
        figures = details.figures_of(results.folder, images)
        page = details.page(title, figures, details.files_of(results.folder, files), **more)
        pages[Path(details.address(kind, name)).relative_to("details")] = page
    return pages


Subject = tuple[str, str, str, list[Path], list[Path], dict[str, Any]]


def _subjects(results: Results) -> Iterator[Subject]:
    """Kind, name, title, figures, tables and further arguments of each page."""
    changes: dict[str, str] = {}
    for path in results.changes.values():
        changes |= _read(path)["recordings"]
    for row in results.recordings:
        found = results.document("recording", name := row["recording"])
        lines = [*words.sentences(found), *([changes[name]] if name in changes else [])]
        one = _measured(results, "recording", row, found["word"], [*lines, words.mean_words(found)])
        one[-1]["tables"] = [{"title": "Mean of all frames", "table": _means(found)}]
        yield one
    for row in results.calibrations:
        found = results.document("calibration", row["calibration"])["verdict"]
        yield _measured(results, "calibration", row, found["word"], [found["reason"]])
    for group in results.subjects["group"]:
        yield "group", group, group, results.of(group, ".svg"), results.of(group, ".csv"), {}
    for paper in results.papers:
        yield _paper(results, paper)


def _means(found: Record) -> site.Table:
    head, *rows = words.mean_table(found["series"])
    units = ("", " (mm)", "", " (mm)", "", " (s)", " (s)")
    named = [f"{name or 'series'}{unit}" for name, unit in zip(head, units, strict=True)]
    return site.Table(named, "tnnntnn", rows, range(len(named)))


def _measured(results: Results, kind: str, row: Record, verdict: str, lines: list[str]) -> Subject:
    name, group = row[kind], row["group"]
    folder = results.folder / f"{kind}s" / name
    up = {group: f"../groups/{group}.html"} if group in results.subjects["group"] else {}
    more = {"verdict": verdict, "lines": lines, "up": up}
    return kind, name, name, results.within(folder, ".svg"), results.within(folder, ".csv"), more


def _paper(results: Results, paper: str) -> Subject:
    held = details.of_paper(results.claims, paper)
    csv = [path for path in results.files if path.suffix == ".csv"]
    compared = details.table_of_tables(details.tables_of(paper, csv))
    of_claims = [{"title": "Claims", "table": details.claim_table(held)}] if held else []
    tables = [*of_claims, {"title": "Published tables", "table": compared}]
    files = [*results.of(paper, ".csv"), *(path for path in csv if path.stem == "claims")]
    title = details.PAPERS[paper]
    return "paper", paper, title, results.of(paper, ".svg"), files, {"tables": tables}


def overview(results: Results) -> Picture:
    """Figure of one's own recordings against the limits."""
    every = [results.document("recording", row["recording"]) for row in results.recordings]
    mine = front.own({"recording": every, "calibration": []})["recording"]
    return overview_figure(mine, "One frame against the limits", front.source(mine))


def summaries(
    results: Results, checks: Iterable[Path], tables: Iterable[Path], png: Path
) -> tuple[str, str]:
    """The summary as a page, and as the front of the report.

    checks: check.json of all that was measured, refused or not; png: the `overview`, saved.
    """
    refused = [
        {"kind": path.parent.parent.name.removesuffix("s"), "name": path.parent.name} | check
        for path in checks
        if not (check := _read(path))["ok"]
    ]
    recordings = [results.document("recording", row["recording"]) for row in results.recordings]
    calibrations = [
        {"pose": results.document("calibration", row["calibration"]), **row}
        for row in results.calibrations
    ]
    found = summary.Found(
        recordings,
        calibrations,
        refused,
        {group: _read(path) for group, path in results.cameras.items()},
        {group: _read(path)["words"] for group, path in results.changes.items()},
        png.read_bytes(),
        caption_of(png)[1],
    )
    csv = [path for path in tables if path.suffix == ".csv"]
    papers = [
        summary.Paper(
            details.PAPERS[paper],
            details.address("paper", paper),
            details.claim_counts(details.of_paper(results.claims, paper)),
            details.tables_of(paper, csv),
        )
        for paper in results.papers
    ]
    names = [path.stem for path in csv if path.parent.name == "tables"]

    def address(kind: str, name: str) -> str:
        return details.address(kind, name) if name in results.subjects[kind] else ""

    page, part = (summary.page(found, address, papers, names, p) for p in (False, True))
    return page, part
