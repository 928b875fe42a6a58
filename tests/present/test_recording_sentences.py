"""Every sentence of a diagnosis with its numbers."""

import math
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mocap_metrology.noise.diagnosis.events import Event
from mocap_metrology.noise.diagnosis.export import LowPass, Resolution
from mocap_metrology.noise.diagnosis.filtering import Filter, Filtered, Left
from mocap_metrology.noise.diagnosis.levels import Sides, Trend
from mocap_metrology.noise.diagnosis.outliers import Tails
from mocap_metrology.noise.diagnosis.periodic import Found, Mains
from mocap_metrology.noise.diagnosis.records import Diagnosis, DiagnosisSettings, Recording
from mocap_metrology.noise.diagnosis.repeats import Repeats
from mocap_metrology.noise.diagnosis.resonance import Resonance
from mocap_metrology.noise.diagnosis.signatures import Wander
from mocap_metrology.noise.diagnosis.software import Processed
from mocap_metrology.noise.fit.spectral.lines import Line
from mocap_metrology.noise.gaussian.two_markers import Drift
from mocap_metrology.noise.motion.movement import Movement
from mocap_metrology.present.text import sentence
from mocap_metrology.present.text.diagnosis import line_words, outcome, sentences
from mocap_metrology.present.text.movement import movement_words

NAMES = ("x1", "y1", "z1", "x2", "y2", "z2")
NONE = np.zeros(0, int)
# 15 minutes of two markers at 100 Hz in which nothing was found
RECORDING = Recording(
    dict.fromkeys(NAMES, np.zeros(90_000)), ("A", "B"), [(1, 2)], 100.0, 1e-5, "float32"
)
QUIET = Diagnosis(
    [], [], [], [], dict.fromkeys(NAMES, NONE), {"A": 0.0, "B": 0.0}, {},
    dict.fromkeys((*NAMES, "L"), Movement(0.0)), {}, {}, 45_332, {}, {}, [], [], [], [], {}, {}, [],
    {}, [],
)  # fmt: skip
SIDE = Sides("x1", 0.02, 0.03, 0.01, 0.012, 1.2, 1.1, 1.3)
SIDES = {
    "changed": (SIDE,),
    "alike": (replace(SIDE, ratio=1.01, lower=0.98, upper=1.02),),
    "undecided": (replace(SIDE, ratio=1.01, lower=0.5, upper=2.0),),
}
EVENT = Event(98.49, 1.5, "burst", ("x1", "y2"), "y2", 0.771, 0.0, 1e-6, 9.0, 0.1, of=3)
LINE = Found(
    *("x1", Line(0.01, 20.0, 0.0, 1e-5, 30.0), 0.0, 0.02, 1e-4, None, None, 9.0, None, 0.02),
    *(math.nan, None),
)
MOVED = (-0.05, 0.001, 0.06)  # net, its error, range of a wander


def of(seconds: float, **more: Any) -> Recording:
    coordinates = dict.fromkeys(NAMES, np.zeros(round(100 * seconds)))
    return replace(RECORDING, coordinates=coordinates, **more)


def wander(kind: str, size: float = 0.06, *at_s: float) -> dict[str, Any]:
    kinds = (kind,) if kind else ()
    jumps = {"step": [(t, size) for t in at_s], "shift": [*zip(at_s, (size, -size), strict=False)]}
    one = Wander(
        kinds, "", kinds or ("cycle", "drift"), *MOVED, size, at_s, tuple(jumps.get(kind, ()))
    )
    return {"wanders": {"x1": one, "L": replace(one, size_mm=9.0, range_mm=9.0)}}


def row(series: str, parameter: str, value: float, status: str = "ok", note: str = "") -> Any:
    return {
        "series": series, "estimator": "likelihood", "model": "sampled", "parameter": parameter,
        "value": value, "status": status, "std_error": 0.0, "lower_95": 0.9 * value,
        "upper_95": 1.1 * value, "note": note,
    }  # fmt: skip


