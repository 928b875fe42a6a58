"""The word, on both sides of every threshold."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any

import pytest

from mocap_metrology.noise.assess.verdict import Facts, Thresholds, duration_words, verdict
from mocap_metrology.noise.diagnosis.findings import Finding

LIMITS = Thresholds()
FINE = {
    "status": "ok",
    "frame_mm": 0.02,
    "frame_lower_mm": 0.019,
    "frame_upper_mm": 0.021,
    "drift_mm_per_h": 0.01,
}
FACTS = Facts(7200.0, 3600.0, 2, {"x1": 0.0, "y1": 0.0}, {"x1": 0.0, "y1": 0.0})


def found_of(code: str, **values: float) -> list[dict[str, Any]]:
    return [Finding(code, name, value).as_dict() for name, value in values.items()]


def judged(facts: Mapping[str, Any] | None = None, **y1: Any) -> Any:
    series = {"x1": FINE, "y1": {**FINE, **y1}, "L": {**FINE, "frame_mm": 9.0, "status": "misfit"}}
    return verdict(series, replace(FACTS, **(facts or {})), LIMITS)


def test_good_says_by_what_number() -> None:
    found = judged(frame_mm=0.05)
    assert (found.word, found.caps) == ("good", ())
    decided = found.decided_by.as_row()
    assert decided["threshold"] == "verdict.good_mm"
    assert (decided["series"], decided["value"], decided["limit"]) == ("y1", 0.05, 0.1)
    # by the upper end of the interval
    assert found.reference_for_mm == {"4": pytest.approx(0.084), "10": pytest.approx(0.21)}


# threshold: what is just within it, what is just beyond it, and the words of both
SIDES = {
    "good_mm": ({"frame_mm": 0.1}, {"frame_mm": 0.1001}, "good", "usable"),
    "usable_mm": ({"frame_mm": 0.25}, {"frame_mm": 0.2501}, "usable", "bad"),
    "good_drift_mm": ({"drift_mm_per_h": -0.35}, {"drift_mm_per_h": -0.351}, "good", "usable"),
    "usable_drift_mm": ({"drift_mm_per_h": 0.85}, {"drift_mm_per_h": 0.851}, "usable", "bad"),
    "good_missing": (
        *({"facts": {"missing": {"y1": 0.01}}}, {"facts": {"missing": {"y1": 0.0101}}}),
        *("good", "usable"),
    ),
    "usable_missing": (
        *({"facts": {"missing": {"y1": 0.1}}}, {"facts": {"missing": {"y1": 0.101}}}),
        *("usable", "bad"),
    ),
    "good_outliers": (
        *({"facts": {"outliers": {"y1": 0.01}}}, {"facts": {"outliers": {"y1": 0.0101}}}),
        *("good", "usable"),
    ),
    "usable_outliers": (
        *({"facts": {"outliers": {"y1": 0.05}}}, {"facts": {"outliers": {"y1": 0.051}}}),
        *("usable", "bad"),
    ),
    "good_duration_s": (
        *({"facts": {"duration_s": 60.0}}, {"facts": {"duration_s": 59.9}}),
        *("good", "usable"),
    ),
    "good_markers": (
        *({"facts": {"n_markers": 2}}, {"facts": {"n_markers": 1}}),
        *("good", "usable"),
    ),
    "misfit": ({"status": "ok"}, {"status": "misfit"}, "good", "usable"),
}


@pytest.mark.parametrize("threshold", SIDES)
def test_both_sides_of_a_threshold(threshold: str) -> None:
    within, beyond, word, worse = SIDES[threshold]
    assert judged(**within).word == word
    found = judged(**beyond)
    assert found.word == worse
    assert found.decided_by.threshold == f"verdict.{threshold}"
    assert found.decided_by.limit == ("ok" if threshold == "misfit" else getattr(LIMITS, threshold))


def test_every_threshold_has_its_sides() -> None:
    assert set(SIDES) == {field.name for field in fields(Thresholds)}


def test_the_word_for_a_misfit_is_a_choice() -> None:
    series = {"x1": {**FINE, "status": "misfit"}}
    for word in ("good", "usable", "bad"):
        assert verdict(series, FACTS, replace(LIMITS, misfit=word)).word == word


def test_what_else_is_wrong_stands_beside() -> None:
    found = judged({"n_markers": 1}, frame_mm=0.3, status="misfit")
    assert (found.word, found.decided_by.threshold) == ("bad", "verdict.usable_mm")
    assert [c.threshold for c in found.caps] == ["verdict.misfit", "verdict.good_markers"]


def test_drift_counts_over_the_horizon_only() -> None:
    """A minute with 6 mm/h moved by 0.1 mm."""
    assert judged({"duration_s": 60.0, "horizon_s": 60.0}, drift_mm_per_h=6.0).word == "good"


SHORT = {"duration_s": 120.0, "horizon_s": 120.0, "asked_s": 3600.0}


def test_a_short_recording_says_what_is_not_known() -> None:
    said = "good is up to 0.1 mm; over 2 min only, nothing is known of an hour."
    assert judged(SHORT).decided_by.sentence.endswith(said)
    for reached in (3300.0, 3600.0):
        long = judged({**SHORT, "horizon_s": reached})
        assert long.decided_by.sentence.endswith("good is up to 0.1 mm.")


@pytest.mark.parametrize(("upper", "word"), [(0.1, "good"), (0.1001, "usable")])
def test_of_a_short_recording_the_upper_end_counts(upper: float, word: str) -> None:
    wide = {"frame_mm": 0.05, "frame_upper_mm": upper}
    found = judged(SHORT, **wide)
    assert found.word == word
    assert judged(**wide).word == "good"  # whose horizon is reached: the value decides
    if word == "usable":
        decided = found.decided_by
        assert (decided.series, decided.value, decided.limit) == ("y1", upper, 0.1)
        assert decided.sentence.startswith("Over 2 min only, one frame of y1 may be uncertain by")
    beyond = judged(SHORT, frame_mm=0.15, frame_upper_mm=0.2)  # said once
    assert (beyond.decided_by.value, beyond.caps) == (0.15, ())


@pytest.mark.parametrize(
    "bad", [{"frame_mm": 0.3}, {"drift_mm_per_h": 5.0}, {"facts": {"missing": {"y1": 0.4}}}]
)
def test_what_is_bad_is_no_reference(bad: Mapping[str, Any]) -> None:
    found = judged(**bad)
    assert found.word == "bad"
    assert all(math.isnan(v) for v in found.reference_for_mm.values())


def test_a_reference_without_an_interval_goes_by_its_value() -> None:
    found = judged(frame_mm=0.05, frame_lower_mm=math.nan, frame_upper_mm=math.nan)
    assert found.reference_for_mm == {"4": pytest.approx(0.2), "10": pytest.approx(0.5)}


def test_without_numbers_it_is_bad() -> None:
    found = verdict({"x1": {**FINE, "frame_mm": math.nan, "status": "no valid samples"}}, FACTS)
    assert (found.word, found.decided_by.quantity) == ("bad", "uncertainty of one frame")
    assert math.isnan(found.reference_for_mm["4"])


@pytest.mark.parametrize(
    ("duration_s", "n_frames", "word"),
    [
        (0.02, 2, "bad"),
        (0.3, 30, "bad"),
        (0.99, 990, "bad"),
        (9.9, 99, "bad"),
        (1.0, 100, "usable"),
    ],
)
def test_nothing_is_judged_by_a_handful_of_frames(
    duration_s: float, n_frames: int, word: str
) -> None:
    found = judged(
        {"duration_s": duration_s, "horizon_s": duration_s, "n_frames": n_frames},
        status="refused",
        drift_mm_per_h=-1000.0,
    )
    assert found.word == word
    if word == "bad":
        assert found.decided_by.sentence == (
            f"The recording is too short to judge: {n_frames} frames in {duration_s:g} s; a "
            "verdict needs 100 frames and 1 s at least."
        )
        assert (found.caps, found.uncertainty) == ((), "")
        assert math.isnan(found.reference_for_mm["4"])


def test_gaps_that_leave_no_number_are_the_reason() -> None:
    gaps = {"frame_mm": math.nan, "status": "refused"}
    series = {"x1": {**FINE, **gaps}, "y1": {**FINE, **gaps}}
    found = verdict(series, replace(FACTS, missing={"x1": 0.614, "y1": 0.6}))
    said = "61.4 % of the frames of x1 are missing; usable is up to 10 %."
    assert (found.word, found.decided_by.sentence) == ("bad", said)
    assert not any("valid samples" in cap.sentence for cap in found.caps)
    found = verdict(series, FACTS)
    assert found.decided_by.sentence == "There are too few valid samples to judge by."


def test_what_decided_stands_beside_the_number() -> None:
    said = "One frame of y1 is uncertain by 0.0260 mm (0.0255 to 0.0264) about the mean of an hour;"
    interval = {"frame_lower_mm": 0.0255, "frame_upper_mm": 0.02641}
    found = judged({"n_markers": 1}, frame_mm=0.026, **interval)
    assert found.uncertainty.startswith(said)
    assert judged(frame_mm=0.026, **interval).uncertainty == ""
    moved = {"n_markers": 1, "findings": found_of("moves", y1=5.0)}
    assert judged(moved).uncertainty == ""


def test_no_model_says_why() -> None:
    why = "too short: 700 samples, a noise model needs 1000"
    words = judged(status="refused", why_measured=why).decided_by.sentence
    assert words.startswith(f"There is no noise model ({why}) of y1: its numbers are")
    none = {**FINE, "status": "refused", "why_measured": why}
    words = verdict({"x1": none, "y1": none}, FACTS).decided_by.sentence
    assert words.startswith(f"There is no noise model ({why}): its numbers are")
    both = {"x1": none, "y1": {**FINE, "status": "misfit"}}
    words = verdict(both, FACTS).decided_by.sentence
    assert "of x1; the noise model does not describe the spectrum of y1: its" in words


def test_what_never_changes_is_not_measured() -> None:
    found = judged(status="constant", frame_mm=1e-7)
    assert (found.word, found.decided_by.series) == ("bad", "y1")
    assert found.decided_by.sentence.startswith("y1 never changes")
    assert math.isnan(found.reference_for_mm["4"])


@pytest.mark.parametrize(
    ("seconds", "words"), [(3600, "an hour"), (600, "10 min"), (5.2, "5.2 s"), (32400, "9 h")]
)
def test_durations_in_words(seconds: float, words: str) -> None:
    assert duration_words(seconds) == words


def test_movement_leads_and_what_still_counts_follows() -> None:
    far = {"frame_mm": 693.0, "frame_lower_mm": 503.0}
    series = {"x1": FINE, "y2": {**FINE, **far}, "L": {**FINE, "frame_mm": 0.3}}
    facts = replace(FACTS, labels=("Head", "RFT1"), findings=found_of("moves", y2=2021.4))
    found = verdict(series, facts)
    assert (found.word, found.decided_by.threshold) == ("bad", "still.range_mm")
    words = found.decided_by.sentence
    assert words.startswith("RFT1 moves: y2 by 2020 mm within an hour, which its noise does not")
    assert words.endswith("the distance L, one frame uncertain by 0.300 mm.")
    assert math.isnan(found.reference_for_mm["4"])
    assert not any("One frame of y2" in cap.sentence for cap in found.caps)
    facts = replace(facts, findings=found_of("moves", y2=2021.4, L=2000.0))
    words = verdict(series, facts).decided_by.sentence
    assert words.endswith("what still counts are the numbers of Head.")
    both = replace(FACTS, findings=found_of("moves", x1=2021.4, y2=2021.4, L=2000.0))
    words = verdict({**series, "x1": {**FINE, **far}}, both).decided_by.sentence
    assert words.startswith("marker 1, marker 2 move:")
    assert words.endswith("none of its numbers is of noise alone.")


@pytest.mark.parametrize(("step", "word"), [(0.1, "usable"), (0.25, "usable"), (0.3, "bad")])
@pytest.mark.parametrize("frame_mm", [1e-7, 0.02, 0.14])
def test_a_coarse_export_decides_by_its_steps_alone(step: float, word: str, frame_mm: float):
    """Whatever a frame seems to scatter by; and a coordinate in the middle of a step is no fault
    of its own."""
    coarse = {"findings": found_of("resolution_limited", x1=step, y1=step)}
    found = judged(coarse, frame_mm=frame_mm, frame_upper_mm=frame_mm)
    assert (found.word, found.decided_by.quantity) == (word, "step of the file")
    assert "export finer steps" in found.decided_by.sentence
    assert "One frame of" not in found.uncertainty
    in_a_step = judged(coarse, frame_mm=0.0, frame_upper_mm=0.0, status="constant")
    assert (in_a_step.word, in_a_step.decided_by.quantity) == (word, "step of the file")
    if word == "usable":
        assert found.reference_for_mm["4"] == pytest.approx(4 * max(step, frame_mm))
    else:
        assert math.isnan(found.reference_for_mm["4"])


def test_wander_beyond_the_steps_is_bad_whatever_the_steps() -> None:
    coarse = {"findings": found_of("resolution_limited", x1=0.1, y1=0.1)}
    found = judged(coarse, frame_mm=0.3)
    assert (found.word, found.decided_by.series) == ("bad", "y1")
    fine = judged({"findings": found_of("resolution_limited", y1=0.1)}, status="constant")
    assert (fine.word, fine.decided_by.value) == ("bad", pytest.approx(math.nan, nan_ok=True))


def test_filtered_data_are_no_reference() -> None:
    found = judged({"findings": found_of("low_pass", x1=6.1, y1=5.9)})
    assert found.word == "usable"
    said = "The recording looks low-pass filtered at about 6.1 Hz; a frame's noise before"
    assert found.decided_by.sentence.startswith(said)
    assert all(math.isnan(v) for v in found.reference_for_mm.values())
    known = judged({"findings": found_of("low_pass", y1=math.nan)}).decided_by.sentence
    assert known.startswith("y1 looks low-pass filtered; a frame's noise")


def test_filled_frames_count_as_missing() -> None:
    found = judged({"missing": {"y1": 0.008}, "findings": found_of("gap_filled", y1=0.004)})
    assert (found.word, found.decided_by.threshold) == ("usable", "verdict.good_missing")
    assert "1.2 % of the frames of y1 are missing, or filled by" in found.decided_by.sentence


def test_a_walk_is_a_walk() -> None:
    walk = {"findings": found_of("random_walk", y1=1e-9)}
    assert "y1 wanders as a random walk" in judged(walk, drift_mm_per_h=0.5).decided_by.sentence
    straight = judged(drift_mm_per_h=0.5).decided_by.sentence
    assert straight.startswith("y1 drifts by 0.5 mm in an hour")
