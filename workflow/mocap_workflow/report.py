"""How Snakemake's report shows results: the order of its menu, and tables as pages."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import SimpleNamespace

from mocap_workflow.calibration_twins import CalibrationTwin
from mocap_workflow.recording_twins import AnyTwin
from mocap_workflow.rows import SheetRow

REPORTER = "snakemake.report.html_reporter"  # of Snakemake 9.27, and its modules `.data.*`
# Titles of tables: `Jansen et al. 2019, Table I: mean absolute error`; `skurowski2019: outliers`
TITLE = re.compile(r"(?P<whose>.+?)(?:, (?P<item>(?:Table|Figure)s? [^:]+))?: (?P<shows>.+)")
PLACES = {  # by whose table it is; any other is of a group. The menu is in alphabetical order
    "Skurowski & Pawlyta 2019": ("2 Skurowski & Pawlyta 2019", "Table"),
    "Jansen et al. 2019": ("3 Jansen et al. 2019", "Table"),
    "Left out": ("7 Provenance", "Left out"),
}


def entry(path: str) -> dict[str, object]:
    """Category, subcategory and labels of a table, by the title of its Markdown.

    One label: of several, Snakemake 9.27 makes a switch of any but the first that has two values
    equally often, and its page is blank if a result lacks one of them.
    """
    with Path(path).open(encoding="utf-8") as stream:
        title = next((line[2:].strip() for line in stream if line.startswith("# ")), path)
    match = TITLE.fullmatch(title)
    whose, item, shows = match.group("whose", "item", "shows") if match else (None, None, title)
    category, kind = PLACES.get(whose or "", ("4 Groups", "table"))
    subcategory = None if whose in PLACES else whose
    labels = {"result": f"{item or kind}: {shows}"}
    return {"category": category, "subcategory": subcategory, "labels": labels}


def without_markup() -> None:
    """Let Snakemake write the data of its report without tags. It puts cells of the sheets into
    scripts of the page, as JSON in which `</script>` would end the script."""

    def safe(value: object) -> str:
        return json.dumps(value).replace("<", r"\u003c")

    for module in [m for name, m in sys.modules.items() if name.startswith(REPORTER)]:
        if getattr(module, "json", None) is json:
            module.json = SimpleNamespace(dumps=safe)  # type: ignore[attr-defined]


def inputs(
    rows: Iterable[SheetRow], twins: Mapping[str, AnyTwin | CalibrationTwin]
) -> list[dict[str, object]]:
    """Entries of the page of provenance for each row, besides its files."""
    return [
        {
            "name": row.name,
            "kind": row.KIND,
            "source": row.source,
            "seed": twins[row.twin].seed if row.twin else None,
        }
        for row in rows
    ]


def plain_configuration(config: Mapping[str, object]) -> dict[str, object]:
    """The configuration without folders of this machine: sheets by name."""
    sheets = ("recordings", "calibrations", "twins")
    plain = {key: Path(str(config[key])).name if config[key] else None for key in sheets}
    return {key: value for key, value in {**config, **plain}.items() if key != "results"}
