"""The frame of the room in which the poses of the stations are exported.

p_world = R p_master + t

gravity      z up: by the accelerometer of the board where it was used, else the mean of the
             directions that the stations' accelerometers measure; origin at the master, x the
             horizontal part of the master's x (of its z where the master looks straight up or
             down)
master       the master's own frame
board-start  the board's own frame, where it was at the start of the recording
points       the frame of places that were measured in the room: of stations, and of diodes
             while the board was there; least squares without scale (Kabsch)
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import PurePath

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.board import narrowness_m, read_places
from mocap_metrology.lighthouse.calibrate.superpose import kabsch
from mocap_metrology.lighthouse.known_length import PLACE
from mocap_metrology.lighthouse.records import ROLES, Path, Station

GRAVITY, MASTER, BOARD_START, POINTS = "gravity", "master", "board-start", "points"
WORDS = {
    GRAVITY: "z up by gravity, origin at the master, x horizontal as the master looks",
    MASTER: "that of the master: x out of its glass, y to its own left, z up in its housing",
    BOARD_START: "that of the board at the start of the recording",
    POINTS: "that of the measured points",
}
EXPECTED = "master, slave, diode 3 (at the start), diode 3 at 12.5 s or the channel of a V2 station"
STILL_S = 0.2  # the board's place is the mean over so long
LARGEST_ROOM_M = 100.0  # beyond this a place is in mm
NARROWEST_M = 0.01  # spread of points off their line, root of the sum of squares
LARGEST_RESIDUAL_M = 0.1  # rms: beyond this a label is wrong
LEAST_HORIZONTAL = 0.05  # part of an axis, to show a direction

Pose = tuple[np.ndarray, np.ndarray]  # R (3, 3), t (3,) in metres


@dataclass(frozen=True)
class Calibrated:
    """Stations, their poses in the frame of the first, which is the master, and the board: diodes
    (n, 3) in m, and its path in the master's frame, None where it is not known; up (3,) in that
    frame, as the board's accelerometer has it."""

    stations: Sequence[Station]
    poses: Sequence[Pose]
    board: np.ndarray
    path: Path | None
    up: np.ndarray | None = None


@dataclass(frozen=True)
class World:
    """A frame, and the pose R, t of the master in it; why: it is not the requested one, or what
    limits it; residuals_m: of points, by label."""

    name: str
    R: np.ndarray = field(default_factory=lambda: np.eye(3))
    t_m: np.ndarray = field(default_factory=lambda: np.zeros(3))
    why: str = ""
    residuals_m: Mapping[str, float] | None = None

    @property
    def rms_m(self) -> float | None:
        """Root mean square distance of points from where they were measured."""
        if self.residuals_m is None:
            return None
        return float(np.sqrt(np.mean(np.square(list(self.residuals_m.values())))))

    def place(self, pose: Pose) -> Pose:
        """A pose in the master's frame as one in the world."""
        R, t = pose
        return self.R @ R, self.R @ t + self.t_m


def read_points(path: str) -> dict[str, np.ndarray]:
    """Places in the room by label, (3,) in m: see `world_of`. Raises `Refusal` for fewer than
    three, for places on one line, and for other labels."""
    points = read_places(path, "point", LARGEST_ROOM_M, "the origin")
    for label in points:
        if label not in ROLES and not label.isdigit() and not PLACE.fullmatch(label):
            raise Refusal(f"{PurePath(path).name}: label {label!r}; expected {EXPECTED}")
    _check_spread(np.array(list(points.values())), PurePath(path).name)
    return points


def frame_words(name: str, stations: Sequence[Station]) -> str:
    """A world in words; of the second generation with the channel of the reference."""
    first = stations[0]
    return WORDS[name].replace("the master", f"station {first.role}", 2 * (first.generation - 1))


def world_of(name: str, calibrated: Calibrated, points: str | None = None) -> World:
    """The frame `name`, one of `WORDS`; with `points`, a CSV file, always theirs.

    A label of a point is the role of a station (its origin), `diode 3` (where this diode of the
    board was at the start of the recording) or `diode 3 at 12.5 s`. The board's place is the mean
    over 0.2 s, from the start or around the moment, so it should be still there.

    Where the data for a frame is missing, the next of points, gravity (by the stations, else by the
    geometry in a Crazyflie's file), board-start, master is taken, and `why` states this. Raises
    `Refusal` for points that determine no frame.
    """
    if points is not None:
        return _of_points(points, calibrated)
    why = ""
    if name == POINTS:
        why, name = "no points were given (column world_points); ", GRAVITY
    if name == BOARD_START:
        if calibrated.path is not None and len(calibrated.path):
            R, t = board_pose(calibrated.path, None)
            return World(BOARD_START, R.T, -R.T @ t)
        why, name = "the path of the board is not known; ", GRAVITY
    if name == GRAVITY:
        world = _of_gravity(calibrated)
        return World(world.name, world.R, why=(why + world.why).removesuffix("; "))
    return World(MASTER)


