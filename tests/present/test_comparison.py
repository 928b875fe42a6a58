"""Tables of both papers in short: what agrees, and how often."""

from __future__ import annotations

import math
import re

import pytest

from mocap_metrology.lighthouse.published import QUANTITIES, SETUPS
from mocap_metrology.papers.jansen import jansen_table
from mocap_metrology.present import tables
from mocap_metrology.present.pages import comparison, details, document, summary
from mocap_metrology.present.skurowski import appendix, camera_tables

GAP = math.nan


def words(found: comparison.Comparison) -> list[str]:
    at = [str(head) for head in found.table.head].index("verdict")
    return [re.sub("<[^>]+>", "", str(row[at])) for row in found.table.rows]


def one(name: str, **row) -> str:
    found = comparison.compare(name, [row])
    assert found is not None
    return words(found)[0]


def law(**row) -> str:
    given = {"noise": "white", "quantity": "mu", "tau_s": GAP, "method": "integral"}
    given |= {"published": 0.5, "standard_error": 1e-9, "source": "computed", "note": GAP}
    return one("skurowski_table1", **(given | row))


def test_a_law_agrees_within_rounding_or_the_errors_of_a_simulation() -> None:
    assert law(regenerated=0.5004) == law(regenerated=0.0009, published=0.0) == "agrees"
    assert law(regenerated=0.4924) == law(regenerated=0.0011, published=0.0) == "differs"
    assert law(regenerated=0.53, standard_error=0.011, method="simulation") == "agrees"
    assert law(regenerated=0.53, standard_error=0.009, method="simulation") == "differs"
    assert law(regenerated=0.5, method="point samples") == "not compared"


def test_cameras_are_cited_and_subsets_are_those_of_the_sheet() -> None:
    types = comparison.compare("skurowski_table2", camera_tables.table_2())
    assert types and set(words(types)) == {"cited"} and types.counts == "all cited"
    rows = camera_tables.table_3({})
    assert comparison.compare("skurowski_table3", rows).counts == "all cited"
    rows = [row | {"regenerated": row["published"]} for row in rows]
    rows[0]["regenerated"] += ";99"
    found = comparison.compare("skurowski_table3", rows)
    assert words(found)[:2] == ["differs", "agrees"]
    assert found.counts == f"{len(rows) - 1} of {len(rows)} agree, 1 differ"


@pytest.mark.parametrize(
    ("inside", "published_inside", "expected"),
    [
        (True, GAP, "agrees"),  # a mean
        (True, True, "agrees"),
        (False, True, "differs"),
        (True, False, "differs"),
        (GAP, GAP, "not compared"),  # measured: no coefficients to compare with
    ],
)
def test_a_moment_agrees_where_both_numbers_are_within_chance(
    inside, published_inside, expected
) -> None:
    row = {"camera_type": "T40", "quantity": "sigma_1_mm", "published": 0.02, "regenerated": 0.01}
    row |= {"lower_5": GAP, "upper_95": GAP, "source": "twin", "note": GAP}
    row |= {"nine_hours_lower_5": 0.0125, "nine_hours_upper_95": 0.0178}
    row |= {"inside": inside, "published_inside": published_inside}
    found = comparison.compare("skurowski_table4", [row])
    assert words(found) == [expected]
    assert "0.0125…0.0178" in found.table.rows[0]
    assert one("skurowski_table4", **(row | {"regenerated": GAP, "source": "cited"})) == "cited"


@pytest.mark.parametrize(
    ("status", "lower", "upper", "expected"),
    [
        ("ok", 1.0, 3.0, "agrees"),
        ("ok", 2.1, 3.0, "differs"),
        ("not_detected", GAP, 2.1, "not detected"),
        ("not_detected", GAP, 1.9, "differs"),
        ("unpaired", GAP, GAP, "no partner"),
        ("at_bound", GAP, GAP, "not compared"),
    ],
)
def test_a_coefficient_agrees_within_its_interval(status, lower, upper, expected) -> None:
    row = dict.fromkeys(appendix.COLUMNS, GAP) | {"likelihood": 2.2, "source": "twin"}
    row |= {"n_cameras": 10, "series": "x1", "parameter": "q_c1", "unit": "mm", "published": 2.0}
    row |= {"likelihood_status": status, "supported": False, "note": "expected: its q_c2; a note"}
    row |= {"likelihood_lower_95": lower, "likelihood_upper_95": upper}
    found = comparison.compare("skurowski_tableA2", [row, row | {"published": GAP}])
    assert words(found) == [expected]
    assert found.table.rows[0][-1] == "recording too short for it; a note"


def test_every_printed_coefficient_is_in_the_short_table() -> None:
    rows = appendix.table_a("Bonita", {}, {})
    found = comparison.compare("skurowski_tableA2", rows)
    assert len(found.table.rows) == len(rows)
    assert found.counts == "all cited"


def test_errors_agree_in_size_and_are_those_of_the_claims() -> None:
    rows = jansen_table(1, [])
    assert comparison.compare("jansen_table1", rows).counts == "all cited"
    rows = [row | {"n": 2, "source": "twin", "regenerated": 1.0, "ratio": 3.9} for row in rows]
    for row in rows:
        if row["quantity"] == QUANTITIES[0]:
            row["ratio"] = 4.1 if row["estimator"] == "paper" else 0.24
    found = comparison.compare("jansen_table1", rows)
    n = len(SETUPS) + 1
    assert found.counts == f"{5 * n} of {6 * n} agree, {n} differ"
    assert found.note == "Regenerated: by paper, kabsch, ideal optics."
    assert found.others.rows[0] == ["paper, kabsch, ideal optics", found.counts]
    assert len(found.table.rows) == 6 * n


def test_other_tables_are_of_no_paper() -> None:
    assert comparison.compare("skurowski2019_noise", []) is None
    assert comparison.paper_of("skurowski2019_noise") == ""
    assert comparison.paper_of("jansen_table3") == "jansen"


def test_a_page_compares_first_and_keeps_the_whole_table(tmp_path) -> None:
    rows, title = camera_tables.table_3({}), "Skurowski & Pawlyta 2019, Table 3: camera subsets"
    stem = tmp_path / "skurowski_table3"
    tables.write(stem, rows, title, "A caption.")
    csv = stem.with_suffix(".csv")
    text = stem.with_suffix(".md").read_text()
    page = document.page(text, stem.name, True, comparison.of_file(csv), {"J": "../j.html"})
    assert page.count("<h1>") == 1 and page.count("<table") == 2
    assert page.index("all cited") < page.index("<table") < page.index("A caption.")
    assert page.index("../summary.html") < page.index("../j.html")
    (entry,) = details.tables_of("skurowski", [csv, tmp_path / "skurowski_support.csv"])
    assert entry == details.PaperTable(
        "Table 3: camera subsets", "pages/skurowski_table3.html", "all cited"
    )
    assert details.tables_of("jansen", [csv]) == []
    paper = summary.Paper("S", "details/papers/skurowski.html", "2 hold", [entry])
    front = summary.page(summary.Found(), papers=[paper])
    assert front.index("2 hold") < front.index('href="pages/skurowski_table3.html"')
