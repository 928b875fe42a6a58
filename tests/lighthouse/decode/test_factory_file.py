"""Calibrations from files: there and back, libsurvive's file, and refusals."""

import json
from pathlib import Path

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import write_json
from mocap_metrology.lighthouse.decode.chain import _with_factory
from mocap_metrology.lighthouse.decode.factory_file import (
    NAMES_OF,
    read_factory,
    stations_from_json,
    stations_to_json,
)
from mocap_metrology.lighthouse.records import Factory, Station

COMPANION = "lighthouse/libsurvive_extras/lh1_test_cal.rec.gz.json"
FACTORY = Factory(*(np.array([0.01 * k, -0.005 * k]) for k in range(1, 6)))
MASTER = Station(
    "master", 4152238579, "b", FACTORY, np.array([0.0, 0.6, 0.8]), 3, "", firmware=436, hardware=9,
    up_by_geometry=np.array([0.6, 0.0, 0.8]),
)  # fmt: skip
SLAVE = Station("slave", why="no calibration frame")


def test_gravity_of_a_file_is_taken_where_the_recording_tells_none(tmp_path: Path) -> None:
    write_json(tmp_path / "stations.json", stations_to_json([MASTER, SLAVE]))
    up = np.array([0.0, 0.0, 1.0])
    for own, expected in ((None, MASTER.gravity), (up, up)):
        seen = [Station("master", why="no frame", gravity=own), SLAVE]
        stations, notes = _with_factory(seen, tmp_path / "stations.json")
        assert stations[0].gravity.tolist() == expected.tolist()
        assert stations[0].factory is not None and len(notes) == 1


def test_there_and_back(tmp_path: Path) -> None:
    """Through the file, master first whatever the order given."""
    entries = stations_to_json([SLAVE, MASTER])
    assert [e["role"] for e in entries] == ["master", "slave"]
    assert entries[0]["factory"]["gibphase"] == [0.04, -0.02]
    write_json(tmp_path / "stations.json", entries)
    master, slave = stations_from_json(json.loads((tmp_path / "stations.json").read_text()))
    assert slave == SLAVE
    assert (master.id, master.mode, master.frames_found) == (4152238579, "b", 3)
    assert (master.firmware, master.hardware) == (436, 9)
    assert master.gravity.tolist() == MASTER.gravity.tolist()
    assert master.up_by_geometry.tolist() == [0.6, 0.0, 0.8]
    for name in NAMES_OF[2]:
        assert getattr(master.factory, name).tolist() == getattr(FACTORY, name).tolist()
    filed = read_factory(tmp_path / "stations.json")
    assert [(s.role, s.id) for s in filed] == [("master", 4152238579)]


def test_the_file_of_libsurvive(samples: Path) -> None:
    """Its lighthouse 1 flashes first: the master; its id is printed with a sign."""
    master, slave = read_factory(samples / COMPANION)
    assert (master.role, master.id, master.mode) == ("master", -142728717 + 2**32, "b")
    assert (slave.role, slave.id, slave.mode) == ("slave", 178605925, "A")
    assert slave.factory.gibphase.tolist() == [2.890625, 0.024002]


GOOD = stations_to_json([MASTER])[0]
SHORT = {**GOOD["factory"], "tilt": [0.1]}
LIGHTHOUSE_2 = {**GOOD["factory"], "curve": [0.35, 0.14]}
CASES = {
    "no JSON": ("not: json", "no JSON"),
    "nested": ("[" * 100_000, "no JSON"),
    "nested YAML": ("lighthouse_system_configuration: " + "[" * 5000, "no YAML"),
    "beyond floats": ([{**GOOD, "gravity": [10**400, 0, 1]}], "gravity is"),
    "no list": ({"a": 1}, "expected a list"),
    "no role": ([{"id": 1}], "role is None"),
    "two masters": ([GOOD, GOOD], "two stations have the same role"),
    "id of 33 bits": ([{**GOOD, "id": 1 << 32}], "id is"),
    "unknown mode": ([{**GOOD, "mode": "B"}], "mode is 'B'"),
    "one number": ([{**GOOD, "factory": SHORT}], "tilt is"),
    "a number": ([{**GOOD, "factory": 3}], "factory is not an object"),
    "second generation": ([{**GOOD, "factory": LIGHTHOUSE_2}], "second-generation"),
    "gravity": ([{**GOOD, "gravity": [0, 0]}], "gravity is"),
    "up": ([{**GOOD, "up_by_geometry": [0, 0, 1, 0]}], "up_by_geometry is"),
    "no values": ([stations_to_json([SLAVE])[0]], "no station has factory values"),
}


