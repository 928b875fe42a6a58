"""Tables I-III of J from poses whose errors are known; tables of calibrations."""

import math

import numpy as np
import pytest

from mocap_metrology.lighthouse.assess.rows import calibration_rows
from mocap_metrology.lighthouse.published import QUANTITIES, SETUPS, published_table
from mocap_metrology.papers.jansen import jansen_table, jansen_table_3
from mocap_metrology.present.calibration.pose_text import calibration_markdown
from mocap_metrology.present.jansen.jansen_text import markdown
from mocap_metrology.present.pages.details import parts_of
from mocap_metrology.present.pages.site import Table

KINDS = [(e, s) for e in ("paper", "paper-tight", "paper-lm") for s in ("kabsch", "final")]


def record(setup, number, errors, optics=("ideal",), share=0.1, source="twin"):
    """A calibration with the same errors (6,) by every variant; factory values cut them tenfold."""
    poses = [
        {
            "estimator": e,
            "stage": s,
            "optics": o,
            "translation_mm": [300.0, 400.0, 0.0],
            "quaternion_xyzw": [0, 0, 0, 1],
            "rotation_deg": {"alpha": 1.0, "beta": 2.0, "gamma": 3.0},
            "covariance": np.diag([4.0, 1, 1, 0.01, 0.04, 0.01]).tolist(),
            "residual_rms_urad": 240.0,
            "n_angles": 1000,
            "mirrored_share": share,
            "errors_mm": (np.array(errors[:3]) * (0.1 if o == "factory" else 1)).tolist(),
            "errors_deg": (np.array(errors[3:]) * (0.1 if o == "factory" else 1)).tolist(),
        }
        for o in optics
        for e, s in KINDS
    ]
    pose = {
        "stations": {"master": {"id": 11}, "slave": {"id": 12}},
        "chosen": 0,
        "verdict": {"word": "usable", "reason": "Because."},
        "check_against": {"sentence": "No sign that a station moved."},
        "poses": poses,
    }
    return {"calibration": f"{setup}-{number}", "setup": setup, "source": source, "pose": pose}


def cell(rows, setup, quantity, **wanted):
    wanted = {"estimator": "paper", "stage": "kabsch", "optics": "ideal", **wanted}
    found = [
        row
        for row in rows
        if (row["setup"], row["quantity"]) == (setup, quantity)
        and all(row[k] == v for k, v in wanted.items())
    ]
    assert len(found) == 1
    return found[0]


@pytest.fixture(scope="module")
def records():
    """Five errors a setup with the mean and the SD that J prints: its tables must come back.

    Values m + s d with d of mean 0 and sample SD 1; where s is small enough all stay positive, and
    the mean absolute error is m. The other setups are left out of that comparison.
    """
    d = np.array([-1.264911, -0.632456, 0.0, 0.632456, 1.264911])
    mae, sd = published_table(1), published_table(2)
    made = []
    for setup in SETUPS:
        m, s = (np.array([t[setup][q] for q in QUANTITIES]) for t in (mae, sd))
        made += [record(f"real-{setup}", k, m + s * d[k], ("ideal", "factory")) for k in range(5)]
    return made


def test_tables_i_and_ii_come_back_from_errors_of_that_mean_and_sd(records):
    one, two = jansen_table(1, records), jansen_table(2, records)
    mae, sd = published_table(1), published_table(2)
    compared = 0
    for setup in SETUPS:
        for quantity in QUANTITIES:
            row = cell(two, setup, quantity)
            assert row["published"] == sd[setup][quantity]
            assert row["regenerated"] == pytest.approx(sd[setup][quantity], rel=1e-5)
            assert (row["n"], row["source"]) == (5, "twin")
            if mae[setup][quantity] > 1.27 * sd[setup][quantity]:
                compared += 1
                row = cell(one, setup, quantity)
                assert row["regenerated"] == pytest.approx(row["published"], rel=1e-5)
                assert row["ratio"] == pytest.approx(1, rel=1e-5)
    assert compared == 29
    average = cell(two, "Average", "x_mm")
    assert average["regenerated"] == pytest.approx(8.9, rel=1e-4) and average["n"] == 40
    assert cell(two, "Average", "gamma_deg")["regenerated"] == pytest.approx(0.52375, rel=1e-4)


def test_table_iii_keeps_both_noises_apart():
    errors = [np.full(6, 1.0), np.full(6, -2.0)]
    made = [record(f"sim-{s}", k, (s + 1) * errors[k]) for s in (1, 2) for k in (0, 1)]
    made += [record("noise-1", k, 10 * errors[k], share=0.4) for k in (0, 1)]
    rows = jansen_table_3(made)
    quantised = cell(rows, "MAE", "x_mm", noise="quantisation")
    assert quantised["regenerated"] == pytest.approx(1.5 * 2.5)
    assert quantised["ratio"] == pytest.approx(1.5 * 2.5 / 6.9)
    assert (quantised["n_setups"], quantised["n"]) == (2, 4)
    sd = cell(rows, "Average SD", "x_mm", noise="quantisation")["regenerated"]
    assert sd == pytest.approx(3 / math.sqrt(2) * 2.5)
    jitter = cell(rows, "MAE", "x_mm", noise="quantisation and jitter")
    assert jitter["regenerated"] == pytest.approx(15) and jitter["mirrored_share"] == 0.4
    text = markdown(3, rows, made)
    assert "2 setups, 4 calibrations" in text and "1 setup, 2 calibrations" in text
    assert "α" in text and "40 % of the board poses are mirrored" in text
    assert "phases" not in text  # rotors of the simulation are ideal
    assert [line for line in text.splitlines() if line.startswith("### ")] == (
        ["### MAE", "### Average SD"] * 2
    )


