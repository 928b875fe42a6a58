"""Verdicts: each check alone turns a good calibration into what it deserves."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mocap_metrology.lighthouse.assess.fit_checks import Case
from mocap_metrology.lighthouse.assess.validation import Verdict, verdict
from mocap_metrology.lighthouse.records import Factory, Halves, PoseEstimate, Station
from mocap_metrology.present.text.calibration import reason

R = Rotation.from_euler("ZYX", [-40, 8, 15], degrees=True).as_matrix()
T = np.array([0.4, 2.1, -0.2])
UP = np.array([0.0, 0.1, 1.0]) / np.hypot(0.1, 1)
STATIONS = [
    Station("master", 1, "b", Factory(), UP, 2),
    Station("slave", 2, "c", Factory(), R.T @ UP, 2),
]
POSE = PoseEstimate(
    "paper-lm", "final", "factory", R, T, covariance=np.diag([1.0, 1, 1, 1e-4, 1e-4, 1e-4]),
    residual_rms_urad=240.0, n_angles=20_000, mirrored_share=0.0,
)  # fmt: skip
GIVEN = {"n_common": 470, "span_m": 0.6, "duration_s": 8.0}


def word(pose=POSE, stations=STATIONS, poses=(), **given):
    return verdict(pose, [pose, *poses], stations, **(GIVEN | given))


WIDE = np.diag([100.0, 1, 1, 1e-4, 1e-4, 1e-4])


@pytest.mark.parametrize(
    ("change", "expected", "case", "numbers"),
    [({"residual_rms_urad": 900.0}, "usable", Case.RESIDUAL_HIGH, {"times": 12}),
     ({"residual_rms_urad": 9000.0}, "failed", Case.RESIDUAL_HIGH, {"times": 120}),
     ({"stage": "static", "residual_rms_urad": 60.0}, "usable", Case.STILL, {}),
     ({"weighted_rms_urad": 84.0, "halves": Halves(1.5, 0.03, 30.0)}, "good", None, {}),
     ({"weighted_rms_urad": 110.0}, "usable", Case.BEYOND_PATH, {"noise": 75}),
     ({"halves": Halves(4.0, 0.05, 2238.0)},
      *("doubtful", Case.HALVES_OPEN, {"mm": 4.0, "deg": 0.05, "times": 19})),
     ({"mirrored_share": 0.42}, "doubtful", Case.MIRRORED_BOTH, {"percent": 42}),
     ({"mirrored_share": 0.02, "estimator": "paper"}, "usable", Case.MIRRORED_FLAT, {}),
     ({"t_m": np.array([1e24, 0.0, 0.0])}, "failed", Case.TOO_DISTANT, {}),
     ({"covariance": WIDE}, "usable", Case.UNCERTAINTY, {"value": 10}),
     ({"covariance": WIDE * np.nan}, "doubtful", Case.UNCERTAINTY_UNKNOWN, {"value": np.nan}),
     ({"n_common": 30}, "doubtful", Case.COMMON_FEW, {"value": 30}),
     ({"n_common": 30, "estimator": "batch", "residual_rms_urad": 60.0}, "good", None, {}),
     ({"board_rms_urad": 40.0}, "good", None, {}),
     ({"board_rms_urad": 120.0}, "usable", Case.BOARD_POSES_HIGH, {"value": 120}),
     ({"duration_s": 2.0}, "usable", Case.DURATION_SHORT, {"value": 2})],
)  # fmt: skip
def test_of_a_pose_and_its_recording(change, expected, case, numbers):
    """Each check has its word; `tests/frozen/words.py` has where each word begins."""
    own = {name: value for name, value in change.items() if hasattr(POSE, name)}
    found = word(replace(POSE, **own), **{k: v for k, v in change.items() if k not in own})
    assert found.word == expected
    decided(found, case, numbers)


@pytest.mark.parametrize(
    ("mm", "share", "expected"),
    [(9.5, 0.0, "good"), (18.0, 0.0, "usable"), (18.0, 0.8, "good"), (35.0, 0.0, "doubtful"),
     (35.0, 0.8, "usable"), (35.0, 1.0, "usable"), (95.0, 1.0, "doubtful")],
)  # fmt: skip
def test_an_open_scale_is_told_and_is_no_sign_of_a_wrong_pose(mm, share, expected) -> None:
    """What remains without its share decides, of a share of 8/9 at most."""
    covariance = np.diag([mm**2, 1, 1, 1e-4, 1e-4, 1e-4])
    details = {"weighted_rms_urad": 60.0, "prior_p": 1.0, "scale_share": share}
    found = word(replace(POSE, estimator="batch", covariance=covariance, details=details))
    told = next(check for check in found.checks if check.name == "uncertainty")
    assert found.word == expected and told.numbers["percent"] == 100 * share
    by_scale = np.sqrt(share * (mm**2 + 2)) / (1e3 * np.linalg.norm(T))
    assert told.numbers["size"] == pytest.approx(100 * by_scale)


def test_single_board_poses_do_not_decide_where_none_is_used() -> None:
    """Reflections that `batch` gives no weight raise them."""
    batch = replace(POSE, estimator="batch", residual_rms_urad=60.0)
    found = word(batch, board_rms_urad=700.0)
    assert found.word == "good"
    assert next(c for c in found.checks if c.name == "board poses").ok is False
    assert "Angles of single board poses are 700" in reason(found)


@pytest.mark.parametrize(
    ("details", "turned", "case"),
    [({}, 0.0, Case.HALVES_APART), ({"prior_p": 1e-9}, 0.0, Case.HALVES_OPEN),
     ({"scale_p": 1e-5}, 0.0, Case.HALVES_OPEN), ({}, 20.0, Case.HALVES_OPEN)],
)  # fmt: skip
def test_a_touch_is_asked_for_where_nothing_else_explains_a_step(details, turned, case) -> None:
    """Not where board, optics or the ways up of the stations contradict the pose."""
    halves = Halves(50.0, 0.5, 900.0, stepped=True)
    details = {"weighted_rms_urad": 60.0, "prior_p": 1.0, **details}
    pose = replace(POSE, estimator="batch", halves=halves, details=details)
    way = Rotation.from_euler("Y", turned, degrees=True).as_matrix() @ UP
    stations = [replace(STATIONS[0], gravity=way), STATIONS[1]]
    assert case in {check.case for check in word(pose, stations).checks}


def decided(found: Verdict, case: Case | None, numbers: dict[str, float]) -> None:
    """By the check of this case, with these numbers, to a half; without a case, all passed."""
    if case is None:
        assert all(check.ok is not False for check in found.checks)
        return
    check = next(c for c in found.checks if c.case is case)
    assert check.level == found.word and not check.ok
    known = {"value": check.value, **check.numbers}
    assert {k: known[k] for k in numbers} == pytest.approx(numbers, abs=0.5, nan_ok=True)
