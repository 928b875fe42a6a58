"""Files of other programs: their content by other parsers, by this project's own readers, and by
those of the programs, where these are installed."""

import json
import os
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest
import yaml

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.assess.reference import pose_reference
from mocap_metrology.lighthouse.decode.factory_file import FACTORY_NAMES, read_factory
from mocap_metrology.lighthouse.decode.libsurvive_solution import read_solution, solution_pose
from mocap_metrology.lighthouse.export.formats import (
    Export,
    crazyflie_yaml,
    libsurvive_json,
    ros2_launch,
)
from mocap_metrology.lighthouse.records import Factory, Station

VALUES = FACTORY_NAMES
STATIONS = [
    Station("master", 4152238579, "b", Factory(*(np.array([1e-5 * k, -0.05]) for k in range(5)))),
    Station("slave", 178605925, "A", Factory(*(np.array([0.03, -6e-8 * k]) for k in range(5)))),
]
# By hand. The master stands at (1, 2, 3), level, and looks along -y of the room: its left is +x.
# The slave hangs at (-1, 0, 2.5), looks down, its top towards +x: its left is +y.
X, Y, Z = np.eye(3)
AXES = [(-Y, X, Z), (-Z, Y, X)]
PLACES = [np.array([1.0, 2.0, 3.0]), np.array([-1.0, 0.0, 2.5])]
POSES = [(np.stack(axes, axis=1), place) for axes, place in zip(AXES, PLACES, strict=True)]
GOOD = Export(STATIONS, POSES, ["Calibration hall--1, verdict good.", 'World: "z" up \\ ±1°, µ.'])
FAILED = Export(STATIONS, None, ["No poses, because the calibration failed: −3 µrad."])


def turned(q_xyzw: list[float], v: np.ndarray) -> np.ndarray:
    """v turned by a quaternion: v + 2 w (u x v) + 2 u x (u x v)."""
    *u, w = q_xyzw
    assert np.linalg.norm(q_xyzw) == pytest.approx(1)
    return v + 2 * w * np.cross(u, v) + 2 * np.cross(u, np.cross(u, v))


def members(text: str) -> dict:
    """libsurvive's configuration: the entries of an object, without its braces."""
    assert not text.startswith("{")
    return json.loads("{" + text + "}")


def test_crazyflie() -> None:
    found = yaml.safe_load(crazyflie_yaml(GOOD))
    assert (found["type"], found["version"]) == ("lighthouse_system_configuration", "1")
    assert found["systemType"] == 1
    for k, (axes, place) in enumerate(zip(AXES, PLACES, strict=True)):
        geo = found["geos"][k]
        assert geo["origin"] == place.tolist()
        assert np.array(geo["rotation"]).T.tolist() == [axis.tolist() for axis in axes]
        assert found["calibs"][k]["uid"] == STATIONS[k].id
        for axis, sweep in enumerate(found["calibs"][k]["sweeps"]):
            for name in VALUES:
                assert sweep[name] == pytest.approx(getattr(STATIONS[k].factory, name)[axis])
            assert (sweep["ogeemag"], sweep["ogeephase"]) == (0, 0)


def test_libsurvive() -> None:
    """A station of libsurvive looks along its -Z, X to its right, Y up. Lighthouse 1 flashes first,
    so it is the master. Arrays are of texts, and its id is unsigned."""
    found = members(libsurvive_json(GOOD))
    for k, (ahead, left, top) in enumerate(AXES):
        own = found[f"lighthouse{1 - k}"]
        assert [own[key] for key in ("index", "id", "mode")] == [
            str(1 - k),
            str(STATIONS[k].id),
            "10"[k],
        ]
        assert (own["OOTXSet"], own["PositionSet"]) == ("1", "1")
        x, y, z, w, *v = map(float, own["pose"])
        assert [x, y, z] == PLACES[k].tolist()
        for given, expected in ((X, -left), (Y, top), (Z, -ahead)):
            np.testing.assert_allclose(turned([*v, w], given), expected, atol=1e-11)
        for name, key in zip(VALUES, ("phase", "tilt", "curve", "gibpha", "gibmag"), strict=True):
            values = [float(value) for value in own[f"fcal{key}"]]
            assert values == pytest.approx(getattr(STATIONS[k].factory, name))


