"""Origin of results, as a page, and run times, as a table."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from mocap_metrology.present.pages.site import Table, render, table
from mocap_metrology.present.tables import Record, Row
from mocap_metrology.present.text.numbers import significant

INPUTS = ("name", "kind", "source", "file", "seed", "sha256")
TIMES = ("rule", "jobs", "total_s", "longest_s", "max_rss_mb")
UP = {"summary": "summary.html"}
TIMES_NOTE = (
    "Wall-clock time and greatest resident memory of the jobs that made these results, as "
    "Snakemake measured them. The pages of the report come after this and are missing."
)
INPUTS_NOTE = (
    "SHA-256 of every input file, before anything is done to it. A twin is made from the "
    "parameters of the file of twins and its seed, to which the seed of the configuration is "
    "added; the checksum of its recording is that of the simulated file."
)
RESULTS_NOTE = (
    "SHA-256 of the tables. The same code, inputs and seed give the same on this machine."
)


def run_times(files: Mapping[str, Iterable[str | Path]]) -> list[Row]:
    """A row a rule: `TIMES`. files: Snakemake's benchmarks of one repetition, by rule."""
    rows = []
    for rule, paths in sorted(files.items()):
        jobs = [_benchmark(path) for path in paths]
        if jobs:
            seconds = [job[0] for job in jobs]
            memory = [job[1] for job in jobs if not math.isnan(job[1])]
            most = max(memory, default=math.nan)
            values = (rule, len(jobs), round(math.fsum(seconds), 2), max(seconds), most)
            rows.append(dict(zip(TIMES, values, strict=True)))
    return rows


def _benchmark(path: str | Path) -> tuple[float, float]:
    """Seconds and MB of a benchmark; Snakemake writes NA or - for what it could not see."""
    import pandas as pd

    row = pd.read_csv(path, sep="\t", na_values=["-"]).iloc[0]
    return float(row["s"]), float(row["max_rss"])


def page(found: Record) -> str:
    """The page of provenance.json, which also has the configuration."""
    tables = [
        ("Inputs", INPUTS_NOTE, _rows(INPUTS, found["inputs"])),
        ("Run times", TIMES_NOTE, _rows(TIMES, [_shown(row) for row in found["run_times"]])),
        ("Tables", RESULTS_NOTE, table(("table", "sha256"), found["tables"].items())),
        ("Packages", "", table(("package", "version"), found["packages"].items())),
    ]
    shown = [{"title": title, "note": note, "table": it} for title, note, it in tables]
    return render("provenance.html", "Provenance", code=found["code"], tables=shown, up=UP)


def _shown(row: Record) -> Row:
    """A row of `run_times` with numbers of three digits, and jobs as they are."""
    return {k: significant(v) if isinstance(v, float) else v for k, v in row.items()}


def _rows(head: Sequence[str], rows: Sequence[Record]) -> Table:
    return table(head, [[row[name] for name in head] for row in rows])
