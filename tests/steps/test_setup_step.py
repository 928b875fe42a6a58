"""The recordings of a setup, from their files to the pose.json of all."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mocap_metrology.calibration.setup import Member, write_setup
from mocap_metrology.calibration.sweeps import paths_in
from mocap_metrology.calibration.tables import TABLES
from mocap_metrology.common.files import write_json
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.assess.pose_file import (
    chosen_pose,
    is_network,
    matrix_and_metres,
    pairs,
    read_pose_json,
)
from mocap_metrology.lighthouse.assess.rows import calibration_rows
from mocap_metrology.lighthouse.decode.factory_file import stations_to_json
from mocap_metrology.lighthouse.records import Station
from tests.lighthouse.track.test_track_bar import on_a_bar
from tests.steps.test_calibration_bar import SETTINGS, calibrate, write_both

KINDS = ("sweeps", "stations", "board", "pose")


@pytest.fixture(scope="module")
def two_objects(tmp_path_factory: pytest.TempPathFactory) -> tuple:
    """One recording of two objects before three stations, a row of the sheet for each; and the
    setup of both."""
    folder = tmp_path_factory.mktemp("setup")
    made = on_a_bar(3, 3, duration_s=3.0, cover_mm=(-0.75, 1.55), place_mm=0.1)
    write_both(folder / "a.rec.gz", made)
    known = zip(made[0].twin.channels, made[0].ids, made[0].factories, strict=True)
    stations = [Station(str(c), id=i, factory=f, generation=2, channel=c) for c, i, f in known]
    write_json(folder / "stations.json", stations_to_json(stations))
    members = []
    for name, board in (("a", "T20"), ("b", "T21")):
        calibrate(folder, name, "a", board)
        files = paths_in(TABLES, folder / name)
        members.append(Member(name, *(files[kind] for kind in KINDS)))
    return made, folder, members, write_setup("room", members, SETTINGS, str(folder / "pose.json"))


def test_both_objects_of_a_recording_place_the_stations(two_objects) -> None:
    made, folder, _, document = two_objects
    read = read_pose_json(folder / "pose.json")
    assert is_network(read) and read["reference"] == "0" and read["recordings"] == ["a", "b"]
    assert read["covariance_joint_stations"] == ["1", "6"]
    twin = made[0].twin
    for k, (name, one) in enumerate(pairs(read).items(), start=1):
        entry = chosen_pose(one)
        R, t = matrix_and_metres(entry)
        off = np.r_[1e3 * (t - twin.t[k]), np.degrees(rotation.error(R, twin.R[k]))]
        assert np.abs(off / np.sqrt(np.diag(entry["covariance"]))).max() < 3.5
        assert np.linalg.norm(off[:3]) < 10 and np.linalg.norm(off[3:]) < 0.2
        assert set(document["predicted"][name]) == {"a", "b"}
    assert read["verdict"]["word"] in ("good", "usable"), read["verdict"]["reason"]
    record = {"calibration": "room (joint)", "setup": "room", "source": "measured"}
    rows = calibration_rows([{**record, "pose": document}])
    assert [row["calibration"] for row in rows] == [f"room (joint), station {k}" for k in (1, 6)]


def test_a_recording_without_ids_is_matched_by_channel(two_objects) -> None:
    """As of 8 s, in which no frame of factory values is whole."""
    _, folder, members, known = two_objects
    listed = json.loads(Path(members[1].stations).read_text())
    for one in listed:
        one |= {"id": None, "factory": None, "why": "no frame"}
    write_json(folder / "short.json", listed)
    short = replace(members[1], stations=str(folder / "short.json"))
    found = write_setup("room", [members[0], short], SETTINGS, str(folder / "found.json"))
    for name in ("poses", "stations", "covariance_joint"):
        assert json.dumps(found[name]) == json.dumps(known[name])


def test_one_object_of_one_recording_counts_once(two_objects) -> None:
    _, folder, members, _ = two_objects
    twice = [members[0], replace(members[0], name="again"), members[1]]
    found = write_setup("room", twice, SETTINGS, str(folder / "twice.json"))
    assert "a and again are of one object in one recording" in found["verdict"]["reason"]