def left(sigma: float, at_1s: float) -> Left:
    return Left(sigma, (1.0, 1.0, at_1s, 1.0), 0.5 * sigma, 1.0, (NONE, NONE))


FILTERS = [
    Filtered(name, Filter(text, sos), 9, None, left(sigma, at_1s))
    for name, text, sos, sigma, at_1s in (
        ("x1", "none", None, 1.0, 1.0), ("x1", "F", np.ones(6), 0.2, 0.5),
        ("y1", "none", None, 2.0, math.nan), ("y1", "F", np.ones(6), 0.6, math.nan),
        ("z1", "none", None, 0.0, 1.0), ("z1", "F", np.ones(6), 0.0, 1.0),
    )
]  # fmt: skip
DRIFTS = {"x1": Drift(-1.2, 0.4, 9.0), "y1": Drift(0.3, 0.1, 9.0), "L": Drift(math.nan, 5.0, 9.0)}
STEP = Resolution("x1", 0.01, "text", 0.003, 1e-7, 0.03, 0.00926)
SAID = [
    # What is found, or the recording, or rows of noise.csv; the template, whether it warns, words
    ({"n_windows": 0}, "event.undetectable", False, "Events cannot be detected: the recording is "
     "too short, or its steps are too coarse."),
    (of(21.0), "event.short", False, "Too short to decide on events: 21 s with 45 332 windows of "
     "the dynamic Allan variance; both sides of an event together need at least 22 s."),
    ({}, "event.none", False, "No event in 15 min: none of 45 332 windows of the dynamic Allan "
     "variance departs from the noise by more than it would by chance in 1 % of undisturbed "
     "recordings."),
    ({"events": [EVENT] * 11}, "event.many", True, "11 events in 15 min; the 10 most important are "
     "listed. The recording was disturbed."),
    ({"events": [EVENT]}, "event.one", True, "At 98.5 s A, B moved by up to 0.771 mm (y2) for 1.5 "
     "s; too few samples remain on one side to compare the noise before and after."),
    ({"events": [replace(EVENT, kind="level", series=("L",), sides=SIDES["changed"])]},
     "event.one", True, "At 98.5 s the noise level of L changed; noise changed: sd of x1 10 µm "
     "before, 12 µm after, ratio 1.200 (1.100 to 1.300)."),
    ({"events": [replace(EVENT, series=("L",), sides=SIDES["alike"])]}, "event.one", True, "At "
     "98.5 s L moved by up to 0.771 mm (y2) for 1.5 s; noise is the same before and after: sd of "
     "x1 10 µm before, 12 µm after, ratio 1.010 (0.980 to 1.020)."),
    ({"events": [replace(EVENT, sides=SIDES["undecided"])], **wander("step", -0.05, 98.0)},
     "event.shift", True, "At 98.5 s A, B shifted by 50 µm (x1) and stayed there; undecided "
     "whether the noise changed: sd of x1 10 µm before, 12 µm after, ratio 1.010 (0.500 to "
     "2.000)."),
    ({"events": [EVENT], **wander("shift", 0.05, 98.0, 118.0)}, "event.shift", True, "At 98.5 s A, "
     "B shifted by 50 µm (x1) and came back within 20 s; too few samples remain on one side to "
     "compare the noise before and after."),
    ({"events": [EVENT], **wander("shift", 0.05, 48.0, 98.0)}, "event.shift", True, "At 98.5 s A, "
     "B shifted back by 50 µm (x1); too few samples remain on one side to compare the noise before "
     "and after."),
    ({"recurring": {"x1": 12.345, "L": 12.3}}, "recurring.bursts", True, "Bursts recur every 12.3 "
     "s in x1, L."),
    ({}, "periodic.none", False, "No periodic disturbance was detected in any series."),
    ({"lines": [replace(LINE, line=replace(LINE.line, f_0=k)) for k in range(1, 12)]},
     "periodic.many", False, "11 periodic disturbances; the 10 most important are listed."),
    ({"lines": [replace(LINE, share=0.0312, in_adev=True), replace(LINE, series="y1",
      line=replace(LINE.line, A_s=0.004))]}, "periodic.one", True, "Periodic disturbance at 20 Hz, "
     "amplitude: x1 10 µm, y1 4 µm; seen in the periodogram and in the ADEV; it contributes 3.12 % "
     "of the Allan variance of x1 at 0.02 s."),
    ([row("x1", "h_0", 1.0, "misfit"), row("L", "h_0", 1.0, "misfit")], "misfit.misfit", True,
     "No noise model describes the spectrum of x1, L; the noise left by filters is therefore "
     "measured, not predicted."),
    ([row("x1", "h_0", 1.0, "refused", "too short"), row("y1", "h_0", 1.0, "refused", "gaps")],
     "misfit.refused", True, "No noise model of x1, y1: too short."),
    ([row("x1", "A_w", 0.22), row("x1", "T_w", 360.0), row("y1", "A_w", -0.1),
      row("y1", "T_w", 360.0)], "warm_up.model", True, "Still warming up: 0.202 mm in the first "
     "15 min (x1), time constant 6 min: start recording later."),
    ([row("x1", "drift", 0.5), row("y1", "drift", -1.2)], "drift.model", False, "A steady drift of "
     "−1.2 mm/h (y1), 0.3 mm in total."),
    ({"drifts": DRIFTS, **wander("cycle", 0.03, 200.0)}, "drift.slow", False, "Slow movement: "
     "means over 9 s wander by up to 0.4 mm (x1) in 15 min; the slope of a straight line through "
     "them is −1.2 mm/h. From its first tenth to its last it moved by −50 µm +- 1.96 µm."),
    (wander("warm_up"), "wander.warm_up", True, "x1 approaches a position: it moved by 50 µm in "
     "15 min, ever more slowly."),
    (wander("accelerating"), "wander.accelerating", True, "x1 moved by 50 µm in 15 min, ever "
     "faster: check that the marker and the cameras are mounted firmly."),
    (wander("slowing"), "wander.slowing", True, "x1 moved by 50 µm in 15 min, ever more slowly."),
    (wander("creep"), "wander.creep", True, "x1 creeps: it moved by 50 µm in 15 min, ever more "
     "slowly."),
    (wander("cycle", -0.03, 200.0), "wander.cycle", True, "x1 goes to and fro with a period of "
     "3.33 min, amplitude 30 µm."),
    (wander("step", -0.03, 200.0), "wander.step", True, "At 3 min 20.0 s x1 shifted by 30 µm and "
     "stayed there."),
    (wander("shift", 0.03, 200.0, 240.0), "wander.shift", True, "At 3 min 20.0 s x1 shifted by "
     "30 µm, and came back within 40 s."),
    (wander("levels", 0.03, 50.0), "wander.levels", True, "x1 switches between several positions "
     "up to 30 µm apart, every 50 s on average: cameras may gain and lose the marker."),
    ({"resonances": [Resonance(k, 6.0, 0.03, 0.03) for k in ("x1", "x2")]}, "resonance.broad",
     True, "Broad resonance at 6 Hz, damping ratio 0.03: x1 30 µm, x2 30 µm rms, in all markers: a "
     "floor, a tripod or a mount that vibrates."),
    (wander("two_levels", 0.03, 50.0), "wander.two_levels", True, "x1 switches between two "
     "positions 30 µm apart, every 50 s on average: a camera may gain and lose the marker."),
    (wander(""), "wander.undecided", True, "Slow wander of 60 µm in 15 min (x1); its kind cannot "
     "be decided from this recording, one of an hour may show it."),
    ({"low_pass": [LowPass("x1", 5.0, 0.1), LowPass("y1", 8.0, 0.1)]}, "low_pass.filtered", True,
     "x1, y1 appear to be low-pass filtered at about 6.5 Hz; the noise of a frame before the "
     "filter cannot be estimated."),
    ({"processed": [Processed("smoothed", "x1", 0.1)]}, "smoothed.frames", True, "x1 has no white "
     "noise: the software smoothed them, as far as can be told. The noise of a measured frame "
     "cannot be estimated. Export unprocessed frames."),
    ({"processed": [Processed("resampled", k, 20.0) for k in ("x1", "y1")]}, "resampled.frames",
     True, "x1, y1 were interpolated to another frame rate: the variance of their frames varies "
     "with 20 Hz, so they were measured at 80 or 20 Hz. Export unprocessed frames."),
    ({"processed": [Processed("running_median", "x1", 0.4)]}, "running_median.frames", True, "x1 "
     "are running medians: their values repeat, each coordinate's for itself. Export unprocessed "
     "frames."),
    ({"trends": [Trend("x1", -0.3, -0.4, -0.2, -0.3, 0.0), Trend("y1", -0.2, -0.4, -0.1, -0.2, 0)]},
     "level.noise", True, "Noise of x1, y1 falls by 30 % over the recording (x1; 95 %: −40 % to "
     "−20 %)."),
    ({"trends": [Trend("x1", 0.0, -0.01, 0.01, -0.2, 0.1)]}, "level.noise", True, "Noise of x1 "
     "changes over the recording, by −20 % to +10 % from its level at the start (x1)."),
    ({"tails": [Tails("x1", 0.5, 0.4, 0.6), Tails("y1", 1.54, 1.4, 1.6)]}, "tails.heavy", False,
     "Noise of x1, y1 has heavy tails: the differences of frames have an excess kurtosis of up to "
     "1.5 (y1; Gaussian noise: 0)."),
    (of(10.0, n_filled={"B": 11}), "filled.marker", True, "1.1 % of the frames of B are "
     "gap-filled: they show less noise than is possible. They are excluded as missing."),
    ({"solved": {"L": 0.001}}, "solved.distances", True, "Solved by the software: L is not "
     "measured, as its markers keep the distance that a rigid body has. Export the markers as "
     "they were reconstructed."),
    (of(60.0, exchanged=[{"labels": ["A", "B"], "n_frames": 17, "first": 100, "last": 1170}]),
     "exchanged.pair", True, "The labels of A and B are exchanged in 17 frames between 1.0 s and "
     "11.7 s: each is where the other was. They are put right here."),
    ({"repeats": [Repeats("B", 0.123, 40, 0.5)]}, "repeated.marker", True, "B repeats its position "
     "exactly in 12.3 % of the frames, for up to 0.4 s, and then jumps by 0.5 mm: it was filtered "
     "or gap-filled before the export."),
    ({}, "gaps.marker", False, "No frame is missing."),
    ({"missing": {"A": 0.001, "B": 0.02}}, "gaps.marker", True, "Marker B is missing in 2 % of the "
     "frames."),
    ({}, "outliers.count", False, "No isolated frames deviate by more than 6 standard deviations."),
    ({"spikes": {"x1": NONE, "y1": np.arange(100)}}, "outliers.count", True, "100 isolated frames "
     "deviate by more than 6 standard deviations, 400 an hour, most in y1 (100)."),
    ({"resolutions": [STEP, replace(STEP, series="y1", share=0.001)]}, "resolution.steps", False,
     "Resolution: the steps of the file are 10 µm (text). They contribute at most 0.926 % of the "
     "Allan variance at one frame (x1), which is negligible; an export in steps of 0.01 mm would "
     "contribute 0.926 %."),
    ({"resolutions": [replace(STEP, share=0.1, noise_mm=0.0012)]}, "resolution.steps", True,
     "Resolution: the steps of the file are 10 µm (text). They contribute at most 10 % of the "
     "Allan variance at one frame (x1), which is visible in the white level; an export in steps of "
     "0.01 mm would add 5.8 times that variance."),
    ({"resolutions": [replace(STEP, share=0.5, noise_mm=0.0)]}, "resolution.steps", True,
     "Resolution: the steps of the file are 10 µm (text). They contribute at most 50 % of the "
     "Allan variance at one frame (x1), so the resolution of the export limits the result: export "
     "with finer steps; an export in steps of 0.01 mm would hide all of it."),
    ({"filtered": FILTERS}, "filter.left", False, "F leaves 4 % to 9 % of the variance of a frame "
     "and 50 % of the Allan deviation at 1 s."),
    ({"movements": QUIET.movements | {"x2": Movement(5.0, 4.9, 5.1, 450.0)}}, "moving.markers",
     True, "Marker B seems to move: shifts by 5 mm along x at 450 s, which noise does not explain; "
     "the Allan variance assumes stationary markers."),
]  # fmt: skip


