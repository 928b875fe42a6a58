"""Frames of the room, against poses that were built from the room's side."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.board import flat_board
from mocap_metrology.lighthouse.export.world import Calibrated, read_points, world_of
from mocap_metrology.lighthouse.records import Path as BoardPath
from mocap_metrology.lighthouse.records import Station

UP = np.array([0.0, 0.0, 1.0])
BOARD = flat_board()
# Stations in a level room, R (3, 3) and t in m: x of each looks along the first column.
MASTER = Rotation.from_euler("ZYX", [0, 25, -4], degrees=True).as_matrix(), np.zeros(3)
SLAVE = (
    Rotation.from_euler("ZYX", [-140, 31, 7], degrees=True).as_matrix(),
    np.array([3.1, 1.2, -0.2]),
)
TIMES = np.arange(0.3, 4.0, 0.025)
MOVED_S = 1.0  # the board keeps its first pose until then, and its last from 2 s


def board_at(time_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """R (n, 3, 3) and t (n, 3) of the board in the room."""
    share = np.clip(time_s - MOVED_S, 0, 1)[:, None]
    turn = Rotation.from_euler("ZYX", [170.0, 5.0, 3.0], degrees=True)
    R = Rotation.from_rotvec(share * [0.1, -0.3, 0.5]) * turn
    return R.as_matrix(), np.array([2.0, -0.4, -1.1]) + share * [0.3, 0.8, 0.2]


def in_master(R: np.ndarray, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A pose in the room as one in the master's frame."""
    return MASTER[0].T @ R, (t - MASTER[1]) @ MASTER[0]


def calibrated(*, gravity: tuple[object, object] = (UP, UP), path: bool = True) -> Calibrated:
    """What a perfect calibration of the room finds; gravity: up of each station in the room."""
    stations = [
        Station(role, gravity=None if up is None else np.asarray(up) @ R)
        for role, up, (R, _) in zip(("master", "slave"), gravity, (MASTER, SLAVE), strict=True)
    ]
    none = np.full(TIMES.size, np.nan)
    board = BoardPath(TIMES, *in_master(*board_at(TIMES)), none, none, none)
    poses = [in_master(*MASTER), in_master(*SLAVE)]
    return Calibrated(stations, poses, BOARD, board if path else None)


OFF = Rotation.from_rotvec(np.radians([0.6, -0.8, 0.0]))
GRAVITIES = {
    "both": ((UP, UP), ""),
    "each wrong by 1 deg, to opposite sides": ((3 * OFF.apply(UP), OFF.inv().apply(UP)), ""),
    "one": ((None, UP), "gravity of the slave alone"),
    "the other": ((UP, np.zeros(3)), "gravity of the master alone"),
}


@pytest.mark.parametrize("case", GRAVITIES)
def test_gravity_gives_the_level_room_back(case: str) -> None:
    """Whose x is where the master looks, as in `MASTER`."""
    gravity, why = GRAVITIES[case]
    found = calibrated(gravity=gravity)
    world = world_of("gravity", found)
    assert (world.name, world.why) == ("gravity", why)
    for (R, t), own in zip((MASTER, SLAVE), found.poses, strict=True):
        placed = world.place(own)
        np.testing.assert_allclose(placed[0], R, atol=1e-12)
        np.testing.assert_allclose(placed[1], t, atol=1e-12)


def test_gravity_by_the_accelerometer_of_the_board_comes_first() -> None:
    """It is known to tenths of a degree, that of a station to one."""
    up = np.array([0.1, 0.2, 9.7])
    world = world_of("gravity", replace(calibrated(), up=up))
    np.testing.assert_allclose(world.R @ up, [0, 0, np.linalg.norm(up)], atol=1e-12)
    assert world.name == "gravity" and world.why == ""


def test_what_is_missing_is_replaced_and_stated() -> None:
    blind = calibrated(gravity=(None, None), path=False)
    world = world_of("gravity", blind)
    assert (world.name, world.why) == ("master", "no station states the direction of gravity")
    np.testing.assert_array_equal(world.R, np.eye(3))
    world = world_of("board-start", blind)
    assert world.name == "master"
    assert world.why == (
        "the path of the board is not known; no station states the direction of gravity"
    )
    world = world_of("gravity", calibrated(gravity=(None, None)))
    assert (world.name, world.why) == ("board-start", "no station states the direction of gravity")
    np.testing.assert_allclose(world.R, world_of("board-start", calibrated()).R)
    filed = [
        Station(role, up_by_geometry=R.T @ UP)
        for role, (R, _) in zip(("master", "slave"), (MASTER, SLAVE), strict=True)
    ]
    world = world_of("gravity", replace(calibrated(), stations=filed))
    np.testing.assert_allclose(world.R @ MASTER[0].T @ UP, UP, atol=1e-12)
    assert world.why.endswith("z up by the geometry in the Crazyflie's file")
    world = world_of("points", calibrated())
    assert (world.name, world.why) == ("gravity", "no points were given (column world_points)")
    assert world_of("master", calibrated()).why == ""


