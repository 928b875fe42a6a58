"""Findings by code: documented, complete, and not in conflict with the sentences."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal

from mocap_metrology.common.files import write_json
from mocap_metrology.noise.diagnosis.findings import (
    CODES,
    Finding,
    approach,
    deterministic_parts,
    findings_of,
    model_findings,
    other_wanders,
)
from mocap_metrology.noise.diagnosis.recording import diagnose
from mocap_metrology.noise.diagnosis.records import DiagnosisSettings, Recording
from mocap_metrology.noise.diagnosis.signatures import Wander
from mocap_metrology.noise.model.deterministic import Deterministic
from mocap_metrology.present.text.diagnosis import sentences

DOCUMENT = Path(__file__).parents[3] / "docs" / "findings.md"


def test_every_code_is_documented_with_its_unit() -> None:
    rows = re.findall(r"^\| `(\w+)` \| ([^|]*) ?\| ([^|]+) \|$", DOCUMENT.read_text("utf-8"), re.M)
    assert {code: (unit.strip(), words) for code, unit, words in rows} == CODES


def test_findings_in_json(tmp_path: Path) -> None:
    """No interval is null."""
    with pytest.raises(ValueError, match="low_pass"):
        Finding("lowpass", "x1", 6.0)
    event = Finding("event", "x1", 3.0)
    write_json(tmp_path / "f.json", {"findings": [event.as_dict()]})
    (one,) = json.loads((tmp_path / "f.json").read_text())["findings"]
    ends = {"lower_95": None, "upper_95": None}
    assert one == {"code": "event", "series": "x1", "value": 3.0, "unit": "s"} | ends
    assert str(Finding.of(one)) == str(event)  # NaN is not equal to itself


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


SETTLING = [{"parameter": "T_w", "value": 360.0, "lower_95": 300.0, "upper_95": 420.0}]
KEYS = ("parameter", "series", "value", "lower_95", "upper_95", "std_error", "status", "estimator")
ROW = st.tuples(
    st.sampled_from(["drift", "A_w", "h_-2", "h_0"]), st.sampled_from(["x1", "y1"]),
    st.sampled_from([-1.2, 1.2]), st.sampled_from([-2.0, 0.0, 1e-5]),
    st.sampled_from([-1e-5, 0.0, 2.0]), st.sampled_from([0.5, 1.2 / 1.95, 1.2 / 1.97]),
    st.sampled_from(["ok", "at_bound", "misfit", "not_detected"]),
    st.sampled_from(["likelihood", "likelihood", "slopes"]),
)  # fmt: skip


@given(st.lists(ROW, max_size=5), st.sampled_from([(), ("drift",), ("warm_up", "creep")]))
def test_findings_of_the_model_by_their_rule(drawn: list[tuple], kinds: tuple[str, ...]) -> None:
    """Of `likelihood`, detected and no misfit; an interval without zero, a walk of 1.96 standard
    errors (which a slow term could stand for all the same); of y1, by its signature, these kinds
    alone, and no walk."""
    rows = [dict(zip(KEYS, one, strict=True)) for one in drawn]
    code = {"drift": "drift", "A_w": "warm_up", "h_-2": "random_walk"}
    wanders = {"y1": Wander(kinds, "", kinds, 0.0, 0.0, 1.0)}
    expected, parts = [], {}
    for row in rows:
        low, value, high = row["lower_95"], row["value"], row["upper_95"]
        walk = row["parameter"] == "h_-2"
        sure = value >= 1.96 * row["std_error"] if walk else low > 0 or high < 0
        named = row["series"] == "x1" or code.get(row["parameter"]) in kinds
        used = row["status"] in ("ok", "at_bound") and row["estimator"] == "likelihood"
        if used and sure and named and row["parameter"] in code:
            expected.append((code[row["parameter"]], row["series"], value, low, high))
            if not walk:
                parts.setdefault(row["series"], set()).add(row["parameter"])
    found = [(f.code, f.series, f.value, f.lower_95, f.upper_95) for f in
             model_findings(rows, wanders)]  # fmt: skip
    assert found == expected
    ends = [SETTLING[0] | {"series": k, "status": "ok", "estimator": "likelihood"}
            for k in ("x1", "y1")]  # fmt: skip
    own = deterministic_parts(rows + ends, wanders)
    assert {k: (v.drift != 0, v.A_w != 0) for k, v in own.items()} == {
        k: ("drift" in v, "A_w" in v) for k, v in parts.items()
    }


def test_what_a_warm_up_does_and_how_long() -> None:
    part = Deterministic(A_w=0.22, T_w=360.0)
    assert approach(part, 7200.0) == (pytest.approx(0.22 * (1 - math.exp(-3))), 1080.0)
    assert approach(part, 600.0) == (pytest.approx(0.22 * (1 - math.exp(-600 / 360))), 600.0)


@pytest.mark.parametrize("at_s", [100.0, 500.0])
@pytest.mark.parametrize("stated", [Deterministic(A_w=1.0, T_w=1.0), Deterministic(drift=1.0)])
def test_other_wander_by_kind(at_s: float, stated: Deterministic) -> None:
    """The coordinate that has most, and all sizes; no step that is an event, at 100 s here; no
    warm-up where one is stated; a distance only where no coordinate has any."""
    own = {
        "x1": Wander(("step",), "", ("step",), 0.0, 0.0, 5.0, -2.0, (at_s,), ((at_s, -2.0),)),
        "y1": Wander(("step", "creep"), "", ("step",), 0.0, 0.0, 5.0, 1.0, (300.0,)),
        "z1": Wander(("warm_up", "drift"), "", ("drift",), 0.0, 0.0, 5.0, 1.0),
        "L": Wander((), "", ("step",), 0.0, 0.0, 7.0),
    }
    event = SimpleNamespace(kind="burst", time_s=99.0, stop_s=101.0)
    found = SimpleNamespace(wanders=own, events=[event])
    recording = SimpleNamespace(coordinates={"x1", "y1", "z1"})
    expected = {"creep": ("y1", {"y1": 1.0}), "undecided": ("L", {"L": 7.0})}
    if at_s == 500:
        expected["step"] = "x1", {"x1": 2.0, "y1": 1.0}
    if not stated.A_w:
        expected["warm_up"] = "z1", {"z1": 1.0}
    assert other_wanders(recording, found, {"x1": stated}) == expected
