"""Pages of all results of a run: of each table, recording, calibration, group and paper, and the
summary that is read first."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from mocap_metrology.common.files import read_json
from mocap_metrology.common.types import Record
from mocap_metrology.present.pages import comparison, details, site, summary
from mocap_metrology.present.plot.figure import Picture, Texts, caption_of
from mocap_metrology.present.tables import read
from mocap_metrology.present.text.captions import PAPERS
from mocap_metrology.present.text.sentence import render
from mocap_metrology.present.verdict import words
from mocap_metrology.present.verdict.figure import overview_figure

OF_RECEIVER = "receiver.json"  # of a calibration
MEAN_UNITS = ("", " (mm)", "", " (mm)", "", " (s)", " (s)")  # of `words.mean_table`


@dataclass(frozen=True)
class Results:
    """What there is in a folder of results.

    recordings, calibrations: rows of the sheets, accepted; papers: those that have results;
    subjects: names with a page, by kind; files: all results.
    """

    folder: Path
    recordings: list[Record]
    calibrations: list[Record]
    papers: Sequence[str]
    subjects: Mapping[str, Sequence[str]]
    files: list[Path]

    def tables(self, suffix: str) -> list[Path]:
        """Files of the folder of tables, of groups and papers."""
        folder = self.folder / "tables"
        return [path for path in self.files if path.parent == folder and path.suffix == suffix]

    def of_groups(self, kind: str) -> dict[str, Any]:
        """Contents of <group>_<kind>.json, by group."""
        paths = {
            group: self.folder / f"tables/{group}_{kind}.json" for group in self.subjects["group"]
        }
        return {group: read_json(path) for group, path in paths.items() if path in self.files}

    @cached_property
    def monitors(self) -> dict[str, Any]:
        """monitor.json of each facility that is watched, by name."""
        names = self.subjects["monitor"]
        return {name: read_json(self.folder / f"monitors/{name}/monitor.json") for name in names}

    @cached_property
    def claims(self) -> list[Any]:
        """Rows of claims.csv."""
        paths = [path for path in self.tables(".csv") if path.stem == "claims"]
        return [row for path in paths for row in read(path).fillna("").to_dict("records")]

    @cached_property
    def verdicts(self) -> list[Record]:
        """verdict.json of each recording."""
        folder = self.folder / "recordings"
        return [read_json(folder / row["recording"] / "verdict.json") for row in self.recordings]

    @cached_property
    def poses(self) -> list[Record]:
        """Each row of calibrations with its pose.json."""
        folder = self.folder / "calibrations"
        poses = (read_json(folder / row["calibration"] / "pose.json") for row in self.calibrations)
        return [{"pose": pose, **row} for pose, row in zip(poses, self.calibrations, strict=True)]

    def of(self, kind: str, name: str, suffix: str) -> list[Path]:
        """Files of a recording, calibration or monitor by folder, of a group or paper by name:
        where several names begin a file's, it is of the longest (`lab` and `lab_2`)."""
        files = [path for path in self.files if path.suffix == suffix]
        if kind in ("recording", "calibration", "monitor"):
            return [path for path in files if self.folder / f"{kind}s" / name in path.parents]
        names = [*self.subjects["group"], *self.papers]
        begin = {p: [n for n in names if p.stem.startswith(f"{n}_")] for p in files}
        return [path for path in files if name == max(begin[path], key=len, default="")]

    def page(self, kind: str, name: str, title: str, more_csv: Sequence[Path], **more: Any) -> str:
        """The page of a subject, with its figures and tables."""
        images = self.of(kind, name, ".png" if kind == "monitor" else ".svg")
        figures = details.figures_of(self.folder, images)
        csv = [*self.of(kind, name, ".csv"), *more_csv]
        csv = [path.relative_to(self.folder) for path in csv]
        return details.page(title, figures, csv, **more)


def table_pages(results: Results) -> dict[str, str]:
    """A page of each table in Markdown, by file name; of a paper's, first what it compares."""
    pages = {}
    for source in results.tables(".md"):
        name, csv = source.stem, source.with_suffix(".csv")
        short = comparison.of_file(csv) if csv.is_file() else None
        paper = comparison.paper_of(name)
        up = {}
        if paper in results.papers:
            up[PAPERS[paper]] = f"../{details.address('paper', paper)}"
        if (source.parents[1] / "figures" / f"{name}.pdf").is_file():
            up["PDF"] = f"../figures/{name}.pdf"
        text = source.read_text(encoding="utf-8")
        pages[f"{name}.html"] = details.table_page(text, name, csv.is_file(), short, up)
    return pages


