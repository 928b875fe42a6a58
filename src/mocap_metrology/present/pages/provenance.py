"""Origin of results, as a page, and run times, as a table."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from pathlib import Path

from mocap_metrology.common.types import Record
from mocap_metrology.present.pages import details, site
from mocap_metrology.present.tables import Row
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import significant

INPUTS = ("name", "kind", "source", "file", "seed", "sha256")
TIMES = ("rule", "jobs", "total_s", "longest_s", "max_rss_mb")


def run_times(files: Mapping[str, Iterable[str | Path]]) -> list[Row]:
    """A row a rule: `TIMES`. files: Snakemake's benchmarks of one repetition, by rule; it writes NA
    or - for what it could not see."""
    import pandas as pd

    rows = []
    for rule, paths in sorted(files.items()):
        jobs = [pd.read_csv(path, sep="\t", na_values=["-"]).iloc[0] for path in paths]
        if jobs:
            seconds, memory = ([float(job[name]) for job in jobs] for name in ("s", "max_rss"))
            most = max((mb for mb in memory if not math.isnan(mb)), default=math.nan)
            values = (rule, len(jobs), round(math.fsum(seconds), 2), max(seconds), most)
            rows.append(dict(zip(TIMES, values, strict=True)))
    return rows


def page(document: Record) -> str:
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
    up = {"summary": "summary.html"}
    return details.page("Provenance", lines=lines, tables=shown, up=up)
