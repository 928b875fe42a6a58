"""pose.json: what is written is what is read; earlier poses compared with closed forms."""

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import write_json
from mocap_metrology.lighthouse.assess.calibration_files import beyond_sigma
from mocap_metrology.lighthouse.assess.pose_file import (
    chosen_pose,
    matrix_and_metres,
    pose_json,
    read_pose_json,
)
from mocap_metrology.lighthouse.assess.reference import Reference
from mocap_metrology.lighthouse.assess.validation import verdict
from mocap_metrology.lighthouse.records import PoseEstimate, Station

ANGLES = (15.0, 8.0, -40.0)  # alpha, beta, gamma in deg
R = Rotation.from_euler("ZYX", ANGLES[::-1], degrees=True).as_matrix()
T = np.array([0.4, 2.1, -0.2])
STATIONS = [Station("master", 11, "b"), Station("slave", 12, "c")]
COVARIANCE = np.diag([4.0, 1, 1, 1e-4, 1e-4, 1e-4])


def estimate(stage="final", t=T, turn=R, covariance=COVARIANCE, **more):
    return PoseEstimate(
        "paper-lm", stage, "ideal", turn, np.asarray(t), "optical", covariance, **more
    )


def content(poses=None, stations=STATIONS, chosen=0, **more):
    poses = [estimate()] if poses is None else poses
    found = verdict(None if chosen is None else poses[chosen], poses, stations)
    return pose_json(poses, stations, {} if chosen is None else {"slave": chosen}, found, **more)


def test_written_and_read(tmp_path):
    poses = [estimate("kabsch", covariance=None), estimate(seconds=1.5)]
    reference = Reference(R, T - [0.001, 0, 0])
    diagnostics = {"n_common": 470, "span_m": np.float64(0.5)}
    made = content(poses, chosen=1, true={"slave": reference}, diagnostics=diagnostics)
    write_json(tmp_path / "pose.json", made)
    given = read_pose_json(tmp_path / "pose.json")
    assert given["stations"] == {
        "master": {"id": 11, "mode": "b"},
        "slave": {"id": 12, "mode": "c"},
    }
    assert given["verdict"]["word"] == "doubtful" and given["convention"].startswith("Pose of")
    assert given["diagnostics"]["n_common"] == 470
    pose = chosen_pose(given)
    assert (pose["estimator"], pose["stage"], pose["frame"]) == ("paper-lm", "final", "optical")
    assert "seconds" not in json.dumps(given)
    np.testing.assert_allclose(pose["translation_mm"], [400, 2100, -200])
    np.testing.assert_allclose(list(pose["rotation_deg"].values()), ANGLES, atol=1e-9)
    np.testing.assert_allclose(matrix_and_metres(pose)[0], R, atol=1e-12)
    np.testing.assert_allclose(pose["errors_mm"], [1, 0, 0], atol=1e-9)
    pose["errors_deg"] = [0.0, 0.0, 0.0]
    for error_mm, is_beyond in ([5.9, 0, 0], False), ([0, 3.1, 0], True), (None, False):
        assert beyond_sigma(pose | {"errors_mm": error_mm}) == is_beyond  # sigma: 2, 1, 1 mm
    np.testing.assert_allclose(pose["covariance"], COVARIANCE)
    assert given["poses"][0]["covariance"] is None
    assert pose["residual_rms_urad"] is None  # unknown, as JSON has no NaN


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"stations": {"master": {"id": 1}}}'])
def test_other_files_are_refused(tmp_path, text):
    (tmp_path / "pose.json").write_text(text)
    with pytest.raises(Refusal, match=r"pose\.json"):
        read_pose_json(tmp_path / "pose.json")


@pytest.mark.parametrize(
    ("field", "value", "match"),
    [
        ("covariance", [[1.0, 2.0]], "covariance"),
        ("covariance", [[1.0], [2.0, 3.0]], "inhomogeneous"),
        ("covariance", [[0.0] * 5 + [float(k)] for k in range(6)], "symmetric"),
        ("covariance", [[float("nan")] * 6] * 6, "symmetric"),
        ("quaternion_xyzw", [0.0, 0.0, 0.0, 1.0101], "quaternion_xyzw is"),
        ("quaternion_xyzw", [0.0, 0.0, 0.0, 0.9899], "quaternion_xyzw is"),
        ("quaternion_xyzw", [0.0, 0.0, 1.0], "quaternion_xyzw is"),
        ("translation_mm", [10**400, 0, 0], "too large"),
        ("translation_mm", [1.0, 2.0], "translation_mm is"),
        ("translation_mm", [1.0, 2.0, float("nan")], "translation_mm is"),
    ],
)
def test_damaged_poses_are_refused(tmp_path, field, value, match):
    """Those that no comparison should begin with."""
    write_json(tmp_path / "pose.json", content([estimate()]))
    document = json.loads((tmp_path / "pose.json").read_text())
    document["poses"][0][field] = value
    (tmp_path / "pose.json").write_text(json.dumps(document))
    with pytest.raises(Refusal, match=match):
        read_pose_json(tmp_path / "pose.json")


@pytest.mark.parametrize("chosen", [-1, 1, True, "0"])
def test_a_choice_of_none_of_the_poses_is_refused(tmp_path, chosen):
    write_json(tmp_path / "pose.json", content([estimate()]) | {"chosen": chosen})
    with pytest.raises(Refusal, match="of 1 poses"):
        read_pose_json(tmp_path / "pose.json")
