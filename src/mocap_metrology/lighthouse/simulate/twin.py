"""Twins of lighthouse recordings: two base stations, a board and how it moves, and what disturbs.

Every field is a key of the file of twins, with its range, default and meaning.
"""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, model_validator

from mocap_metrology.common.entries import Entry, Number, Text, Whole, list_of, one_of
from mocap_metrology.common.faults import Unfit
from mocap_metrology.lighthouse.board import flat_board
from mocap_metrology.lighthouse.records import Factory
from mocap_metrology.lighthouse.rotation import from_angles
from mocap_metrology.lighthouse.rotor import VARIANTS, Variant, check
from mocap_metrology.lighthouse.timing import CYCLE_S

REFERENCES = ("truth", "mocap")  # what calibrations are compared with
PATTERNS = ("line", "arc", "circle", "hand", "still")
ORIGIN = (0.0, 0.0, 0.0)
WORD_BITS = 32  # diodes that a word of a dump has room for

Metres = Annotated[float, Number(-20, 20)]
Degrees = Annotated[float, Number(-180, 180)]
QuarterTurn = Annotated[float, Number(-90, 90)]
InHousing = Annotated[float, Number(-0.2, 0.2)]
OfFactory = Annotated[float, Number(-7, 7)]
PointWithin20 = Annotated[tuple[Metres, Metres, Metres], list_of(3, "a list of 3 numbers")]
Angles = Annotated[tuple[Degrees, Degrees, Degrees], list_of(3, "a list of 3 numbers")]
Tilt = Annotated[tuple[QuarterTurn, QuarterTurn], list_of(2, "a list of 2 numbers")]
Laser = Annotated[tuple[InHousing, InHousing, InHousing], list_of(3, "a list of 3 numbers")]
Lasers = Annotated[tuple[Laser, Laser], list_of(2, "[[x, y, z], [x, y, z]] of axis 0 and axis 1")]
Rotors = Annotated[tuple[OfFactory, OfFactory], list_of(2, "a list of 2 numbers")]
Time = Number(0, 60)


def _blocked(value: object) -> object:
    if not isinstance(value, list | tuple) or not all(
        isinstance(one, list | tuple) and len(one) == 3 for one in value
    ):
        raise Unfit("a list of [station, from_s, to_s]", value)
    blocked = []
    for station, *times in value:
        start, end = map(Time.read, times)
        if end <= start:
            raise ValueError(f"{start:g} to {end:g} s, expected an end after the start")
        blocked.append((Whole(0, 1).read(station), start, end))
    return tuple(blocked)


Blocked = Annotated[tuple[tuple[int, float, float], ...], BeforeValidator(_blocked)]


class FactoryValues(Entry):
    """Factory calibration of both rotors."""

    phase: Rotors | None = None
    """Phase of rotor 0 and 1."""
    tilt: Rotors | None = None
    """Tilt of rotor 0 and 1."""
    curve: Rotors | None = None
    """Curve of rotor 0 and 1."""
    gibphase: Rotors | None = None
    """Phase of the gibbous term of rotor 0 and 1."""
    gibmag: Rotors | None = None
    """Amplitude of the gibbous term of rotor 0 and 1."""

    def made(self) -> Factory:
        """The values as the station itself can state them: half floats."""
        values: dict[str, Any] = {
            name: np.array(pair, dtype=np.float16).astype(np.float64)
            for name, pair in self.model_dump(exclude_none=True).items()
        }
        return Factory(**values)

    @model_validator(mode="after")
    def _of_first_generation(self) -> FactoryValues:
        check(self.made())
        return self


class BoardTwin(Entry):
    """A grid of diodes that faces along +x."""

    columns: Annotated[int, Whole(1, 32)] = 8
    """Diodes in a row."""
    rows: Annotated[int, Whole(1, 32)] = 4
    """Rows of diodes."""
    width_m: Annotated[float, Number(0.01, 2)] = 0.24
    """Width of the grid."""
    height_m: Annotated[float, Number(0.01, 2)] = 0.16
    """Height of the grid."""
    out_of_plane_m: Annotated[float, Number(0, 0.2)] = 0.0
    """Displaces each diode by this distance before or behind the plane."""

    def positions(self) -> np.ndarray:
        """Places of the diodes, (n, 3) in metres."""
        board = flat_board(self.columns, self.rows, self.width_m, self.height_m)
        if self.out_of_plane_m:
            depths = [-self.out_of_plane_m, self.out_of_plane_m]
            board[:, 0] = np.random.default_rng(99).choice(depths, len(board))
        return board


