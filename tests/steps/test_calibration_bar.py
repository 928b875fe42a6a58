"""A recording of two objects: a bar as truth of a calibration, and a setup of both."""

import csv
import gzip
import json
import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mocap_metrology.accuracy.bar import BarEntry
from mocap_metrology.calibration.bar import bar
from mocap_metrology.calibration.pose import pose
from mocap_metrology.calibration.setup import Member, write_setup
from mocap_metrology.calibration.sweeps import Entry, paths_in, sweeps
from mocap_metrology.calibration.tables import BAR, TABLES
from mocap_metrology.cli import calibration, main
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
from mocap_metrology.lighthouse.simulate.turns import MadeTurns, write_rec
from mocap_metrology.present.plot.figure import Texts, words_picture
from mocap_metrology.settings import Bar, Lighthouse
from tests.lighthouse.track.test_track_bar import HEAD, LENGTH_M, on_a_bar

NAMES, SERIALS = ("T20", "T21"), ("LHR-A1", "LHR-B2")
LENGTH_MM = 1e3 * LENGTH_M
SETTINGS = Lighthouse(estimators=("batch", "paper-lm"))


def write_both(path: Path, made: list) -> None:
    """Both objects in one file, heads in their descriptions; clocks begin elsewhere."""
    R, t = HEAD
    head = {"plus_x": R[:, 0].tolist(), "plus_z": R[:, 2].tolist(), "position": t.tolist()}
    text = b""
    for k, (one, name, serial) in enumerate(zip(made, NAMES, SERIALS, strict=True)):
        part = path.with_suffix(".part")
        write_rec(part, one, name, serial, begin=k * 700_000_000)
        text += gzip.decompress(part.read_bytes())
    told = f'CONFIG {{"head": {json.dumps(head)}, '.encode()
    path.write_bytes(gzip.compress(text.replace(b"CONFIG {", told), 1))


def write_stations(folder: Path, made: MadeTurns) -> None:
    known = zip(made.twin.channels, made.ids, made.factories, strict=True)
    stations = [Station(str(c), id=i, factory=f, generation=2, channel=c) for c, i, f in known]
    write_json(folder / "stations.json", stations_to_json(stations))


@cache
def recording() -> list[MadeTurns]:
    return on_a_bar(3, 3, duration_s=2.5, cover_mm=(-0.75, 1.55), place_mm=0.1)


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording of two objects before three stations, calibrated by each of them."""
    folder = tmp_path_factory.mktemp("bar")
    write_both(folder / "a.rec.gz", recording())
    write_stations(folder, recording()[0])
    for name, board in (("a", "T20"), ("b", "T21")):
        calibrate(folder, name, "a", board)
    return folder


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures take most of the time of the command."""
    for name in ("calibration_figure", "track_figure"):
        monkeypatch.setattr(calibration, name, lambda *_: words_picture("undrawn", Texts("")))


@pytest.fixture(scope="module")
def attitude() -> str:
    """Of the heads, turned half about the way up against each other."""
    turn = Rotation.from_matrix(HEAD[0])
    half = turn.inv() * Rotation.from_euler("z", 180, degrees=True) * turn
    return json.dumps({"quaternion_xyzw": half.as_quat().tolist()})


@pytest.fixture(scope="module")
def found(lab: Path, attitude: str) -> dict:
    asked = BarEntry("T20-T21", LENGTH_MM, 0.1, attitude)
    return judged(lab, entry_of(lab, "a", "a", "T20"), asked) | {
        "csv": (lab / "a/bar.csv").read_text(),
        "json": (lab / "a/bar.json").read_text(),
    }


def calibrate(folder: Path, name: str, recording: str, board: str) -> Entry:
    own = folder / name
    own.mkdir(exist_ok=True)
    entry = entry_of(folder, name, recording, board)
    given = {"dump": str(entry.path), "factory": str(folder / "stations.json")}
    sweeps(entry, given, SETTINGS, own)
    pose(entry, {}, SETTINGS, None, own)
    return entry


def entry_of(folder: Path, name: str, recording: str, board: str) -> Entry:
    return Entry(name, str(folder / f"{recording}.rec.gz"), "libsurvive-rec", board)


def judged(folder: Path, entry: Entry, asked: BarEntry, **more: object) -> dict:
    own = folder / entry.calibration
    given = {"dump": str(entry.path), "factory": str(folder / "stations.json")}
    given |= paths_in(TABLES, own) | more.pop("given", {})
    return bar(entry, asked, given, SETTINGS, Bar(), paths_in(BAR, own), **more)


