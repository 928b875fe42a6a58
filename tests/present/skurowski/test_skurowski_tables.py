"""Tables 1, 2 and 4 of S: all that is printed is there, and what agrees is told from what not."""

from __future__ import annotations

import csv
import math
import re
from pathlib import Path

import numpy as np
import pytest
from mocap_workflow.recording_twins import twin_from_mapping

from mocap_metrology.noise.gaussian.moments import Cleaning
from mocap_metrology.noise.twins.published import published_gaussian
from mocap_metrology.present.pages import left_out
from mocap_metrology.present.skurowski import camera_tables, gaussian_table, table_1

NAMES = {("T40", 10): "T", ("Bonita", 10): "B", ("Vantage", 9): "V", ("All", 30): "A"}


@pytest.fixture(scope="module")
def first() -> list[dict]:
    return table_1.table_1(repeats=24, samples=1 << 15)


@pytest.fixture(scope="module")
def fourth() -> list[dict]:
    """Of twins without a recording that differs from the printed row: so `inside` is of that."""
    sheet = {
        name: {"recording": name, "twin": name, "camera_type": kind, "n_cameras": n}
        for (kind, n), name in NAMES.items()
    }
    printed = {name: published_gaussian(kind) for (kind, _), name in NAMES.items()}
    twins = {
        name: twin_from_mapping(
            {"published": {"camera_type": kind, "n_cameras": n}, "seed": 5}, name
        )
        for (kind, n), name in NAMES.items()
        if kind != "All"
    }
    rows = camera_tables.table_4(sheet, printed)
    return gaussian_table.with_chance(rows, twins, Cleaning(0.966), repeats=80)


def of(rows: list[dict], **keys) -> list[dict]:
    return [row for row in rows if all(row[k] == v for k, v in keys.items())]


def test_every_power_law_and_its_printed_mu_is_there(first: list[dict]) -> None:
    mu = {(row["alpha"], row["published"]) for row in of(first, quantity="mu")}
    assert mu == {(-2, 1), (-1, 0), (0, -1), (1, -2), (2, -2)}
    scales = {row["alpha"]: row["scale"] for row in first}
    assert scales == {-2: "A", -1: "B", 0: "C", 1: "D", 2: "E"}
    assert 1.038 in {row["published"] for row in first}


def test_integrals_are_what_is_printed_and_simulations_within_their_errors(first) -> None:
    for row in of(first, method="integral", quantity="K_alpha"):
        if row["alpha"] <= 0 and row["f_h_hz"] is None:
            assert abs(row["deviation_percent"]) < 1e-7, row
        if row["alpha"] > 0:
            assert abs(row["deviation_percent"]) < 0.02, row
    simulated = of(first, method="simulation")
    off = np.array([row["errors_off"] for row in simulated])
    assert np.abs(off).max() < 4
    assert np.mean(np.abs(off) < 1.5) > 0.7
    assert {row["source"] for row in simulated} == {"twin"}


def test_blue_is_no_power_law_and_cameras_see_more_of_blue_and_violet(first) -> None:
    blue = next(r for r in of(first, method="integral", quantity="mu", alpha=1))
    assert blue["regenerated"] == pytest.approx(-1.847, abs=0.001)
    assert "ln tau" in blue["note"]
    ratios = {
        (row["alpha"], row["tau_s"]): 1 + row["deviation_percent"] / 100
        for row in of(first, method="point samples")
    }
    longest = max(tau for _, tau in ratios)
    assert ratios[2, longest] == pytest.approx(2 * math.log(2), rel=1e-3)
    assert ratios[1, longest] == pytest.approx(1.0603, rel=1e-3)


