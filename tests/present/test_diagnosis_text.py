"""The whole diagnosis of simulated recordings: numbers in the tables and in the words."""

from __future__ import annotations

import csv
import json
import math
from dataclasses import replace

import numpy as np
import pytest
from mocap_workflow.recording_twins import twin_from_mapping

from mocap_metrology.noise.diagnosis.events import Event
from mocap_metrology.noise.diagnosis.findings import findings_of
from mocap_metrology.noise.diagnosis.levels import Sides
from mocap_metrology.noise.diagnosis.periodic import Found, Mains
from mocap_metrology.noise.diagnosis.recording import DiagnosisSettings, Recording, diagnose
from mocap_metrology.noise.fit.estimates import rows
from mocap_metrology.noise.fit.spectral.likelihood import likelihood
from mocap_metrology.noise.fit.spectral.lines import Line
from mocap_metrology.noise.model.deterministic import Deterministic
from mocap_metrology.noise.series import all_series
from mocap_metrology.noise.twins.simulate import simulate
from mocap_metrology.present.diagnosis.tables import write_diagnosis
from mocap_metrology.present.text.diagnosis import line_words, outcome, sentences
from mocap_metrology.present.text.drift import drift_words, warm_up_words
from mocap_metrology.present.text.numbers import moment

RATE = 120.0
NAMES = ("x1", "y1", "z1", "x2", "y2", "z2")
CRUMP = {"time_s": 150.0, "amplitude_mm": 1.0, "decay_s": 0.6, "frequency_hz": 5.0}
SETTINGS = DiagnosisSettings()


def made(position, resolution_mm=1.5e-5):
    coordinates = dict(zip(NAMES, position.reshape(6, -1).astype(np.float32), strict=True))
    return Recording(coordinates, ("A", "B"), [(1, 2)], RATE, resolution_mm, "float32")


def noise_rows(recording):
    found = []
    for name, series in all_series(recording.coordinates, recording.pairs):
        found += rows(name, likelihood(series, RATE).estimate)
    return found


@pytest.fixture(scope="module")
def crumped():
    twin = twin_from_mapping(
        {"published": {"camera_type": "T40", "n_cameras": 10}, "seed": 9, "crump": CRUMP}, "T40-10"
    )
    recording = made(simulate(twin, 420.0).position_mm)
    noise = noise_rows(recording)
    found = diagnose(recording, noise, None, SETTINGS)
    return recording, noise, found, sentences(recording, found, noise, SETTINGS)


def test_files_hold_what_was_found(crumped, tmp_path):
    recording, _, found, said = crumped
    write_diagnosis(
        tmp_path, "r", "twin", recording, found, findings_of(recording, found, []), said
    )
    (event,) = csv.DictReader((tmp_path / "events.csv").open())
    assert float(event["time_s"]) == pytest.approx(150.0, abs=0.1)
    assert event["markers"] == "A;B"
    assert event["word"] == "happened once"
    assert float(event["ratio_lower"]) < 1 < float(event["ratio_upper"])
    lines = list(csv.DictReader((tmp_path / "periodic.csv").open()))
    z1 = next(r for r in lines if r["series"] == "z1")
    assert float(z1["f_hz"]) == pytest.approx(14.4, abs=0.01)
    assert float(z1["alias_below_hz"]) == pytest.approx(105.6, abs=0.01)
    table = list(csv.DictReader((tmp_path / "filters.csv").open()))
    names = {r["filter"] for r in table if r["series"] == "z1"}
    assert {"none", "Butterworth 6 Hz", "Butterworth 10 Hz", "notch 14.4 Hz"} <= names
    document = json.loads((tmp_path / "diagnosis.json").read_text())
    assert document["source"] == "twin"
    assert {"event", "periodic", "filter", "resolution"} <= {
        f["kind"] for f in document["sentences"]
    }
    told = {f["code"]: f for f in document["findings"] if f["series"] == "z1"}
    assert told["line"]["value"] == pytest.approx(14.4, abs=0.01)
    assert told["line"]["lower_95"] < 14.4 < told["line"]["upper_95"]
    times = [f["value"] for f in document["findings"] if f["code"] == "event"]
    assert times == pytest.approx([150.0], abs=0.1)


def test_filters_are_predicted_without_the_event(crumped):
    """The model in noise.csv holds the crump; the one fitted anew agrees with what is measured."""
    _, _, found, _ = crumped
    for one in found.filtered:
        assert one.measured.sigma == pytest.approx(one.predicted.sigma, rel=0.05)


