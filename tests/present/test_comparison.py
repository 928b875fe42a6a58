"""Tables of both papers in short: what agrees, and how often."""

import math
import re

import pytest

from mocap_metrology.lighthouse.published import QUANTITIES, SETUPS
from mocap_metrology.papers import coefficient_tables as appendix
from mocap_metrology.papers import subsets
from mocap_metrology.papers.jansen import jansen_table
from mocap_metrology.present import tables
from mocap_metrology.present.pages import comparison, details, summary

GAP = math.nan


def words(found: comparison.Comparison | None) -> list[str]:
    assert found is not None
    at = [str(head) for head in found.table.head].index("verdict")
    return [re.sub("<[^>]+>", "", str(row[at])) for row in found.table.rows]


LAW = {"noise": "white", "quantity": "mu", "tau_s": GAP, "published": 0.5, "source": "computed"}
LAW |= {"note": GAP, "method": "integral", "standard_error": 1e-9}
MOMENT = {"camera_type": "T40", "quantity": "sigma_1_mm", "published": 0.02, "regenerated": 0.01}
MOMENT |= {"lower_5": GAP, "upper_95": GAP, "source": "twin", "note": GAP}
MOMENT |= {"nine_hours_lower_5": 0.0125, "nine_hours_upper_95": 0.0178}
COEFFICIENT = dict.fromkeys(appendix.COLUMNS, GAP) | {"likelihood": 2.2, "source": "twin"}
COEFFICIENT |= {"n_cameras": 10, "series": "x1", "parameter": "q_c1", "unit": "mm"}
COEFFICIENT |= {"published": 2.0, "supported": False, "note": "expected: its q_c2; a note"}


def inside(here: object, published: object) -> dict:
    return MOMENT | {"inside": here, "published_inside": published}


def fitted(status: str, lower: float, upper: float, source: str = "twin") -> dict:
    row = COEFFICIENT | {"likelihood_status": status, "source": source}
    return row | {"likelihood_lower_95": lower, "likelihood_upper_95": upper}


@pytest.mark.parametrize(
    ("name", "row", "verdict"),
    [  # a law agrees within the rounding of its print, or the errors of a simulation
        ("table1", LAW | {"regenerated": 0.5004}, "agrees"),
        ("table1", LAW | {"regenerated": 0.4994}, "differs"),
        ("table1", LAW | {"regenerated": 0.0009, "published": 0.0}, "agrees"),
        ("table1", LAW | {"regenerated": 0.0011, "published": 0.0}, "differs"),
        ("table1", LAW | {"regenerated": 0.53, "standard_error": 0.011}, "differs"),
        *(
            ("table1", LAW | {"regenerated": 0.53, "method": "simulation", "standard_error": e}, w)
            for e, w in ((0.011, "agrees"), (0.009, "differs"))
        ),
        ("table1", LAW | {"regenerated": 0.5, "method": "point samples"}, "not compared"),
        ("table4", inside(True, GAP), "agrees"),  # a mean
        ("table4", inside(True, True), "agrees"),
        ("table4", inside(False, True), "differs"),
        ("table4", inside(True, False), "differs"),
        ("table4", inside(GAP, GAP), "not compared"),  # measured: no coefficients
        ("table4", inside(True, True) | {"regenerated": GAP, "source": "cited"}, "cited"),
        ("tableA2", fitted("ok", 2.0, 3.0), "agrees"),
        ("tableA2", fitted("ok", 1.0, 2.0), "agrees"),
        ("tableA2", fitted("ok", 2.1, 3.0), "differs"),
        ("tableA2", fitted("ok", 1.0, 1.9), "differs"),
        ("tableA2", fitted("not_detected", GAP, 2.0), "not detected"),
        ("tableA2", fitted("not_detected", GAP, 1.9), "differs"),
        ("tableA2", fitted("unpaired", GAP, GAP), "no partner"),
        ("tableA2", fitted("at_bound", GAP, GAP), "not compared"),
        ("tableA2", fitted("ok", 1.0, 3.0, "cited"), "cited"),
    ],
)
def test_a_number_agrees_within_what_its_rule_allows(name: str, row: dict, verdict: str) -> None:
    found = comparison.compare(f"skurowski_{name}", [row, row | {"published": GAP}])
    assert words(found) == [verdict]
    assert {*found.meanings} <= {verdict} and all(found.meanings.values())
    cells = found.table.rows[0]
    if name == "table4":
        assert "0.0125…0.0178" in cells
    if name == "tableA2":
        assert cells[-1] == "recording too short for it; a note"


def test_cameras_are_cited_and_subsets_are_those_of_the_sheet() -> None:
    types = comparison.compare("skurowski_table2", subsets.table_2())
    assert {*words(types)} == {"cited"} and types.counts == "all cited"
    rows = subsets.table_3({})
    assert comparison.compare("skurowski_table3", rows).counts == "all cited"
    rows = [row | {"regenerated": row["published"]} for row in rows]
    rows[0]["regenerated"] += ";99"
    found = comparison.compare("skurowski_table3", rows)
    assert words(found)[:2] == ["differs", "agrees"]
    assert found.counts == f"{len(rows) - 1} of {len(rows)} agree, 1 differ"
    rows = appendix.table_a("Bonita", {}, {}, {})
    found = comparison.compare("skurowski_tableA2", rows)
    assert len(found.table.rows) == len(rows) and found.counts == "all cited"


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
    assert found.meanings["agrees"].startswith("between 1/4 and 4 times the published value.")
    assert found.others.rows[0] == ["paper, kabsch, ideal optics", found.counts]
    assert len(found.table.rows) == 6 * n
    assert comparison.compare("skurowski2019_noise", []) is None
    assert comparison.counts(["not detected", "no partner", "not compared"]) == (
        "0 of 2 agree, 1 not detected, 1 without a partner, 1 not compared"
    )


def test_a_page_compares_first_and_keeps_the_whole_table(tmp_path) -> None:
    rows, title = subsets.table_3({}), "Skurowski & Pawlyta 2019, Table 3: camera subsets"
    stem = tmp_path / "skurowski_table3"
    tables.write(stem, rows, title, "A caption.")
    csv = stem.with_suffix(".csv")
    text = stem.with_suffix(".md").read_text()
    page = details.table_page(text, stem.name, True, comparison.of_file(csv), {"J": "../j.html"})
    assert page.count("<h1>") == 1 and page.count("<table") == 2
    assert page.index("all cited") < page.index("<table") < page.index("A caption.")
    assert page.index("../summary.html") < page.index("../j.html")
    (entry,) = details.tables_of("skurowski", [csv, tmp_path / "skurowski2019_noise.csv"])
    expected = "Table 3: camera subsets", "pages/skurowski_table3.html", "all cited"
    assert entry == expected
    assert details.tables_of("jansen", [csv]) == []
    paper = summary.Paper("S", "details/papers/skurowski.html", "2 hold", [entry])
    front = summary.page(summary.Verdicts(), papers=[paper])
    assert front.index("2 hold") < front.index('href="pages/skurowski_table3.html"')
