"""Reasons of a verdict and sentences on bars and points, each with its numbers."""

import math

import pytest
from said import numbers_in, templates

from mocap_metrology.noise.assess.checks import Check, Code, LengthCheck, ModelCheck, MovementCheck
from mocap_metrology.noise.assess.uncertainty import Reason, Unmodelled
from mocap_metrology.present.text.sentence import render
from mocap_metrology.present.verdict.words import reason, why_measured

FRAME = {"series": "y1", "lower": 0.0255, "upper": 0.02641, "over_s": 3600.0}
HOUR, MINUTE = {"series": "y1", "over_s": 3600.0}, {"series": "x1", "over_s": 60.0}
SHORT, TWO = Unmodelled(Reason.TOO_SHORT, 700, 1000), {"n_coordinates": 2}
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
    (Check(Code.LOW_PASS, "usable", 6.1, math.nan, "Hz", lower=6.1, upper=6.1), "6.1 Hz, 1.4"),
    (Check(Code.LOW_PASS, "usable", 8.0, math.nan, "Hz", lower=6.0, upper=11.0), "6, 11 Hz, 1.4"),
    (Check(Code.DRIFT, "usable", 0.5, 0.35, "mm", **HOUR), "y1, 0.5 mm, 0.35 mm"),
    (Check(Code.RANDOM_WALK, "usable", 0.5, 0.35, "mm", **HOUR), "y1, 0.5 mm, 0.35 mm"),
    (Check(Code.WANDER, "usable", 0.5, 0.35, "mm", **HOUR), "y1, 0.5 mm, 0.35 mm"),
    (ModelCheck(Code.MISFIT, "usable", "", "", **TWO, unmodelled={"y1": SHORT}), "700, 1000, y1"),
    (ModelCheck(Code.MISFIT, "usable", "", "", **TWO, unmodelled={"x1": None, "y1": Unmodelled(
     Reason.MISFIT)}), "x1, y1"),
    (Check(Code.DURATION, "usable", 30.0, 60.0, "s"), "30 s, 60 s"),
    (Check(Code.MARKERS, "usable", 1, 2), "1, 2"),
]  # fmt: skip
UNMODELLED = [
    (None, ""),
    (Unmodelled(Reason.NO_SAMPLES), ""),
    (Unmodelled(Reason.NO_MODEL), ""),
    (Unmodelled(Reason.MISFIT), ""),
    (Unmodelled(Reason.REFUSED, note="any note"), ""),
    (SHORT, "700, 1000"),
    (Unmodelled(Reason.TOO_MANY_GAPS, 500, 1000), "500, 1000"),
    (Unmodelled(Reason.FRAMES_DISAGREE, 0.02, 0.04), "20 µm, 40 µm"),
    (Unmodelled(Reason.MEANS_DISAGREE, 0.0312, 0.01, 1.0), "1 s, 31.2 µm, 10 µm"),
]  # fmt: skip


@pytest.mark.parametrize(("check", "said"), REASONS)
def test_numbers_of_a_check(check: Check, said: str) -> None:
    assert numbers_in(reason(check)) == said


@pytest.mark.parametrize(("unmodelled", "said"), UNMODELLED)
def test_why_numbers_are_measured(unmodelled: Unmodelled | None, said: str) -> None:
    words = why_measured(unmodelled)
    assert numbers_in(words) == said and bool(words) == (unmodelled is not None)


def test_every_template_of_a_verdict_is_here() -> None:
    texts = templates()
    assert set(texts["check"]) == set(texts["quantity"]) == set(Code)
    assert {check.code for check, _ in REASONS} == set(Code)
    assert set(texts["measured"]) == set(Reason) == {one.why for one, _ in UNMODELLED if one}


