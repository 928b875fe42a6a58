"""How Snakemake's report shows results: the order of its menu, and tables as pages."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from snakemake.io import report as snakemake_report

CATEGORIES = (
    "Summary",
    "Skurowski & Pawlyta 2019",
    "Jansen et al. 2019",
    "Groups",
    "Recordings",
    "Calibrations",
    "Provenance",
)
LEFT_OUT = "Left out"  # what the table is called of the figures that are not regenerated
# `Jansen et al. 2019, Table I: mean absolute error`; `skurowski2019: outliers`
TITLE = re.compile(r"(?P<whose>.+?)(?:, (?P<item>(?:Table|Figure)s? [^:]+))?: (?P<shows>.+)")


def category(name: str) -> str:
    """The name behind spaces, the more the earlier it comes: the menu of a report is in order of
    the alphabet, and a browser shows no spaces at the start of a line."""
    if name not in CATEGORIES:
        raise ValueError(f'category "{name}" of a report; expected one of {", ".join(CATEGORIES)}')
    return " " * (len(CATEGORIES) - CATEGORIES.index(name)) + name


def report(value: Any, *args: Any, **settings: Any) -> Any:
    """Snakemake's `report` with ordered categories and all labels in one. A CSV is left out: a
    report can only offer it for download, and report_pages makes a page of it that carries it."""
    if str(value).endswith(".csv"):
        return value
    if not callable(settings["category"]):
        settings["category"] = category(settings["category"])
        settings["labels"] = label(settings["labels"])
    return snakemake_report(value, *args, **settings)


def label(labels: Mapping[str, str]) -> dict[str, str]:
    """All labels of a result as one. Of several, Snakemake 9.27 makes a switch of any but the first
    that has two values equally often, and its page goes blank where a result lacks one of them."""
    text = ": ".join(labels.values())
    # A space as wide as a digit, so that Figure 2 comes before Figure 10.
    return {"result": re.sub(r"^Figure (?=\d\b)", "Figure \u2007", text)}


def entry(path: str) -> dict[str, Any]:
    """Category, subcategory and labels of a table, by the title of its Markdown."""
    title = _title(path)
    found = TITLE.fullmatch(title)
    whose, item, shows = found.group("whose", "item", "shows") if found else (None, None, title)
    if whose in CATEGORIES:
        labels = {"item": item or "Table", "shows": shows}
        return {"category": category(whose), "subcategory": None, "labels": label(labels)}
    if whose == LEFT_OUT:
        labels = {"item": LEFT_OUT, "shows": shows}
        return {"category": category("Provenance"), "subcategory": None, "labels": label(labels)}
    labels = {"item": item or "table", "shows": shows}
    return {"category": category("Groups"), "subcategory": whose, "labels": label(labels)}


def _title(path: str) -> str:
    with Path(path).open(encoding="utf-8") as stream:
        return next((line[2:].strip() for line in stream if line.startswith("# ")), path)


def link(name: str, subcategory: str, figure: str) -> str:
    """Address within the report: opens the category at the subcategory, and a figure, which is
    known by the end of its path. Nothing happens where the report lacks it."""
    view = (
        f"navbarMode:'subcategory',category:'{category(name)}',subcategory:'{subcategory}',"
        "content:'img',contentPath:results[path].data_uri,resultPath:path"
    )
    found = f"Object.keys(results).find(path=>path.endsWith('/{figure}'))"
    # The menu first: the list of one subcategory does not turn into that of another.
    steps = f"app.setView({{navbarMode:'menu'}}),setTimeout(()=>app.setView({{{view}}}))"
    return f"javascript:void(path=>path&&({steps}))({found})"
