"""The page of a diagnosis: with and without events, lines, models; short, constant, odd names."""

from __future__ import annotations

import numpy as np
import pytest
from figure_data import check_saved, every_text

from mocap_metrology.noise.diagnosis.levels import Sides
from mocap_metrology.noise.diagnosis.recording import DiagnosisSettings, Recording, diagnose
from mocap_metrology.noise.fit.spectral.welch import welch
from mocap_metrology.present.diagnosis.diagnosis_figure import diagnosis_figure
from mocap_metrology.present.diagnosis.spectra import (
    FILTER_LOOKS,
    ROUNDING,
    _size,
    broad_peak,
)
from mocap_metrology.present.diagnosis.time import moment, view_of
from mocap_metrology.present.plot.decimate import log_bins
from mocap_metrology.present.plot.figure import LOOKS
from mocap_metrology.present.text.diagnosis import sentences

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
    assert any("Most unusual window" in text for text in texts)
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
    size = f"{1000 * event.size_mm:.0f} µm in {event.largest}, happened once"  # as the axis has it
    assert size in texts
    assert f"{', '.join(f'{a}{event.largest[1]}' for a in 'xyz')} (µm)" in texts
    assert any(t.startswith("Time (s) from 88.") for t in texts)
    assert "noise alike" in texts and "alike" in texts
    line = next(x.line for x in found.lines if x.series == "z1")
    assert abs(line.A_s - 0.004) < 0.0005
    assert f"14.4 Hz: {1000 * line.A_s:.2g} µm" in texts
    assert "(a) Dynamic Allan deviation of " + event.largest in texts
    check_saved(figure, tmp_path)


def axes_of(figure, title):
    """The panel whose title begins so."""
    return next(a for a in figure.figure.axes if a.get_title(loc="left")[4:].startswith(title))


def test_the_map_is_of_the_series_of_the_window_and_frames_it():
    figure, found = page(recording())
    surest = max((d.x.max(), k) for k, own in found.dynamics.items() for d in own)[1]
    view = view_of(found, None)
    assert view.series == surest
    above = axes_of(figure, f"Dynamic Allan deviation of {surest}")
    (frame,) = (p for p in above.patches if p.get_fill() is False or p.get_facecolor()[3] == 0)
    assert frame.get_x() * 60 == pytest.approx(view.first_s)  # the axis is in minutes
    assert frame.get_width() * 60 == pytest.approx(view.last_s - view.first_s)
    assert axes_of(figure, f"Spectrum of {surest}") and "this window" in every_text(figure)


def test_of_seconds_it_says_what_is_seen_and_not_how_likely():
    """Of a recording too short to decide on events: the range within the window."""
    one = recording(660)
    figure, found = page(one)
    view = view_of(found, None)
    first, last = round(view.first_s * RATE), round(view.last_s * RATE)
    ranges = {k: float(np.ptp(found.quiet[k][first:last])) for k in view.names}
    most = max(ranges, key=ranges.get)
    texts = every_text(figure)
    assert "too short to decide on events" in texts
    assert f"{most} spans {1000 * ranges[most]:.1f} µm" in texts
    assert not any("chance" in t for t in texts)


def test_wide_intervals_do_not_say_alike():
    rng = np.random.default_rng(3)
    one = recording(1200)
    for values in one.coordinates.values():  # the noise comes and goes
        values[:] = 0.02 * np.repeat(rng.lognormal(0, 1, 10), 120) * rng.normal(size=1200)
    one.coordinates["x1"][:] += 160
    figure, _ = page(one)
    texts = every_text(figure)
    assert "alike" not in texts
    assert any(t.endswith("undecided") for t in texts)


@pytest.mark.parametrize(
    ("lower", "upper", "word"),
    [
        *((0.98, 1.02, "alike"), (0.7, 1.4, "alike"), (0.1, 5.0, "undecided")),
        *((0.9, 1.6, "undecided"), (1.1, 5.0, "changed"), (0.2, 0.9, "changed")),
    ],
)
def test_what_a_ratio_tells(lower, upper, word):
    assert Sides("x1", 1, 1, 1, 1, (lower * upper) ** 0.5, lower, upper).word == word


