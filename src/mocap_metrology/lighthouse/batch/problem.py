"""Unknowns of a joint estimate, and what is known of them beforehand.

The pose of each station but the master, and the board's trajectory, are free. Everything else has a
prior, a normal distribution about the value of the board file, the factory calibration or 0:

| unknown | of | default standard deviation |
|---|---|---|
| time zero | station and axis | 0.15 us (57 urad): flashes rise late, by diodes differently |
| phase | station and axis | 1 mrad: together with the time zero one offset |
| depth between both lasers | station | 10 mm |
| scale of the board | | 1e-3, of a small one 0.3 mm over its largest extent |
| place of a diode | diode, coordinate | 0.2 mm |
| gravity | | none; its magnitude 0.03 m/s^2 about 9.81 |
| gyroscope: bias | recording, axis | 0.1 rad/s |
| accelerometer: bias | recording, axis | 0.3 m/s^2 |
| accelerometer: scale | recording | 1e-2 |
| orientation of both on the board | recording, axis | 2 deg |
| place of the accelerometer | recording, coordinate | 3 mm |
| delay of both against light | recording | 3 ms |

0 means exactly known. Scale and depth are hardly seen by the angles, so their priors go into the
covariance of the poses nearly as they are. The last seven are unknowns only where such data are
used.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mocap_metrology.lighthouse.batch.kernel import POSE
from mocap_metrology.lighthouse.records import Hits
from mocap_metrology.lighthouse.rotation import exp
from mocap_metrology.lighthouse.rotor import CURVE, GIBMAG, GIBPHASE, IMPERFECT, TAN_TILT, X
from mocap_metrology.lighthouse.timing import CYCLE_S

RAD_PER_S = np.pi / CYCLE_S
GROUPS = ("pose", "depth", "offset", "intrinsic", "scale", "place", "gravity", "inertial")
# Of the sensors of a recording: bias of both, scale, orientation, place, delay; in SI and rad.
INERTIAL_SD = np.repeat([0.1, 0.3, 1e-2, np.radians(2.0), 3e-3, 3e-3], [3, 3, 1, 3, 3, 1])
GRAVITY_M_S2 = 9.81
ANY_GRAVITY = 100.0  # of a coordinate: for recordings that say nothing of it
# Between the outermost diodes: decks of 33 mm were 0.5 to 1.3 % larger than their files.
EFFECTIVE_M = 3e-4
NEARLY_KNOWN = 1e-3  # of a standard deviation: of what the angles are not asked for


@dataclass(frozen=True)
class Priors:
    """Standard deviations; those of phase and intrinsics count for known factory values."""

    time_zero_us: float = 0.15
    phase_mrad: float = 1.0
    laser_depth_mm: float = 10.0
    board_scale: float = 1e-3
    board_position_mm: float = 0.2
    tilt_mrad: float = 0.0
    curve_mrad: float = 0.0
    gib_mrad: float = 0.0

    def of_unknown_rotors(self) -> Priors:
        """With the spread of the factory values of eight real stations about 0, in place of their
        errors."""
        return replace(self, phase_mrad=37.0, tilt_mrad=5.0, curve_mrad=5.0, gib_mrad=9.0)

    def of_board(self, board: np.ndarray) -> Priors:
        """With the scale of a board (n, 3) in m: of a small one, places of diodes as light sees
        them are less well known than its size."""
        if not self.board_scale > 0:
            return self
        apart = np.linalg.norm(board[:, None] - board, axis=2).max()
        return replace(self, board_scale=max(self.board_scale, EFFECTIVE_M / float(apart)))

    @property
    def time_zero_rad(self) -> float:
        """As an angle."""
        return float(1e-6 * RAD_PER_S * self.time_zero_us)

    @property
    def offset_rad(self) -> float:
        """Of an axis: time zero and phase."""
        return float(np.hypot(self.time_zero_rad, 1e-3 * self.phase_mrad))

    @property
    def estimated(self) -> bool:
        """Whether the intrinsics are unknown."""
        return min(self.tilt_mrad, self.curve_mrad, self.gib_mrad) > 0


@dataclass(frozen=True)
class Layout:
    """Columns of the global unknowns, and their prior standard deviations (inf: none).

    columns (stations, 2, 7), scale, places: as the kernels read them, -1 where known; gravity: its
    first column; inertial (recordings,): the first of the sensors of each. working: standard
    deviations that the estimate starts with; group: which of `GROUPS` each is of.
    """

    columns: np.ndarray
    scale: int
    places: int
    gravity: int
    inertial: tuple[int, ...]
    sd: np.ndarray
    working: np.ndarray
    group: np.ndarray

    @property
    def size(self) -> int:
        """How many unknowns."""
        return int(self.sd.size)


def layout(
    n_stations: int,
    n_diodes: int,
    priors: Priors,
    known_poses: bool = False,
    inertial: Sequence[bool] = (),
    gravity: bool = False,
    sized_scale: bool = False,
) -> Layout:
    """The unknowns of so many stations and diodes; known_poses: those of the stations are none;
    inertial: which recordings have such sensors; gravity: whether it is an unknown without them;
    sized_scale: whether data show the scale of the board."""
    columns = np.full((n_stations, 2, 7), -1)
    sd: list[float] = []
    working: list[float] = []
    group: list[int] = []

    def new(name: str, value: float, count: int = 1, used: float | None = None) -> int:
        if not value > 0 or not count:
            return -1
        sd.extend([value] * count)
        working.extend([max(value if used is None else used, NEARLY_KNOWN * value)] * count)
        group.extend([GROUPS.index(name)] * count)
        return len(sd) - count

    for station in range(1, 1 if known_poses else n_stations):
        columns[station, :, 0] = new("pose", np.inf, POSE)
    zero = priors.offset_rad if priors.estimated else priors.time_zero_rad
    intrinsic = [priors.tilt_mrad, priors.curve_mrad, priors.gib_mrad, priors.gib_mrad]
    for station in range(n_stations):
        columns[station, :, 1] = new("depth", 1e-3 * priors.laser_depth_mm)
        for axis in range(2):
            columns[station, axis, 2] = new("offset", priors.offset_rad, 1, zero)
            if priors.estimated:
                columns[station, axis, 3:] = [new("intrinsic", 1e-3 * value) for value in intrinsic]
    scale = new("scale", priors.board_scale, 1, None if sized_scale else 0.0)
    places = new("place", 1e-3 * priors.board_position_mm, 3 * n_diodes)
    down = new("gravity", ANY_GRAVITY, 3 if gravity or any(inertial) else 0)
    sensors = []
    for there in inertial:
        sensors.append(len(sd) if there else -1)
        for value in INERTIAL_SD if there else ():
            new("inertial", value)
    return Layout(
        columns, scale, places, down, tuple(sensors), *map(np.array, (sd, working, group))
    )


@dataclass(frozen=True)
class State:
    """Values of all unknowns but the trajectory.

    R (stations, 3, 3), t_m (stations, 3): into the master's frame; rotors (stations, 2, 10) as
    `rotor_parameters`; offsets (stations, 2) in rad; board (n, 3) in m; gravity (3,) in m/s^2, of
    the master's frame; values (unknowns,): steps from where the priors are centred.
    """

    R: np.ndarray
    t_m: np.ndarray
    rotors: np.ndarray
    offsets: np.ndarray
    board: np.ndarray
    gravity: np.ndarray
    values: np.ndarray

    def moved(self, step: np.ndarray, of: Layout) -> State:
        """With a step (unknowns,) added; poses turn by left rotation vectors."""
        R, t, rotors = self.R.copy(), self.t_m.copy(), self.rotors.copy()
        offsets, board, gravity = self.offsets.copy(), self.board.copy(), self.gravity.copy()
        for station in range(len(R)):
            pose, depth = of.columns[station, 0, :2]
            if pose >= 0:
                t[station] += step[pose : pose + 3]
                R[station] = exp(step[pose + 3 : pose + 6]) @ R[station]
            if depth >= 0:
                rotors[station, :, X] += [step[depth] / 2, -step[depth] / 2]
            for axis in range(2):
                offset, *intrinsics = of.columns[station, axis, 2:]
                if offset >= 0:
                    offsets[station, axis] += step[offset]
                if intrinsics[0] >= 0:
                    _turn(rotors[station, axis], step[intrinsics])
        if of.scale >= 0:
            board *= 1 + step[of.scale]
        if of.places >= 0:
            board += step[of.places : of.places + board.size].reshape(-1, 3)
        if of.gravity >= 0:
            gravity += step[of.gravity : of.gravity + 3]
        return State(R, t, rotors, offsets, board, gravity, self.values + step)


def _turn(rotor: np.ndarray, step: np.ndarray) -> None:
    """Add a step of the intrinsics to the parameters of a rotor, in place."""
    rotor[TAN_TILT] += step[0]
    rotor[CURVE] += step[1]
    along = rotor[GIBMAG] * np.cos(rotor[GIBPHASE]) + step[2]
    across = rotor[GIBMAG] * np.sin(rotor[GIBPHASE]) + step[3]
    rotor[GIBMAG], rotor[GIBPHASE] = np.hypot(along, across), np.arctan2(across, along)
    rotor[IMPERFECT] = 1.0


def start(
    R: Sequence[np.ndarray],
    t_m: Sequence[np.ndarray],
    rotors: np.ndarray,
    board: np.ndarray,
    n: int,
) -> State:
    """Stations at these poses in the master's frame, the first of them the master; n unknowns."""
    offsets, own = np.zeros((len(R), 2)), np.array(rotors)
    return State(np.array(R), np.array(t_m), own, offsets, board.copy(), np.zeros(3), np.zeros(n))


@dataclass(frozen=True)
class Sweeps:
    """Hits in the order of their sweeps; first (sweeps + 1,): where each begins."""

    hits: Hits
    first: np.ndarray

    @property
    def sweep(self) -> np.ndarray:
        """Which sweep each hit is of."""
        return np.repeat(np.arange(self.first.size - 1), np.diff(self.first))


def by_sweep(hits: Hits) -> Sweeps:
    """Hits by cycle, station and axis, so nearly by time."""
    order, first = hits.by_sweep()
    return Sweeps(hits.take(order), np.append(first, order.size))