def test_a_bar_is_as_long_as_it_is(found: dict) -> None:
    """Stations 2.5 m away, calibrated by one object through its cover."""
    assert found["word"] == "good" and sum(one["n_frames"] for one in found["classes"]) > 140
    for statistics in (one["statistics_mm"] for one in found["classes"]):
        assert abs(statistics["mean"]["value"]) < 1.0 and statistics["sd"]["value"] < 0.3
    assert found["stated"]["sd_mm"] < 1.0 and found["stated"]["within_2"] > 0.9
    assert found["clock"]["rms_ns"] < 100 and found["clock"]["stations_apart_ns"] < 100
    assert found["angles_deg"]["p95"]["value"] < 0.3
    rows = list(csv.DictReader(found["csv"].splitlines()))
    assert {row["quantity"] for row in rows} == {"length_mm", "angle_deg"}
    written = json.loads(found["json"])
    assert written["pair"] == ["T20", "T21"] and written["certificate"]["length_mm"] == LENGTH_MM


def test_the_other_end_can_be_of_another_row(lab: Path, attitude: str, found: dict) -> None:
    entry, other = entry_of(lab, "a", "a", "T20"), entry_of(lab, "b", "a", "T21")
    given = {"other_dump": str(other.path)}
    given |= {f"other_{k}": v for k, v in paths_in(TABLES, lab / "b").items()}
    asked = BarEntry("T20-b:T21", LENGTH_MM, 0.1, attitude)
    of_rows = judged(lab, entry, asked, given=given, other=other)
    assert of_rows["pair"] == ["T20", "b:T21"]
    assert json.dumps(of_rows["classes"]) == json.dumps(found["classes"])
    refused = judged(lab, entry, BarEntry("T20-b:T20", LENGTH_MM), given=given, other=other)
    assert refused["refused"] == "bar: b:T20 is not the board of calibration b"


@pytest.mark.parametrize(
    ("asked", "why"),
    [
        (BarEntry("T20-T22"), 'bar is "T20-T22"; expected two objects of the recording'),
        (BarEntry("T20-LHR-A1"), "expected the board T20 and another object"),
        (BarEntry("T20-T21", 26.786), "length_mm is 26.786, but T20 and T21 are 26.* is it in cm"),
    ],
)
def test_what_is_no_bar_is_refused(lab: Path, asked: BarEntry, why: str) -> None:
    found = judged(lab, entry_of(lab, "a", "a", "T20"), asked)
    assert re.search(why, found["refused"])
    assert (lab / "a/bar.csv").read_text() == "quantity,class\n"


@pytest.mark.usefixtures("undrawn")
def test_the_command(lab: Path, tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    named = ["--board", "T20", "--bar", "T20-T21", "--length", "267.86"]
    given = ["--factory", str(lab / "stations.json"), "--output", str(tmp_path / "out")]
    assert main.main(["check", str(lab / "a.rec.gz"), *named, *given]) == 0
    assert "Error of the length of T20 and T21 against its certificate" in capsys.readouterr().out
    assert json.loads((tmp_path / "out/bar.json").read_text())["pair"] == ["T20", "T21"]


@pytest.fixture(scope="module")
def members(lab: Path) -> list[Member]:
    """A row of the sheet for each object."""
    kinds = ("sweeps", "stations", "board", "pose")
    own = {name: paths_in(TABLES, lab / name) for name in ("a", "b")}
    return [Member(name, *(files[kind] for kind in kinds)) for name, files in own.items()]


def test_both_objects_of_a_recording_place_the_stations(lab: Path, members: list) -> None:
    document = write_setup("room", members, SETTINGS, str(lab / "pose.json"))
    read = read_pose_json(lab / "pose.json")
    assert is_network(read) and read["reference"] == "0" and read["recordings"] == ["a", "b"]
    assert read["covariance_joint_stations"] == ["1", "6"]
    twin = recording()[0].twin
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


def test_one_object_of_one_recording_counts_once(lab: Path, members: list) -> None:
    twice = [members[0], replace(members[0], name="again"), members[1]]
    found = write_setup("room", twice, SETTINGS, str(lab / "twice.json"))
    assert "a and again are of one object in one recording" in found["verdict"]["reason"]
