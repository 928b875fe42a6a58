"""Unknowns of a joint estimate, and what is known of them beforehand.

The pose of each station but the master, and the board's trajectory, are free. Everything else has a
prior, a normal distribution about the value of the board file, the factory calibration or 0:

| unknown | of | default standard deviation |
|---|---|---|
| time zero | station and axis | 0.15 us (57 urad): flashes rise late, by diodes differently |
| phase | station and axis | 1 mrad: together with the time zero one offset |
| depth between both lasers | station | 10 mm |
| scale of the board | | 1e-3, of a small one 0.3 mm over its largest extent (`Scene.used_priors`) |
| place of a diode | diode, coordinate | 0.2 mm |
| cover of the diodes: shift at 50 deg, thickness | | 0.08, 0.8 mm about 0, 1.6 mm |
| gravity | | none; its magnitude 0.03 m/s^2 about 9.81 |
| gyroscope: bias | recording, axis | 0.1 rad/s |
| accelerometer: bias | recording, axis | 0.3 m/s^2 |
| accelerometer: scale | recording | 1e-2 |
| orientation of both on the board | recording, axis | 2 deg |
| that of the accelerometer from the gyroscope's | recording, axis | 1 deg |
| place of the accelerometer | recording, coordinate | 3 mm |
| delay of both against light | recording | 3 ms |

0 means exactly known. A station of the second generation has one rotor, so no depth; the time zero
of its turns is the offset of both planes, the phase is that of plane 1; the spread of its other
factory values is given beside these. The cover is an unknown where normals of diodes are known.
Scale and depth are hardly seen by the angles, so their priors go into the
covariance of the poses nearly as they are; where poses are known, the scale is seen. The last eight
are unknowns only where such data are used.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse import rotor
from mocap_metrology.lighthouse.batch.kernel import HELD, POSE, Values
from mocap_metrology.lighthouse.records import Hits
from mocap_metrology.lighthouse.rotation import exp
from mocap_metrology.lighthouse.timing import CYCLE_S

RAD_PER_S = np.pi / CYCLE_S
GROUPS = ("pose", "depth", "offset", "intrinsic", "scale", "place", "gravity", "inertial", "cover")
# Of the sensors of a recording: bias of both, scale, orientation, place, delay, orientation of the
# accelerometer from the gyroscope; in SI and rad.
_SD = 0.1, 0.3, 1e-2, np.radians(2.0), 3e-3, 3e-3, np.radians(1.0)
INERTIAL_SD = np.repeat(_SD, [3, 3, 1, 3, 3, 1, 3])
GRAVITY_M_S2 = 9.81
ANY_GRAVITY = 100.0  # of a coordinate: for recordings that say nothing of it
# Between the outermost diodes: decks of 33 mm were 0.5 to 1.3 % larger than their files.
EFFECTIVE_M = 3e-4
COVER_M = np.array([-0.8e-3, 1.6e-3])  # a and t of two kinds of trackers, within 0.06 mm
# Of a + HELD t and of t. Found with 2 mm in place of the first, a + HELD t of five real objects is
# -0.14, -0.09, -0.03, -0.02, -0.02 mm, each within 0.04 to 0.12 mm: 0.08 rms, their noise included.
# The estimate leaves it more freedom. Bare diodes, of which both are 0, are two off.
COVER_SD_M, COVER_USED_M = np.array([0.08e-3, 0.8e-3]), np.array([0.15e-3, 0.8e-3])
NO_NORMALS = np.zeros((0, 3))
NEARLY_KNOWN = 1e-3  # of a standard deviation: of what the angles are not asked for
MAGNITUDE_SD = 0.03  # m/s^2: between equator and pole, and by altitude
UP_SD = np.radians(1.5)  # of the accelerometer of a station


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
        """Priors of unknown rotors: the spread of the factory values of eight real stations about
        0, in place of their errors."""
        return replace(self, phase_mrad=37.0, tilt_mrad=5.0, curve_mrad=5.0, gib_mrad=9.0)

    def of_board(self, board: np.ndarray) -> Priors:
        """Priors with the scale of a board (n, 3) in m: on a small one, the places at which diodes
        receive light are less well known than its size."""
        if not self.board_scale > 0:
            return self
        apart = np.linalg.norm(board[:, None] - board, axis=2).max()
        return replace(self, board_scale=max(self.board_scale, EFFECTIVE_M / float(apart)))

    @property
    def time_zero_rad(self) -> float:
        """The time zero as an angle, rad."""
        return float(1e-6 * RAD_PER_S * self.time_zero_us)

    @property
    def offset_rad(self) -> float:
        """Standard deviation of the offset of an axis, by time zero and phase."""
        return float(np.hypot(self.time_zero_rad, 1e-3 * self.phase_mrad))


@dataclass(frozen=True)
class SideInformation:
    """What is known besides, where it is. ups (stations, 3): the way up in the frame of each
    station, NaN where it is unknown; spreads (stations, 2, 7): of stations of the second
    generation, standard deviations of phase, tilt, curve, and both parts of gibbous and of ogee of
    each plane, 0 where known; normals (n, 3): of the diodes, whose cover then is an unknown."""

    ups: np.ndarray | None = None
    spreads: np.ndarray | None = None
    normals: np.ndarray | None = None


@dataclass(frozen=True)
class Layout:
    """Columns of the global unknowns, and their prior standard deviations (inf: none).

    columns (stations, 2, 9), scale, places, cover: as the kernels read them, -1 where known;
    gravity: its first column; inertial (recordings,): the first of the sensors of each. working:
    standard deviations that the estimate starts with; group: which of `GROUPS` each is of.
    """

    columns: np.ndarray
    scale: int
    places: int
    gravity: int
    inertial: tuple[int, ...]
    sd: np.ndarray
    working: np.ndarray
    group: np.ndarray
    cover: int = -1

    @property
    def size(self) -> int:
        return int(self.sd.size)

    @property
    def rows(self) -> tuple[np.ndarray, int, int, int]:
        """Columns and rows of the unknowns as the kernels read them."""
        return self.columns, self.scale, self.places, self.cover


def layout(
    n_stations: int,
    n_diodes: int,
    priors: Priors,
    known_poses: bool = False,
    inertial: Sequence[bool] = (),
    gravity: bool = False,
    sized_scale: bool = False,
    more: SideInformation | None = None,
) -> Layout:
    """The unknowns of so many stations and diodes; known_poses: those of the stations are none;
    inertial: which recordings have such sensors; gravity: whether it is an unknown without them;
    sized_scale: whether data show the scale of the board."""
    more = more or SideInformation()
    columns = np.full((n_stations, 2, 9), -1)
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
    first, spreads = more.spreads is None, more.spreads
    if spreads is None:  # phase, tilt, curve and both parts of gibbous
        spread_mrad = priors.phase_mrad, priors.tilt_mrad, priors.curve_mrad, *2 * [priors.gib_mrad]
        spreads = np.tile(1e-3 * np.array(spread_mrad), (n_stations, 2, 1))
    for station in range(n_stations):
        if first:
            columns[station, :, 1] = new("depth", 1e-3 * priors.laser_depth_mm)
        for axis in range(2):
            phase, *others = spreads[station, axis].tolist()
            known = not min(others) > 0
            offset = float(np.hypot(priors.time_zero_rad, phase))
            used = priors.time_zero_rad if first and known else None
            columns[station, axis, 2] = new("offset", offset, 1, used)
            if not known:
                at = [new("intrinsic", value) for value in others]
                columns[station, axis, 3 : 3 + len(at)] = at
    scale = new("scale", priors.board_scale, 1, None if sized_scale else 0.0)
    places = new("place", 1e-3 * priors.board_position_mm, 3 * n_diodes)
    down = new("gravity", ANY_GRAVITY, 3 if gravity or any(inertial) else 0)
    sensors = []
    for there in inertial:
        sensors.append(len(sd) if there else -1)
        for value in INERTIAL_SD if there else ():
            new("inertial", value)
    covers = -1 if more.normals is None else len(sd)
    for value, used in () if more.normals is None else zip(COVER_SD_M, COVER_USED_M, strict=True):
        new("cover", float(value), 1, float(used))
    sizes = np.array(sd), np.array(working), np.array(group)
    return Layout(columns, scale, places, down, tuple(sensors), *sizes, covers)


class State(Values):
    """`Values` that a step changes."""

    def moved(self, step: np.ndarray, of: Layout) -> State:
        """The state with a step (unknowns,) added; poses turn by left rotation vectors."""
        R, t, rotors = self.R.copy(), self.t_m.copy(), self.rotors.copy()
        offsets, board, gravity = self.offsets.copy(), self.board.copy(), self.gravity.copy()
        for station in range(len(R)):
            pose, depth = of.columns[station, 0, :2]
            if pose >= 0:
                t[station] += step[pose : pose + 3]
                R[station] = exp(step[pose + 3 : pose + 6]) @ R[station]
            if depth >= 0:
                rotors[station, :, rotor.X] += [step[depth] / 2, -step[depth] / 2]
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
        cover = self.cover
        if of.cover >= 0:
            held, thicker = step[of.cover : of.cover + 2]
            cover = cover + np.array([held - HELD * thicker, thicker])
        values = self.values + step
        return State(R, t, rotors, offsets, board, gravity, values, self.normals, cover)


def _turn(row: np.ndarray, step: np.ndarray) -> None:
    row[rotor.TAN_TILT] += step[0]
    row[rotor.CURVE] += step[1]
    parts = [(rotor.GIBMAG, rotor.GIBPHASE, step[2], step[3])]
    if row[rotor.GENERATION] == 2:
        parts.append((rotor.OGEEMAG, rotor.OGEEPHASE, step[4], step[5]))
    for size, phase, by_along, by_across in parts:
        along = row[size] * np.cos(row[phase]) + by_along
        across = row[size] * np.sin(row[phase]) + by_across
        row[size], row[phase] = np.hypot(along, across), np.arctan2(across, along)
    row[rotor.IMPERFECT] = 1.0


def start(
    R: Sequence[np.ndarray],
    t_m: Sequence[np.ndarray],
    rotors: np.ndarray,
    board: np.ndarray,
    n: int,
    normals: np.ndarray = NO_NORMALS,
) -> State:
    """The state in which a search begins: factory rotors, board as filed, no offsets."""
    offsets, copied = np.zeros((len(R), 2)), np.array(rotors)
    known = offsets, board.copy(), np.zeros(3), np.zeros(n), np.ascontiguousarray(normals)
    return State(np.array(R), np.array(t_m), copied, *known, COVER_M.copy())


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
    """Hits by cycle, station and axis, and the sweeps by time: turns of stations of the second
    generation are of different lengths."""
    order, first = hits.by_sweep()
    ends = np.append(first, order.size)
    begin = hits.time_s[order[first]]
    if (np.diff(begin) < 0).any():
        by_time = np.argsort(begin, kind="stable")
        size = np.diff(ends)[by_time]
        shift = np.repeat(first[by_time] - np.r_[0, np.cumsum(size)[:-1]], size)
        order, ends = order[np.arange(order.size) + shift], np.r_[0, np.cumsum(size)]
    return Sweeps(hits.take(order), ends)


def first_gravity(state: State, ups: np.ndarray) -> Floats:
    """Gravity (3,) in m/s^2 by the stations' ways up (stations, 3), NaN where unknown."""
    up = np.nansum(np.einsum("sij,sj->si", state.R, ups), axis=0)
    return -GRAVITY_M_S2 * up / np.linalg.norm(up)