class MotionTwin(Entry):
    """Path of the board's centre in the master's frame, and how the board turns meanwhile."""

    pattern: Annotated[str, one_of(PATTERNS)] = "hand"
    """`line`, `arc` (half a circle, to and fro), `circle`, `hand` (random, three sines a
    coordinate) or `still`."""
    centre_m: PointWithin20
    """Centre of the path."""
    speed_m_s: Annotated[float, Number(0, 5)] = 0.4
    """Largest speed on the path."""
    extent_m: Annotated[float, Number(0, 5)] = 0.3
    """Diameter, length, largest extent along an axis."""
    sway_m: Annotated[float, Number(0, 1)] = 0.0
    """Slow random motion along each axis (rms) that is added to line, arc and circle. A hand is
    never exactly on a line, and positions on a straight line leave the rotation about it
    undetermined."""
    wobble_deg: Annotated[float, Number(0, 45)] = 8.0
    """Slow random rotation about each axis (rms)."""
    tremor_mm: Annotated[float, Number(0, 10)] = 0.0
    """Rms of each coordinate at 3-5 Hz and at 8-10 Hz."""
    tremor_deg: Annotated[float, Number(0, 10)] = 0.0
    """Rms of each angle in the same bands."""
    turn_deg: Angles = ORIGIN
    """Rotation of the board away from the middle between the stations, which it otherwise faces."""


class InertialTwin(Entry):
    """Gyroscope and accelerometer on the board."""

    rate_hz: Annotated[float, Number(50, 10_000)] = 1000.0
    """Samples a second."""
    gyro_density: Annotated[float, Number(0, 0.1)] = 1.75e-4
    """White noise of the gyroscope, in rad/s per root of 1 Hz."""
    accel_density: Annotated[float, Number(0, 1)] = 3e-3
    """White noise of the accelerometer, in m/s^2 per root of 1 Hz."""
    gyro_bias_rad_s: Annotated[float, Number(0, 1)] = 0.02
    """SD of the bias of each axis of the gyroscope."""
    accel_bias_m_s2: Annotated[float, Number(0, 5)] = 0.1
    """SD of that of the accelerometer."""
    accel_scale_error: Annotated[float, Number(0, 0.1)] = 3e-3
    """SD of the scale of the accelerometer about 1."""
    place_m: PointWithin20 = ORIGIN
    """Place on the board, as stated."""
    place_error_mm: Annotated[float, Number(0, 100)] = 1.0
    """SD of each coordinate of the place about this."""
    turn_error_deg: Annotated[float, Number(0, 20)] = 0.5
    """SD of the misalignment about each axis."""
    delay_ms: Annotated[float, Number(0, 15)] = 3.0
    """By how much both are late."""


class StationTwin(Entry):
    """A base station: pose of its housing in the master's, and its optics and lasers in there."""

    id: Annotated[int, Whole(1, 2**32 - 1)]
    """Identity that the flashes transmit."""
    mode: Annotated[str, one_of(("A", "b", "c"))]
    """Mode that the flashes transmit: b and c, or b and A by cable. A master in mode A without a
    slave sweeps alone."""
    position_m: PointWithin20 = ORIGIN
    """Position of the housing of the slave in that of the master."""
    rotation_deg: Angles = ORIGIN
    """Rotation of the housing of the slave: [alpha, beta, gamma]."""
    factory: FactoryValues | None = None
    """Values of rotor 0 and 1 (rounded to half floats), or a name of `factories`; without it, ideal
    optics."""
    lasers_m: Lasers = (ORIGIN, ORIGIN)
    """Positions of the lasers of axis 0 and 1 in the housing: [[x, y, z], [x, y, z]] (default: both
    at its origin)."""

    @property
    def optics(self) -> Factory:
        """Values of the rotors as the station states them."""
        return self.factory.made() if self.factory else Factory()

    @property
    def R(self) -> np.ndarray:
        return from_angles(*np.radians(self.rotation_deg))

    @property
    def t(self) -> np.ndarray:
        """Origin of the station's frame in the master's, metres."""
        return np.array(self.position_m)

    @property
    def optical_origin(self) -> np.ndarray:
        """Origin of the optics in the housing, metres: axis 0 sees nothing of its laser's z, axis 1
        nothing of its y; in depth the middle of both lasers."""
        first, second = np.array(self.lasers_m)
        return np.array([(first[0] + second[0]) / 2, first[1], second[2]])