NAN = math.nan
LIMITS = {"good": 0.5, "usable": 2.0}
SAID = [
    ("bar.accuracy", {"p95": 0.4, "one": True, "worst": "bar x, way x", "certificate": {"u_mm":
     0.0}, "word": "good", "limits_mm": LIMITS, "size_mm": 0.4}, "95 %, 0.4 mm, 0.5 mm, 2 mm"),
    ("bar.accuracy", {"p95": 0.4, "one": True, "worst": "bar x, way x", "certificate": {"u_mm":
     0.0}, "word": "usable", "limits_mm": LIMITS, "size_mm": 0.4, "seen": 0.4, "rms_mm": 3.0},
     "95 %, 0.4 mm, 0.5 mm, 2 mm, 40 %, 3 mm"),
    ("bar.accuracy", {"p95": 1.9, "one": False, "worst": "bar x, way x", "certificate": {"u_mm":
     0.1}, "word": "bad", "limits_mm": LIMITS, "size_mm": 2.1}, "95 %, 1.9 mm, 2.1 mm, 2 mm"),
    ("bar.precise", {"p95": 0.4, "one": False, "worst": "oblique"}, "95 %, 0.4 mm"),
    ("bar.mean", {"c": {"class": "bar x, way x", "statistics_mm": {"mean": {"value": 0.5, "lower":
     0.3, "upper": 0.7}}, "n_eff": 30.0, "passes": ["a", "b"]}, "length_mm": 500.0, "fewest": 3},
     "2, 0.50, 0.30, 0.70, +0.1 %"),
    ("bar.mean", {"c": {"class": "bar x, way x", "statistics_mm": {"mean": {"value": 0.5, "lower":
     NAN, "upper": NAN}}, "n_eff": 12.0, "passes": ["a"]}, "length_mm": 500.0, "fewest": 3},
     "0.5 mm, +0.1 %, 12"),
    ("bar.length_bias", {"series": "bar x, way x", "value": -0.31, "lower_95": -0.5, "upper_95":
     -0.12, "passes": 3, "fewest": 3}, "−0.31, −0.50, −0.12"),
    ("bar.length_bias", {"series": "bar x, way x", "value": 0.31, "lower_95": 0.12, "upper_95": 0.5,
     "passes": 1, "fewest": 3}, "0.31, 0.12, 0.50"),
    ("bar.exact", {}, ""),
    ("bar.angle_bias", {"value": 1.9, "lower_95": 1.7, "upper_95": 2.1}, "1.90, 1.70, 2.10"),
    ("bar.by_direction", {"value": 0.31, "lower_95": 0.12, "upper_95": 0.5},
     "0.31 mm, 0.12 mm, 0.5 mm"),
    ("bar.by_pass", {"value": 0.31, "lower_95": 0.12, "upper_95": 0.5, "series": "bar z, way x",
     "farthest": "take-3", "away": -0.7}, "0.31 mm, 0.12 mm, 0.5 mm, 3, −0.7 mm"),
    ("bar.by_place", {"value": 0.31, "lower_95": 0.12, "upper_95": 0.5, "series": "bar z, way x"},
     "0.31 mm, 0.12 mm, 0.5 mm"),
    ("bar.by_speed", {"value": 0.5, "lower_95": 0.4, "upper_95": 0.6}, "0.5, 0.4, 0.6"),
    ("bar.more_than_still", {"value": 12.0}, "12"),
    ("bar.spikes", {"series": "bar z, way x", "value": 0.013}, "1.3 %, 6"),
    ("bar.scale_slope", {"value": 120.0, "lower_95": 60.0, "upper_95": 180.0},
     "120 ppm/m, 60, 180"),
    ("bar.no_slope", {"way_m": 12.7, "slope_ppm_m": -54.2, "lower_95": -688.0, "upper_95": 580.0,
     "pairs": 6}, "12.7 m, -54.2 ppm/m, -688, 580, 6"),
    ("bar.few", {"passes": 1, "fewest": 3}, "1, 3"),
    ("bar.few", {"passes": 4, "few": 2, "of": 5, "fewest": 3}, "2, 5, 3"),
    ("bar.seen", {"seen": 0.7}, "70 %"),
    ("bar.gross", {"n": 1, "at_s": 6.0, "largest": 99.0, "pair": ("A", "B")}, "1, 6 s, 99 mm"),
    ("bar.reversals", {"n": 2, "pair": ("A", "B")}, "2"),
    ("bar.twice", {"name": "x2", "known": "x1"}, "x2, x1"),
    ("bar.change", {"pair": ("A", "B"), "change": -2.01, "at_s": 30.0}, "−2.01 mm, 30 s"),
    ("bar.change", {"pair": ("A", "B"), "change": 0.5, "at_s": NAN}, "0.5 mm"),
    ("bar.repeated", {"share": 0.095}, "9.5 %"),
    ("bar.latency", {"value": -2.0, "lower_95": -2.1, "upper_95": -1.9, "earlier": "B",
     "later": "A"}, "2, 1.9, 2.1"),
    ("bar.loose", {"pair": ("A", "B"), "spread": 2.5, "limit": 1.5}, "2.5 mm, 1.5 mm"),
    ("bar.one_place", {"pair": ("A", "B"), "way": 20.0, "least": 500.0}, "20 mm, 500 mm"),
    ("bar.cluster", {"labels": ["A", "B", "C"], "spread_mm": 0.52, "n_frames": 2941},
     "0.52 mm, 2941"),
    ("points.headline", {"left_out_rms_mm": 7.8, "n": 11, "fit_rms_mm": 5.2}, "7.8 mm, 11, 5.2 mm"),
    ("points.frame_changed", {"cuts": [10, 17], "jumps_mm": [145.0, 62.0], "inside_mm": 7.84},
     "10, 17, 145 mm, 62 mm, 7.84 mm"),
    ("points.frame_drifts", {"drift_mm": 60.0, "rest_mm": 0.5}, "60 mm, 0.5 mm"),
    ("points.does_not_fit", {"noise_mm": 0.5, "rest_mm": 7.8, "has_u": True, "cuts": [],
                             "drift_mm": None, "findings": ["scale"]}, "7.8 mm, 0.5 mm"),
    ("points.does_not_fit", {"noise_mm": 0.5, "rest_mm": 7.8, "has_u": False, "cuts": [10],
                             "drift_mm": None, "findings": []}, "7.8 mm, 0.5 mm"),
    ("points.causes", {"mispaired": True, "cuts": [], "drift_mm": None, "turn_deg": 0.0,
                       "lever_mm": None}, ""),
    ("points.causes", {"mispaired": False, "cuts": [10], "drift_mm": None, "turn_deg": 2.5,
                       "lever_mm": None}, "2.50°"),
    ("points.exchanged", {"exchanged": ["A", "B"], "exchanged_mm": 0.4}, "0.4 mm"),
    ("points.wrong_point", {"wrong_point": "P", "wrong_mm": 5.1, "others_mm": 1.36},
     "5.1 mm, 1.36 mm"),
    ("points.unsteady", {"unsteady": ["P"], "unsteady_mm": 40.0}, "40 mm"),
    ("points.scale", {"scale_ppm": -3700.0, "scale_se_ppm": 1000.0}, "-3700 ppm, 1000"),
    ("points.no_scale", {"scale_ppm": 300.0, "scale_se_ppm": 800.0}, "300 ppm, 800"),
]  # fmt: skip


@pytest.mark.parametrize(("key", "numbers", "said"), SAID)
def test_numbers_of_a_sentence(key: str, numbers: dict, said: str) -> None:
    assert numbers_in(render(key, **numbers)) == said


def test_every_template_of_bars_and_points_is_here() -> None:
    texts = templates()
    keys = {f"{kind}.{case}" for kind in ("bar", "points") for case in texts[kind]}
    assert keys == {key for key, _, _ in SAID}
