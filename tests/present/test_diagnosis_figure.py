"""Files and page of a diagnosis: with and without events, lines, models; short, constant."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest
from figure_data import check_saved, every_text
from mocap_workflow.recording_twins import twin_from_mapping

from mocap_metrology.noise.diagnosis.evidence import halves, view_of
from mocap_metrology.noise.diagnosis.findings import findings_of
from mocap_metrology.noise.diagnosis.recording import diagnose
from mocap_metrology.noise.diagnosis.records import DiagnosisSettings, Recording
from mocap_metrology.noise.diagnosis.resonance import Resonance
from mocap_metrology.noise.fit.estimates import rows
from mocap_metrology.noise.fit.spectral.likelihood import likelihood
from mocap_metrology.noise.fit.spectral.welch import welch
from mocap_metrology.noise.twins.simulate import simulate
from mocap_metrology.present.diagnosis import diagnosis_figure, write_diagnosis
from mocap_metrology.present.plot.figure import Texts
from mocap_metrology.present.text.diagnosis import sentences

pytestmark = pytest.mark.filterwarnings("error")
RATE = 120.0
NAMES = ("x1", "y1", "z1", "x2", "y2", "z2")
CRUMP = {"time_s": 150.0, "amplitude_mm": 1.0, "decay_s": 0.6, "frequency_hz": 5.0}


def of(position: np.ndarray, step_mm: float = 1e-5) -> Recording:
    coordinates = dict(zip(NAMES, np.float64(np.float32(position.reshape(6, -1))), strict=True))
    return Recording(coordinates, ("A", "B"), [(1, 2)], RATE, step_mm, "float32")


def white(n: int = 24_000, seed: int = 1) -> np.ndarray:
    position = np.random.default_rng(seed).normal(0, 0.01, (6, n))
    position[0] += 160
    return position


def page(recording: Recording):
    found = diagnose(recording, [], None)
    return diagnosis_figure(recording, found, Texts("R: diagnosis", "Source: twin.")), found


def axes_of(picture, title: str):
    """The panel whose title begins so."""
    return next(a for a in picture.figure.axes if a.get_title(loc="left")[4:].startswith(title))


def read(path) -> list[dict[str, str]]:
    return list(csv.DictReader(path.read_text(encoding="utf-8").splitlines()))


def test_files_and_page_of_a_twin_with_a_shock_and_a_line(tmp_path) -> None:
    """As simulated: a shock at 150 s, and 14.4 Hz in z."""
    published = {"published": {"camera_type": "T40", "n_cameras": 10}, "seed": 9, "crump": CRUMP}
    recording = of(simulate(twin_from_mapping(published, "T40-10"), 420.0).position_mm)
    noise = []
    for name in ("x1", "z1"):
        series = recording.coordinates[name]
        noise += rows(name, likelihood(series, RATE).estimate)
    found = diagnose(recording, noise, None)
    findings = findings_of(recording, found, noise)
    said = sentences(recording, found, noise, DiagnosisSettings())
    write_diagnosis(tmp_path, "r", "twin", recording, found, findings, said)
    (event,) = read(tmp_path / "events.csv")
    assert float(event["time_s"]) == pytest.approx(150.0, abs=0.1)
    assert (event["event"], event["markers"], event["word"]) == ("1", "A;B", "happened once")
    side = found.events[0].most_changed
    assert (event["side_series"], float(event["ratio"])) == (side.series, side.ratio)
    assert float(event["ratio_lower"]) < 1 < float(event["ratio_upper"])
    lines = {row["series"]: row for row in read(tmp_path / "periodic.csv")}
    numbers = [float(lines["z1"][f]) for f in ("f_hz", "alias_below_hz", "alias_above_hz")]
    assert numbers == pytest.approx([14.4, 105.6, 134.4], abs=0.01)
    filters = read(tmp_path / "filters.csv")
    assert {"none", "Butterworth 6 Hz", "Butterworth 10 Hz", "notch 14.4 Hz"} <= {
        row["filter"] for row in filters if row["series"] == "z1"
    }
    for row in filters:  # by the model without the shock, and as measured
        before, after = float(row["measured_sigma_before_mm"]), float(row["measured_sigma_mm"])
        assert float(row["predicted_sigma_mm"]) == pytest.approx(after, rel=0.05)
        assert float(row["measured_share_left"]) == pytest.approx((after / before) ** 2)
        assert (after == before) == (row["filter"] == "none")
    document = json.loads((tmp_path / "diagnosis.json").read_text())
    told = {f["code"]: f for f in document["findings"] if f["series"] == "z1"}
    assert told["line"]["lower_95"] < 14.4 < told["line"]["upper_95"]
    assert document["source"] == "twin" and len(document["sentences"]) == len(said)
    picture = diagnosis_figure(recording, found, Texts("R", "S", "Remark."))
    assert {"curve: by the noise model", "as recorded", "notch 14.4 Hz"} <= set(every_text(picture))
    check_saved(picture, tmp_path / "page")


def test_without_an_event_the_most_unusual_window_is_framed() -> None:
    picture, found = page(of(white()))
    surest = max((d.x.max(), k) for k, every in found.dynamics.items() for d in every)[1]
    view = view_of(found, None)
    assert (view.series, view.kind) == (surest, "window")
    above = axes_of(picture, f"Dynamic Allan deviation of {surest}")
    ((left, width),) = [
        (path.vertices[:, 0].min(), np.ptp(path.vertices[:, 0]))
        for collection in above.collections
        for path in collection.get_paths()
    ]
    assert [left * 60, width * 60] == pytest.approx([view.first_s, view.last_s - view.first_s])
    texts = every_text(picture)
    assert any(text.startswith("no event in") for text in texts)
    assert axes_of(picture, f"Spectrum of {surest}") and "this window" in texts
    chance = min(found.n_windows * np.exp(-max(d.x.max() for d in found.dynamics[surest])), 1.0)
    assert view.chance == pytest.approx(chance)
    sides = {side.series: side for side in halves(found, 200.0)}
    first, second = np.split(found.quiet["y1"], 2)
    assert sides["y1"].ratio == pytest.approx(second.std() / first.std(), rel=5e-3)
    assert 0.9 < sides["y1"].lower < 1 < sides["y1"].upper < 1.1


def test_a_broad_resonance_of_the_series_is_beside_its_spectrum() -> None:
    one = of(white())
    found = diagnose(one, [], None)
    spectra = {name: welch(values, RATE) for name, values in one.coordinates.items()}
    spectra = {k: {"f_hz": v.f_hz, "psd_mm2_hz": v.psd} for k, v in spectra.items()}
    for seen in ([], list(one.coordinates)):
        at = [Resonance(name, 4.5, 0.1, 0.01) for name in seen]
        found = replace(found, spectra=spectra, lines=[], resonances=at)
        panel = axes_of(diagnosis_figure(one, found, Texts("R")), "Spectrum of ")
        assert ("4.5 Hz" in panel.get_title(loc="right")) == bool(seen)