def points_file(folder: Path, off_m: float = 0.0) -> tuple[str, dict[str, np.ndarray]]:
    """Places in a room whose origin and axes are others; off_m: error of the first, upwards."""
    turn, shift = Rotation.from_rotvec([0.4, -1.0, 2.0]), np.array([10.0, -3.0, 0.5])
    first, last = (board_at(np.array([s])) for s in (0.4, 3.0))
    room = {
        "master": MASTER[1],
        "slave": SLAVE[1],
        "diode 3": first[0][0] @ BOARD[3] + first[1][0],
        "diode 31 at 3.0 s": last[0][0] @ BOARD[31] + last[1][0],
    }
    places = {label: turn.apply(p) + shift for label, p in room.items()}
    places["master"] = places["master"] + [0, 0, off_m]
    lines = ["label,x_m,y_m,z_m"]
    lines += [",".join([label, *(f"{v:.9f}" for v in p)]) for label, p in places.items()]
    (folder / "room.csv").write_text("\n".join(lines) + "\n")
    return str(folder / "room.csv"), places


def test_points_of_stations_and_of_the_board(tmp_path: Path) -> None:
    """At the start, and while it was still later; whatever else was requested."""
    path, places = points_file(tmp_path)
    found = calibrated()
    world = world_of("gravity", found, path)
    assert world.name == "points"
    np.testing.assert_allclose(world.place(found.poses[1])[1], places["slave"], atol=1e-8)
    assert world.rms_m == pytest.approx(0, abs=1e-8)
    level = Rotation.from_rotvec([0.4, -1.0, 2.0]).as_matrix()
    np.testing.assert_allclose(world.place(found.poses[0])[0], level @ MASTER[0], atol=1e-8)


HEADER = "label,x_m,y_m,z_m\n"
LINE = HEADER + "master,0,0,0\nslave,1,1,1\ndiode 0,2,2,2\n"
BAD = {
    "two": (HEADER + "master,0,0,0\nslave,1,0,0\n", "2 points; a pose needs at least three"),
    "line": (LINE, "lie on one line; expected a triangle"),
    "label": (LINE + "marker 3,1,0,0\n", "label 'marker 3'; expected master, slave, diode 3"),
    "sign": (LINE + "diode -1,1,0,0\n", "label 'diode -1'; expected master, slave, diode 3"),
    "twice": (LINE + "slave,1,0,0\n", "label slave occurs twice"),
    "mm": (HEADER + "master,0,0,0\nslave,3100,0,0\ndiode 1,0,900,0\n", "is the file in mm?"),
    "number": (HEADER + "master,0,0,x\n", "line 2 is 'master,0,0,x'"),
    "header": ("name,x,y,z\n", "header is 'name,x,y,z'"),
}
UNSUITED = {
    "diode": ("diode 32,1,0,0\n", "diode 32: the board has the diodes 0 to 31"),
    "time": ("diode 2 at 9 s,1,0,0\n", "diode 2 at 9 s: the board is not known then"),
    "far": ("diode 2,1,0,0\n", "mm rms from where the calibration has them; expected at most 100"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_points_are_refused_in_one_line(tmp_path: Path, case: str) -> None:
    text, words = BAD[case]
    path = tmp_path / "room.csv"
    path.write_text(text)
    with pytest.raises(Refusal, match=r"room\.csv: ") as refused:
        read_points(str(path))
    assert words in str(refused.value) and "\n" not in str(refused.value)


@pytest.mark.parametrize("case", UNSUITED)
def test_points_that_the_recording_does_not_have(tmp_path: Path, case: str) -> None:
    line, words = UNSUITED[case]
    path = tmp_path / "room.csv"
    path.write_text(HEADER + "master,0,0,0\nslave,0,1,1\n" + line)
    with pytest.raises(Refusal, match=r"room\.csv: ") as refused:
        world_of("points", calibrated(), str(path))
    assert words in str(refused.value) and "\n" not in str(refused.value)
    path.write_text(HEADER + "master,0,0,0\nslave,0,1,1\ndiode 2,1,0,0\n")
    with pytest.raises(Refusal, match="the path of the board is not known; expected stations"):
        world_of("points", calibrated(path=False), str(path))