@pytest.mark.parametrize(("step_mm", "drawn"), [(1e-5, 0), (1e-3, 1)])
def test_rounding_is_in_the_key_if_it_is_drawn(step_mm, drawn):
    one = recording()
    one = Recording(one.coordinates, one.labels, one.pairs, RATE, step_mm, "float32")
    figure, _ = page(one)
    dotted = [
        line
        for title in ("Spectrum", "Allan deviation")
        for line in axes_of(figure, f"{title} of ").lines
        if line.get_linestyle() == ROUNDING["ls"] and line.get_color() == ROUNDING["color"]
    ]
    assert bool(dotted) == bool(drawn)
    assert every_text(figure).count("rounding of the file") == drawn


def test_filters_look_like_no_coordinate_and_the_same_in_key_and_panel():
    assert not {f["color"] for f in FILTER_LOOKS} & {look.colour for look in LOOKS.values()}
    figure, found = page(recording())  # without a model: points joined
    assert not any(f.predicted for f in found.filtered)
    panel = axes_of(figure, "Allan deviation of ")
    (legend,) = figure.body.legends
    for look in FILTER_LOOKS[1:3]:
        dashes = [
            {line.get_linestyle() for line in lines if line.get_color() == look["color"]}
            for lines in (panel.lines, legend.get_lines())
        ]
        assert dashes[0] == dashes[1] == {"--"}


@pytest.mark.parametrize(
    ("mm", "text"), [(0.0036, "3.6 µm"), (0.123, "0.12 mm"), (1.97, "2 mm"), (2345.0, "2.3 m")]
)
def test_sizes_of_lines(mm, text):
    assert _size(mm) == text


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(98.49, "98.5 s"), (298.5, "4 min 58.5 s"), (16198.5, "4 h 29 min 58.5 s")],
)
def test_moments(seconds, text):
    assert moment(seconds) == text


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
    assert len(figure.figure.axes) == 2
    texts = " ".join(every_text(figure))
    assert "Events cannot be detected" in texts
    assert "windows" not in texts
    check_saved(figure, tmp_path)


def test_a_recording_that_never_changes_has_words_in_place_of_axes(tmp_path):
    one = recording(2400)
    for values in one.coordinates.values():
        values[:] = 5.0
    figure, found = page(one)
    words = " ".join(f.words for f in sentences(one, found, [], DiagnosisSettings()))
    assert "inf" not in words
    assert "nan" not in words
    texts = every_text(figure)
    assert "no spectrum" in texts
    assert "no Allan deviation" in texts
    check_saved(figure, tmp_path)


@pytest.mark.parametrize(("width_hz", "shown"), [(0.6, True), (1e9, False)])
def test_a_broad_peak_of_a_short_recording_is_undecided(width_hz, shown):
    """White noise, and as much again in a band about 4.5 Hz: too wide for a spectral line."""
    rng, n = np.random.default_rng(5), 1200
    f = np.fft.rfftfreq(n, 1 / RATE)
    gain = np.sqrt(1 + 60 * np.exp(-(((f - 4.5) / width_hz) ** 2)))
    one = recording(n)
    for values in one.coordinates.values():
        noise = np.fft.irfft(np.fft.rfft(0.01 * rng.normal(size=n)) * gain, n)
        values[:] = np.mean(values) + noise
    spectra = {name: welch(values, RATE) for name, values in one.coordinates.items()}
    psd = {
        "series": np.repeat(NAMES, spectra["x1"].f_hz.size),
        "f_hz": np.concatenate([own.f_hz for own in spectra.values()]),
        "psd_mm2_hz": np.concatenate([own.psd for own in spectra.values()]),
    }
    found = diagnose(one, [], psd)
    figure = diagnosis_figure(one, found, "R: diagnosis")
    name = axes_of(figure, "Spectrum of ").get_title(loc="left").split()[3]
    peak = broad_peak(log_bins(spectra[name].f_hz, spectra[name].psd, 40))
    assert (peak is not None) == shown
    if peak is not None:
        assert abs(peak - 4.5) < 1
    remark = axes_of(figure, "Spectrum of ").get_title(loc="right")
    undecided = shown and not any(line.series == name for line in found.lines)
    assert ("10 s cannot decide" in remark) == undecided
