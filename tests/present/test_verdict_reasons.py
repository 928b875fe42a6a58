"""Reasons of a verdict on a recording, each check with its numbers."""

import math
import tomllib
from pathlib import Path

import pytest

from mocap_metrology.noise.assess.checks import Check, Code, LengthCheck, ModelCheck, MovementCheck
from mocap_metrology.noise.assess.uncertainty import Unmodelled, Why
from mocap_metrology.present.text import sentence
from mocap_metrology.present.verdict.document import reason, why_measured

FRAME = {"series": "y1", "lower": 0.0255, "upper": 0.02641, "over_s": 3600.0}
HOUR, MINUTE = {"series": "y1", "over_s": 3600.0}, {"series": "x1", "over_s": 60.0}
SHORT, TWO = Unmodelled(Why.TOO_SHORT, 700, 1000), {"n_coordinates": 2}
MANY = "too short: 700 samples, a noise model needs 1000"
LATER = "its numbers describe this recording and may not hold for the next one."
REASONS = [
    (Check(Code.EXCHANGED, "bad", 0.0278, 0.0, series="x1", names=("A", "B")), "The labels of A "
     "and B are exchanged in 2.78 % of the frames; the numbers are of the labels put right. "
     "Correct them in the file."),
    (Check(Code.PROCESSED, "usable", "running_median", "", names=("x1",)), "x1: running medians of "
     "the measured frames. Export unprocessed frames."),
    (Check(Code.PROCESSED, "usable", "smoothed", ""), "The recording: no white noise, so the "
     "software smoothed it, as far as can be told; the noise of a measured frame is not known. "
     "Export unprocessed frames."),
    (LengthCheck(Code.TOO_SHORT, "bad", 0.3, 1.0, "s", n_frames=30, duration_s=0.3), "The "
     "recording is too short to judge: 30 frames in 0.3 s; a verdict needs at least 100 frames "
     "and 1 s."),
    (Check(Code.FRAME, "good", 0.026, 0.1, "mm", **FRAME), "One frame of y1 is uncertain by 26.00 "
     "(25.50…26.41) µm about the mean of an hour; within the limit for good, 0.1 mm."),
    (Check(Code.FRAME, "good", 0.026, 0.026, "mm", **FRAME | {"over_s": 120.0}, asked_s=3600.0),
     "One frame of y1 is uncertain by 26.00 (25.50…26.41) µm about the mean of 2 min; within the "
     "limit for good, 26 µm (the interval includes the limit); a recording of 2 min gives no "
     "information about an hour."),
    (Check(Code.FRAME, "bad", 693.0, 0.25, "mm", series="x1", over_s=5.0), "One frame of x1 is "
     "uncertain by 693 mm about the mean of 5 s; the limit for usable is 0.25 mm."),
    (Check(Code.CONSTANT, "bad", math.nan, 0.25, "mm", names=("y1",)), "y1 never changes: nothing "
     "is measured there, or the steps of the file are too coarse."),
    (Check(Code.NO_SAMPLES, "bad", math.nan, 0.25, "mm"), "There are no valid samples for a "
     "verdict."),
    (Check(Code.FEW_SAMPLES, "bad", math.nan, 0.25, "mm"), "There are too few valid samples for a "
     "verdict."),
    (Check(Code.UPPER_END, "usable", 0.1001, 0.1, "mm", **MINUTE), "Over only 60 s, the "
     "uncertainty of one frame of x1 may be 0.1 mm (upper end of its interval); the limit for good "
     "is 0.1 mm."),
    (MovementCheck(Code.MOVES, "bad", 2021.4, 0.0, "mm", "", "y2", names=("RFT1",), over_s=3600.0,
     distance="L", distance_mm=0.3), "RFT1 moves: y2 by 2.02 m within an hour, which its noise "
     "does not explain; the distance L is still valid, with an uncertainty of one frame of "
     "0.3 mm."),
    (MovementCheck(Code.MOVES, "bad", 3.0, 0.0, "mm", **MINUTE, names=("A", "B"),
     still=("C", "D")), "A, B move: x1 by 3 mm within 60 s, which its noise does not explain; "
     "still valid are the numbers of C, D."),
    (Check(Code.MISSING, "bad", 0.614, 0.1, series="x1"), "61.4 % of the frames of x1 are missing; "
     "the limit for usable is 10 %."),
    (Check(Code.MISSING_OR_FILLED, "usable", 0.012, 0.01, series="y1"), "1.2 % of the frames of y1 "
     "are missing or filled by interpolation; the limit for good is 1 %."),
    (Check(Code.OUTLIERS, "usable", 0.02, 0.01, series="z1"), "2 % of the frames of z1 are "
     "outliers, more than clean noise and chance explain; the limit for good is 1 %."),
    (Check(Code.STEP, "usable", 0.1, 0.25, "mm"), "The resolution of the export limits the result: "
     "its steps of 0.1 mm hide the noise of all coordinates, so a frame is known no better than "
     "one step; export with finer steps."),
    (Check(Code.LOW_PASS, "usable", 6.1, math.nan, "Hz"), "The recording looks to be low-pass "
     "filtered at about 6.1 Hz; the noise of a frame before the filter cannot be estimated. Export "
     "unfiltered data."),
    (Check(Code.DRIFT, "usable", 0.5, 0.35, "mm", **HOUR), "y1 drifts by 0.5 mm in an hour; the "
     "limit for good is 0.35 mm."),
    (Check(Code.RANDOM_WALK, "usable", 0.5, 0.35, "mm", **HOUR), "y1 wanders as a random walk: a "
     "straight line fitted to it rises by 0.5 mm in an hour; the limit for good is 0.35 mm."),
    (Check(Code.WANDER, "usable", 0.5, 0.35, "mm", **HOUR), "y1 wanders: a straight line fitted "
     "to it changes by 0.5 mm in an hour; the limit for good is 0.35 mm."),
    (ModelCheck(Code.MISFIT, "usable", "", "", **TWO, unmodelled={"y1": SHORT}), "There is no "
     f"noise model ({MANY}) of y1: {LATER}"),
    (ModelCheck(Code.MISFIT, "usable", "", "", **TWO, unmodelled={"x1": None, "y1": Unmodelled(
     Why.MISFIT)}), "There is no noise model of x1; the noise model does not describe the spectrum "
     f"of y1: {LATER}"),
    (Check(Code.DURATION, "usable", 30.0, 60.0, "s"), "The recording lasts 30 s; at least 60 s are "
     "needed to estimate slow wander."),
    (Check(Code.MARKERS, "usable", 1, 2), "1 marker; at least 2 are needed: without a distance, "
     "every quantity depends on the positions of the cameras."),
]  # fmt: skip
UNMODELLED = [
    (None, ""),
    (Unmodelled(Why.NO_SAMPLES), "no valid samples"),
    (Unmodelled(Why.NO_MODEL), "there is no noise model"),
    (Unmodelled(Why.MISFIT), "the noise model does not describe the spectrum"),
    (Unmodelled(Why.REFUSED, note="any note"), "any note"),
    (SHORT, MANY),
    (Unmodelled(Why.TOO_MANY_GAPS, 500, 1000), MANY.replace("short: 7", "many gaps: 5")),
    (
        Unmodelled(Why.FRAMES_DISAGREE, 0.02, 0.04),
        "single frames scatter by 20 µm, the model predicts 40 µm",
    ),
    (
        Unmodelled(Why.MEANS_DISAGREE, 0.0312, 0.01, 1.0),
        "means over 1 s scatter by 31.2 µm, the model predicts 10 µm",
    ),
]


@pytest.mark.parametrize(("check", "words"), REASONS)
def test_a_check_in_words(check: Check, words: str) -> None:
    assert reason(check) == words


@pytest.mark.parametrize(("unmodelled", "words"), UNMODELLED)
def test_why_numbers_are_measured(unmodelled: Unmodelled | None, words: str) -> None:
    assert why_measured(unmodelled) == words


def test_every_template_has_its_words_here() -> None:
    path = Path(sentence.__file__).with_name("recording.toml")
    texts = tomllib.loads(path.read_text(encoding="utf-8"))
    assert set(texts["check"]) == set(texts["quantity"]) == set(Code)
    assert {check.code for check, _ in REASONS} == set(Code)
    assert set(texts["measured"]) == set(Why) == {one.why for one, _ in UNMODELLED if one}