def test_every_number_of_table_2_is_there(root: Path) -> None:
    file = root / "src/mocap_metrology/reference/camera_specs_table2.csv"
    lines = list(csv.DictReader(file.read_text(encoding="utf-8").splitlines()))
    printed = {(k, line["spec"]): line[k] for line in lines for k in ("T40", "Bonita", "Vantage")}
    rows = camera_tables.table_2()
    assert {(r["camera_type"], r["quantity"]): r["published"] for r in rows} == printed
    assert {row["source"] for row in rows} == {"cited"}
    assert len(of(rows, ambiguity="open")) == 12
    beside = {
        (k, r["quantity"]): r[k]
        for r in camera_tables.side_by_side(rows)
        for k in camera_tables.TYPES
    }
    assert beside == printed


def test_table_4_says_what_the_coefficients_allow(fourth: list[dict]) -> None:
    inside = {
        (row["camera_type"], row["quantity"]): row["published_inside"]
        for row in fourth
        if row["quantity"] in ("sigma_1_mm", "sigma_2_mm", "sigma_L_mm", "rho_12")
    }
    outside = {key for key, value in inside.items() if value is False}
    assert outside == {("T40", "sigma_1_mm"), ("T40", "rho_12"), ("Bonita", "rho_12")}
    assert {value for (kind, _), value in inside.items() if kind == "All"} == {None}
    for row in fourth:
        assert bool(row["published_inside"] is False) == ("published outside" in row["note"])
        if row["quantity"].startswith("mu_") and row["camera_type"] != "All":
            assert row["inside"], row  # printed numbers stood in for regenerated ones
            assert row["standard_error"] > 0


def test_algebra_of_table_4(fourth: list[dict]) -> None:
    """Printed: to the rounding of three numbers; a row out of one recording: to 1e-4 mm."""
    checked = [row for row in fourth if row["check"]]
    assert len(checked) == 24
    assert all(row["published_consistent"] for row in checked)
    rng = np.random.default_rng(1)
    x1, x2 = rng.normal(166, 0.02, 500), rng.normal(6, 0.02, 500)
    from mocap_metrology.noise.gaussian.two_markers import gaussian_model

    model = gaussian_model(x1, x2, x1 - x2)
    names = {"rho_12": "rho_12", "sigma_12": "sigma_12_mm2"}
    own = {names.get(k, f"{k}_mm"): v for k, v in vars(model).items()}
    for quantity in gaussian_table.RELATIONS:
        assert own[quantity] == pytest.approx(gaussian_table.related(quantity, own), abs=1e-12)


def test_a_row_that_contradicts_itself_is_found() -> None:
    sheet = {"T": {"recording": "T", "twin": None, "camera_type": "T40", "n_cameras": 10}}
    wrong = published_gaussian("T40") | {"sigma_B_mm": 0.0325}
    rows = gaussian_table.with_chance(camera_tables.table_4(sheet, {"T": wrong}), {})
    bad = next(r for r in rows if (r["camera_type"], r["quantity"]) == ("T40", "sigma_B_mm"))
    assert (bad["consistent"], bad["inside"], bad["source"]) == (False, None, "measured")
    assert bad["residual"] == pytest.approx(5.87e-4, abs=2e-6)


def test_every_figure_is_regenerated_or_left_out_with_a_reason(root: Path) -> None:
    rules = "\n".join(p.read_text("utf-8") for p in (root / "workflow/rules").glob("*.smk"))
    listed = re.search(r"SKUROWSKI_FIGURES = \{(.*?)\n\}", rules, re.S)[1]
    made = {int(n) for n in re.findall(r"^    (\d+): ", listed, re.M)}
    made |= {int(n) for n in re.findall(r'"Figure +(\d+): ', rules)}
    listed = re.search(r"JANSEN_FIGURES = \{(.*?)\n\}", rules, re.S)[1]
    made_j = {int(n) for n in re.findall(r"^    (\d+): ", listed, re.M)}
    rows = left_out.left_out()
    assert all(row["reason"] for row in rows)
    for paper, found, count in ((left_out.S, made, 17), (left_out.J, made_j, 9)):
        out = {int(r["figure"].split()[-1]) for r in rows if r["paper"] == paper}
        assert out.isdisjoint(found)
        assert out | found == set(range(1, count + 1)), paper
