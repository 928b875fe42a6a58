"""Findings out of rows of noise.csv."""

from __future__ import annotations

import numpy as np
import pytest

from mocap_metrology.noise.diagnosis.findings import (
    approach,
    deterministic_parts,
    model_findings,
)
from mocap_metrology.noise.fit.estimates import Coefficient, Estimate, rows


def table(*found: Coefficient, series: str = "x1", estimator: str = "likelihood") -> list:
    return rows(series, Estimate(estimator, "sampled", found, 0.0))


WARM = (
    Coefficient("A_w", 0.22, lower_95=0.2, upper_95=0.24),
    Coefficient("T_w", 360.0, lower_95=300.0, upper_95=420.0),
)
NONE = Coefficient("drift", np.nan, upper_95=0.3, detected=False, status="not_detected")


def test_what_was_detected_is_found_with_its_interval():
    found = model_findings(
        table(Coefficient("h_-2", 2e-7, lower_95=1e-7, upper_95=3e-7), NONE, *WARM)
        + table(Coefficient("drift", -1.2, lower_95=-1.3, upper_95=-1.1), series="y1")
        + table(Coefficient("drift", 9.0, status="misfit"), series="z1")
        + table(Coefficient("h_-2", 1e-5), estimator="slopes")
    )
    assert [(f.code, f.series, f.value, f.unit) for f in found] == [
        ("random_walk", "x1", 2e-7, "mm^2 Hz"),
        ("warm_up", "x1", 0.22, "mm"),
        ("drift", "y1", -1.2, "mm/h"),
    ]
    assert (found[2].lower_95, found[2].upper_95) == (-1.3, -1.1)


def test_what_may_be_nothing_is_not_named():
    doubtful = (Coefficient("A_w", 0.2, lower_95=-0.01, upper_95=0.3), WARM[1])
    walk = Coefficient("h_-2", 4e-11, 3e-11, lower_95=0.0, upper_95=1.4e-9)
    found = table(Coefficient("drift", -1.2, lower_95=-2.0, upper_95=1e-5), walk)
    found += table(*doubtful, series="y1")
    assert model_findings(found) == []
    assert deterministic_parts(found) == {}


def test_a_walk_that_a_slow_term_could_stand_for_is_named():
    walk = Coefficient("h_-2", 4e-9, 1e-10, lower_95=0.0, upper_95=4.2e-9)
    assert [f.code for f in model_findings(table(walk))] == ["random_walk"]


def test_what_a_warm_up_does_and_how_long():
    part = deterministic_parts(table(*WARM, NONE))["x1"]
    assert approach(part, 7200.0) == (pytest.approx(0.209, abs=5e-4), 1080.0)  # three T_w
    assert approach(part, 600.0) == (pytest.approx(0.178, abs=5e-4), 600.0)


def test_parts_are_by_series():
    slow, fast = (Coefficient("drift", v) for v in (0.5, -1.2))
    parts = deterministic_parts(table(slow) + table(fast, series="y1"))
    assert {name: part.drift for name, part in parts.items()} == {"x1": 0.5, "y1": -1.2}
    assert deterministic_parts(table(NONE)) == {}