def gravity_equations(
    state: State, of: Layout, ups: np.ndarray | None
) -> tuple[Floats, Floats, float]:
    """Normal matrix, gradient and sum of squares of what is known of gravity: its magnitude, and
    the way up that stations transmit. With g in the master's frame, u = -g / |g|, R of a station,
        (|g| - 9.81) / 0.03,   (R' u - up) / 1.5 deg.
    Real stations were wrong by 1 to 2.5 deg, so this helps only where the pose is known no better.
    """
    S, h, cost = np.zeros((of.size, of.size)), np.zeros(of.size), 0.0
    if of.gravity < 0:
        return S, h, cost
    down = of.gravity + np.arange(3)
    size = np.linalg.norm(state.gravity)
    u = -state.gravity / size
    rows = [((size - GRAVITY_M_S2) / MAGNITUDE_SD, down, -u / MAGNITUDE_SD)]
    for station, up in enumerate(() if ups is None else ups):
        if not np.isfinite(up).all():
            continue
        R, pose = state.R[station], int(of.columns[station, 0, 0])
        by_g = R.T @ (np.outer(u, u) - np.eye(3)) / size
        by_turn = R.T @ np.cross(np.eye(3), u)  # [u]
        at = np.r_[down, pose + 3 + np.arange(3)] if pose >= 0 else down
        D = np.hstack([by_g, by_turn])[:, : at.size] / UP_SD
        rows += zip((R.T @ u - up) / UP_SD, [at] * 3, D, strict=True)
    for e, at, d in rows:
        S[np.ix_(at, at)] += np.outer(d, d)
        h[at] += e * d
        cost += float(e * e)
    return S, h, cost
