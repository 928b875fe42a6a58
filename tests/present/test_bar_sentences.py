"""Sentences on bars and reference points: every template, with its numbers."""

import math
import tomllib
from pathlib import Path

import pytest

from mocap_metrology.present.text import sentence
from mocap_metrology.present.text.sentence import render

NAN = math.nan
LIMITS = {"good": 0.5, "usable": 2.0}
SAID = [
    ("bar.accuracy", {"p95": 0.4, "one": True, "worst": "bar x, way x", "certificate": {"u_mm":
     0.0}, "word": "good", "limits_mm": LIMITS, "size_mm": 0.4},
     "95 % of the lengths are wrong by at most 0.4 mm (limits: good 0.5 mm, usable 2 mm)."),
    ("bar.accuracy", {"p95": 0.4, "one": True, "worst": "bar x, way x", "certificate": {"u_mm":
     0.0}, "word": "usable", "limits_mm": LIMITS, "size_mm": 0.4, "seen": 0.4, "rms_mm": 3.0},
     "95 % of the lengths are wrong by at most 0.4 mm (limits: good 0.5 mm, usable 2 mm). It is "
     "usable at best, as both ends were seen in 40 % of the frames, as gross errors make the rms "
     "3 mm."),
    ("bar.accuracy", {"p95": 1.9, "one": False, "worst": "bar x, way x", "certificate": {"u_mm":
     0.1}, "word": "bad", "limits_mm": LIMITS, "size_mm": 2.1},
     "95 % of the lengths are wrong by at most 1.9 mm in the worst direction (bar x, way "
     "x); with twice the certificate's standard uncertainty 2.1 mm (the limit is 2 mm)."),
    ("bar.precise", {"p95": 0.4, "one": False, "worst": "oblique"},
     "95 % of the lengths are within 0.4 mm of their mean in the worst direction "
     "(oblique). No accuracy is stated without a certificate (length_mm)."),
    ("bar.mean", {"c": {"class": "bar x, way x", "statistics_mm": {"mean": {"value": 0.5,
     "lower": 0.3, "upper": 0.7}}, "n_eff": 30.0}, "length_mm": 500.0},
     "Bar x, way x: mean error 0.50 (0.30…0.70) mm, +0.1 % of the length."),
    ("bar.mean", {"c": {"class": "bar x, way x", "statistics_mm": {"mean": {"value": 0.5,
     "lower": NAN, "upper": NAN}}, "n_eff": 12.0}, "length_mm": 500.0},
     "Bar x, way x: mean error 0.5 mm, +0.1 % of the length (no interval: the frames are "
     "worth 12 independent ones)."),
    ("bar.length_bias", {"series": "bar x, way x", "value": -0.31, "lower_95": -0.5, "upper_95":
     -0.12, "passes": 3, "fewest": 3},
     "Bar x, way x: lengths are too short on average, by more than mean and certificate "
     "are uncertain: −0.31 (−0.50…−0.12) mm."),
    ("bar.length_bias", {"series": "bar x, way x", "value": 0.31, "lower_95": 0.12, "upper_95":
     0.5, "passes": 1, "fewest": 3},
     "Bar x, way x: lengths are too long on average in this pass, by more than mean and "
     "certificate are uncertain: 0.31 (0.12…0.50) mm."),
    ("bar.exact", {},
     "The certified length is taken as exact: state its standard uncertainty (length_u_mm)."),
    ("bar.angle_bias", {"value": 1.9},
     "The rotation between the bodies differs from the stated one by 1.9° on average."),
    ("bar.by_direction", {"value": 0.31, "lower_95": 0.12, "upper_95": 0.5},
     "The mean length depends on the direction of bar and motion: 0.31 mm (SD; 0.12 mm to "
     "0.5 mm)."),
    ("bar.by_direction", {"value": 0.31, "lower_95": 0.12, "upper_95": 5.0},
     "The mean length depends on the direction of bar and motion: 0.31 mm (SD; at least "
     "0.12 mm)."),
    ("bar.by_place", {"value": 0.31, "lower_95": 0.12, "upper_95": 0.5, "series":
     "bar z, way x"},
     "Bar z, way x: the length depends on the place, by 0.31 mm (SD of a quadratic "
     "surface; 0.12 mm to 0.5 mm)."),
    ("bar.by_place", {"value": 0.31, "lower_95": NAN, "upper_95": NAN, "series":
     "bar z, way x"},
     "Bar z, way x: the length depends on the place, by 0.31 mm (SD of a quadratic "
     "surface)."),
    ("bar.by_speed", {"value": 0.5, "lower_95": 0.4, "upper_95": 0.6},
     "What remains grows with speed to the power of 0.5 (0.4 to 0.6)."),
    ("bar.more_than_still", {"value": 12.0},
     "What remains of a moving bar is 12 times the noise of its length at rest."),
    ("bar.spikes", {"series": "bar z, way x", "value": 0.013},
     "Bar z, way x: 1.3 % of the frames are beyond 6 standard deviations of what remains. "
     "Possible causes: wrong assignments, markers half hidden."),
    ("bar.scale_slope", {"value": 120.0, "lower_95": 60.0, "upper_95": 180.0},
     "The scale changes along the way by 120 ppm/m (60 to 180)."),
    ("bar.no_slope", {"way_m": 12.7, "slope_ppm_m": -54.2, "lower_95": -688.0, "upper_95":
     580.0, "pairs": 6},
     "A change of the scale is not shown along the way of 12.7 m: -54.2 ppm/m (-688 to "
     "580, 6 pairs)."),
    ("bar.few", {"passes": 1, "fewest": 3},
     "1 pass: statistics have no interval but that of a mean. Record 3 passes or more, as "
     "rows of one group."),
    ("bar.few", {"passes": 2, "fewest": 3},
     "2 passes: statistics have no interval but that of a mean. Record 3 passes or more, "
     "as rows of one group."),
    ("bar.seen", {"seen": 0.7},
     "both ends were seen in 70 % of the frames: of the others no error is known"),
    ("bar.reversals", {"n": 2, "pair": ("A", "B")},
     "the bar points the other way from one frame to the next (2 of them): A and B "
     "exchange their labels, which leaves the length as it is"),
    ("bar.twice", {"name": "x2", "known": "x1"}, "x2 is the same file as x1, and counts once"),
    ("bar.loose", {"pair": ("A", "B"), "spread": 2.5, "limit": 1.5},
     "the distance of A and B spreads by 2.5 mm, more than 1.5 mm (bar.rigid_mm): are both"
     " on one stiff object?"),
    ("bar.one_place", {"pair": ("A", "B"), "way": 20.0, "least": 500.0},
     "A and B move by 20 mm, less than 500 mm (bar.least_path_mm): the errors are those of"
     " one place"),
    ("bar.cluster", {"labels": ["A", "B", "C"], "spread_mm": 0.52, "n_frames": 2941},
     "Rigid: A, B, C (spread 0.52 mm, seen in 2941 frames)."),
    ("points.headline", {"left_out_rms_mm": 7.8, "n": 11, "fit_rms_mm": 5.2},
     "A point that the fit does not know is off by 7.8 mm (rms of 11; the fit itself "
     "leaves 5.2 mm)."),
    ("points.frame_changed", {"cuts": [10, 17], "jumps_mm": [145.0, 62.0], "inside_mm": 7.84},
     "The frame changed while the points were taken: after points 10, 17, by 145 mm, 62 mm"
     " rms; with a frame for each part 7.84 mm are left."),
    ("points.frame_changed", {"cuts": [10], "jumps_mm": [145.0], "inside_mm": 7.84},
     "The frame changed while the points were taken: after point 10, by 145 mm rms; with a"
     " frame for each part 7.84 mm are left."),
    ("points.does_not_fit", {"noise_mm": 0.5, "wrong_point": None},
     "No rigid fit explains the points: they are off by more than ten times the noise of "
     "takes and reference (0.5 mm). The volume is distorted by as much, or points are not those "
     "of the reference: check which belongs to which, and the order of the columns."),
    ("points.does_not_fit", {"noise_mm": 0.5, "wrong_point": "P4", "others_mm": 1.36},
     "No rigid fit explains the points: they are off by more than ten times the noise of "
     "takes and reference (0.5 mm). Without point P4 the others fit to 1.36 mm: check this point."),
    ("points.scale", {"scale_ppm": -3700.0, "scale_se_ppm": 1000.0},
     "The scale of these points differs by -3700 ppm (standard error 1000)."),
    ("points.no_scale", {"scale_ppm": 300.0, "scale_se_ppm": 800.0},
     "No difference of scale is claimed: 300 ppm of these points, standard error 800."),
]  # fmt: skip


@pytest.mark.parametrize(("key", "numbers", "words"), SAID)
def test_words(key: str, numbers: dict, words: str) -> None:
    assert render(key, **numbers) == words


def test_every_template_has_its_words_here() -> None:
    path = Path(sentence.__file__).with_name("recording.toml")
    texts = tomllib.loads(path.read_text(encoding="utf-8"))
    keys = {f"{kind}.{case}" for kind in ("bar", "points") for case in texts[kind]}
    assert keys == {key for key, _, _ in SAID}