def told(given: Any) -> list[sentence.Sentence]:
    recording, changes, noise = RECORDING, {}, []
    for one in given if isinstance(given, tuple) else (given,):
        recording = one if isinstance(one, Recording) else recording
        changes = one if isinstance(one, dict) else changes
        noise = one if isinstance(one, list) else noise
    return sentences(recording, replace(QUIET, **changes), noise, DiagnosisSettings())


@pytest.mark.parametrize(("given", "key", "warns", "words"), SAID)
def test_what_is_found_in_words(given, key, warns, words) -> None:
    said = {s.words: s.severity for s in told(given) if key.startswith((s.kind, "event.shift"))}
    words = words.replace("45 332", "45\N{NARROW NO-BREAK SPACE}332")
    assert said[words] == ("warning" if warns else "info")


def test_every_template_has_its_words_here() -> None:
    path = Path(sentence.__file__).with_name("recording.toml")
    texts = tomllib.loads(path.read_text(encoding="utf-8"))
    elsewhere = {"check", "limit", "quantity", "measured", "verdict", "bar", "points", "receiver"}
    keys = {f"{kind}.{case}" for kind in set(texts) - elsewhere for case in texts[kind]}
    assert keys == {key for _, key, _, _ in SAID} | {"periodic.seen"}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({}, ""),
        ({"in_psd": True}, " and in the PSD"),
        ({"in_psd": True, "in_adev": True, "harmonic": (3, 7.0)}, ", in the PSD and in the ADEV; "
         "harmonic 3 of 7 Hz"),
        ({"mains": Mains(100.0, 50.0, 120.0)}, "; could be 100 Hz of 50 Hz mains, folded at "
         "120 Hz"),
        ({"mains": Mains(50.0, 50.0)}, "; could be 50 Hz of 50 Hz mains"),
        ({"amplitude": (0.01, 0.02)}, "; its amplitude changes between 10 µm and 20 µm"),
        ({"line": replace(LINE.line, width_f=0.042, band_hz=(19.0, 21.0))}, "; its frequency or "
         "its amplitude varies: it fills a band of 0.042 Hz"),
    ],
)  # fmt: skip
def test_where_a_line_shows(change, words) -> None:
    assert line_words(replace(LINE, **change)) == f"seen in the periodogram{words}"


