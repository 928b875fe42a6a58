"""The page of a diagnosis: with and without events, lines, models; short, constant, odd names."""

from __future__ import annotations

import numpy as np
import pytest
from figure_data import check_saved, every_text

from mocap_metrology.noise.diagnosis.findings import findings
from mocap_metrology.noise.diagnosis.recording import Recording, diagnose
from mocap_metrology.noise.diagnosis.settings import DiagnosisSettings
from mocap_metrology.present.diagnosis.figure import diagnosis_figure

pytestmark = pytest.mark.filterwarnings("error")
RATE = 120.0
NAMES = ("x1", "y1", "z1", "x2", "y2", "z2")


def recording(n=24_000, seed=1):
    rng = np.random.default_rng(seed)
    position = rng.normal(0, 0.01, (6, n)) + np.array([[160], [0], [0], [0], [0], [0]])
    return Recording(
        dict(zip(NAMES, position, strict=True)), ("A", "B"), [(1, 2)], RATE, 1e-5, "float32"
    )


def page(one):
    found = diagnose(one, [], None)
    return diagnosis_figure(one, found, "R: diagnosis", "Source: twin."), found


def test_a_quiet_recording(tmp_path):
    figure, _ = page(recording())
    texts = every_text(figure)
    assert any(text.startswith("no event in") for text in texts)
    assert "Most unusual window" in texts
    check_saved(figure, tmp_path)


def test_an_event_and_a_line_are_marked_with_their_numbers(tmp_path):
    one = recording()
    t = np.arange(24_000) / RATE
    late = np.maximum(t - 90, 0)
    for values in one.coordinates.values():
        values += 0.7 * np.exp(-late) * np.sin(2 * np.pi * 4 * late)
    one.coordinates["z1"][:] += 0.004 * np.sin(2 * np.pi * 14.4 * t)
    figure, found = page(one)
    texts = every_text(figure)
    (event,) = found.events
    assert any(text.startswith("1 event in") for text in texts)
    assert any(f"{event.size_mm:.3f} mm, one of a kind" in text for text in texts)
    line = next(x.line for x in found.lines if x.series == "z1")
    assert abs(line.A_s - 0.004) < 0.0005
    assert f"14.4 Hz: {1000 * line.A_s:.2g} µm" in texts
    assert "Dynamic Allan deviation of " + event.largest in texts
    check_saved(figure, tmp_path)


@pytest.mark.parametrize("n", [17, 130, 700])
def test_short_and_missing(n, tmp_path):
    one = recording(n)
    for name in NAMES[3:]:
        one.coordinates[name][:] = np.nan
    one.coordinates["x1"][:] = 5.0
    figure, _ = page(one)
    check_saved(figure, tmp_path)


def test_a_recording_of_seconds_has_no_empty_panel(tmp_path):
    """Four seconds have no windows and no halves to compare: the spectrum and the deviation are
    left, the page says why."""
    figure, found = page(recording(480))
    assert not any(found.dynamics.values())
    assert len(figure.axes) == 3  # two panels and the key
    texts = " ".join(every_text(figure))
    assert "Events could not be looked for" in texts
    assert "windows" not in texts
    check_saved(figure, tmp_path)


def test_a_recording_that_never_changes_has_words_in_place_of_axes(tmp_path):
    one = recording(2400)
    for values in one.coordinates.values():
        values[:] = 5.0
    figure, found = page(one)
    words = " ".join(f.words for f in findings(one, found, [], DiagnosisSettings()))
    assert "inf" not in words
    assert "nan" not in words
    texts = every_text(figure)
    assert "no spectrum" in texts
    assert "no Allan deviation" in texts
    check_saved(figure, tmp_path)
