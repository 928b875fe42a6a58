"""Reasons of a verdict on a recording, each check with its numbers."""

import math
import tomllib
from pathlib import Path

import pytest
from said import numbers_in

from mocap_metrology.noise.assess.checks import Check, Code, LengthCheck, ModelCheck, MovementCheck
from mocap_metrology.noise.assess.uncertainty import Unmodelled, Why
from mocap_metrology.present.text import sentence
from mocap_metrology.present.verdict.words import reason, why_measured

FRAME = {"series": "y1", "lower": 0.0255, "upper": 0.02641, "over_s": 3600.0}
HOUR, MINUTE = {"series": "y1", "over_s": 3600.0}, {"series": "x1", "over_s": 60.0}
SHORT, TWO = Unmodelled(Why.TOO_SHORT, 700, 1000), {"n_coordinates": 2}
REASONS = [
    (Check(Code.EXCHANGED, "bad", 0.0278, 0.0, series="x1", names=("A", "B")), "2.78 %"),
    (Check(Code.PROCESSED, "usable", "running_median", "", names=("x1",)), "x1"),
    (Check(Code.PROCESSED, "usable", "smoothed", ""), ""),
    (LengthCheck(Code.TOO_SHORT, "bad", 0.3, 1.0, "s", n_frames=30, duration_s=0.3),
     "30, 0.3 s, 100, 1 s"),
    (Check(Code.FRAME, "good", 0.026, 0.1, "mm", **FRAME), "y1, 26.00, 25.50, 26.41, 0.1 mm"),
    (Check(Code.FRAME, "good", 0.026, 0.026, "mm", **FRAME | {"over_s": 120.0}, asked_s=3600.0),
     "y1, 26.00, 25.50, 26.41, 2 min, 26 µm, 2 min"),
    (Check(Code.FRAME, "bad", 693.0, 0.25, "mm", series="x1", over_s=5.0),
     "x1, 693 mm, 5 s, 0.25 mm"),
    (Check(Code.CONSTANT, "bad", math.nan, 0.25, "mm", names=("y1",)), "y1"),
    (Check(Code.NO_SAMPLES, "bad", math.nan, 0.25, "mm"), ""),
    (Check(Code.FEW_SAMPLES, "bad", math.nan, 0.25, "mm"), ""),
    (Check(Code.UPPER_END, "usable", 0.1001, 0.1, "mm", **MINUTE), "60 s, x1, 0.1 mm, 0.1 mm"),
    (MovementCheck(Code.MOVES, "bad", 2021.4, 0.0, "mm", "", "y2", names=("RFT1",), over_s=3600.0,
     distance="L", distance_mm=0.3), "y2, 2.02 m, L, 0.3 mm"),
    (MovementCheck(Code.MOVES, "bad", 3.0, 0.0, "mm", **MINUTE, names=("A", "B"), still=("C", "D")),
     "x1, 3 mm, 60 s"),
    (Check(Code.MISSING, "bad", 0.614, 0.1, series="x1"), "61.4 %, x1, 10 %"),
    (Check(Code.MISSING_OR_FILLED, "usable", 0.012, 0.01, series="y1"), "1.2 %, y1, 1 %"),
    (Check(Code.OUTLIERS, "usable", 0.02, 0.01, series="z1"), "2 %, z1, 1 %"),
    (Check(Code.STEP, "usable", 0.1, 0.25, "mm"), "0.1 mm"),
    (Check(Code.LOW_PASS, "usable", 6.1, math.nan, "Hz"), "6.1 Hz"),
    (Check(Code.DRIFT, "usable", 0.5, 0.35, "mm", **HOUR), "y1, 0.5 mm, 0.35 mm"),
    (Check(Code.RANDOM_WALK, "usable", 0.5, 0.35, "mm", **HOUR), "y1, 0.5 mm, 0.35 mm"),
    (Check(Code.WANDER, "usable", 0.5, 0.35, "mm", **HOUR), "y1, 0.5 mm, 0.35 mm"),
    (ModelCheck(Code.MISFIT, "usable", "", "", **TWO, unmodelled={"y1": SHORT}), "700, 1000, y1"),
    (ModelCheck(Code.MISFIT, "usable", "", "", **TWO, unmodelled={"x1": None, "y1": Unmodelled(
     Why.MISFIT)}), "x1, y1"),
    (Check(Code.DURATION, "usable", 30.0, 60.0, "s"), "30 s, 60 s"),
    (Check(Code.MARKERS, "usable", 1, 2), "1, 2"),
]  # fmt: skip
UNMODELLED = [
    (None, ""),
    (Unmodelled(Why.NO_SAMPLES), ""),
    (Unmodelled(Why.NO_MODEL), ""),
    (Unmodelled(Why.MISFIT), ""),
    (Unmodelled(Why.REFUSED, note="any note"), ""),
    (SHORT, "700, 1000"),
    (Unmodelled(Why.TOO_MANY_GAPS, 500, 1000), "500, 1000"),
    (Unmodelled(Why.FRAMES_DISAGREE, 0.02, 0.04), "20 µm, 40 µm"),
    (Unmodelled(Why.MEANS_DISAGREE, 0.0312, 0.01, 1.0), "1 s, 31.2 µm, 10 µm"),
]  # fmt: skip


@pytest.mark.parametrize(("check", "said"), REASONS)
def test_numbers_of_a_check(check: Check, said: str) -> None:
    assert numbers_in(reason(check)) == said


@pytest.mark.parametrize(("unmodelled", "said"), UNMODELLED)
def test_why_numbers_are_measured(unmodelled: Unmodelled | None, said: str) -> None:
    words = why_measured(unmodelled)
    assert numbers_in(words) == said and bool(words) == (unmodelled is not None)


def test_every_template_is_here() -> None:
    path = Path(sentence.__file__).with_name("recording.toml")
    texts = tomllib.loads(path.read_text(encoding="utf-8"))
    assert set(texts["check"]) == set(texts["quantity"]) == set(Code)
    assert {check.code for check, _ in REASONS} == set(Code)
    assert set(texts["measured"]) == set(Why) == {one.why for one, _ in UNMODELLED if one}