def arguments(text: str) -> dict[str, dict[str, str]]:
    """Options of each static_transform_publisher in a launch file, by its name."""
    launch = ElementTree.fromstring(text)
    assert [arg.attrib for arg in launch.iter("arg")] == [
        {"name": "frame", "default": "lighthouse_world"}
    ]
    found = {}
    for node in launch.iter("node"):
        assert (node.get("pkg"), node.get("exec")) == ("tf2_ros", "static_transform_publisher")
        words = str(node.get("args")).replace("$(var frame)", "map").split()
        found[str(node.get("name"))] = dict(zip(words[::2], words[1::2], strict=True))
    return found


def test_ros() -> None:
    """Frames of ROS have x ahead, y left, z up, as those here."""
    found = arguments(ros2_launch(GOOD))
    assert list(found) == ["lighthouse_f77e21f3", "lighthouse_0aa54f65"]
    for (name, own), axes, place in zip(found.items(), AXES, PLACES, strict=True):
        assert (own["--frame-id"], own["--child-frame-id"]) == ("map", name)
        assert [float(own[f"--{key}"]) for key in "xyz"] == place.tolist()
        q = [float(own[f"--q{key}"]) for key in "xyzw"]
        for given, expected in zip((X, Y, Z), axes, strict=True):
            np.testing.assert_allclose(turned(q, given), expected, atol=1e-11)


def written(folder: Path, export: Export) -> tuple[Path, Path]:
    paths = folder / "crazyflie.yaml", folder / "libsurvive.json"
    for path, text in zip(paths, (crazyflie_yaml, libsurvive_json), strict=True):
        path.write_text(text(export), encoding="utf-8")
    return paths


@pytest.mark.parametrize("export", [GOOD, FAILED], ids=["good", "failed"])
@pytest.mark.parametrize("k", [0, 1], ids=["crazyflie", "libsurvive"])
def test_this_projects_own_readers(tmp_path: Path, k: int, export: Export) -> None:
    """Factory values out of both, and as a reference the relative pose, of a good calibration only:
    the slave is 2 m before the master, 2 m to its right and 0.5 m below; it looks down, its left is
    behind the master, its top on its left."""
    path = written(tmp_path, export)[k]
    found = read_factory(path)
    assert [(s.role, s.id) for s in found] == [(s.role, s.id) for s in STATIONS]
    for station, given in zip(found, STATIONS, strict=True):
        for name in VALUES:
            own = getattr(station.factory, name)
            assert own == pytest.approx(getattr(given.factory, name), abs=1e-12)
    if export is FAILED:
        with pytest.raises(Refusal, match=r"no geos\.0; expected origin|expected poses of the two"):
            pose_reference(path)
        return
    reference = pose_reference(path)
    np.testing.assert_allclose(reference.t_m, [2, -2, -0.5], atol=1e-11)
    np.testing.assert_allclose(reference.R.T, [-Z, -X, Y], atol=1e-11)
    assert reference.ids == (4152238579, 178605925)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("[1.0, 2.0, 3.0]", "[1.0, 2.0]", r"geos\.0\.origin is .* expected 3 finite numbers"),
        ("[1.0, 2.0, 3.0]", "[1.0, .nan, 3.0]", r"geos\.0\.origin is .* expected 3 finite"),
        ("[-1.0, 0.0, 0.0]", "[1.0, 0.0, 0.0]", r"geos\.0\.rotation: R is no rotation"),
        ("systemType: 1", "systemType: 2", r"systemType is 2, second-generation \(V2\) base"),
        ("geos:", "other:", r"no geos\.0; expected origin and rotation of two stations"),
    ],
)
def test_damaged_geometry_of_a_crazyflie(tmp_path: Path, old: str, new: str, words: str) -> None:
    text = crazyflie_yaml(GOOD)
    assert old in text
    (tmp_path / "bad.yaml").write_text(text.replace(old, new, 1))
    with pytest.raises(Refusal, match=r"^bad\.yaml: " + words):
        pose_reference(tmp_path / "bad.yaml")