def _ups(calibrated: Calibrated, name: str) -> list[tuple[Station, np.ndarray]]:
    """Stations that have a way up of this name, and it in the master's frame."""
    ups = [getattr(station, name) for station in calibrated.stations]
    return [
        (station, R @ (up / np.linalg.norm(up)))
        for station, up, (R, _) in zip(calibrated.stations, ups, calibrated.poses, strict=True)
        if up is not None and np.linalg.norm(up) > 0
    ]


def _of_gravity(calibrated: Calibrated) -> World:
    known = _ups(calibrated, "gravity")
    up = np.sum([direction for _, direction in known], axis=0)
    few = 0 < len(known) < len(calibrated.stations)
    alone = f"gravity of the {known[0][0].role} alone" if few else ""
    if calibrated.up is not None:
        alone, up = "", calibrated.up
    elif not known or np.linalg.norm(up) < LEAST_HORIZONTAL:
        alone = "no station states the direction of gravity"
        filed = _ups(calibrated, "up_by_geometry")
        if not filed and calibrated.path is not None and len(calibrated.path):
            R, t = board_pose(calibrated.path, None)
            return World(BOARD_START, R.T, -R.T @ t, why=alone)
        if not filed:
            return World(MASTER, why=alone)
        alone = f"{alone}; z up by the geometry in the Crazyflie's file"
        up = np.sum([direction for _, direction in filed], axis=0)
    z = up / np.linalg.norm(up)
    # x of the master, or its z where the master looks along the vertical
    ahead = next(a for a in np.eye(3)[[0, 2]] if np.linalg.norm(a - (a @ z) * z) > LEAST_HORIZONTAL)
    x = ahead - (ahead @ z) * z
    x /= np.linalg.norm(x)
    return World(GRAVITY, np.stack([x, np.cross(z, x), z]), why=alone)


def _of_points(path: str, calibrated: Calibrated) -> World:
    name, points = PurePath(path).name, read_points(path)
    room = np.array(list(points.values()))
    seen = np.array([_point_m(label, calibrated, name) for label in points])
    _check_spread(seen, f"{name}, as calibrated")
    R, t = kabsch(seen, room)
    off = np.linalg.norm(seen @ R.T + t - room, axis=1)
    rms = float(np.sqrt(np.mean(off**2)))
    if rms > LARGEST_RESIDUAL_M:
        worst = list(points)[int(np.argmax(off))]
        raise Refusal(
            f"{name}: points are {1e3 * rms:.0f} mm rms from where the calibration has them;"
            f" expected at most {1e3 * LARGEST_RESIDUAL_M:g} mm; check {worst} first"
        )
    return World(POINTS, R, t, residuals_m=dict(zip(points, off.tolist(), strict=True)))


def _point_m(label: str, calibrated: Calibrated, name: str) -> np.ndarray:
    """A point in the master's frame, (3,) in m."""
    for station, (_, t) in zip(calibrated.stations, calibrated.poses, strict=True):
        if station.role == label:
            return t
    known = PLACE.fullmatch(label)
    if known is None:
        raise Refusal(f"{name}: label {label!r}; expected {EXPECTED}")
    diode = int(known[1])
    if diode >= len(calibrated.board):
        last = len(calibrated.board) - 1
        raise Refusal(f"{name}: {label}: the board has the diodes 0 to {last}")
    if calibrated.path is None or not len(calibrated.path):
        raise Refusal(f"{name}: {label}: the path of the board is not known; expected stations")
    time_s = None if known[2] is None else float(known[2])
    try:
        R, t = board_pose(calibrated.path, time_s)
    except ValueError as error:
        raise Refusal(f"{name}: {label}: {error}") from None
    return R @ calibrated.board[diode] + t


def board_pose(path: Path, time_s: float | None) -> Pose:
    """Mean pose of the board over 0.2 s around a moment, or of its first 0.2 s. ValueError where it
    was not seen."""
    begin = path.time_s.min() if time_s is None else time_s - STILL_S / 2
    still = path.take((path.time_s >= begin) & (path.time_s <= begin + STILL_S))
    if not len(still):
        seen = f"{path.time_s.min():.2f} to {path.time_s.max():.2f} s"
        raise ValueError(f"the board is not known then; its path is known at moments from {seen}")
    return rotation.mean(still.R), still.t_m.mean(axis=0)


def _check_spread(places: np.ndarray, name: str) -> None:
    if narrowness_m(places) < NARROWEST_M:
        raise Refusal(f"{name}: the points lie on one line; expected a triangle")
