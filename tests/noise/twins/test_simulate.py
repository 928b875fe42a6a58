"""Twins: exact expectation of their Allan variance, joint behaviour, effects, configuration."""

import json
import math
from dataclasses import replace
from datetime import date, timedelta

import numpy as np
import pytest
import yaml
from mocap_workflow.recording_twins import recording_twin, twin_from_mapping

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.faults import Faults
from mocap_metrology.noise.model.components import FORMS, GaussMarkov, NoiseModel, PowerLaw
from mocap_metrology.noise.model.synthesis import circle_length, increment_spectrum
from mocap_metrology.noise.twins.published import published_row
from mocap_metrology.noise.twins.simulate import simulate, stream
from tests.noise.model.textbook import allan_variance

RATE = 120.0
TAU0 = 1 / RATE
T40 = {"published": {"camera_type": "T40", "n_cameras": 10}, "seed": 1}
WHITE = {"coefficients": {"all": {"h_0": "1e-6"}}, "seed": 1}


@pytest.fixture(scope="module")
def document(root):
    return yaml.safe_load((root / "config" / "twins.yaml").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def twins(document):
    common = document["defaults"]["recording"]
    own = {k: v for k, v in document["twins"].items() if {"published", "coefficients"} & set(v)}
    return {name: recording_twin(entry, name, common) for name, entry in own.items()}


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(
    "component",
    [
        *(PowerLaw(alpha, 1.0) for alpha in (-2, -1, 0, 1, 2)),
        *(GaussMarkov(1.0, T_c) for T_c in (1e-4, 0.001, 0.0084, 0.3, 6.0, 100.0, 2000.0)),
    ],
    ids=str,
)
@pytest.mark.parametrize("n", [600, 6001])
def test_expected_allan_variance_is_the_models_at_every_tau(component, form, n):
    """The drawn spectrum of first differences through sin^4(pi f m tau0) / (2 m^2 sin^4(pi f
    tau0)), bin by bin, in 5 s and 50 s: T_c = 2000 s is far beyond the recording."""
    model, length = NoiseModel((component,)), circle_length(n)
    spectrum = increment_spectrum(model, length, RATE, form=form) / (length * TAU0)
    assert spectrum.min() >= 0
    spectrum[[0, -1]] /= 2
    u = np.arange(1, spectrum.size) / length
    for m in (1, 2, 10, n // 10, n // 3, n // 2 - 1):
        gain = np.sin(np.pi * u * m) ** 4 / (2 * m**2 * np.sin(np.pi * u) ** 4)
        found = spectrum[0] * m**2 / 2 + spectrum[1:] @ gain
        tolerance = 2e-3 if component == PowerLaw(1, 1.0) else 1e-5
        assert found == pytest.approx(model.avar(m, RATE, form), rel=tolerance)


@pytest.mark.parametrize("form", FORMS)
def test_a_twin_has_the_allan_variance_of_its_form(form):
    # y1 of T40-2, whose correlated term of 2.3 ms is a quarter of a frame: 1.76 times at m = 1
    entry = {"published": {"camera_type": "T40", "n_cameras": 2}, "seed": 1, "form": form}
    position = simulate(twin_from_mapping(entry, "T"), 600).position_mm
    m = np.array([1, 2, 5])
    found = [allan_variance(position[0, 1], k) for k in m]
    assert found == pytest.approx(published_row("T40", 2)["y1"].avar(m, RATE, form), rel=0.03)


def test_same_seed_same_bytes_and_no_stream_depends_on_another():
    twin = twin_from_mapping(T40, "T40-10")
    first = simulate(twin, 30)
    assert simulate(twin, 30).position_mm.tobytes() == first.position_mm.tobytes()
    for other in (replace(twin, name="T40-9"), replace(twin, seed=2)):
        different = simulate(other, 30).position_mm - first.position_mm
        assert np.all(np.abs(different).max(axis=2) > 1e-3)
    assert first.truth["seed"] == twin.seed
    streams = {stream("a", 1, p).integers(1 << 62) for p in ("x", "y", "z", "phases")}
    assert len(streams) == 4
    spiky = twin_from_mapping(T40 | {"outliers": {"per_hour": 3600, "amplitude_mm": 2}}, "T40-10")
    changed = simulate(spiky, 30).position_mm != first.position_mm
    assert 10 < changed.sum() < 60


def test_crump_gaps_drift_and_rounding():
    quiet = {"coefficients": {"all": {}}, "seed": 1, "start_mm": [[160, 1, 1], [0, 0, 0]]}
    crump = {"time_s": 10, "amplitude_mm": 0.5, "decay_s": 2, "frequency_hz": 3}
    swing = simulate(twin_from_mapping(quiet | {"crump": crump}), 60)
    moved = swing.position_mm - swing.position_mm[:, :, :1]
    t = np.arange(moved.shape[2]) / 120 - 10
    shape = 0.5 * np.exp(-t.clip(0) / 2) * np.sin(6 * np.pi * t) * (t >= 0)
    weights = np.array(swing.truth["crump"]["weights"])
    assert moved == pytest.approx(weights[:, :, None] * shape, abs=1e-8)
    assert np.all((np.abs(weights) >= 0.5) & (np.abs(weights) <= 1))
    late = simulate(twin_from_mapping(quiet | {"crump": crump | {"time_s": 100}}), 60)
    assert np.ptp(late.position_mm, axis=2) == pytest.approx(0)
    del crump["time_s"]
    share = simulate(twin_from_mapping(quiet | {"crump": crump | {"time_share": 1 / 6}}), 60)
    assert share.truth["crump"]["time_s"] == pytest.approx(10)
    assert np.argmax(np.any(share.position_mm != share.position_mm[..., :1], axis=(0, 1))) == 1201

    drift = simulate(twin_from_mapping(quiet | {"drift_mm_per_h": {"Wand2": [0, 0, -6]}}), 60)
    moved = drift.position_mm[:, :, -1] - drift.position_mm[:, :, 0]
    assert moved == pytest.approx(np.array([[0, 0, 0], [0, 0, -0.1]]), abs=1e-4)

    gaps = simulate(twin_from_mapping(WHITE | {"gaps": {"per_hour": 600, "mean_s": 0.5}}), 600)
    lost = np.isnan(gaps.position_mm)
    assert np.array_equal(lost[:, 0], lost[:, 1]) and np.array_equal(lost[:, 0], lost[:, 2])
    truth = gaps.truth["gaps"]
    assert abs(len(truth["frames"]) - 200) < 4 * math.sqrt(200)
    assert np.mean(truth["frames"]) / 120 == pytest.approx(0.5, rel=0.3)
    assert 0.9 * sum(truth["frames"]) < lost[:, 0].sum() <= sum(truth["frames"])

    rounded = simulate(twin_from_mapping(WHITE | {"resolution_mm": 0.01}), 60).position_mm
    assert rounded * 100 == pytest.approx(np.round(rounded * 100), abs=1e-9)
    assert len(np.unique(rounded[0, 1])) > 3


def test_every_twin_of_the_configuration_simulates(twins):
    table_3 = {"T40": (2, 3, 4, 5, 6, 8, 10), "Bonita": (2, 3, 4, 5, 6, 8, 10)}
    table_3["Vantage"] = (2, 3, 4, 5, 6, 8, 9, 10)
    expected = {f"{kind}-{n}" for kind, counts in table_3.items() for n in counts}
    expected |= {"All-30", "T40-10-crump", "outliers", "rounded", "walk-and-white"}
    assert expected <= set(twins)
    takes = {twin.slow.take: twin.seed for twin in twins.values() if twin.slow}
    assert len(takes) == 3 and all(twins[f"{kind}-2"].slow.take == kind for kind in table_3)
    own = [twin.seed for twin in twins.values() if twin.slow is None]
    assert len({*own, *takes.values()}) == len(own) + len(takes)
    assert all(twin.seed == takes[twin.slow.take] for twin in twins.values() if twin.slow)
    for name, twin in twins.items():
        recording = simulate(twin, 60)
        assert twin.name == name and recording.position_mm.shape == (2, 3, 7200)
        assert np.all(np.isfinite(recording.position_mm))
        truth = json.loads(json.dumps(recording.truth, allow_nan=False))
        assert truth == recording.truth


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ({"seed": 1}, "expected either published or coefficients"),
        (T40 | {"colour": 1}, "unknown key 'colour', expected one of published"),
        ({"published": {"camera_type": "T40"}, "seed": 1}, "n_cameras is missing"),
        ({"published": {"camera_type": "T40", "n_cameras": 7}, "seed": 1}, "expected T40 with"),
        ({"coefficients": {"x1": {"h_5": 1}}, "seed": 1}, "coefficients.x1: noise coefficient"),
        ({"coefficients": {"w": {}}, "seed": 1}, "unknown key 'w', expected one of x1"),
        ({"coefficients": {"all": {"h_0": "ten"}}, "seed": 1}, "'ten', expected a number >= 0"),
        (T40 | {"labels": ["A", "A"]}, "expected two names"),
        (T40 | {"labels": 5}, "expected two names"),
        (T40 | {"distance_line": "both"}, "split or omit"),
        (T40 | {"drift_mm_per_h": {"Wand9": [0, 0, 1]}}, "unknown key 'Wand9'"),
        (T40 | {"drift_mm_per_h": {"Wand1": [0, 1]}}, "expected three numbers"),
        (T40 | {"without": ["q_c9"]}, "'q_c9', expected one of"),
        (T40 | {"without": ["T_c1"]}, "'T_c1', expected one of"),  # goes with q_c1
        (T40 | {"scale": {"L": 2}}, "unknown key 'L'"),
    ],
)
def test_a_wrong_entry_is_refused_in_one_line(entry, words):
    with pytest.raises(Faults, match=r"^twin T9: [^\n]*$") as refusal:
        twin_from_mapping(entry, "T9")
    assert words in str(refusal.value)