def test_estimators_stand_side_by_side():
    """Setup 3 with errors of 8 mm and 0.5° by every method and, with factory values, a tenth of
    them by paper-lm and a twentieth by batch; J had simplexes with ideal optics only."""
    given = record("3", 1, [8.0, 8.0, 8.0, 0.5, 0.5, 0.5], optics=("ideal", "factory"))
    poses = given["pose"]["poses"]
    poses = [p for p in poses if p["estimator"] == "paper-lm" or p["optics"] == "ideal"]
    for pose in [p for p in poses if p["estimator"] == "paper-lm"]:
        halved = {k: [v / 2 for v in pose[k]] for k in ("errors_mm", "errors_deg")}
        poses.append({**pose, **halved, "estimator": "batch"})
    given["pose"]["poses"] = poses
    text = markdown(1, jansen_table(1, [given]), [])
    lines = text[text.index("## Estimators side by side") :].splitlines()
    tables = [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines if "|" in line]
    head = tables[0]
    assert head == ["x / y / z mm", "published", "paper, ideal", "paper-lm, factory",
                    "batch, factory"]  # fmt: skip
    of_setup = [row for row in tables if row[0] == "3"][:2]
    published = published_table(1)["3"]
    assert of_setup[0][1] == " / ".join(f"{published[q]:#.3g}" for q in QUANTITIES[:3])
    assert of_setup[0][2:] == [" / ".join(3 * [v]) for v in ("8.00", "0.800", "0.400")]
    assert of_setup[1][2:] == [" / ".join(3 * [v]) for v in ("0.500", "0.0500", "0.0250")]
    assert not any(row[0] == "4" for row in tables[:6])  # without a calibration


def test_calibrations_of_a_group():
    made = [
        record("lab", 1, [3.0, 4, 0, 0.3, 0, 0.4], source="measured"),
        record("lab", 2, [0.0] * 6),
    ]
    made[1]["pose"] |= {"chosen": None}
    first, second = calibration_rows(made)
    assert first["baseline_mm"] == pytest.approx(500)
    assert (first["master_id"], first["slave_id"], first["verdict"]) == (11, 12, "usable")
    assert first["sigma_x_mm"] == 2 and first["sigma_ry_deg"] == pytest.approx(0.2)
    assert first["error_y_mm"] == 4 and list(first) == list(second)
    assert math.isnan(second["baseline_mm"]) and second["estimator"] is None
    made[0]["pose"] |= {"verdict": {"word": "usable", "reason": "Because it is 9° off."}}
    first = calibration_rows(made)[0]
    text = calibration_markdown([first, second], "Calibrations of lab", "")
    assert "5.00 mm, 0.500°" in text and "2.00 mm, 0.200°" in text and "300.0 400.0 0.0" in text
    assert "- lab-1: usable. Because it is 9° off." in text and "No sign that" in text
    table = next(one for one in parts_of(text) if isinstance(one, Table))
    seen = {str(table.head[k]) for k in table.first}
    assert {"t mm", "σ", "error", "verdict"} <= seen and "hits" not in seen
    assert "No calibrations." in calibration_markdown([], "Calibrations of lab", "")


def test_few_calibrations_are_cautioned_by_the_law_of_their_sd(records):
    """Of two normal errors, the SD over the true one is |N(0, 1)|: 95 % within 0.031 and 2.24."""
    pair = [record("3", k, (k + 1) * np.ones(6)) for k in (0, 1)]
    text = markdown(2, jansen_table(2, pair), [])
    said = next(line for line in text.splitlines() if line.startswith("An SD of 2"))
    low, high = float(said.split()[8]), float(said.split()[10])
    drawn = np.random.default_rng(3).standard_normal((200_000, 2)).std(axis=1, ddof=1)
    assert np.mean(drawn < low) == pytest.approx(0.025, abs=0.004)
    assert np.mean(drawn > high) == pytest.approx(0.025, abs=0.004)
    assert "An SD of" not in markdown(2, jansen_table(2, records), [])
    three_each = [record("sim-1", k, (k + 1) * np.ones(6)) for k in range(3)]
    assert "An SD of 3" in markdown(3, jansen_table_3(three_each), [])
    one = jansen_table(2, [record("3", 1, np.ones(6))])
    assert "fewer than two" in markdown(2, one, [])
