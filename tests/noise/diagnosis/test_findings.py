"""Findings by code: documented, complete, and not in conflict with the sentences."""

import json
import math
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import signal

from mocap_metrology.common.files import write_json
from mocap_metrology.noise.diagnosis.events import Event
from mocap_metrology.noise.diagnosis.findings import CODES, Finding, _level_changes, findings_of
from mocap_metrology.noise.diagnosis.one_series import _bounded
from mocap_metrology.noise.diagnosis.recording import diagnose
from mocap_metrology.noise.diagnosis.records import DiagnosisSettings, Recording
from mocap_metrology.noise.diagnosis.sides import Blocks, Sides
from mocap_metrology.noise.diagnosis.signatures import _slowest
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
    [(troubled, {"heavy_tails", "level_changes", "event", "line", "gap_filled"}),
     (filtered, {"low_pass"}), (plain, set())],
)  # fmt: skip
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
    put = replace(one, exchanged=[{"labels": ["A", "B"], "n_frames": N // 4}])
    exchanged = [f for f in findings_of(put, found, []) if f.code == "exchanged"]
    assert [(f.series, f.value) for f in exchanged] == [(name, 0.25) for name in names]


def _names_something(sentence) -> bool:
    """Not "no event", nor "no periodic disturbance"."""
    return sentence.numbers.get("n_events", 1) not in (0, None) and (
        sentence.numbers.get("n_lines", 1) != 0
    )


def test_movement_is_no_filter() -> None:
    """It may have any spectrum: neither on the axis that moves nor on others of the marker."""
    t, rng = np.arange(N) / RATE, np.random.default_rng(6)
    sos = signal.butter(2, 12.0, fs=RATE, output="sos")
    position = signal.sosfiltfilt(sos, 0.05 * rng.standard_normal((6, N)))
    position[0] += 40 * np.sin(2 * np.pi * t / 60)
    names = ("x1", "y1", "z1", "x2", "y2", "z2")
    coordinates = {name: np.float32(position[i]) for i, name in enumerate(names)}
    one = Recording(coordinates, ("A", "B"), [], RATE, 6e-5, "float32", {})
    findings = findings_of(one, diagnose(one, [], None, DiagnosisSettings()), [])
    assert {f.series for f in findings if f.code == "low_pass"} == {"x2", "y2", "z2"}


@pytest.mark.parametrize(
    ("lasts", "n_series", "least", "most"),
    [(0.22, 6, 0, 10), (0.15, 6, 0, 2), (math.inf, 6, 70, 100), (math.inf, 1, 20, 50)],
)
def test_noise_that_is_correlated_over_a_fifth_of_the_recording_is_no_walk(
    lasts, n_series, least, most
):
    """By all series together, of 100 recordings of 900 means; AR(1) sampled exactly."""
    rng, keep = np.random.default_rng(8), math.exp(-1 / lasts / 900)
    draw = 0.01 * rng.normal(size=(100, n_series, 900))
    draw[..., 0] /= math.sqrt(1 - keep**2 if keep < 1 else 1)
    x = signal.lfilter([1], [1, -keep], draw) + 0.003 * rng.normal(size=draw.shape)
    slowest = [[_slowest(row) for row in recording] for recording in x]
    assert least <= sum(not _bounded(one) for one in slowest) <= most
    assert all(_bounded(one[:1] * 6) == _bounded(one[:1]) for one in slowest)  # one movement of all


def test_numbers_of_a_change_of_level_at_once() -> None:
    side = Sides("x1", 1.0, 1.5, 1.0, 1.5, 1.5, 1.2, 1.9)
    event = Event(90.0, 1.0, "level", ("x1",), "x1", math.nan, 0.0, 0.01, 9.0, 0.1, sides=(side,))
    (found,) = _level_changes(SimpleNamespace(trends=[], events=[event]))
    assert (found.value, found.lower_95, found.upper_95) == pytest.approx((0.5, 0.2, 0.9))
    two = Blocks(np.array([1.0, 3.0]), np.array([4.0, 6.0]), 1.0)
    assert two.sd == pytest.approx(math.sqrt(5 + 1))  # within blocks and between them