def test_too_short_is_refused():
    with pytest.raises(Refusal, match="expected 16 frames at least"):
        simulate(twin_from_mapping(WHITE), 15 / RATE)
    assert simulate(twin_from_mapping(WHITE), 16 / RATE).position_mm.shape[-1] == 16


def test_days_of_a_facility() -> None:
    """300 dates of one twin: place, length and jitter scatter from day to day as stated (standard
    errors of 4 %), and what changes on a date stays changed. The same date gives the same bytes."""
    change = {"since": "2026-03-01", "place_mm": [3, 0, 0], "length_mm": 1, "jitter": 4}
    days = {"place_mm": 0.2, "length_mm": 0.1, "jitter": 0.1}
    own = WHITE | {"duration_s": 4, "start_mm": [[0, 0, 0], [0, 500, 0]]}
    before = recording_twin(own | {"days": days}, "t")
    after = recording_twin(own | {"days": days | {"changes": [change]}}, "t")

    def numbers(twin) -> np.ndarray:
        found = []
        for k in range(300):
            day = date(2026, 3, 1) + timedelta(days=k)
            made = simulate(replace(twin, date=f"{day.isoformat()}T10:00"))
            mean = made.position_mm.mean(axis=2)
            noise = np.diff(made.position_mm).std() / math.sqrt(2)
            found.append([mean[:, 0].mean(), mean[1, 1] - mean[0, 1], math.log(noise)])
        return np.array(found)

    quiet, moved = numbers(before), numbers(after)
    assert quiet.std(axis=0) == pytest.approx([0.2, 0.1, 0.1], rel=0.15)
    assert np.median(moved - quiet, axis=0) == pytest.approx([3, 1, math.log(4)], abs=0.03)
    creeping = {"since": "2026-03-01", "length_mm_per_day": 0.5}
    late = recording_twin(own | {"days": {"changes": [creeping]}}, "t")
    one, two = (simulate(replace(late, date="2026-03-21")).position_mm for _ in range(2))
    assert one.tobytes() == two.tobytes()
    assert np.linalg.norm(one[1] - one[0], axis=0).mean() == pytest.approx(510, abs=0.3)


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"since": "2026-03-01"}, "days.changes: {'since': '2026-03-01'}, expected a list such as"),
        ([{"since": "March"}], "days.changes.since: 'March', expected a day such as 2026-03-16"),
        ([{"since": "2026-03-01", "jitter": 0}], "days.changes.jitter: 0, expected a number > 0"),
    ],
)
def test_what_is_no_change_is_refused(changes: object, expected: str) -> None:
    with pytest.raises(Faults) as faults:
        recording_twin(WHITE | {"days": {"changes": changes}}, "t")
    assert expected in faults.value.lines[0]


def test_scale_is_of_the_series_that_are_named() -> None:
    """Amplitudes: h_0 of the one is four times as large, of the others as before."""
    twin = recording_twin(WHITE | {"scale": {"x1": 2.0}}, "scaled", {})
    h_0 = {s: c["h_0"] for s, c in simulate(twin, 1.0).truth["coefficients"].items()}
    assert h_0 == pytest.approx(dict.fromkeys(h_0, 1e-6) | {"x1": 4e-6}) and len(h_0) == 6
