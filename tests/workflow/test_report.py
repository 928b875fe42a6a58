"""`make report`: where results stand in its menu, and what is no markup in it."""

import json
import re
from importlib import import_module
from pathlib import Path

import pytest
from mocap_workflow import report

from mocap_metrology.present.pages import summary

ROOT = Path(__file__).resolve().parents[2]


def test_no_cell_of_a_sheet_is_markup_in_the_data_of_the_report() -> None:
    """As Snakemake writes it: parameters of jobs, a sheet's cells among them, as JSON."""
    cell = "</script><img src=x onerror=alert(1)><!-- ; var x = 1;"
    params = f"rows=[{{'camera_type': '{cell}'}}]"
    metadata = import_module(f"{report.REPORTER}.data.metadata")
    report.without_markup()
    text = metadata.render_metadata({"params": params})
    assert "<" not in text
    assert json.loads(text) == {"params": params}


@pytest.mark.parametrize(
    "title, expected",
    [
        (
            "Jansen et al. 2019, Table I: mean absolute error",
            ("3 Jansen et al. 2019", None, "Table I: mean absolute error"),
        ),
        (
            "Skurowski & Pawlyta 2019, Tables A1-A3: white noise: given back",
            ("2 Skurowski & Pawlyta 2019", None, "Tables A1-A3: white noise: given back"),
        ),
        ("hall.1: outliers", ("4 Groups", "hall.1", "table: outliers")),
    ],
)
def test_titles_of_tables_say_where_they_go(tmp_path, title: str, expected: tuple) -> None:
    path = tmp_path / "table.md"
    path.write_text(f"# {title}\n\nText.\n")
    found = report.entry(str(path))
    shown = found["category"], found["subcategory"], found["labels"]["result"]
    assert shown == expected


def test_pages_name_categories_that_there_are() -> None:
    named = re.findall("“(.+?)”", summary.INSIDE)
    assert named and set(named) <= set(report.CATEGORIES)


def test_rules_name_numbered_categories_and_offer_no_table_twice() -> None:
    """A report could only offer a CSV for download, which lies beside it; it shows its page."""
    for path in (ROOT / "workflow/rules").glob("*.smk"):
        text = path.read_text(encoding="utf-8")
        assert set(re.findall(r'\bcategory="(.+)"', text)) <= set(report.CATEGORIES), path
        assert not re.search(r'report\(\s*f?"[^"]+\.csv"', text), path
