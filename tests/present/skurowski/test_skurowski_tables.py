"""Tables 1, 2 and 4 of S: all that is printed is there, and what agrees is distinguished."""

import csv
import math
import re
from pathlib import Path

import numpy as np
import pytest
from mocap_workflow.recording_twins import twin_from_mapping

from mocap_metrology.noise.gaussian.moments import Cleaning
from mocap_metrology.noise.gaussian.two_markers import gaussian_model
from mocap_metrology.noise.twins.published import published_gaussian
from mocap_metrology.papers import gaussian_table, power_laws, subsets
from mocap_metrology.present.skurowski import appendix, theory_figures
from mocap_metrology.present.text import captions

NAMES = {("T40", 10): "T", ("Bonita", 10): "B", ("Vantage", 9): "V", ("All", 30): "A"}
SIGMAS = ("sigma_1_mm", "sigma_2_mm", "sigma_L_mm", "rho_12")


@pytest.fixture(scope="module")
def first() -> list[dict]:
    return power_laws.table_1(repeats=24, samples=1 << 15)


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
    rows = gaussian_table.table_4(sheet, printed, twins, Cleaning(0.966), repeats=80)
    return [row | {"note": appendix.note_of_table_4(row)} for row in rows]


def of(rows: list[dict], **keys) -> list[dict]:
    return [row for row in rows if all(row[k] == v for k, v in keys.items())]


def test_table_1_is_complete_and_integrals_and_simulations_agree_with_it(first) -> None:
    mu = {(row["alpha"], row["scale"], row["published"]) for row in of(first, quantity="mu")}
    assert mu == {(-2, "A", 1), (-1, "B", 0), (0, "C", -1), (1, "D", -2), (2, "E", -2)}
    for row in of(first, method="integral", quantity="K_alpha"):
        if row["alpha"] > 0 or row["f_h_hz"] is None:
            assert abs(row["deviation_percent"]) < (0.02 if row["alpha"] > 0 else 1e-7), row
    constants = {row["method"]: row for row in of(first, quantity="constant of D")}
    exact = 3 * np.euler_gamma - math.log(2)
    assert constants["integral"]["regenerated"] == pytest.approx(exact, abs=1e-4)
    assert {row["published"] for row in constants.values()} == {1.038}
    off = np.array([row["errors_off"] for row in of(first, method="simulation")])
    assert np.abs(off).max() < 4 and np.mean(np.abs(off) < 1.5) > 0.7
    ratios = {
        row["alpha"]: 1 + row["deviation_percent"] / 100  # at the longest tau, which is last
        for row in of(first, method="point samples")
    }
    assert ratios == pytest.approx({1: 1.0603, 2: 2 * math.log(2)}, rel=1e-3)
    blue = of(first, method="integral", quantity="mu", alpha=1)[0]
    assert blue["regenerated"] == pytest.approx(-1.847, abs=0.001) and "ln tau" in blue["note"]


def test_every_number_of_table_2_is_there(root: Path) -> None:
    file = root / "src/mocap_metrology/reference/camera_specs_table2.csv"
    lines = list(csv.DictReader(file.read_text(encoding="utf-8").splitlines()))
    printed = {(k, line["spec"]): line[k] for line in lines for k in ("T40", "Bonita", "Vantage")}
    rows = subsets.table_2()
    assert {(r["camera_type"], r["quantity"]): r["published"] for r in rows} == printed
    assert len(of(rows, ambiguity="open", source="cited")) == 12
    beside = {(k, r["quantity"]): r[k] for r in subsets.side_by_side() for k, _ in printed}
    assert beside == printed


def test_table_4_states_what_the_coefficients_allow(fourth: list[dict]) -> None:
    inside = {(r["camera_type"], r["quantity"]): r["published_inside"] for r in fourth}
    outside = {key for key, value in inside.items() if value is False and key[1] in SIGMAS}
    assert outside == {("T40", "sigma_1_mm"), ("T40", "rho_12"), ("Bonita", "rho_12")}
    assert {value for (kind, _), value in inside.items() if kind == "All"} == {None}
    for row in fourth:
        assert (row["published_inside"] is False) == ("published outside" in row["note"])
        if row["camera_type"] != "All":
            assert row["lower_5"] < row["median"] < row["upper_95"]
            assert row["quantity"][:3] != "mu_" or (row["inside"] and row["standard_error"] > 0)
    notes = {(row["camera_type"], row["quantity"]): row["note"] for row in fourth}
    assert notes["T40", "mu_L_mm"] == (
        "printed 0.0044 above mu_e: the markers are not quite along x"
    )
    assert "h_-2 of L is printed as" in notes["Bonita", "rho_12"]
    assert "too small for it: h_-2 is" in notes["T40", "rho_12"]
    assert notes["Vantage", "sigma_1_mm"].endswith("agrees with nine cameras, not ten")
    assert notes["All", "rho_12"].startswith("no coefficients of all thirty cameras")


def test_algebra_of_table_4(fourth: list[dict]) -> None:
    """Printed: to the rounding of three numbers; a row out of one recording: to 1e-4 mm."""
    checked = [row for row in fourth if row["check"]]
    assert len(checked) == 24 and all(row["published_consistent"] for row in checked)
    rng = np.random.default_rng(1)
    x1, x2 = rng.normal(166, 0.02, 500), rng.normal(6, 0.02, 500)
    names = {"rho_12": "rho_12", "sigma_12": "sigma_12_mm2"}
    model = vars(gaussian_model(x1, x2, x1 - x2))
    own = {names.get(k, f"{k}_mm"): v for k, v in model.items()}
    for quantity in gaussian_table.RELATIONS:
        assert own[quantity] == pytest.approx(gaussian_table.by_relation(quantity, own), abs=1e-12)
    sheet = {"T": {"recording": "T", "twin": None, "camera_type": "T40", "n_cameras": 10}}
    wrong = published_gaussian("T40") | {"sigma_B_mm": 0.0325}
    (bad,) = of(gaussian_table.table_4(sheet, {"T": wrong}, {}), consistent=False)
    assert (bad["quantity"], bad["inside"], bad["source"]) == ("sigma_B_mm", None, "measured")
    assert bad["residual"] == pytest.approx(5.87e-4, abs=2e-6)


def test_every_figure_is_regenerated_or_left_out_with_a_reason(root: Path) -> None:
    rules = (root / "workflow/rules/papers.smk").read_text("utf-8")
    drawn = {"skurowski": {7, 8}, "jansen": set()}  # those two as cases, by a wildcard
    for paper, numbers in re.findall(r'figure_of\("(\w+)", n\) for n in ([^\]]*)\]', rules):
        numbers = re.search(rf"{numbers} = (.*)", rules)[1] if numbers.isidentifier() else numbers
        drawn[paper] |= set(eval(numbers))
    made = {}
    for paper in drawn:
        titles = captions.texts(f"{paper.upper()}_TITLES")
        made[paper] = {int(number) for number in titles if number.isdigit()}
    assert made == drawn
    rows = theory_figures.left_out()
    assert all(row["reason"] for row in rows)
    for paper, found, count in (
        (theory_figures.S, made["skurowski"], 17),
        (theory_figures.J, made["jansen"], 9),
    ):
        out = {int(r["figure"].split()[-1]) for r in rows if r["paper"] == paper}
        assert out.isdisjoint(found) and out | found == set(range(1, count + 1)), paper