@pytest.mark.parametrize("case", CASES)
def test_bad_files_get_one_line(tmp_path: Path, case: str) -> None:
    content, message = CASES[case]
    path = tmp_path / "bad.json"
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    with pytest.raises(Refusal, match=message) as refused:
        read_factory(path)
    assert "bad.json" in str(refused.value) and "\n" not in str(refused.value)


CRAZYFLIE = """
calibs:
  0:
    sweeps:
    - {curve: 0.004421234130859375, gibmag: 0.016876220703125, gibphase: 1.705078125,
       ogeemag: 0.0, ogeephase: 0.0, phase: 0.0178680419921875, tilt: -0.005260467529296875}
    - {curve: -0.00661468505859375, gibmag: -0.006725311279296875, gibphase: 0.55322265625,
       ogeemag: 0.0, ogeephase: 0.0, phase: 0.054107666015625, tilt: 0.00345611572265625}
    uid: 4255386550
  1:
    sweeps:
    - curve: 0.001911163330078125
      gibmag: 0.001270294189453125
      gibphase: 2.3671875
      phase: 0.0257110595703125
      tilt: -0.0027256011962890625
    - curve: -0.0004279613494873047
      gibmag: -0.008636474609375
      gibphase: -1.099609375
      phase: 0.0540771484375
      tilt: -0.002552032470703125
    uid: 3359964365
geos:
  0: {origin: [-2.6, -0.3, 3.2], rotation: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}
systemType: 1
type: lighthouse_system_configuration
version: '1'
"""


@pytest.mark.parametrize("name", ["system-config.yaml", "any.txt"])
def test_the_system_configuration_of_a_crazyflie(tmp_path: Path, name: str) -> None:
    """Values of two real stations; station 0 flashes first."""
    path = tmp_path / name
    path.write_text(CRAZYFLIE)
    master, slave = read_factory(path)
    assert (master.role, master.id) == ("master", 4255386550)
    assert (slave.role, slave.id) == ("slave", 3359964365)
    assert master.factory.phase.tolist() == [0.0178680419921875, 0.054107666015625]
    assert master.factory.curve.tolist() == [0.004421234130859375, -0.00661468505859375]
    assert slave.factory.gibphase.tolist() == [2.3671875, -1.099609375]
    assert slave.factory.gibmag.tolist() == [0.001270294189453125, -0.008636474609375]
    assert slave.factory.tilt.tolist() == [-0.0027256011962890625, -0.002552032470703125]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("systemType: 1", "systemType: 2", "second-generation"),
        ("systemType: 1\n", "", "of a second-generation"),
        ("version: '1'", "version: '7'", "version is '7'"),
        ("tilt: -0.0027256011962890625", "tilt: left", "calibs.1.sweeps.0..tilt is 'left'"),
        ("tilt: -0.0027256011962890625", "tilt: '1_0'", "calibs.1.sweeps.0..tilt is '1_0'"),
        ("tilt: -0.0027256011962890625", "tilt: 'nan'", "calibs.1.sweeps.0..tilt is nan"),
        ("tilt: -0.0027256011962890625", "slope: 0", "calibs.1.sweeps.0..tilt is None"),
        ("uid: 3359964365", "uid: -3", "calibs.1.uid is -3"),
        ("  1:\n    sweeps:", "  1:\n    sweeps: []\n    other:", "two, azimuth and elevation"),
        ("  1:\n    sweeps", "  4:\n    sweeps", "calibs of station 4"),
        ("curve: 0.0019111", "curve: 0.2119111", "second-generation"),
        ("geos:", "\tgeos:", "no YAML"),
        ("geos:", "  geos:", "key 0 is repeated"),
    ],
)
def test_bad_configurations_of_a_crazyflie(
    tmp_path: Path, old: str, new: str, message: str
) -> None:
    assert old in CRAZYFLIE
    path = tmp_path / "bad.yaml"
    path.write_text(CRAZYFLIE.replace(old, new, 1))
    with pytest.raises(Refusal, match=message) as refused:
        read_factory(path)
    assert "bad.yaml" in str(refused.value) and "\n" not in str(refused.value)


def test_missing_and_second_generation_files(tmp_path: Path, samples: Path) -> None:
    with pytest.raises(Refusal, match="cannot be read"):
        read_factory(tmp_path / "none.json")
    found = read_factory(samples / "lighthouse/libsurvive_extras/haagh-tracking.rec.gz.json")
    assert [(one.role, one.channel, one.generation) for one in found] == [("2", 2, 2), ("8", 8, 2)]