def test_words_are_sentences_with_the_numbers(crumped):
    _, _, _, said = crumped
    event = next(f for f in said if f.kind == "event")
    assert event.severity == "warning"
    assert event.words.startswith("At 150.0 s A, B moved")
    for finding in said:
        assert finding.words.endswith(".")
        assert "nan" not in finding.words
        assert finding.severity in ("info", "warning")
    assert [f.severity for f in said] == sorted((f.severity for f in said), reverse=True)


def test_tables_without_rows_keep_their_heads(tmp_path):
    rng = np.random.default_rng(1)
    recording = made(rng.normal(0, 0.01, (6, 6000)) + np.array([[160], [0], [0], [0], [0], [0]]))
    found = diagnose(recording, [], None, SETTINGS)
    said = sentences(recording, found, [], SETTINGS)
    write_diagnosis(tmp_path, "r", "measured", recording, found, [], said)
    assert len((tmp_path / "events.csv").read_text().splitlines()) == 1
    assert len((tmp_path / "periodic.csv").read_text().splitlines()) == 1
    assert next(f for f in said if f.kind == "event").words.startswith("No event")
    assert all(f.predicted is None for f in found.filtered)


@pytest.mark.parametrize(("seconds", "words"), [(21, "Too short to decide"), (23, "No event")])
def test_without_room_for_both_sides_nothing_is_decided(seconds, words):
    rng = np.random.default_rng(1)
    recording = made(rng.normal(0, 0.01, (6, round(seconds * RATE))) + 100)
    found = diagnose(recording, [], None, SETTINGS)
    assert found.n_windows > 0 and not found.events
    said = next(f for f in sentences(recording, found, [], SETTINGS) if f.kind == "event")
    assert said.words.startswith(words)
    assert said.numbers["n_events"] == (None if seconds < 22 else 0)


@pytest.mark.parametrize("n", [17, 130, 700])
def test_short_constant_and_missing_series_are_told_of(n, tmp_path):
    rng = np.random.default_rng(2)
    position = rng.normal(0, 0.01, (6, n))
    position[0] = 5.0
    position[3:] = np.nan
    recording = made(position)
    found = diagnose(recording, [], None, SETTINGS)
    said = sentences(recording, found, [], SETTINGS)
    write_diagnosis(tmp_path, "r", "measured", recording, found, [], said)
    gaps = next(f for f in said if f.kind == "gaps")
    assert gaps.severity == "warning"
    assert "B is missing in 100 %" in gaps.words


def test_a_coarse_file_and_a_moving_marker_are_warned_of():
    rng = np.random.default_rng(3)
    position = rng.normal(0, 0.008, (6, 12_000)) + np.array([[160], [0], [0], [0], [0], [0]])
    position[1] += np.linspace(0, 5, 12_000)
    recording = made(np.round(position / 0.01) * 0.01, 0.01)
    found = diagnose(recording, [], None, SETTINGS)
    said = {f.kind: f for f in sentences(recording, found, [], SETTINGS)}
    assert said["resolution"].severity == "warning"
    share = found.resolutions[0].share
    assert share == pytest.approx(0.01**2 / 12 / (0.008**2 + 0.01**2 / 12), rel=0.1)
    assert said["moving"].severity == "warning"
    assert math.isclose(found.drifts["y1"].per_hour, 5 * 36, rel_tol=0.05)


WARM = Deterministic(0.0, 0.22, 360.0)


def test_the_sentence_of_a_warm_up_says_how_much_and_how_long():
    assert warm_up_words({"x1": WARM}, 7200.0) == (
        "still warming up: 0.209 mm in the first 18 min (x1), time constant 6 min: "
        "start recording later"
    )
    assert "0.178 mm in the first 10 min" in warm_up_words({"x1": WARM}, 600.0)
    assert drift_words({"x1": WARM}, 7200.0) == ""


