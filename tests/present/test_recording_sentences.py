"""Every sentence of a diagnosis with its numbers."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from said import numbers_in, templates

from mocap_metrology.noise.diagnosis.events import Event
from mocap_metrology.noise.diagnosis.export import LowPass, Resolution
from mocap_metrology.noise.diagnosis.filtering import Filter, Filtered, ResidualNoise
from mocap_metrology.noise.diagnosis.levels import Trend
from mocap_metrology.noise.diagnosis.outliers import Tails
from mocap_metrology.noise.diagnosis.periodic import Mains, SpectralLine
from mocap_metrology.noise.diagnosis.records import Diagnosis, DiagnosisSettings, Recording
from mocap_metrology.noise.diagnosis.resonance import Resonance
from mocap_metrology.noise.diagnosis.sides import Sides
from mocap_metrology.noise.diagnosis.signatures import Wander
from mocap_metrology.noise.diagnosis.software import Processed, Repeats
from mocap_metrology.noise.fit.spectral.line import Line
from mocap_metrology.noise.gaussian.two_markers import Drift
from mocap_metrology.noise.motion.movement import Movement
from mocap_metrology.present.text import sentence
from mocap_metrology.present.text.diagnosis import line_words, sentences

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
LINE = SpectralLine(
    *("x1", Line(0.01, 20.0, 0.0, 1e-5, 30.0), 0.0, 0.02, 1e-4, None, None, 9.0, None, 0.02),
    *(math.nan, None),
)
MOVED = (-0.05, 0.001, 0.06)  # net, its error, range of a wander


def of(seconds: float, **more: Any) -> Recording:
    coordinates = dict.fromkeys(NAMES, np.zeros(round(100 * seconds)))
    return replace(RECORDING, coordinates=coordinates, **more)


NAMED = {"wanders": dict.fromkeys(("x1", "y1"), Wander(("drift", "warm_up"), "", (), *MOVED))}


def wander(kind: str, size: float = 0.06, *at_s: float, **more: Any) -> dict[str, Any]:
    kinds = (kind,) if kind else ()
    jumps = {"step": [(t, size) for t in at_s], "shift": [*zip(at_s, (size, -size), strict=False)]}
    one = Wander(
        kinds, "", kinds or ("cycle", "drift"), *MOVED, size, at_s, tuple(jumps.get(kind, ()))
    )
    one = replace(one, **more)
    return {"wanders": {"x1": one, "L": replace(one, size_mm=9.0, range_mm=9.0)}}


def row(series: str, parameter: str, value: float, status: str = "ok", note: str = "") -> Any:
    return {
        "series": series, "estimator": "likelihood", "model": "sampled", "parameter": parameter,
        "value": value, "status": status, "std_error": 0.0, "lower_95": 0.9 * value,
        "upper_95": 1.1 * value, "note": note,
    }  # fmt: skip


def left(sigma: float, at_1s: float) -> ResidualNoise:
    return ResidualNoise(sigma, (1.0, 1.0, at_1s, 1.0), 0.5 * sigma, 1.0, (NONE, NONE))


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
SAID = [  # found, or the recording, or rows of noise.csv; template, whether it warns, numbers
    ({"n_windows": 0}, "event.undetectable", False, ""),
    (of(21.0), "event.short", False, "21 s, 45332, 22 s"),
    ({}, "event.none", False, "15 min, 45332, 1 %"),
    ({"events": [EVENT] * 11}, "event.many", True, "11, 15 min, 10"),
    ({"events": [EVENT]}, "event.one", True, "98.5 s, 0.771 mm, y2, 1.5 s"),
    ({"events": [replace(EVENT, kind="level", series=("L",), sides=SIDES["changed"])]}, "event.one",
     True, "98.5 s, L, x1, 10 µm, 12 µm, 1.200, 1.100, 1.300"),
    ({"events": [replace(EVENT, series=("L",), sides=SIDES["alike"])]}, "event.one", True,
     "98.5 s, L, 0.771 mm, y2, 1.5 s, x1, 10 µm, 12 µm, 1.010, 0.980, 1.020"),
    ({"events": [replace(EVENT, sides=SIDES["undecided"])], **wander("step", -0.05, 98.0)},
     "event.shift", True, "98.5 s, 50 µm, x1, x1, 10 µm, 12 µm, 1.010, 0.500, 2.000"),
    ({"events": [EVENT], **wander("shift", 0.05, 98.0, 118.0)}, "event.shift", True,
     "98.5 s, 50 µm, x1, 20 s"),
    ({"events": [EVENT], **wander("shift", 0.05, 48.0, 98.0)}, "event.shift", True,
     "98.5 s, 50 µm, x1"),
    ({"recurring": {"x1": 12.345, "L": 12.3}}, "recurring.bursts", True, "12.3 s, x1, L"),
    ({}, "periodic.none", False, ""),
    ({"lines": [replace(LINE, line=replace(LINE.line, f_0=k**1.5)) for k in range(1, 12)]},
     "periodic.many", False, "11, 10"),
    ({"lines": [replace(LINE, line=replace(LINE.line, f_0=1.3 * k)) for k in (1, 2, 3, 5)]},
     "periodic.comb", False, "4, 1.3 Hz, 6.5 Hz, x1, 14.1 µm, 0.769 s"),
    ({"lines": [replace(LINE, share=0.0312, in_adev=True), replace(LINE, series="y1",
     line=replace(LINE.line, A_s=0.004))]}, "periodic.one", True,
     "20 Hz, x1, 10 µm, y1, 4 µm, 3.12 %, x1, 0.02 s"),
    ([row("x1", "h_0", 1.0, "misfit"), row("L", "h_0", 1.0, "misfit")], "misfit.misfit", True,
     "x1, L"),
    ([row("x1", "h_0", 1.0, "refused", "too short"), row("y1", "h_0", 1.0, "refused", "gaps")],
     "misfit.refused", True, "x1, y1"),
    (([row("x1", "A_w", 0.22), row("x1", "T_w", 360.0), row("y1", "A_w", -0.1), row("y1", "T_w",
     360.0)], NAMED), "warm_up.model", True, "0.202 mm, 15 min, x1, 6 min"),
    (([row("x1", "drift", 0.5), row("y1", "drift", -1.2)], NAMED), "drift.model", False,
     "−1.2 mm/h, y1, 0.3 mm"),
    ({"drifts": DRIFTS, **wander("cycle", 0.03, 200.0)}, "drift.slow", False,
     "9 s, 0.4 mm, x1, 15 min, −1.2 mm/h, −50 µm, 3 µm, 99 %"),
    (wander("warm_up"), "wander.warm_up", True, "x1, 60 µm, 15 min"),
    (wander("accelerating"), "wander.accelerating", True, "x1, 60 µm, 15 min"),
    (wander("slowing"), "wander.slowing", True, "x1, 60 µm, 15 min"),
    (wander("creep"), "wander.creep", True, "x1, 60 µm, 15 min"),
    (wander("cycle", -0.03, 200.0), "wander.cycle", True, "x1, 3.33 min, 30 µm"),
    (wander("step", 0.03, 200.0, kinds=("drift", "step"), moved_mm=-0.05), "wander.drift", False,
     "x1, 50 µm, 15 min"),
    (wander("step", -0.03, 200.0), "wander.step", True, "3 min, 20.0 s, x1, 30 µm"),
    (wander("step", -0.03, 200.0, error_mm=0.005), "wander.step", True,
     "3 min, 20.0 s, x1, 30.0, 20.2, 39.8"),
    (wander("step", -0.03, 200.0, lost_s=30.0), "wander.step", True,
     "3 min, 20.0 s, 3 min, 50.0 s, x1, 30 µm"),
    (wander("shift", 0.03, 200.0, 240.0), "wander.shift", True, "3 min, 20.0 s, x1, 30 µm, 40 s"),
    (wander("shift", 0.03, 200.0, 240.0, jumps=((200.0, 0.03), (240.0, -0.05))), "wander.shift",
     True, "3 min, 20.0 s, x1, 30 µm, 50 µm, 40 s"),
    (wander("levels", 0.03, 50.0), "wander.levels", True, "x1, 30 µm, 50 s"),
    ({"resonances": [Resonance(k, 6.0, 0.03, 0.03) for k in ("x1", "x2")]}, "resonance.broad", True,
     "6 Hz, 0.03, x1, 30 µm, x2, 30 µm"),
    (wander("two_levels", 0.03, 50.0), "wander.two_levels", True, "x1, 30 µm, 50 s"),
    (wander(""), "wander.undecided", True, "15 min, x1, 18 s, 60 µm"),
    ({"low_pass": [LowPass("x1", 5.0, 0.1), LowPass("y1", 8.0, 0.1)]}, "low_pass.filtered", True,
     "x1, y1, 5, 8 Hz, 1.4"),
    ({"processed": [Processed("smoothed", "x1", 0.1)]}, "smoothed.frames", True, "x1"),
    ({"processed": [Processed("resampled", k, 20.0) for k in ("x1", "y1")]}, "resampled.frames",
     True, "x1, y1, 20 Hz, 80, 120, 20 Hz"),
    ({"processed": [Processed("running_median", "x1", 0.4)]}, "running_median.frames", True, "x1"),
    ({"processed": [Processed("repeated", "x1", 0.4)]}, "repeated.frames", True, "x1"),
    ({"trends": [Trend("x1", -0.3, -0.4, -0.2, -0.3, 0.0), Trend("y1", -0.2, -0.4, -0.1, -0.2, 0)]},
     "level.noise", True, "x1, y1, 30 %, x1, 95 %, −40 %, −20 %"),
    ({"trends": [Trend("x1", 0.0, -0.01, 0.01, -0.2, 0.1)]}, "level.noise", True,
     "x1, −20 %, +10 %, x1"),
    ({"trends": [Trend("x1", 0.2, 0.1, 0.3, -0.2, 0.1, 60.0)]}, "level.noise", True,
     "x1, 60 s, −20 %, +10 %, x1"),
    ({"tails": [Tails("x1", 0.5, 0.4, 0.6), Tails("y1", 1.54, 1.4, 1.6)]}, "tails.heavy", False,
     "x1, y1, 1.5, y1, 0"),
    (of(10.0, n_filled={"B": 11}), "filled.marker", True, "1.1 %"),
    ((of(10.0, n_filled={"B": 9}), {"processed": [Processed("running_median", "x1", 0.4)]}),
     "filled.smooth", False, "0.9 %"),
    ({"solved": {"L": 0.001}}, "solved.distances", True, "L"),
    (of(60.0, exchanged=[{"labels": ["A", "B"], "n_frames": 17, "first": 100, "last": 1170}]),
     "exchanged.pair", True, "17, 1.0 s, 11.7 s"),
    ({"repeats": [Repeats("B", 0.123, 40, 0.5)]}, "repeated.marker", True, "12.3 %, 0.4 s, 0.5 mm"),
    ({}, "gaps.marker", False, ""),
    ({"missing": {"A": 0.001, "B": 0.02}}, "gaps.marker", True, "2 %"),
    ({}, "outliers.count", False, "6"),
    ({"spikes": {"x1": NONE, "y1": np.arange(100)}}, "outliers.count", True,
     "100, 6, 400, y1, 100"),
    ({"resolutions": [STEP, replace(STEP, series="y1", share=0.001)]}, "resolution.steps", False,
     "10 µm, 0.926 %, x1, 0.01 mm, 0.926 %"),
    ({"resolutions": [replace(STEP, share=0.1, noise_mm=0.0012)]}, "resolution.steps", True,
     "10 µm, 10 %, x1, 0.01 mm, 5.8"),
    ({"resolutions": [replace(STEP, share=0.5, noise_mm=0.0)]}, "resolution.steps", True,
     "10 µm, 50 %, x1, 0.01 mm"),
    ({"filtered": FILTERS}, "filter.left", False, "4 %, 9 %, 50 %, 1 s"),
    ({"movements": QUIET.movements | {"x2": Movement(5.0, 4.9, 5.1, 450.0)}}, "moving.markers",
     True, "5 mm, 450 s"),
]  # fmt: skip


def told(given: Any) -> list[sentence.Sentence]:
    recording, changes, noise = RECORDING, {}, []
    for one in given if isinstance(given, tuple) else (given,):
        recording = one if isinstance(one, Recording) else recording
        changes = one if isinstance(one, dict) else changes
        noise = one if isinstance(one, list) else noise
    return sentences(recording, replace(QUIET, **changes), noise, DiagnosisSettings())


@pytest.mark.parametrize(("given", "key", "warns", "numbers"), SAID)
def test_sentence_and_numbers_of_what_is_found(given, key, warns, numbers, monkeypatch) -> None:
    keys, render = {}, sentence.render

    def noted(key: str, **values: Any) -> str:
        words = render(key, **values)
        keys[words] = key
        return words

    monkeypatch.setattr(sentence, "render", noted)
    said = {(keys[s.words], numbers_in(s.words), s.severity) for s in told(given)}
    if key == "event.shift":
        assert any(words.partition(" shifted")[1] for words in keys)
        key = "event.one"
    assert (key, numbers, "warning" if warns else "info") in said


def test_every_template_is_here() -> None:
    texts = templates()
    elsewhere = {"check", "limit", "quantity", "measured", "verdict", "bar", "points", "receiver"}
    keys = {f"{kind}.{case}" for kind in set(texts) - elsewhere for case in texts[kind]}
    assert keys == {key for _, key, _, _ in SAID} | {"moving.line", "periodic.seen", "wander.when"}


@pytest.mark.parametrize(
    ("change", "numbers"),
    [
        ({"in_psd": True, "in_adev": True, "harmonic": (3, 7.0)}, "3, 7 Hz"),
        ({"mains": Mains(100.0, 50.0, 120.0)}, "100 Hz, 50 Hz, 120 Hz"),
        ({"mains": Mains(50.0, 50.0)}, "50 Hz, 50 Hz"),
        ({"amplitude": (0.01, 0.02)}, "10 µm, 20 µm"),
        ({"line": replace(LINE.line, width_f=0.042, band_hz=(19.0, 21.0))}, "0.042 Hz"),
    ],
)
def test_what_is_said_of_a_line(change, numbers) -> None:
    assert numbers_in(line_words(replace(LINE, **change))) == numbers


def test_warnings_come_first_and_of_walkers_only_the_movement() -> None:
    said = told({"missing": {"A": 0.5, "B": 0.0}, "events": [EVENT], "solved": {"L": 0.1}})
    assert [s.severity for s in said] == sorted((s.severity for s in said), reverse=True)
    assert all(s.words.endswith(".") and "nan" not in s.words for s in said)
    walks = QUIET.movements | {name: Movement(2000.0) for name in ("x1", "x2")}
    assert [s.kind for s in told({"movements": walks, "events": [EVENT]})] == ["moving", "gaps"]


def test_a_cycle_or_recurring_bursts_are_periodic() -> None:
    """So there is no other disturbance, and not none."""
    for given in (wander("cycle", 0.03, 200.0), {"recurring": {"x1": 12.3}}):
        assert [s.words for s in told(given) if s.kind == "periodic"] == [
            "No other periodic disturbance was detected in any series."
        ]


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
        ((93.5,), "shifted", False), ((93.4,), "were measured", True), ((104.9,), "shifted", False),
        ((105.0,), "were measured", True), ((98.0, 108.1), "shifted", False),
        ((48.0, 104.9), "shifted back", True), ((48.0, 105.1), "were measured", True),
    ],
)  # fmt: skip
def test_a_step_or_shift_that_is_an_event_is_said_once(at_s, event, wanders) -> None:
    """Within 5 s. An event at the begin of a shift states it."""
    kind = "step" if len(at_s) == 1 else "shift"
    said = told({"events": [EVENT], **wander(kind, 0.05, *at_s)})
    (words,) = (one.words for one in said if one.kind == "event")
    assert words.startswith(f"At 98.5 s A, B {event}")
    assert any(one.kind == "wander" for one in said) == wanders


@pytest.mark.parametrize(
    ("possible", "how_many"), [((), "several"), (("two_levels",), "two or more")]
)
def test_several_positions_may_be_two(possible, how_many) -> None:
    """Where two explain a series, too."""
    one = replace(wander("levels", 0.05, 40.0)["wanders"]["x1"], possible=("levels", *possible))
    assert any(f"between {how_many} positions" in s.words for s in told({"wanders": {"x1": one}}))


def test_every_step_is_said_and_once() -> None:
    """That of an event, with its marker, and a later one, but not its part of the distance."""
    at = {"x1": 98.0, "y2": 300.0, "L": 300.0}
    steps = {k: wander("step", 0.05, t)["wanders"]["x1"] for k, t in at.items()}
    said = [s.words for s in told({"events": [EVENT], "wanders": steps})]
    assert sum("shifted by 50 µm (x1)" in words for words in said) == 1
    assert sum("y2 shifted" in words for words in said) == 1
    assert not any("L shifted" in words for words in said)


def test_no_net_movement_where_an_event_is_at_an_end() -> None:
    for time_s, there in ((98.49, True), (870.0, False)):
        event = replace(EVENT, time_s=time_s)
        said = told({"events": [event], "drifts": DRIFTS, **wander("cycle", 0.03, 200.0)})
        assert any("first tenth" in s.words for s in said) is there


def test_steps_are_told_at_the_times_of_events() -> None:
    """Which are known to less than a block; and what is left afterwards has an interval."""
    event = replace(EVENT, shift_mm=0.5, shift_error=0.01)
    said = [s.words for s in told({"events": [event], **wander("step", 0.05, 97.0, 300.0)})]
    assert any("at about 98.5 s, 5 min;" in words for words in said)
    long = replace(EVENT, duration_s=20.0)
    said = [s.words for s in told({"events": [long], **wander("step", 8.0, 99.0)})]
    assert any("A, B moved by 8 mm (x1) within 20 s and stayed there" in words for words in said)
    said = [s.words for s in told({"events": [event]})]
    assert any("were 0.500 (0.480…0.520) mm off afterwards" in words for words in said)


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
