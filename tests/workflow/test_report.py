"""`make report`: where results stand in its menu, and what is no markup in it."""

import json
from importlib import import_module

import pytest
from mocap_workflow import report


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
        ("Jansen et al. 2019, Table I: mean absolute error", ("3 Jansen et al. 2019", None,
         "Table I: mean absolute error")),
        ("Skurowski & Pawlyta 2019, Tables A1-A3: white noise: given back",
         ("2 Skurowski & Pawlyta 2019", None, "Tables A1-A3: white noise: given back")),
        ("hall.1: outliers", ("4 Groups", "hall.1", "table: outliers")),
    ],
)  # fmt: skip
def test_titles_of_tables_say_where_they_go(tmp_path, title: str, expected: tuple) -> None:
    path = tmp_path / "table.md"
    path.write_text(f"# {title}\n\nText.\n")
    found = report.entry(str(path))
    shown = found["category"], found["subcategory"], found["labels"]["result"]
    assert shown == expected