def detail_pages(results: Results) -> dict[Path, str]:
    """A page of each subject, by its path in the folder."""
    titles = {"paper": PAPERS.__getitem__, "monitor": "Monitor {}".format}
    return {
        Path(details.address(kind, name)).relative_to("details"): results.page(
            kind, name, titles.get(kind, str)(name), csv, **more
        )
        for kind, name, csv, more in _subjects(results)
    }


def _subjects(results: Results) -> Iterator[tuple[str, str, list[Path], dict[str, Any]]]:
    """Kind, name, tables beside its own, and further arguments of each page."""
    changes: dict[str, str] = {}
    for compared in results.of_groups("compare").values():
        changes |= compared["recordings"]
    groups = results.subjects["group"]
    rows = zip(results.recordings, results.verdicts, strict=True)
    for name, group, verdict in ((r["recording"], r["group"], v) for r, v in rows):
        changed = [changes[name]] if name in changes else []
        lines = [*words.sentences(verdict), *changed]
        lines += [] if "bar" in verdict else [words.mean_words(verdict)]
        head, *cells = words.mean_table(verdict["series"])
        units = zip(head, MEAN_UNITS, strict=True)
        shown = [f"{quantity or 'series'}{unit}" for quantity, unit in units]
        means = site.Table(shown, "tnnntnn", cells, range(len(head)))
        tables = [{"title": "Mean of all frames", "table": means}] * words.has_mean(verdict)
        yield "recording", name, [], _judged(verdict, lines, group, groups) | {"tables": tables}
    for row in results.poses:
        verdict, name = row["pose"]["verdict"], row["calibration"]
        files = results.of("calibration", name, ".json")
        documents = [read_json(path) for path in files if path.name == OF_RECEIVER]
        lines = [
            verdict["reason"],
            *(str(one.get("sentence") or one["refused"]) for one in documents),
        ]
        yield "calibration", name, [], _judged(verdict, lines, row["group"], groups)
    for name, state in results.monitors.items():
        told = [render("monitor.left_out", **one) for one in state["left_out"]]
        lines = list(dict.fromkeys([*state["reasons"], *told]))
        yield "monitor", name, [], {"verdict": state["word"], "lines": lines}
    yield from (("group", group, [], {}) for group in groups)
    csv = results.tables(".csv")
    for paper in results.papers:
        claims = details.of_paper(results.claims, paper)
        numbers = [
            (site.link(f"{details.UP}/{one.page}", one.title), one.counts)
            for one in details.tables_of(paper, csv)
        ]
        compared = site.table(("table", "numbers"), numbers, words=(0, 1))
        tables = [{"title": "Claims", "table": details.claim_table(claims)}] if claims else []
        tables += [{"title": "Published tables", "table": compared}]
        yield "paper", paper, [path for path in csv if path.stem == "claims"], {"tables": tables}


def _judged(verdict: Record, lines: list[str], group: str, groups: Sequence[str]) -> dict[str, Any]:
    up = {group: f"../groups/{group}.html"} if group in groups else {}
    return {"verdict": verdict["word"], "lines": lines, "up": up}


def overview(results: Results) -> Picture:
    """Figure of one's own recordings against the limits."""
    mine = summary.own_rows(results.verdicts)
    texts = Texts("Recordings against the limits", f"Source: {summary.origin(mine)}.")
    return overview_figure(mine, texts)


def summaries(results: Results, checks: Iterable[Path], png: Path) -> tuple[str, str]:
    """The summary as a page, and as the front of the report.

    checks: check.json of all that was measured, refused or not; png: the `overview`, saved.
    """
    refused = [
        {"kind": path.parent.parent.name.removesuffix("s"), "name": path.parent.name} | check
        for path in checks
        if not (check := read_json(path))["ok"]
    ]
    verdicts = summary.Verdicts(
        results.verdicts,
        results.poses,
        refused,
        results.of_groups("cameras"),
        results.of_groups("compare"),
        png.read_bytes(),
        caption_of(png)[1],
        {name: document["line"] for name, document in results.monitors.items()},
    )
    csv = results.tables(".csv")
    papers = [
        summary.Paper(
            PAPERS[paper],
            details.address("paper", paper),
            details.claim_counts(details.of_paper(results.claims, paper)),
            details.tables_of(paper, csv),
        )
        for paper in results.papers
    ]
    names = [path.stem for path in csv]

    def address(kind: str, name: str) -> str:
        return details.address(kind, name) if name in results.subjects[kind] else ""

    page, part = (summary.page(verdicts, address, papers, names, p) for p in (False, True))
    return page, part