def test_what_is_left_of_an_event() -> None:
    alike, changed = SIDES["alike"], SIDES["changed"]
    assert outcome(EVENT) == "unknown"
    assert outcome(replace(EVENT, sides=alike)) == "one of 3"
    assert outcome(replace(EVENT, sides=alike, of=1)) == "happened once"
    assert outcome(replace(EVENT, sides=alike + changed)) == "level changed"


def test_warnings_come_first_and_of_walkers_only_the_movement() -> None:
    said = told({"missing": {"A": 0.5, "B": 0.0}, "events": [EVENT], "solved": {"L": 0.1}})
    assert [s.severity for s in said] == sorted((s.severity for s in said), reverse=True)
    assert all(s.words.endswith(".") and "nan" not in s.words for s in said)
    walks = QUIET.movements | {name: Movement(2000.0) for name in ("x1", "x2")}
    assert [s.kind for s in told({"movements": walks, "events": [EVENT]})] == ["moving", "gaps"]


def test_the_most_important_events_are_named() -> None:
    """Two examples of those that recur; a small change of the level alone comes last."""
    small = replace(EVENT, kind="level", size_mm=math.nan, sides=SIDES["changed"])
    small = replace(small, sides=(replace(SIDE, ratio=1.05, lower=1.01),))
    sizes = [small, *(replace(EVENT, size_mm=float(k)) for k in range(1, 4))]
    said = [s for s in told({"events": sizes}) if s.kind == "event"]
    assert [s.numbers["size_mm"] for s in said[:3]] == [3.0, 2.0, 1.0]
    assert (len(said), said[3].severity) == (4, "info")
    recurring = told({"events": sizes, "recurring": {"x1": 5.0}})
    assert [s.kind for s in recurring if s.kind in ("recurring", "event")] == [
        *("recurring", "event", "event")
    ]