def test_the_fastest_drift_is_told():
    parts = {"x1": Deterministic(0.5), "y1": Deterministic(-1.2)}
    assert drift_words(parts, 600.0) == "a steady drift of −1.2 mm/h (y1), 0.2 mm in total"
    assert warm_up_words(parts, 600.0) == ""


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({}, "seen in the periodogram"),
        ({"in_psd": True}, "seen in the periodogram and in the PSD"),
        (
            {"in_psd": True, "in_adev": True, "harmonic": (3, 7.0)},
            "seen in the periodogram, in the PSD and in the ADEV; harmonic 3 of 7 Hz",
        ),
        (
            {"mains": Mains(100.0, 50.0, 120.0)},
            "seen in the periodogram; could be 100 Hz of 50 Hz mains, folded at 120 Hz",
        ),
        (
            {"line": Line(0.01, 20.0, 0.0, 1e-5, 30.0, width_f=0.042, band_hz=(19.0, 21.0))},
            "seen in the periodogram; its frequency or its amplitude varies: "
            "it fills a band of 0.042 Hz",
        ),
        ({"mains": Mains(50.0, 50.0)}, "seen in the periodogram; could be 50 Hz of 50 Hz mains"),
    ],
)
def test_where_a_line_shows(change, words):
    line = Line(0.01, 20.0, 0.0, 1e-5, 30.0)
    one = Found("x1", line, 0.0, 0.02, 1e-4, None, None, 9.0, None, 0.02, 0.3, None)
    assert line_words(replace(one, **change)) == words


def test_what_is_left_of_an_event():
    event = Event(3.0, 1.0, "burst", ("x1",), "x1", 1.0, 0.0, 1e-6, 9.0, 0.1, of=3)
    alike, apart = Sides("x1", 1, 1, 1, 1, 1.01, 0.98, 1.02), Sides("x1", 1, 2, 1, 2, 2, 1.9, 2.1)
    assert outcome(event) == "unknown"
    assert outcome(replace(event, sides=(alike,))) == "one of 3"
    assert outcome(replace(event, sides=(alike,), of=1)) == "happened once"
    assert outcome(replace(event, sides=(alike, apart))) == "level changed"


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (9059.97, "2 h 31 min"),
        (599.97, "10 min"),
        (150.24, "150.2 s"),
        (3661.0, "1 h 1 min 1.0 s"),
    ],
)
def test_times_carry_over(seconds: float, text: str) -> None:
    assert moment(seconds) == text


def of_two_markers(first: np.ndarray, second: np.ndarray):
    """What is said of two markers, and the codes of what was found."""
    recording = made(np.stack([first, second]))
    found = diagnose(recording, [], None, SETTINGS)
    return sentences(recording, found, [], SETTINGS), findings_of(recording, found, [])


def test_of_markers_that_walk_the_movement_is_said_and_no_noise():
    """Codes of what else was found stay for programs."""
    rng = np.random.default_rng(3)
    still = rng.normal(0, 0.05, (2, 3, 2400)) + 200.0
    t = np.arange(2400) / RATE
    gait = np.stack([1200 * t, 60 * np.sin(5.6 * t), 900 + 40 * np.sin(11.2 * t)])
    said, found = of_two_markers(gait, gait + still[1])
    assert said[0].kind == "moving" and said[0].words.startswith("Marker A seems to move, and so")
    assert {one.kind for one in said} <= {"moving", "filled", "repeated", "gaps"}
    assert {"moves", "event"} & {one.code for one in found} == {"moves"}
    # Where one marker stands, its noise is told after the movement
    said, _ = of_two_markers(gait, still[1])
    assert said[0].kind == "moving" and {"resolution", "periodic"} <= {one.kind for one in said}
    # A marker that was pushed once stands before and after
    pushed = rng.normal(0, 0.05, (2, 3, 7200)) + 200.0
    pushed[:, 0, 3600:] += 5.0
    said, _ = of_two_markers(*pushed)
    assert said[0].kind == "moving" and {"resolution", "periodic"} <= {one.kind for one in said}


def test_positions_that_are_repeated_are_named():
    """Every second frame is that before: 60 Hz that were exported as 120."""
    rng = np.random.default_rng(4)
    doubled = np.repeat(rng.normal(0, 0.05, (3, 1200)) + 200.0, 2, axis=1)
    said, found = of_two_markers(doubled, rng.normal(0, 0.05, (3, 2400)) + 300.0)
    (words,) = [one.words for one in said if one.kind == "repeated"]
    assert words.startswith(
        "A repeats its position exactly in 50 % of the frames, for up to 0.0083"
    )
    shares = {one.series: one.value for one in found if one.code == "repeated"}
    assert shares == {axis: pytest.approx(0.5, abs=1e-3) for axis in ("x1", "y1", "z1")}
