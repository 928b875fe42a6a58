"""True poses of any number of stations against a calibration of them."""

import json
from pathlib import Path

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import write_json
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.assess.network_reference import network_reference
from mocap_metrology.lighthouse.assess.pose_file import read_pose_json
from mocap_metrology.lighthouse.assess.rows import calibration_rows
from mocap_metrology.lighthouse.assess.summary import summary
from mocap_metrology.lighthouse.calibrate.stages import Calibration
from mocap_metrology.lighthouse.export.formats import Export, crazyflie_yaml, libsurvive_json
from mocap_metrology.lighthouse.records import Station
from mocap_metrology.present.text.calibration import pose_document
from tests.lighthouse.batch.planes_scene import Made, made
from tests.lighthouse.calibrate.test_stations import calibrated, told

CHANNELS = (3, 7, 11)
ROOM = rotation.exp(np.array([0.3, -0.8, 1.9])), np.array([4.0, -2.0, 1.5])  # of the reference


@pytest.fixture(scope="module")
def three() -> tuple[Made, list[Station], Calibration]:
    given = made(3, 1, 4.0)
    return given, told(given), calibrated(given)[0]


def in_room(given: Made) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    R, t = ROOM
    return {k: (R @ own, R @ at + t) for k, (own, at) in zip(CHANNELS, given.poses, strict=True)}


def lab(of: Export) -> str:
    stations = {one.role: {"id": one.id, "R": pose[0].tolist(), "t_m": pose[1].tolist()}
                for one, pose in of.placed}  # fmt: skip
    return json.dumps({"stations": stations})


@pytest.mark.parametrize("write", [lab, crazyflie_yaml, libsurvive_json])
def test_errors_are_those_of_each_station(write, three: tuple, tmp_path: Path) -> None:
    """Of the poses as seen from the reference, whatever frame the file has; station 11 is 25 mm off
    in the file."""
    given, stations, found = three
    poses = in_room(given)
    poses[11] = poses[11][0], poses[11][1] + ROOM[0] @ [0.025, 0, 0]
    (tmp_path / "reference.any").write_text(write(Export(stations, [*poses.values()], [])))
    reference = network_reference(tmp_path / "reference.any")
    result = summary(found, stations, duration_s=6.0, reference=reference)
    write_json(tmp_path / "pose.json", pose_document(result))
    read = read_pose_json(tmp_path / "pose.json")
    for k, (name, shift) in enumerate((("7", 0.0), ("11", 25.0)), start=1):
        entry = read["poses"][read["chosen"][name]]
        R, t = given.poses[k]
        off = 1e3 * (found.estimates[k - 1].t_m - t) - [shift, 0, 0]
        np.testing.assert_allclose(entry["errors_mm"], off, atol=1e-4)
        turn = np.degrees(rotation.error(found.estimates[k - 1].R, R))
        np.testing.assert_allclose(entry["errors_deg"], turn, atol=1e-6)
        true = read["reference_poses"][name]["translation_mm"]
        np.testing.assert_allclose(true, 1e3 * t + [shift, 0, 0], atol=1e-4)
    checks = {check["name"]: check for check in read["checks"]}
    assert "reference" in checks and checks["reference"]["value"] is not None
    record = {"calibration": "c", "setup": "s", "source": "measured"}
    rows = calibration_rows([{**record, "pose": read}])
    assert abs(rows[1]["error_x_mm"] + 25.0) < 2.0


def test_an_own_pose_file_is_a_reference(three: tuple, tmp_path: Path) -> None:
    _, stations, found = three
    document = pose_document(summary(found, stations, duration_s=6.0))
    write_json(tmp_path / "pose.json", document)
    reference = network_reference(tmp_path / "pose.json")
    again = summary(found, stations, duration_s=6.0, reference=reference).document
    assert all(np.abs(p["errors_mm"]).max() < 1e-6 for p in again["poses"])


def test_stations_are_matched_by_id_and_what_lacks_is_said(three: tuple, tmp_path: Path) -> None:
    given, stations, found = three
    poses = in_room(given)
    (tmp_path / "r.json").write_text(lab(Export(stations[:2], [poses[3], poses[7]], [])))
    reference = network_reference(tmp_path / "r.json")
    document = summary(found, stations, duration_s=6.0, reference=reference).document
    assert "errors_mm" in document["poses"][0] and "errors_mm" not in document["poses"][1]
    assert document["diagnostics"]["notes"] == ["The reference has no pose of station 11."]
    swapped = json.loads((tmp_path / "r.json").read_text())
    swapped["stations"]["7"]["id"] = 5
    (tmp_path / "r.json").write_text(json.dumps(swapped))
    with pytest.raises(Refusal, match="its station 7 is 5, that of the recording is 107"):
        network_reference(tmp_path / "r.json").seen_from("3", stations)
    swapped["stations"]["12"] = swapped["stations"].pop("7") | {"id": 107}
    (tmp_path / "r.json").write_text(json.dumps(swapped))
    seen, _ = network_reference(tmp_path / "r.json").seen_from("3", stations)
    np.testing.assert_allclose(seen["7"].t_m, given.poses[1][1], atol=1e-9)


ONE = {"R": np.eye(3).tolist(), "t_m": [0, 0, 0]}


@pytest.mark.parametrize(
    ("stations", "why"),
    [
        ({"master": ONE, "slave": ONE}, "expected stations of the second generation by channel"),
        ({"3": ONE}, "poses of 1 stations; expected two or more"),
        ({"3": ONE, "4": {**ONE, "t_m": [1500.0, 0, 0]}}, "is the unit right"),
        ({"3": ONE, "4": {"t_m": [1, 0, 0]}}, "station 4: no rotation"),
        ({"3": ONE, "4": {**ONE, "R": (2 * np.eye(3)).tolist()}}, "station 4: R is no rotation"),
    ],
)
def test_other_files_are_refused(stations: dict, why: str, tmp_path: Path) -> None:
    (tmp_path / "r.json").write_text(json.dumps({"stations": stations}))
    with pytest.raises(Refusal, match=why):
        network_reference(tmp_path / "r.json")
