"""Findings by code: documented, complete, and not in conflict with the sentences."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from scipy import signal

from mocap_metrology.common.files import write_json
from mocap_metrology.noise.diagnosis.findings import (
    CODES,
    Finding,
    approach,
    deterministic_parts,
    findings_of,
    model_findings,
)
from mocap_metrology.noise.diagnosis.recording import DiagnosisSettings, Recording, diagnose
from mocap_metrology.noise.fit.estimates import Coefficient, Estimate, rows
from mocap_metrology.present.text.diagnosis import sentences

DOCUMENT = Path(__file__).parents[3] / "docs" / "findings.md"


def test_every_code_is_documented_with_its_unit() -> None:
    rows = re.findall(r"^\| `(\w+)` \| ([^|]*) ?\| ([^|]+) \|$", DOCUMENT.read_text("utf-8"), re.M)
    assert {code: (unit.strip(), words) for code, unit, words in rows} == CODES


def test_only_known_codes() -> None:
    with pytest.raises(ValueError, match="low_pass"):
        Finding("lowpass", "x1", 6.0)


def test_no_interval_is_null(tmp_path: Path) -> None:
    write_json(tmp_path / "f.json", {"findings": [Finding("event", "x1", 3.0).as_dict()]})
    (one,) = json.loads((tmp_path / "f.json").read_text())["findings"]
    assert one == {
        **{"code": "event", "series": "x1", "value": 3.0, "unit": "s"},
        **{"lower_95": None, "upper_95": None},
    }
    assert math.isnan(Finding("event", "x1", 3.0).lower_95)
    read = Finding.of(one)
    assert (read.code, read.series, read.value) == ("event", "x1", 3.0)
    assert math.isnan(read.upper_95)


RATE, N = 100.0, 30_000
# Kinds of sentences, and the finding without which none of them warns
CODE_OF = {
    **{"event": "event", "periodic": "line", "low_pass": "low_pass", "filled": "gap_filled"},
    **{"level": "level_changes", "tails": "heavy_tails"},
}


def troubled() -> tuple[dict, dict]:
    """Heavy tails, a falling level, a shock and a line."""
    rng = np.random.default_rng(4)
    t = np.arange(N) / RATE
    position = 0.05 * rng.standard_t(4, (6, N)) * (1 - 0.4 * t / t[-1])
    position += 0.03 * np.sin(2 * np.pi * 17.0 * t)
    position[:, 12_000:12_100] += np.sin(np.linspace(0, 12, 100))
    return dict(enumerate(position)), {"A": 400}


def filtered() -> tuple[dict, dict]:
    rng = np.random.default_rng(5)
    sos = signal.butter(2, 6.0, fs=RATE, output="sos")
    return dict(enumerate(signal.sosfiltfilt(sos, 0.05 * rng.standard_normal((6, N))))), {}


def plain() -> tuple[dict, dict]:
    return dict(enumerate(0.05 * np.random.default_rng(6).standard_normal((6, N)))), {}


@pytest.mark.parametrize(
    ("made", "codes"),
    [
        (troubled, {"heavy_tails", "level_changes", "event", "line", "gap_filled"}),
        (filtered, {"low_pass"}),
        (plain, set()),
    ],
)
def test_sentences_and_findings_say_the_same(made, codes) -> None:
    position, n_filled = made()
    names = ("x1", "y1", "z1", "x2", "y2", "z2")
    coordinates = {k: np.float32(position[i] + 160 * (i + 1)) for i, k in enumerate(names)}
    one = Recording(coordinates, ("A", "B"), [(1, 2)], RATE, 6e-5, "float32", n_filled)
    found = diagnose(one, [], None, DiagnosisSettings())
    findings = findings_of(one, found, [])
    said = sentences(one, found, [], DiagnosisSettings())
    assert {f.code for f in findings} == codes
    warned = {s.kind for s in said if s.kind in CODE_OF and s.severity == "warning"}
    told = {CODE_OF[s.kind] for s in said if s.kind in CODE_OF and _names_something(s)}
    assert {CODE_OF[kind] for kind in warned} <= codes
    assert told == codes


def _names_something(sentence) -> bool:
    """Not "no event", nor "no periodic disturbance"."""
    return sentence.numbers.get("n_events", 1) not in (0, None) and (
        sentence.numbers.get("n_lines", 1) != 0
    )


def table(*found: Coefficient, series: str = "x1", estimator: str = "likelihood") -> list:
    return rows(series, Estimate(estimator, "sampled", found, 0.0))


WARM = (
    Coefficient("A_w", 0.22, lower_95=0.2, upper_95=0.24),
    Coefficient("T_w", 360.0, lower_95=300.0, upper_95=420.0),
)
NOTHING = Coefficient("drift", np.nan, upper_95=0.3, detected=False, status="not_detected")


def test_what_was_detected_is_found_with_its_interval():
    found = model_findings(
        table(Coefficient("h_-2", 2e-7, lower_95=1e-7, upper_95=3e-7), NOTHING, *WARM)
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
    part = deterministic_parts(table(*WARM, NOTHING))["x1"]
    assert approach(part, 7200.0) == (pytest.approx(0.209, abs=5e-4), 1080.0)  # three T_w
    assert approach(part, 600.0) == (pytest.approx(0.178, abs=5e-4), 600.0)


def test_parts_are_by_series():
    slow, fast = (Coefficient("drift", v) for v in (0.5, -1.2))
    parts = deterministic_parts(table(slow) + table(fast, series="y1"))
    assert {name: part.drift for name, part in parts.items()} == {"x1": 0.5, "y1": -1.2}
    assert deterministic_parts(table(NOTHING)) == {}
