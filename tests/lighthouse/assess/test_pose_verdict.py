"""Verdicts: each check alone turns a good calibration into what it deserves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mocap_metrology.lighthouse.assess.fit_checks import WORDS, expected_noise_urad
from mocap_metrology.lighthouse.assess.outside_checks import gravity_angle_deg
from mocap_metrology.lighthouse.assess.verdict import verdict
from mocap_metrology.lighthouse.records import Factory, Halves, PoseEstimate, Station

R = Rotation.from_euler("ZYX", [-40, 8, 15], degrees=True).as_matrix()
T = np.array([0.4, 2.1, -0.2])
UP = np.array([0.0, 0.1, 1.0]) / np.hypot(0.1, 1)
STATIONS = [
    Station("master", 1, "b", Factory(), UP, 2),
    Station("slave", 2, "c", Factory(), R.T @ UP, 2),
]
POSE = PoseEstimate(
    "paper-lm",
    "final",
    "factory",
    R,
    T,
    covariance=np.diag([1.0, 1, 1, 1e-4, 1e-4, 1e-4]),
    residual_rms_urad=240.0,
    n_angles=20_000,
    mirrored_share=0.0,
)
GIVEN = {"n_common": 470, "span_m": 0.6, "duration_s": 8.0}


def word(pose=POSE, stations=STATIONS, poses=(), **given):
    return verdict(pose, [pose, *poses], stations, **(GIVEN | given))


def test_a_good_calibration_is_called_good_and_says_why():
    found = word()
    assert found.word == "good" and "240 µrad" in found.reason and "1 mm" in found.reason
    assert all(check.ok is not False for check in found.checks)


def test_the_memory_of_the_board_is_as_usual_as_eight_seconds():
    said = {
        d: next(c for c in word(duration_s=d).checks if c.name == "duration") for d in (8, 8.38)
    }
    assert all("not the usual" not in c.sentence for c in said.values())
    other = next(c for c in word(duration_s=20.0).checks if c.name == "duration")
    assert "not the usual 8 s" in other.sentence and word(duration_s=20.0).word == "good"


@pytest.mark.parametrize(
    ("change", "expected", "says"),
    [
        ({"residual_rms_urad": 900.0}, "usable", "12 times the noise"),
        ({"residual_rms_urad": 3400.0}, "doubtful", "45 times the noise"),
        ({"stage": "static", "residual_rms_urad": 60.0}, "usable", "did not move"),
        ({"residual_rms_urad": 400.0}, "usable", "5 times the noise"),
        ({"residual_rms_urad": 333.0}, "good", "passed"),
        ({"weighted_rms_urad": 84.0}, "good", "passed"),
        ({"weighted_rms_urad": 110.0}, "usable", "110 µrad of the residual unexplained"),
        ({"halves": Halves(1.5, 0.03, 30.0)}, "good", "passed"),
        ({"halves": Halves(4.0, 0.05, 2238.0)}, "doubtful", "4 mm and 0.05°, 19 times what"),
        ({"halves": Halves(7.0, 0.2, 157.0)}, "usable", "was a station touched"),
        ({"mirrored_share": 0.02}, "usable", "2 % of the board poses"),
        ({"mirrored_share": 0.42}, "doubtful", "42 % of the board poses"),
        ({"mirrored_share": 0.6}, "failed", "60 % of the board poses"),
        ({"mirrored_share": 0.02}, "usable", "both stations decided"),
        ({"mirrored_share": 0.02, "estimator": "paper"}, "usable", "use `paper-lm`"),
        ({"residual_rms_urad": 9000.0}, "failed", "120 times the noise"),
        ({"weighted_rms_urad": 2000.0, "residual_rms_urad": 3000.0}, "failed", "40 times"),
        ({"weighted_rms_urad": 980.0, "residual_rms_urad": 4000.0}, "failed", "53 times"),
        ({"weighted_rms_urad": 150.0, "residual_rms_urad": 400.0}, "usable", "5 times the noise"),
        ({"t_m": np.array([0.0, 20.5, 0.0])}, "failed", "farther than any board"),
        ({"t_m": np.array([1e24, 0.0, 0.0])}, "failed", "farther than any board"),
        ({"covariance": np.diag([100.0, 1, 1, 1e-4, 1e-4, 1e-4])}, "usable", "10 mm"),
        ({"covariance": np.diag([1.0, 1, 1, 1, 1e-4, 1e-4])}, "doubtful", "1°"),
        ({"covariance": np.full((6, 6), np.nan)}, "doubtful", "nan"),
        ({"R": np.full((3, 3), np.nan)}, "failed", "No pose"),
    ],
)
def test_of_the_pose(change, expected, says):
    found = word(replace(POSE, **change))
    assert found.word == expected and says in found.reason


def test_a_small_board_may_have_a_large_residual():
    """2 mrad where errors of its poses make 75 urad 60 times as large; not where they do not."""
    large = replace(POSE, residual_rms_urad=2000.0, weighted_rms_urad=45.0)
    assert word(large).word == "usable"
    small = word(replace(large, noise_gain=60.0))
    assert small.word == "good" and "poses alone make 4500" in small.reason


@pytest.mark.parametrize(
    ("given", "expected", "says"),
    [
        ({"n_common": 199}, "usable", "199 moments"),
        ({"n_common": 200}, "good", "passed"),
        ({"n_common": 30}, "doubtful", "30 moments"),
        ({"board_rms_urad": 40.0}, "good", "passed"),
        ({"board_rms_urad": 120.0}, "usable", "is the board file right"),
        ({"board_rms_urad": 400.0}, "doubtful", "is the board file right"),
        ({"duration_s": 2.0}, "usable", "few measurements"),
        ({"errors": (np.array([50.0, 0, 0]), np.zeros(3))}, "usable", "50 mm"),
        ({"errors": (np.zeros(3), np.array([0, 6.0, 0]))}, "doubtful", "6°"),
    ],
)
def test_of_the_recording(given, expected, says):
    found = word(**given)
    assert found.word == expected and says in found.reason


def test_ideal_optics_are_doubtful_however_good_the_fit():
    found = word(replace(POSE, optics="ideal", residual_rms_urad=60.0))
    assert found.word == "doubtful" and "no residual shows it" in found.reason
    bad = [STATIONS[0], replace(STATIONS[1], factory=None, why="checksum wrong", frames_found=0)]
    found = word(replace(POSE, optics="ideal"), bad)
    assert "slave: checksum wrong" in found.reason


def test_values_of_a_file_are_said():
    found = word(stations=[replace(STATIONS[0], frames_found=0), STATIONS[1]])
    assert found.word == "usable" and "of the master come from a calibration file" in found.reason


def test_stages_and_optics_that_disagree():
    kabsch = replace(POSE, stage="kabsch", t_m=np.add(T, [0.03, 0, 0]))
    assert word(poses=[kabsch]).word == "usable"
    assert word(poses=[replace(kabsch, t_m=np.add(T, [0.2, 0, 0]))]).word == "doubtful"
    ideal = replace(POSE, optics="ideal", t_m=np.add(T, [0.2, 0, 0]))
    assert word(poses=[ideal]).word == "good"  # as factory values do
    assert word(poses=[replace(ideal, t_m=np.add(T, [0.9, 0, 0]))]).word == "doubtful"
    other = replace(POSE, estimator="paper", stage="kabsch", t_m=np.add(T, [5, 0, 0]))
    assert word(poses=[other]).word == "good"


@pytest.mark.parametrize(
    ("deg", "expected"), [(1.0, "good"), (2.5, "good"), (5.0, "doubtful"), (40.0, "failed")]
)
def test_gravity(deg, expected):
    """Turned about a level axis, up differs by the angle of the turn; about up, not at all."""
    level = np.cross(UP, [1.0, 0, 0])
    turn = Rotation.from_rotvec(np.radians(deg) * level / np.linalg.norm(level)).as_matrix()
    assert gravity_angle_deg(turn @ R, STATIONS) == pytest.approx(deg, abs=1e-9)
    assert word(replace(POSE, R=turn @ R)).word == expected
    about_up = Rotation.from_rotvec(np.radians(deg) * UP).as_matrix()
    assert gravity_angle_deg(about_up @ R, STATIONS) == pytest.approx(0, abs=1e-5)
    assert np.isnan(gravity_angle_deg(R, [replace(s, gravity=None) for s in STATIONS]))


def test_no_pose_fails_with_the_reason():
    found = verdict(None, [], STATIONS, why_none="The slave is not seen.")
    assert found[:2] == ("failed", "The slave is not seen.")


def test_reasons_are_what_made_the_word_and_the_rest_in_short():
    found = word(replace(POSE, optics="ideal", mirrored_share=0.4, residual_rms_urad=4000.0))
    said = {c.name: c.sentence for c in found.checks if not c.ok}
    first, second, *rest = (said[n] for n in ("residual", "factory values", "mirrored board poses"))
    assert found.word == "doubtful"
    assert found.reason.startswith(f"{first} {second} ")
    assert rest[0].split(", as by ")[0].rstrip(".") in found.reason
    assert {c.level for c in found.checks} <= set(WORDS)
    assert {*found.checks[0].as_row()} == {
        "name", "value", "unit", "limit", "ok", "level", "sentence"}  # fmt: skip


def test_a_kabsch_pose_that_is_known_to_be_loose_is_no_fault():
    """Apart by 60 mm at 50 mm standard deviation is what chance does; at 5 mm it is not."""
    far = replace(POSE, stage="kabsch", t_m=np.add(T, [0.06, 0, 0]))
    for sigma, expected in ((50.0, "good"), (5.0, "doubtful")):
        loose = replace(far, covariance=np.diag([sigma**2] * 3 + [0.5**2] * 3))
        assert word(poses=[loose]).word == expected


def test_only_kabsch_needs_a_long_path():
    for span, expected in ((0.5, "good"), (0.2, "usable"), (0.05, "doubtful")):
        found = word(replace(POSE, stage="kabsch"), span_m=span)
        assert found.word == expected
        assert word(span_m=span).word == "good"


def test_noise_to_expect_grows_with_the_steps_of_the_clock():
    """61 urad of jitter and, of two edges, pi/8.333 ms x step / sqrt(24): 38.5 urad at 2 MHz."""
    assert expected_noise_urad(0.5e-6) == pytest.approx(np.hypot(61, 38.5), abs=0.1)
    assert expected_noise_urad(1 / 48e6) == pytest.approx(61, abs=0.1)
