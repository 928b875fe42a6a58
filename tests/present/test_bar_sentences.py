"""Sentences on bars and reference points: every template, with its numbers."""

import math
import tomllib
from pathlib import Path

import pytest
from said import numbers_in

from mocap_metrology.present.text import sentence
from mocap_metrology.present.text.sentence import render

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
     0.3, "upper": 0.7}}, "n_eff": 30.0}, "length_mm": 500.0}, "0.50, 0.30, 0.70, +0.1 %"),
    ("bar.mean", {"c": {"class": "bar x, way x", "statistics_mm": {"mean": {"value": 0.5, "lower":
     NAN, "upper": NAN}}, "n_eff": 12.0}, "length_mm": 500.0}, "0.5 mm, +0.1 %, 12"),
    ("bar.length_bias", {"series": "bar x, way x", "value": -0.31, "lower_95": -0.5, "upper_95":
     -0.12, "passes": 3, "fewest": 3}, "−0.31, −0.50, −0.12"),
    ("bar.length_bias", {"series": "bar x, way x", "value": 0.31, "lower_95": 0.12, "upper_95": 0.5,
     "passes": 1, "fewest": 3}, "0.31, 0.12, 0.50"),
    ("bar.exact", {}, ""),
    ("bar.angle_bias", {"value": 1.9}, "1.9°"),
    ("bar.by_direction", {"value": 0.31, "lower_95": 0.12, "upper_95": 0.5},
     "0.31 mm, 0.12 mm, 0.5 mm"),
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
    ("bar.seen", {"seen": 0.7}, "70 %"),
    ("bar.reversals", {"n": 2, "pair": ("A", "B")}, "2"),
    ("bar.twice", {"name": "x2", "known": "x1"}, "x2, x1"),
    ("bar.loose", {"pair": ("A", "B"), "spread": 2.5, "limit": 1.5}, "2.5 mm, 1.5 mm"),
    ("bar.one_place", {"pair": ("A", "B"), "way": 20.0, "least": 500.0}, "20 mm, 500 mm"),
    ("bar.cluster", {"labels": ["A", "B", "C"], "spread_mm": 0.52, "n_frames": 2941},
     "0.52 mm, 2941"),
    ("points.headline", {"left_out_rms_mm": 7.8, "n": 11, "fit_rms_mm": 5.2}, "7.8 mm, 11, 5.2 mm"),
    ("points.frame_changed", {"cuts": [10, 17], "jumps_mm": [145.0, 62.0], "inside_mm": 7.84},
     "10, 17, 145 mm, 62 mm, 7.84 mm"),
    ("points.does_not_fit", {"noise_mm": 0.5, "wrong_point": None}, "0.5 mm"),
    ("points.does_not_fit", {"noise_mm": 0.5, "wrong_point": "P4", "others_mm": 1.36},
     "0.5 mm, 1.36 mm"),
    ("points.scale", {"scale_ppm": -3700.0, "scale_se_ppm": 1000.0}, "-3700 ppm, 1000"),
    ("points.no_scale", {"scale_ppm": 300.0, "scale_se_ppm": 800.0}, "300 ppm, 800"),
]  # fmt: skip


@pytest.mark.parametrize(("key", "numbers", "said"), SAID)
def test_numbers(key: str, numbers: dict, said: str) -> None:
    assert numbers_in(render(key, **numbers)) == said


def test_every_template_is_here() -> None:
    path = Path(sentence.__file__).with_name("recording.toml")
    texts = tomllib.loads(path.read_text(encoding="utf-8"))
    keys = {f"{kind}.{case}" for kind in ("bar", "points") for case in texts[kind]}
    assert keys == {key for key, _, _ in SAID}
