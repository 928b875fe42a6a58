"""What the functions of lighthouse accept, and refuse one step beyond."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mocap_workflow.calibration_twins import twin_from_mapping
from scipy.spatial.transform import Rotation

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.faults import Faults
from mocap_metrology.lighthouse.assess import reference
from mocap_metrology.lighthouse.assess.pose_file import matrix_and_metres
from mocap_metrology.lighthouse.board import check_board, check_count, flat_board
from mocap_metrology.lighthouse.decode.dump import pulses_of_words
from mocap_metrology.lighthouse.export.world import Calibrated, world_of
from mocap_metrology.lighthouse.known_length import known_length
from mocap_metrology.lighthouse.places import narrowness_m, read_places
from mocap_metrology.lighthouse.records import Factory, Station
from mocap_metrology.lighthouse.rotor import rotor_parameters

TRIANGLE = np.array([[0.0, 0, 0], [0.3, 0, 0], [0, 0.2, 0], [0.1, 0.1, 0.15]])
MOUNT = dict(zip("abcd", TRIANGLE, strict=True))
SITE: dict[str, Any] = {
    "seed": 4,
    "master": {"id": 11, "mode": "b"},
    "slave": {"id": 12, "mode": "c", "position_m": [0.4, 2.2, 0.1]},
    "motion": {"pattern": "line", "centre_m": [3, 0.8, -0.1], "speed_m_s": 1, "extent_m": 0.4},
    "duration_s": 2.0,
}


def twin(**changes: object) -> object:
    return twin_from_mapping({**SITE, **changes})


def slave(distance_m: float) -> object:
    return twin(slave={**SITE["slave"], "position_m": [0, distance_m, 0]})


def moving(**changes: float) -> object:
    return twin(motion={**SITE["motion"], **changes})


def factory(generation: int, name: str, value: float) -> np.ndarray:
    values: dict[str, Any] = {name: np.array([0.0, -value])}
    return rotor_parameters(Factory(**values, generation=generation))


def line(width: float, n: int = 4) -> np.ndarray:
    """Diodes whose root sum of squares off their line is `width`."""
    along = np.linspace(-0.5, 0.5, n)
    across = np.array([1.0, -1, -1, 1]) * width / 2
    return np.column_stack([np.zeros(n), along, across])


def pair(distance_m: float) -> np.ndarray:
    return check_board(np.vstack([flat_board(4, 2), [0, 0.12 + distance_m, 0.08]]), "board")


def spanning(width_m: float) -> np.ndarray:
    return check_board(flat_board(4, 2, width_m), "board")


def places(rows: list[str], folder: Path) -> dict[str, np.ndarray]:
    path = folder / "places.csv"
    path.write_text("\n".join(["label,x_m,y_m,z_m", *rows, ""]))
    return read_places(path, "marker", 1.0, "the origin")


def rotation(off: float) -> np.ndarray:
    return reference.rotation_in({"R": (np.eye(3) * math.sqrt(1 + off)).tolist()}, "pose")


def quaternion(length: float) -> np.ndarray:
    return reference.rotation_in({"quaternion_xyzw": [0, 0, 0, length]}, "pose")


def stored(length: float) -> object:
    entry: Any = {"translation_mm": [1.0, 2, 3], "quaternion_xyzw": [0, 0, 0, length]}
    return matrix_and_metres(entry)


def baseline(length_m: float) -> np.ndarray:
    return reference._baseline({"t_m": [0.0, length_m, 0.0]}, "pose")


def mounts(shake_mm: float = 0.0, off_mm: float = 0.0, own: str = "abcd") -> reference.Reference:
    """Two mounts 3 m apart; a marker of the slave's shakes by that sd, is off by so much; a mount
    is of some of the labels."""
    R = Rotation.from_rotvec([0.1, -0.3, 0.7]).as_matrix()
    position = 1e3 * np.concatenate([TRIANGLE, TRIANGLE @ R.T + [0, 3.0, 0.2]])
    frames = np.repeat(position[:, :, None], 10, axis=2)
    frames[5, 0] += shake_mm * (-1.0) ** np.arange(10)
    frames[7, 2] += off_mm
    labels = [f"{one}{k}" for k in "ms" for one in "abcd"]
    mount = {k: MOUNT[k] for k in own}
    of = ([f"{one}{k}" for one in own] for k in "ms")
    return reference.reference_from_markers(frames, labels, *of, mount)


def words(seconds: float, share: float = 0.01, rate_hz: float = 2000.0) -> object:
    """A diode that is lit for single words, so that `share` of the words differ from the last."""
    every = round(2 / share)
    made = np.zeros(round(seconds * rate_hz), np.uint32)
    made[every // 2 :: every] = 1
    return pulses_of_words(made, rate_hz)


def room(off_m: float, narrow_m: float = 1.0, folder: Path = Path()) -> object:
    """Three of the stations' places as measured in a room; all but the first are off by so much
    along the line of the others. narrow_m: the third's distance from it."""
    t = np.array([[0.0, 0, 0], [4.0, 0, 0], [2.0, narrow_m, 0]])
    poses = [(np.eye(3), one) for one in t]
    stations = [Station(str(k)) for k in range(3)]
    path = folder / "room.csv"
    measured = t + np.array([[-off_m, 0, 0], [off_m, 0, 0], [0, 0, 0]])
    rows = [f"{k},{x},{y},{z}" for k, (x, y, z) in enumerate(measured)]
    path.write_text("\n".join(["label,x_m,y_m,z_m", *rows, ""]))
    found = Calibrated(stations, poses, flat_board(), None)
    return world_of("points", found, str(path))


