"""What the stages hand on, and the columns in which it is stored.

Arrays of one record have one length; all times are of one clock.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from mocap_metrology.lighthouse.rotation import quaternions

MASTER, SLAVE = 0, 1
ROLES = ("master", "slave")
COVARIANCE_UNITS = np.r_[np.full(3, 1e3), np.full(3, 180 / np.pi)]  # m, rad -> mm, deg
AXES = ("azimuth", "elevation")
PLANES = ("plane0", "plane1")  # in place of the axes, of generation 2


@dataclass(frozen=True)
class Inertial:
    """Gyroscope and accelerometer on a board, in axes of the board, sorted by time."""

    time_s: np.ndarray
    rate_rad_s: np.ndarray  # (n, 3)
    force_m_s2: np.ndarray  # (n, 3): acceleration less gravity, 9.81 upwards at rest
    place_m: np.ndarray  # (3,), of the accelerometer on the board

    def __len__(self) -> int:
        return int(self.time_s.size)


@dataclass(frozen=True)
class Pulses:
    """Light on the photodiodes, sorted by start."""

    start_s: np.ndarray  # rising edge, from the beginning of the recording
    length_s: np.ndarray
    diode: np.ndarray  # int16, from 0
    n_diodes: int
    duration_s: float
    resolution_s: float  # step of the clock: 0.5 us in a 2 MHz dump, 1/48 us in a libsurvive one
    notes: tuple[str, ...] = ()  # what a reader should know of the file, one line each
    inertial: Inertial | None = None  # by the same clock
    normals: np.ndarray | None = None  # (n_diodes, 3), unit vectors out of the diodes


@dataclass(frozen=True)
class Clock:
    """Line through the flashes of one station: its cycle c begins at epoch_s + c * cycle_s."""

    epoch_s: float
    cycle_s: float  # measured length of a half turn
    rms_s: float  # of the flashes about the line, outliers apart

    def start(self, cycle: np.ndarray | int) -> np.ndarray:
        """When cycles begin, in s."""
        return self.epoch_s + self.cycle_s * np.asarray(cycle)


@dataclass(frozen=True)
class Flashes:
    """Flashes of one station, one a cycle at most; cycles of both stations carry one numbering."""

    station: int  # MASTER or SLAVE
    clock: Clock
    cycle: np.ndarray  # int32, rising; missed flashes are missing
    time_s: np.ndarray  # first rising edge over the diodes
    length_s: np.ndarray  # with the bias of the recording subtracted
    code: np.ndarray  # int8: 0..7, -1 where the length decides nothing


def is_new(*columns: np.ndarray) -> np.ndarray:
    """Whether a row differs from the one before in any of the columns (n,); the first one does."""
    new = np.any([column[1:] != column[:-1] for column in columns], axis=0)
    return np.insert(new, 0, True)[: columns[0].size]


class Rows:
    """Arrays with one row each at times `time_s`."""

    time_s: np.ndarray

    def __len__(self) -> int:
        return int(self.time_s.size)

    def take(self, chosen: np.ndarray) -> Self:
        """The chosen rows, by a mask or by indices."""
        return type(self)(**{name: values[chosen] for name, values in vars(self).items()})

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """All rows of several, in order."""
        every = [vars(part) for part in parts]
        return cls(
            **{name: np.concatenate([columns[name] for columns in every]) for name in every[0]}
        )


@dataclass(frozen=True)
class Hits(Rows):
    """Sweeps of a laser over photodiodes, sorted by time.

    In generation 2 a station is its place in the list of stations (the reference first, then by
    rising channel), an axis is a plane (0 met first in a turn), and a cycle a turn of that station;
    angle_rad = 2 pi (time - begin of the turn) / T - 2 pi/3 (plane 0) or - 4 pi/3 (plane 1).
    """

    station: np.ndarray  # int8: 0 master, 1 slave
    axis: np.ndarray  # int8: 0 azimuth, 1 elevation
    cycle: np.ndarray  # int32
    diode: np.ndarray  # int16
    time_s: np.ndarray  # middle of the pulse
    angle_rad: np.ndarray  # pi (time - begin of the station's cycle) / cycle length - pi/2
    width_s: np.ndarray

    @classmethod
    def of(cls, *whole: np.ndarray, time_s: np.ndarray, angle_rad: np.ndarray) -> Hits:
        """With columns station, axis, cycle, diode of any type, and unknown widths."""
        kinds = np.int8, np.int8, np.int32, np.int16
        station, axis, cycle, diode = (k.astype(kind) for k, kind in zip(whole, kinds, strict=True))
        return cls(station, axis, cycle, diode, time_s, angle_rad, np.full(time_s.size, np.nan))

    def by_sweep(self) -> tuple[np.ndarray, np.ndarray]:
        """Order of the hits by cycle, station and axis, and where each sweep begins in it."""
        order = np.lexsort((self.axis, self.station, self.cycle))
        keys = (key[order] for key in (self.cycle, self.station, self.axis))
        return order, np.flatnonzero(is_new(*keys))


@dataclass(frozen=True)
class Measurements(Rows):
    """M_t of J Eq. 2 at n moments, of one station.

    time_s (n,); angles_rad (n, diodes, 2): azimuth and elevation, NaN where either is missing.
    """

    time_s: np.ndarray
    angles_rad: np.ndarray

    @property
    def seen(self) -> np.ndarray:
        """Diodes with both angles, (n, diodes)."""
        return np.isfinite(self.angles_rad).all(axis=2)


@dataclass(frozen=True)
class Path(Rows):
    """Board poses of n measurements in a station's frame.

    time_s (n,), R (n, 3, 3), t_m (n, 3); epsilon (n,) the remaining K_1 in rad^2; n_angles (n,);
    ambiguity (n,): K_1 of the mirrored minimum over that of the chosen one, infinite where there is
    none, NaN if not sought.
    """

    time_s: np.ndarray
    R: np.ndarray
    t_m: np.ndarray
    epsilon: np.ndarray
    n_angles: np.ndarray
    ambiguity: np.ndarray

    def seen_from(self, R: np.ndarray, t_m: np.ndarray) -> Path:
        """The path in a frame in which the present one has the pose R, t_m."""
        return replace(self, R=R @ self.R, t_m=self.t_m @ R.T + t_m)


@dataclass(frozen=True)
class Factory:
    """Calibration of a station as written by its maker; each has one value an axis, in generation 2
    a plane. The same name is not the same term in both generations."""

    phase: np.ndarray = field(default_factory=lambda: np.zeros(2))  # rad
    tilt: np.ndarray = field(default_factory=lambda: np.zeros(2))  # rad
    curve: np.ndarray = field(default_factory=lambda: np.zeros(2))  # 1/rad
    gibphase: np.ndarray = field(default_factory=lambda: np.zeros(2))  # rad
    gibmag: np.ndarray = field(default_factory=lambda: np.zeros(2))  # rad
    ogeephase: np.ndarray = field(default_factory=lambda: np.zeros(2))  # rad, of generation 2
    ogeemag: np.ndarray = field(default_factory=lambda: np.zeros(2))  # of generation 2
    generation: int = field(default=1, kw_only=True)


@dataclass(frozen=True)
class Station:
    """Data that a station transmits in the bits of its flashes, or of its sweeps (generation 2)."""

    role: str  # master or slave; of generation 2 its channel index, in digits
    id: int | None = None
    mode: str | None = None  # A, b or c
    factory: Factory | None = None
    gravity: np.ndarray | None = None  # unit vector in the station's frame, upwards
    frames_found: int = 0  # whole frames with the right checksum, voted ones included
    why: str = ""  # why there is no factory calibration
    firmware: int | None = None
    hardware: int | None = None
    up_by_geometry: np.ndarray | None = None  # likewise, by the poses in a Crazyflie's file
    generation: int = 1
    channel: int | None = None  # index 0 to 15, of generation 2


@dataclass(frozen=True)
class Halves:
    """Poses from before and after a moment of a recording, or from one of several recordings and
    from the others: how far apart, and the squared distance d^T C^-1 d of both (six degrees of
    freedom); stepped: whether a step at one moment explains it, None where that was not tested."""

    mm: float
    deg: float
    m2: float
    recordings: bool = False
    stepped: bool | None = None

    @classmethod
    def of(cls, d: np.ndarray, m2: float) -> Halves:
        """By the difference (6,) of their poses in m and rad."""
        return cls(1e3 * float(np.linalg.norm(d[:3])), float(np.degrees(np.linalg.norm(d[3:]))), m2)


@dataclass(frozen=True)
class SharedErrors:
    """Errors of board and optics, which recordings of the same board and stations share.

    sd (n,): standard deviations in m and rad, or of a factor; effect (n, 6): of an error of one
    standard deviation on the pose, in mm and deg as a covariance counts; of_board (n,): whether it
    is of the board, else of the stations; board: digest of the board's diodes.
    """

    sd: np.ndarray
    effect: np.ndarray
    of_board: np.ndarray
    board: str


@dataclass(frozen=True)
class PoseEstimate:
    """Pose of a station in the frame of the reference, by one estimator at one stage."""

    estimator: str  # batch, paper, paper-tight, paper-lm, geometric, pnp
    stage: str  # kabsch, final, static
    optics: str  # ideal, factory
    R: np.ndarray  # 3 x 3
    t_m: np.ndarray  # 3, metres
    frame: str = "optical"
    covariance: np.ndarray | None = None  # 6 x 6 in mm and deg: t, left rotation vector
    covariance_noise: np.ndarray | None = None  # its part that another recording does not share
    shared: SharedErrors | None = None  # the rest of it
    residual_rms_urad: float = float("nan")
    n_angles: int = 0
    mirrored_share: float = float("nan")  # of the board poses it is based on
    weighted_rms_urad: float = float("nan")  # residual beyond errors of the board poses
    noise_gain: float = float("nan")  # residual by errors of the board poses over noise of an angle
    halves: Halves | None = None  # of stage final of batch and paper-lm
    seconds: float = float("nan")
    note: str = ""
    details: Mapping[str, object] | None = None  # of batch: noise and the other unknowns
    path: Path | None = None  # of batch: the board in the master's frame
    station: str = ROLES[SLAVE]  # its role


# Few distinct values, or long runs of one.
PULSES_CODED = ("diode", "length_us")
SWEEPS_CODED = ("station", "axis", "diode", "width_us")
RATES = ("rate_x_rad_s", "rate_y_rad_s", "rate_z_rad_s")
FORCES = ("force_x_m_s2", "force_y_m_s2", "force_z_m_s2")
PLACES = ("place_x_m", "place_y_m", "place_z_m")  # of the sensors on the board, in every row


def pulse_columns(pulses: Pulses) -> dict[str, np.ndarray]:
    """pulses.parquet: rising edge, length, diode."""
    return {
        "start_s": pulses.start_s,
        "length_us": (1e6 * pulses.length_s).astype(np.float32),
        "diode": pulses.diode,
    }


def sweep_columns(hits: Hits) -> dict[str, np.ndarray]:
    """sweeps.parquet: one row for each retained hit."""
    columns = dict(vars(hits))
    width_s = columns.pop("width_s")
    return columns | {"width_us": (1e6 * width_s).astype(np.float32)}


def inertial_columns(inertial: Inertial | None) -> dict[str, np.ndarray]:
    """inertial.parquet: one row a sample; no rows without such sensors."""
    none = np.zeros((0, 3))
    series = inertial or Inertial(none[:, 0], none, none, none[:, 0])
    parts = {"time_s": series.time_s}
    for names, values in ((RATES, series.rate_rad_s), (FORCES, series.force_m_s2)):
        parts |= dict(zip(names, values.T, strict=True))
    place = series.place_m if len(series) else np.zeros(3)
    return parts | {name: np.full(len(series), x) for name, x in zip(PLACES, place, strict=True)}


def inertial_of(columns: Mapping[str, np.ndarray]) -> Inertial | None:
    """The series that `inertial_columns` wrote; None where it is empty."""
    if not columns["time_s"].size:
        return None
    rate, force, place = (
        np.column_stack([columns[name] for name in names]) for names in (RATES, FORCES, PLACES)
    )
    return Inertial(columns["time_s"], rate, force, place[0])


def hits_of(columns: Mapping[str, np.ndarray]) -> Hits:
    """Hits from the columns of sweeps.parquet."""
    names = [name for name in Hits.__dataclass_fields__ if name != "width_s"]
    width_s = 1e-6 * columns["width_us"].astype(np.float64)
    return Hits(**{name: columns[name] for name in names}, width_s=width_s)


def pose_columns(paths: Mapping[tuple[str, str], tuple[Path, ...]]) -> dict[str, np.ndarray]:
    """poses.parquet: board poses in the frame of each station, of every estimator and optics."""
    parts: dict[str, list[np.ndarray]] = {}
    for (estimator, optics), both in paths.items():
        for station, path in enumerate(both):
            n = len(path)
            q = quaternions(path.R)
            columns = {
                "estimator": np.full(n, estimator, dtype=object),
                "optics": np.full(n, optics, dtype=object),
                "station": np.full(n, station, dtype=np.int8),
                "time_s": path.time_s,
                **dict(zip(("x_m", "y_m", "z_m"), path.t_m.T, strict=True)),
                **dict(zip(("qx", "qy", "qz", "qw"), q.T, strict=True)),
                "epsilon_rad2": path.epsilon,
                "n_angles": np.asarray(path.n_angles, dtype=np.int32),
                "ambiguity": path.ambiguity,
            }
            for name, values in columns.items():
                parts.setdefault(name, []).append(values)
    return {name: np.concatenate(values) for name, values in parts.items()}
