"""The word, on both sides of every threshold, and the check that decides."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import pytest

from mocap_metrology.noise.assess.checks import Code, Facts
from mocap_metrology.noise.assess.recording import Verdict, verdict
from mocap_metrology.noise.assess.uncertainty import SeriesNumbers, Unmodelled, Why
from mocap_metrology.noise.diagnosis.findings import Finding
from mocap_metrology.settings import Verdict as Limits

LIMITS = Limits()
FINE = SeriesNumbers(
    "ok", frame_mm=0.02, frame_lower_mm=0.019, frame_upper_mm=0.021, drift_mm_per_h=0.01
)
FACTS = Facts(7200.0, 3600.0, 2, {"x1": 0.0, "y1": 0.0}, {"x1": 0.0, "y1": 0.0})


def found_of(code: str, **values: float) -> list[Finding]:
    return [Finding(code, name, value) for name, value in values.items()]


def judged(facts: Mapping[str, Any] | None = None, **y1: Any) -> Verdict:
    distance = replace(FINE, frame_mm=9.0, status="misfit")
    series = {"x1": FINE, "y1": replace(FINE, **y1), "L": distance}
    return verdict(series, replace(FACTS, **(facts or {})), LIMITS)


def test_good_says_by_what_number() -> None:
    found = judged(frame_mm=0.05)
    assert (found.word, found.caps) == ("good", ())
    decided = found.decided_by
    assert (decided.code, decided.threshold) == (Code.FRAME, "verdict.good_mm")
    assert (decided.series, decided.value, decided.limit) == ("y1", 0.05, 0.1)
    # by the upper end of the interval
    assert found.reference_for_mm == {"4": pytest.approx(0.084), "10": pytest.approx(0.21)}


# threshold: what is just within it, what is just beyond it, and the words of both
SIDES = {
    "good_mm": ({"frame_mm": 0.1}, {"frame_mm": 0.1001}, "good", "usable"),
    "usable_mm": ({"frame_mm": 0.25}, {"frame_mm": 0.2501}, "usable", "bad"),
    "good_drift_mm": ({"drift_mm_per_h": -0.346}, {"drift_mm_per_h": -0.347}, "good", "usable"),
    "usable_drift_mm": ({"drift_mm_per_h": 0.866}, {"drift_mm_per_h": 0.867}, "usable", "bad"),
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
    drift = dict(zip(("good_drift_mm", "usable_drift_mm"), LIMITS.drift_mm, strict=True))
    limits = LIMITS.model_dump() | drift | {"misfit": "ok"}
    assert found.decided_by.limit == limits[threshold]


def test_limits_of_the_drift_follow_those_of_a_frame() -> None:
    """A uniform distribution of width d has a standard deviation of d / sqrt(12)."""
    assert Limits(good_mm=1.0, usable_mm=2.0).drift_mm == (math.sqrt(12), 2 * math.sqrt(12))
    assert Limits(good_mm=1.0, good_drift_mm=0.5).drift_mm[0] == 0.5


def test_every_threshold_has_its_sides() -> None:
    assert set(SIDES) == {*Limits.model_fields} - {"horizon_s", "window_s", "mean_mm"}


def test_the_word_for_a_misfit_is_a_choice() -> None:
    series = {"x1": replace(FINE, status="misfit")}
    for word in ("good", "usable", "bad"):
        assert verdict(series, FACTS, Limits(misfit=word)).word == word


def test_what_else_is_wrong_stands_beside() -> None:
    found = judged({"n_markers": 1}, frame_mm=0.3, status="misfit")
    assert (found.word, found.decided_by.threshold) == ("bad", "verdict.usable_mm")
    assert [c.threshold for c in found.caps] == ["verdict.misfit", "verdict.good_markers"]


def test_drift_counts_over_the_horizon_only() -> None:
    """A minute with 6 mm/h moved by 0.1 mm."""
    assert judged({"duration_s": 60.0, "horizon_s": 60.0}, drift_mm_per_h=6.0).word == "good"


SHORT = {"duration_s": 120.0, "horizon_s": 120.0, "asked_s": 3600.0}


def test_a_short_recording_says_what_is_not_known() -> None:
    decided = judged(SHORT).decided_by
    assert (decided.over_s, decided.asked_s) == (120.0, 3600.0)
    for reached in (3200.0, 3300.0, 3600.0):  # nine tenths of it are enough
        long = judged({**SHORT, "horizon_s": reached}).decided_by
        assert (long.over_s, math.isnan(long.asked_s)) == (reached, reached > 3240)


@pytest.mark.parametrize(("upper", "word"), [(0.1, "good"), (0.1001, "usable")])
def test_of_a_short_recording_the_upper_end_counts(upper: float, word: str) -> None:
    wide = {"frame_mm": 0.05, "frame_upper_mm": upper}
    found = judged(SHORT, **wide)
    assert found.word == word
    assert judged(**wide).word == "good"  # whose horizon is reached: the value decides
    if word == "usable":
        decided = found.decided_by
        assert (decided.series, decided.value, decided.limit) == ("y1", upper, 0.1)
        assert (decided.code, decided.over_s) == (Code.UPPER_END, 120.0)
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
    found = verdict({"x1": SeriesNumbers("no valid samples")}, FACTS)
    assert (found.word, found.decided_by.code) == ("bad", Code.NO_SAMPLES)
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
        decided = found.decided_by
        assert decided.code is Code.TOO_SHORT
        assert (decided.n_frames, decided.duration_s) == (n_frames, duration_s)
        by_frames = duration_s >= 1
        expected = (n_frames, 100, "") if by_frames else (duration_s, 1.0, "s")
        assert (decided.value, decided.limit, decided.unit) == expected
        assert (found.caps, found.uncertainty) == ((), None)
        assert math.isnan(found.reference_for_mm["4"])


def test_gaps_that_leave_no_number_are_the_reason() -> None:
    gaps = replace(FINE, frame_mm=math.nan, status="refused")
    series = {"x1": gaps, "y1": gaps}
    found = verdict(series, replace(FACTS, missing={"x1": 0.614, "y1": 0.6}))
    decided = found.decided_by
    assert (found.word, decided.code) == ("bad", Code.MISSING)
    assert (decided.series, decided.value, decided.limit) == ("x1", 0.614, 0.1)
    assert Code.FEW_SAMPLES not in {cap.code for cap in found.caps}
    assert verdict(series, FACTS).decided_by.code is Code.FEW_SAMPLES


def test_what_decided_stands_beside_the_number() -> None:
    interval = {"frame_lower_mm": 0.0255, "frame_upper_mm": 0.02641}
    found = judged({"n_markers": 1}, frame_mm=0.026, **interval)
    told = found.uncertainty
    assert (told.code, told.series, told.value) == (Code.FRAME, "y1", 0.026)
    assert (told.lower, told.upper, told.over_s) == (0.0255, 0.02641, 3600.0)
    assert judged(frame_mm=0.026, **interval).uncertainty is None
    moved = {"n_markers": 1, "findings": found_of("moves", y1=5.0)}
    assert judged(moved).uncertainty is None


def test_no_model_says_why() -> None:
    why = Unmodelled(Why.TOO_SHORT, 700, 1000)
    decided = judged(status="refused", unmodelled=why).decided_by
    assert (decided.code, decided.value) == (Code.MISFIT, "refused")
    assert (decided.unmodelled, decided.n_coordinates) == ({"y1": why}, 2)
    none = replace(FINE, status="refused", unmodelled=why)
    both = {"x1": none, "y1": replace(FINE, status="misfit")}
    decided = verdict(both, FACTS).decided_by
    assert decided.unmodelled["x1"] is why
    assert decided.unmodelled["y1"].why == Why.MISFIT and len(decided.unmodelled) == 2
    assert (decided.series, decided.value) == ("x1,y1", "refused, misfit")


def test_what_never_changes_is_not_measured() -> None:
    found = judged(status="constant", frame_mm=1e-7)
    assert (found.word, found.decided_by.series) == ("bad", "y1")
    assert (found.decided_by.code, found.decided_by.names) == (Code.CONSTANT, ("y1",))
    assert math.isnan(found.reference_for_mm["4"])


def test_movement_leads_and_what_still_counts_follows() -> None:
    far = replace(FINE, frame_mm=693.0, frame_lower_mm=503.0)
    series = {"x1": FINE, "y2": far, "L": replace(FINE, frame_mm=0.3)}
    facts = replace(FACTS, labels=("Head", "RFT1"), findings=found_of("moves", y2=2021.4))
    found = verdict(series, facts)
    assert (found.word, found.decided_by.threshold) == ("bad", "still.range_mm")
    decided = found.decided_by
    assert (decided.code, decided.names) == (Code.MOVES, ("RFT1",))
    assert (decided.series, decided.value, decided.over_s) == ("y2", 2021.4, 3600.0)
    assert (decided.distance, decided.distance_mm) == ("L", 0.3)
    assert math.isnan(found.reference_for_mm["4"])
    assert Code.FRAME not in {cap.code for cap in found.caps}
    facts = replace(facts, findings=found_of("moves", y2=2021.4, L=2000.0))
    decided = verdict(series, facts).decided_by
    assert (decided.distance, decided.still) == ("", ("Head",))
    both = replace(FACTS, findings=found_of("moves", x1=2021.4, y2=2021.4, L=2000.0))
    decided = verdict({**series, "x1": far}, both).decided_by
    assert decided.names == ("marker 1", "marker 2")
    assert (decided.distance, decided.still) == ("", ())
    # Both feet of one who walks: their distance swings, though no movement of it was found
    gait = replace(FACTS, findings=found_of("moves", x1=3590.0, y2=3590.0))
    decided = verdict({**series, "x1": far, "L": replace(FINE, frame_mm=165.0)}, gait).decided_by
    assert decided.distance == ""


@pytest.mark.parametrize(("step", "word"), [(0.1, "usable"), (0.25, "usable"), (0.3, "bad")])
@pytest.mark.parametrize("frame_mm", [1e-7, 0.02, 0.14])
def test_a_coarse_export_decides_by_its_steps_alone(step: float, word: str, frame_mm: float):
    """Whatever a frame seems to scatter by; and a coordinate in the middle of a step is no fault
    of its own."""
    coarse = {"findings": found_of("resolution_limited", x1=step, y1=step)}
    found = judged(coarse, frame_mm=frame_mm, frame_upper_mm=frame_mm)
    assert (found.word, found.decided_by.code) == (word, Code.STEP)
    assert (found.decided_by.value, found.decided_by.names) == (step, ())
    assert found.uncertainty is None
    in_a_step = judged(coarse, frame_mm=0.0, frame_upper_mm=0.0, status="constant")
    assert (in_a_step.word, in_a_step.decided_by.code) == (word, Code.STEP)
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
    decided = found.decided_by
    assert (found.word, decided.code) == ("usable", Code.LOW_PASS)
    assert (decided.value, decided.unit, decided.names) == (6.1, "Hz", ())
    assert all(math.isnan(v) for v in found.reference_for_mm.values())
    decided = judged({"findings": found_of("low_pass", y1=math.nan)}).decided_by
    assert (decided.names, math.isnan(decided.value)) == (("y1",), True)


def test_filled_frames_count_as_missing() -> None:
    found = judged({"missing": {"y1": 0.012}, "findings": found_of("gap_filled", y1=0.004)})
    assert (found.word, found.decided_by.threshold) == ("usable", "verdict.good_missing")
    assert found.decided_by.code is Code.MISSING_OR_FILLED
    assert (found.decided_by.series, found.decided_by.value) == ("y1", pytest.approx(0.012))


def test_a_walk_is_a_walk() -> None:
    walk = {"findings": found_of("random_walk", y1=1e-9)}
    found = judged(walk, drift_mm_per_h=0.5).decided_by
    assert (found.code, found.series, found.value) == (Code.RANDOM_WALK, "y1", 0.5)
    found = judged(drift_mm_per_h=0.5).decided_by
    assert (found.code, found.value, found.over_s) == (Code.DRIFT, 0.5, 3600.0)


def test_of_what_moves_only_gaps_count_beside_the_movement() -> None:
    """Drift, outliers and a misfit of a marker that walks are its walk."""
    spoilt = {"drift_mm_per_h": 5.0, "status": "misfit"}
    facts = {"missing": {"y1": 0.05}, "outliers": {"y1": 0.03}, "n_markers": 1}
    still = judged(facts, **spoilt)
    assert {c.code for c in still.caps} == {
        *(Code.MISSING, Code.OUTLIERS, Code.MISFIT, Code.MARKERS),
    }
    moving = found_of("moves", x1=2021.4, y1=300.0, L=5.0)
    gone = judged(facts | {"findings": moving, "labels": ("A",)}, **spoilt)
    assert (gone.word, gone.decided_by.code) == ("bad", Code.MOVES)
    assert [c.code for c in gone.caps] == [Code.MISSING]
    # Another marker stands still: what there is of its noise is told
    both = replace(FACTS, findings=found_of("moves", x1=2021.4, L=5.0), labels=("A", "B"))
    series = {"x1": FINE, "x2": replace(FINE, **spoilt), "L": FINE}
    found = verdict(series, both, LIMITS)
    assert found.decided_by.code is Code.MOVES and Code.MISFIT in {c.code for c in found.caps}