FIRST = {"phase": 0.3, "tilt": 0.3, "curve": 0.1}
SECOND = {"phase": 0.05, "tilt": 0.1, "curve": 1.5, "gibmag": 0.1, "ogeemag": 2.0}
Try = Callable[[Path], object]
LIMITS: dict[str, tuple[Try, Try]] = {
    **{
        f"{name} of generation {generation}": (
            lambda _, g=generation, n=name, v=limit: factory(g, n, v),
            lambda _, g=generation, n=name, v=limit: factory(g, n, 1.0001 * v),
        )
        for generation, limits in ((1, FIRST), (2, SECOND))
        for name, limit in limits.items()
    },
    "diodes of a board": (
        lambda _: check_board(flat_board(2, 2), "board"),
        lambda _: check_board(flat_board(2, 2)[:3], "board"),
    ),
    "extent of a board": (lambda _: spanning(2.0), lambda _: spanning(2.0001)),
    "distance of diodes": (lambda _: pair(1.01e-4), lambda _: pair(0.99e-4)),
    "width of a board": (
        lambda _: check_board(line(1.01e-3), "board"),
        lambda _: check_board(line(0.99e-3), "board"),
    ),
    "lit diodes": (
        lambda _: check_count(flat_board(4, 2), 8, 7, "dump"),
        lambda _: check_count(flat_board(4, 2), 8, 8, "dump"),
    ),
    "diodes of a recording": (
        lambda _: check_count(flat_board(4, 2), 8, 0, "dump"),
        lambda _: check_count(flat_board(4, 2), 7, 0, "dump"),
    ),
    "places": (
        lambda path: places(["a,0,0,0", "b,1,0,0", "c,0,1,0"], path),
        lambda path: places(["a,0,0,0", "b,1,0,0"], path),
    ),
    "a place far off": (
        lambda path: places(["a,0,0,-1", "b,1,0,0", "c,0,1,0"], path),
        lambda path: places(["a,0,0,-1.0001", "b,1,0,0", "c,0,1,0"], path),
    ),
    "cells of a place": (
        lambda path: places(["a,0,0,0", "b,1,0,0", "c,0,1,0"], path),
        lambda path: places(["a,0,0,0", "b,1,0,0", "c,0,1,inf"], path),
    ),
    "known length": (
        lambda _: known_length("stations 100 0.005", 4),
        lambda _: known_length("stations 100.0001 0.005", 4),
    ),
    "sd of a length": (
        lambda _: known_length("stations 2 1.999", 4),
        lambda _: known_length("stations 2 2", 4),
    ),
    "no sd of a length": (
        lambda _: known_length("stations 2 0.000000001", 4),
        lambda _: known_length("stations 2 0", 4),
    ),
    "diode of a length": (
        lambda _: known_length("diode 3 at 0 s - diode 0 at 1 s 2 0.1", 4),
        lambda _: known_length("diode 4 at 0 s - diode 0 at 1 s 2 0.1", 4),
    ),
    "two stations": (
        lambda _: known_length("stations 2 0.1", 4, names=("3", "5")),
        lambda _: known_length("stations 2 0.1", 4, names=("3", "5", "7")),
    ),
    "rotation": (lambda _: rotation(0.99e-3), lambda _: rotation(1.01e-3)),
    "mirror image": (
        lambda _: reference.rotation_in({"R": np.diag([1.0, -1, -1])}, "pose"),
        lambda _: reference.rotation_in({"R": np.diag([1.0, 1, -1])}, "pose"),
    ),
    "long quaternion": (lambda _: quaternion(1.0099), lambda _: quaternion(1.0101)),
    "short quaternion": (lambda _: quaternion(0.9901), lambda _: quaternion(0.9899)),
    "stored quaternion": (lambda _: stored(1.0099), lambda _: stored(1.0101)),
    "stored, short": (lambda _: stored(0.9901), lambda _: stored(0.9899)),
    "long baseline": (lambda _: baseline(30.0), lambda _: baseline(30.001)),
    "short baseline": (lambda _: baseline(0.1), lambda _: baseline(0.0999)),
    "labels of a mount": (lambda _: mounts(own="abc"), lambda _: mounts(own="ab")),
    "marker at rest": (lambda _: mounts(shake_mm=4.99), lambda _: mounts(shake_mm=5.01)),
    "room of points": (
        lambda path: room(0.122, folder=path),
        lambda path: room(0.123, folder=path),
    ),
    "line of points": (
        lambda path: room(0.0, 0.0123, path),
        lambda path: room(0.0, 0.0122, path),
    ),
    "short dump": (lambda _: words(0.5), lambda _: words(0.4995)),
    "long dump": (lambda _: words(60.0), lambda _: words(60.0005)),
    "distance of stations": (lambda _: slave(0.1), lambda _: slave(0.0999)),
    **{
        f"{key} of the master": (
            lambda _: twin(),
            lambda _, k=key: twin(master={**SITE["master"], k: [0, 0, 1e-9]}),
        )
        for key in ("position_m", "rotation_deg")
    },
    "diodes of a twin": (
        lambda _: twin(board={"columns": 3, "rows": 1}),
        lambda _: twin(board={"columns": 2, "rows": 1}),
    ),
    "most diodes of a twin": (
        lambda _: twin(board={"columns": 8, "rows": 4}),
        lambda _: twin(board={"columns": 11, "rows": 3}),
    ),
    "speed": (lambda _: moving(speed_m_s=1e-9), lambda _: moving(speed_m_s=0)),
    "extent": (lambda _: moving(extent_m=1e-9), lambda _: moving(extent_m=0)),
    "blocked station": (lambda _: twin(blocked=[[1, 0, 2]]), lambda _: twin(blocked=[[2, 0, 2]])),
    "blocked, alone": (
        lambda _: twin(slave=None, master={"id": 11, "mode": "A"}, blocked=[[0, 0, 2]]),
        lambda _: twin(slave=None, master={"id": 11, "mode": "A"}, blocked=[[1, 0, 2]]),
    ),
    "blocked until": (
        lambda _: twin(blocked=[[1, 0, 2]]),
        lambda _: twin(blocked=[[1, 0, 2.0001]]),
    ),
    "blocked from": (
        lambda _: twin(blocked=[[1, 1, 1.0001]]),
        lambda _: twin(blocked=[[1, 1, 1]]),
    ),
}