@pytest.mark.parametrize(
    ("at_s", "event", "wanders"),
    [  # EVENT lasts from 98.49 to 99.99 s
        ((93.5,), "shifted", False), ((93.4,), "moved", True), ((104.9,), "shifted", False),
        ((105.0,), "moved", True), ((98.0, 108.1), "shifted", False),
        ((98.0, 107.9), "moved", False), ((48.0, 104.9), "shifted back", True),
        ((48.0, 105.1), "moved", True),
    ],
)  # fmt: skip
def test_a_step_or_shift_that_is_an_event_is_said_once(at_s, event, wanders) -> None:
    """Within 5 s; a shift of less than 10 s is movement. An event at its begin states it."""
    kind = "step" if len(at_s) == 1 else "shift"
    said = told({"events": [EVENT], **wander(kind, 0.05, *at_s)})
    (words,) = (one.words for one in said if one.kind == "event")
    assert words.startswith(f"At 98.5 s A, B {event}")
    assert any(one.kind == "wander" for one in said) == wanders


def test_wander_that_the_noise_model_states_is_said_once() -> None:
    both = {name: Wander((kind,), "", (kind,), *MOVED, 0.06)
            for name, kind in (("x1", "drift"), ("y1", "warm_up"))}  # fmt: skip
    warm = [row("y1", "A_w", 0.2), row("y1", "T_w", 60.0)]
    for noise, kinds in ((warm, {"warm_up"}), ([], {"wander"}), ([row("x1", "drift", 1.0)], None)):
        said = {one.kind for one in told(({"wanders": both}, noise))}
        assert said & {"wander", "warm_up", "drift"} == (kinds or {"wander", "drift"})
    unexplained = {"x1": Wander(("step",), "", ("step",), *MOVED, 0.06, (9.0,))}
    assert "drift" not in {
        one.kind for one in told(({"wanders": unexplained}, [row("x1", "drift", 1.0)]))
    }


def test_markers_that_move_are_one_line() -> None:
    assert movement_words({}, 100.0) == []
    sizes = {"A": 2360.0, "B": 2380.0, "C": 2340.0}
    walking = {name: ("x", Movement(mm)) for name, mm in sizes.items()}
    first = "marker A seems to move, and so do B and C: B moves by 2.38 m along x within 1.7 s, "
    tail = "which noise does not explain; the Allan variance assumes stationary markers"
    assert movement_words(walking, 1.7) == [first + tail]
    many = {f"M{k}": ("x", Movement(3.0)) for k in range(9)}
    assert ", and so do 8 others: M0 moves by" in movement_words(many, 1.7)[0]
