"""The studies of J's claims: a small one by its rule, and what is said about given errors."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import spearmanr

from mocap_metrology.papers.studies.findings import SHOWN, rows_of
from mocap_metrology.papers.studies.study import STUDIES
from mocap_metrology.present import tables
from mocap_metrology.present.claims import studies_markdown, study_figure
from mocap_metrology.present.plot.figure import save

SMALL = "{recordings: 2, duration_s: 1.0, diodes: [3, 6, 32], distances_m: [2.0, 5.0]}"
NAMES = {shown.name: shown for shown in SHOWN}


@pytest.fixture(scope="module")
def results(root: Path, snakemake, tmp_path_factory) -> Path:
    """Two studies by their rule, two recordings at each value."""
    folder = tmp_path_factory.mktemp("studies")
    wanted = [f"{folder}/jansen_studies/{name}.csv" for name in ("diodes", "distance")]
    done = snakemake(
        *(root, "--cores", "1", *wanted),
        *("--config", "recordings=", "calibrations=", f"results={folder}"),
        f"jansen_studies={SMALL}",
    )
    assert done.returncode == 0, done.stdout
    return folder / "jansen_studies"


def read(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_numbers_of_a_study_follow_from_its_recordings(results: Path) -> None:
    rows = rows_of(NAMES["distance"], tables.read(results / "distance.csv"))
    given = [row for row in read(results / "distance.csv") if row["variant"] == "weighted"]
    methods = {(row["estimator"], row["stage"]) for row in given}
    assert methods == {(e, s) for e in ("paper", "paper-lm") for s in ("kabsch", "final")} | {
        ("batch", "final")
    }
    assert len(rows) == 2 * len(methods)
    for row in rows:
        own = [g for g in given if (g["estimator"], g["stage"]) == (row["estimator"], row["stage"])]
        x, y = (np.array([float(g[k]) for g in own]) for k in ("value", "error_mm"))
        assert row["correlation_mm"] == pytest.approx(spearmanr(x, y).statistic)
        assert row["median_mm"] == pytest.approx(np.median(y[x == row["value"]]))
        assert row["n"] == 2 and not row["failed"] and math.isnan(row["lower_mm"])
    best = {row["estimator"]: row["median_mm"] for row in rows if row["stage"] == "final"}
    assert best["batch"] < 30 and best["paper-lm"] < 100  # mm, after one second


def test_weights_are_compared_in_the_same_recordings(results: Path) -> None:
    rows = rows_of(NAMES["weights"], tables.read(results / "distance.csv"))
    errors = {
        (g["estimator"], g["variant"], float(g["value"]), g["recording"]): float(g["error_mm"])
        for g in read(results / "distance.csv")
        if g["stage"] == "kabsch"
    }
    weighted = [row for row in rows if row["variant"] == "weighted"]
    assert [row["value"] for row in weighted] == [2, 5, 2, 5]
    for row in weighted:
        both = [
            [errors[row["estimator"], v, row["value"], k] for k in "12"]
            for v in ("weighted", "unweighted")
        ]
        assert row["ratio"] == pytest.approx(np.median(np.divide(*both)))
    assert all(math.isnan(row["ratio"]) for row in rows if row["variant"] == "unweighted")


def test_three_diodes_are_refused_and_counted(results: Path, tmp_path: Path) -> None:
    rows = rows_of(NAMES["diodes"], tables.read(results / "diodes.csv"))
    three = [row for row in rows if row["value"] == 3]
    assert len(three) == 5 and all(row["failed"] == row["n"] == 2 for row in three)
    assert all(math.isnan(row["median_mm"]) for row in three)
    whys = {g["why"] for g in read(results / "diodes.csv") if g["value"] == "3"}
    assert len(whys) == 1 and "moments with both angles of four diodes" in whys.pop()
    others = [row for row in rows if row["value"] != 3]
    assert not any(row["failed"] for row in others)
    for row in others:  # of 6 and 32 diodes alone
        own = [
            (float(g["value"]), float(g["error_mm"]))
            for g in read(results / "diodes.csv")
            if (g["estimator"], g["stage"]) == (row["estimator"], row["stage"]) and g["error_mm"]
        ]
        assert len(own) == 4
        assert row["correlation_mm"] == pytest.approx(spearmanr(*zip(*own, strict=True)).statistic)
    text = studies_markdown(rows, 2, 1.0, 2019)
    assert "2 of 2" in text and "## 5. Number of diodes" in text
    svg, png = save(study_figure(NAMES["diodes"], rows, "Source: simulated."), tmp_path / "five")
    assert "refused" in svg.read_text(encoding="utf-8") and png.stat().st_size > 10_000


def made(name: str, effect: float, n: int) -> list[dict[str, object]]:
    """n recordings at each value of a study, with errors that grow as exp(effect k) with the k-th
    value."""
    rng, shown = np.random.default_rng(1), NAMES[name]
    values = {"pattern": ["arc", "hand"], "lasers": [0.0, 5.0, 25.0]}.get(name, [1.0, 2.0, 4.0])
    rows = []
    for approach in STUDIES[shown.data].approaches:
        for estimator in approach.estimators:
            for k, value in enumerate(values):
                for recording in range(n):
                    error = float(np.exp(effect * k + rng.normal(0, 0.3)))
                    stage = "final" if estimator == "batch" else "kabsch"
                    row = {"value": value, "distance_m": 1.0, "recording": recording, "why": ""}
                    row |= {"estimator": estimator, "stage": stage, "variant": approach.variant}
                    row |= {"error_mm": error, "error_deg": error / 10, "mirrored": math.nan}
                    rows.append(row)
    return rows


@pytest.mark.parametrize(
    ("name", "effect", "finding"),
    [("baseline", 0.0, "holds"), ("baseline", 1.0, "does not"), ("baseline", -1.0, "does not"),
     ("pattern", 0.0, "holds"), ("pattern", 1.0, "does not"), ("diodes", -1.0, "holds"),
     ("diodes", 1.0, "does not"), ("lasers", 1.0, "error rises"),
     ("lasers", 0.0, "no noticeable influence")],
)  # fmt: skip
def test_words_follow_the_errors(name: str, effect: float, finding: str) -> None:
    import pandas as pd

    rows = rows_of(NAMES[name], pd.DataFrame(made(name, effect, 200)))
    assert {row["finding"] for row in rows if row["estimator"] == "paper"} == {finding}