class LighthouseTwin(Entry):
    """A simulated recording of a board of photodiodes before two base stations. Metres,
    degrees; the frame of everything is the housing of the master: x forwards, y to its left, z up.
    A rotation [alpha, beta, gamma] is Rz(gamma) Ry(beta) Rx(alpha)."""

    seed: Annotated[int, Whole(0, 2**63 - 1)]
    """The same seed gives the same recording."""
    setup: Text = ""
    """Name of one of `setups`, which has the keys that the twin does not set."""
    master: StationTwin
    """The master."""
    slave: StationTwin | None = None
    """The slave."""
    motion: MotionTwin
    """Motion of the board."""
    board: BoardTwin = BoardTwin()
    """Diodes that face forwards (+x)."""
    inertial: InertialTwin | None = None
    """Gyroscope and accelerometer on the board; `lighthouse.inertial` of config.yaml uses them."""
    variant: Annotated[str, one_of(VARIANTS)] = "crazyflie"
    """Formula of the rotors: crazyflie, libsurvive or astrobee."""
    tilt_deg: Tilt = (0.0, 0.0)
    """[roll, pitch] of the master in the room; sets gravity of both stations."""
    duration_s: Annotated[float, Number(0.02, 60)] = 8.0
    """8 s are 16 000 000 words; 8.388608 fills the memory of the board."""
    start_cycle: Annotated[float, Number(0, 4)] = 0.0
    """Position of the first sample in the period of four cycles."""
    clock_ppm: Annotated[float, Number(-1000, 1000)] = 0.0
    """Deviation of the clock of the recording from that of the stations."""
    slave_offset_us: Annotated[float, Number(-50, 50)] = 0.0
    """Added to the 416.67 us from the flash of the master to that of the slave."""
    sync_jitter_us: Annotated[float, Number(0, 20)] = 0.0
    """Jitter of each flash (SD)."""
    flash_shortfall_us: Annotated[float, Number(0, 10.41)] = 5.2
    """Difference between a flash and the longest flash of its code."""
    flash_bias_us: Annotated[float, Number(-10, 10)] = 0.0
    """Lengthening of a flash by the analogue electronics."""
    flash_spread_us: Annotated[float, Number(0, 5)] = 0.0
    """SD of this lengthening, for each diode and flash."""
    flash_rise_us: Annotated[float, Number(0, 5)] = 0.0
    """Most by which a diode sees the begin of every flash late; each has its own delay, uniform
    from 0."""
    aperture_mm: Annotated[float, Number(0.1, 20)] = 3.0
    """A sweep lasts aperture / (377/s x distance) + `beam_us`."""
    beam_us: Annotated[float, Number(0, 20)] = 0.0
    """See `aperture_mm`."""
    common_urad: Annotated[float, Number(0, 1e4)] = 0.0
    """Noise of a sweep, the same for all diodes (SD)."""
    independent_urad: Annotated[float, Number(0, 1e4)] = 0.0
    """Noise of each hit (SD)."""
    incidence_deg: Annotated[float, Number(1, 90)] = 70.0
    """A diode sees no light from larger angles."""
    dropout: Annotated[float, Number(0, 1)] = 0.0
    """Share of hits that are lost."""
    reflections: Annotated[float, Number(0, 1)] = 0.0
    """Share of hits with a second, shorter pulse 30 to 800 us away."""
    missed_flashes: Annotated[float, Number(0, 1)] = 0.0
    """Share of flashes that are missed."""
    false_flashes_per_s: Annotated[float, Number(0, 1000)] = 0.0
    """Flashes of other origin, seen by all diodes."""
    blocked: Blocked = ()
    """[[1, 2.0, 3.5]]: station (0 master, 1 slave), start and end in s; its light is blocked."""
    occlusions_per_min: Annotated[float, Number(0, 600)] = 0.0
    """Random interruptions of this kind, for each station."""
    occlusion_s: Annotated[float, Number(0.001, 60)] = 0.2
    """Their mean length."""
    reference: Annotated[str, one_of(REFERENCES)] = "truth"
    """`mocap`: calibrations are compared with the markers on mounts of both housings, seen by a
    motion-capture system with a frame of its own."""
    mocap_noise_mm: Annotated[float, Number(0, 10)] = 0.3
    """Noise of these markers."""
    mocap_frames: Annotated[int, Whole(1, 100_000)] = 100
    """Number of their frames."""
    mocap_rate_hz: Annotated[float, Number(1, 10_000)] = 100.0
    """Their frame rate."""
    mount_error_deg: Annotated[float, Number(0, 10)] = 0.0
    """Misalignment of a mount, the same in all calibrations of a setup."""

    @model_validator(mode="after")
    def _together(self) -> LighthouseTwin:
        if self.slave is not None:
            apart = float(np.linalg.norm(self.slave.t - self.master.t))
            if apart < 0.1:
                raise ValueError(f"slave.position_m: {apart:g} m apart, expected 0.1 m or more")
            if self.slave.id == self.master.id:
                raise ValueError("slave.id: the master's too, expected different ids")
            if self.slave.mode == "b" or self.master.mode != "b":
                raise ValueError(
                    f"modes {self.master.mode} + {self.slave.mode}, expected b + c or b + A"
                )
        elif self.master.mode != "A":
            raise ValueError("slave is missing, expected a slave, or a master in mode A")
        if any(self.master.position_m) or any(self.master.rotation_deg):
            raise ValueError("master: has a pose, expected none: it is the frame of all others")
        n = self.board.columns * self.board.rows
        if not 3 <= n <= WORD_BITS:
            raise ValueError(f"board: {n} diodes, expected 3 to {WORD_BITS}")
        moves = self.motion.pattern != "still"
        if moves and not (self.motion.speed_m_s > 0 and self.motion.extent_m > 0):
            raise ValueError("motion: speed or extent is 0, expected more, or pattern still")
        for station, _, until in self.blocked:
            if station >= len(self.stations) or until > self.duration_s + 1e-9:
                raise ValueError("blocked: no such station or time, expected [0 or 1, from, to]")
        return self

    @property
    def stations(self) -> tuple[StationTwin, ...]:
        return (self.master,) if self.slave is None else (self.master, self.slave)

    @property
    def cycle_s(self) -> float:
        """Length of a cycle by the clock of the recording."""
        return CYCLE_S * (1 + 1e-6 * self.clock_ppm)

    @property
    def rotors(self) -> Variant:
        return VARIANTS[self.variant]