def test_cflib_reads_and_writes_the_same(tmp_path: Path) -> None:
    """cflib (GPL) is no part of the project; `make peers` installs it."""
    pytest.importorskip("cflib")
    from cflib.localization.lighthouse_config_manager import LighthouseConfigFileManager as Manager

    path, _ = written(tmp_path, GOOD)
    geos, calibs, kind = Manager.read(str(path))
    assert kind == Manager.SYSTEM_TYPE_V1
    for k, (R, place) in enumerate(POSES):
        assert geos[k].valid and calibs[k].valid
        assert geos[k].origin == place.tolist()
        assert np.array(geos[k].rotation_matrix).tolist() == R.tolist()
        assert calibs[k].uid == STATIONS[k].id
        for axis, sweep in enumerate(calibs[k].sweeps):
            for name in VALUES:
                assert isinstance(getattr(sweep, name), float)
                given = getattr(STATIONS[k].factory, name)[axis]
                assert getattr(sweep, name) == pytest.approx(given, abs=1e-12)
    Manager.write(str(tmp_path / "back.yaml"), geos, calibs, kind)
    assert yaml.safe_load((tmp_path / "back.yaml").read_text()) == yaml.safe_load(path.read_text())
    assert [s.id for s in read_factory(tmp_path / "back.yaml")] == [s.id for s in STATIONS]


LIBSURVIVE = """
import ctypes, sys
library = ctypes.CDLL(sys.argv[1])
words = ["test", "--configfile", sys.argv[2], "--v", "0"]
pointer = ctypes.c_void_p
library.survive_init_internal.restype = pointer
library.survive_init_internal.argtypes = [ctypes.c_int, pointer, pointer, pointer]
library.survive_startup.argtypes = library.survive_close.argtypes = [pointer]
given = (ctypes.c_char_p * (len(words) + 1))(*[word.encode() for word in words], None)
context = library.survive_init_internal(len(words), given, None, None)
library.survive_startup(context)
library.survive_close(context)
"""


@pytest.mark.parametrize("export", [GOOD, FAILED], ids=["good", "failed"])
def test_libsurvive_reads_and_writes_the_same(tmp_path: Path, export: Export) -> None:
    """MOCAP_LIBSURVIVE names libsurvive.so, as in the wheels of pysurvive, of which there is none
    for this Python. libsurvive reads the file and, when it ends, writes it again, in floats."""
    library = os.environ.get("MOCAP_LIBSURVIVE")
    if not library:
        pytest.skip("MOCAP_LIBSURVIVE is not set")
    _, path = written(tmp_path, export)
    before = members(path.read_text())
    command = [sys.executable, "-c", LIBSURVIVE, library, str(path)]
    subprocess.run(command, capture_output=True, check=False, timeout=60)  # it may crash at its end
    again = path.read_text()
    assert "unlock_count" in again  # which only libsurvive writes
    assert json.dumps(before["mocap-metrology"]) in again
    after = {station.index: station for station in read_solution(path)}
    for k, station in enumerate(STATIONS):
        own = after[1 - k]
        assert (own.id, own.mode) == (station.id, station.mode)
        for name in VALUES:
            given = getattr(station.factory, name)
            assert getattr(own.factory, name) == pytest.approx(given, abs=1e-8)
        assert (own.pose is None) == (export is FAILED)
    if export is GOOD:
        np.testing.assert_allclose(solution_pose(list(after.values()))[1], [2, -2, -0.5], atol=1e-6)