@pytest.mark.parametrize("name", LIMITS)
def test_accepts_up_to_the_limit_and_refuses_beyond(name: str, tmp_path: Path) -> None:
    accepted, refused = LIMITS[name]
    accepted(tmp_path)
    with pytest.raises((Refusal, ValueError, Faults)):
        refused(tmp_path)


def test_narrowness_is_the_root_of_the_sum_of_squares_off_the_line() -> None:
    assert narrowness_m(line(0.02)) == pytest.approx(0.02)


@pytest.mark.parametrize("off_mm", [8.0, 9.0, 40.0])
def test_residual_of_a_mount_is_what_a_rigid_fit_leaves(off_mm: float) -> None:
    """By scipy's own least squares of a rotation; above 5 mm the mount is refused."""
    moved = TRIANGLE + np.array([[0, 0, 0], [0, 0, 0], [0, 0, 0], [0, 0, 1e-3 * off_mm]])
    _, rssd = Rotation.align_vectors(moved - moved.mean(axis=0), TRIANGLE - TRIANGLE.mean(axis=0))
    rms = 1e3 * rssd / 2
    R = Rotation.from_rotvec([0.1, -0.3, 0.7]).as_matrix()
    labels = [f"{one}{k}" for k in "ms" for one in "abcd"]
    position = 1e3 * np.concatenate([TRIANGLE, moved @ R.T + [0, 3.0, 0.2]])[:, :, None]
    given = position, labels, labels[:4], labels[4:], MOUNT
    if rms > 5.0:
        with pytest.raises(Refusal, match=f"markers are {rms:.1f} mm rms .* check marker ds"):
            reference.reference_from_markers(*given)
    else:
        assert reference.reference_from_markers(*given).residual_mm == pytest.approx((0, rms))
