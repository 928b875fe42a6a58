"""Twins of calibrations: every key of the file of twins, and what is simulated of it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

import numpy as np
from pydantic import BeforeValidator, model_validator

from mocap_metrology.common.faults import Faults, Unfit
from mocap_metrology.lighthouse.records import Factory
from mocap_metrology.lighthouse.rotor import VARIANTS, check
from mocap_metrology.lighthouse.simulate import twin as twins
from mocap_metrology.lighthouse.simulate.twin import ORIGIN, PATTERNS, REFERENCES, WORD_BITS
from mocap_workflow.entries import (
    Entry,
    Number,
    Text,
    TwinsFile,
    Whole,
    list_of,
    one_of,
    read_entry,
)

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
    found = []
    for station, *times in value:
        start, end = map(Time.read, times)
        if end <= start:
            raise ValueError(f"{start:g} to {end:g} s, expected an end after the start")
        found.append((Whole(0, 1).read(station), start, end))
    return tuple(found)


Blocked = Annotated[tuple[tuple[int, float, float], ...], BeforeValidator(_blocked)]


class FactoryValues(Entry):
    """Factory calibration of both rotors."""

    BEFORE_KEY = "."

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
        given = self.model_dump(exclude_none=True)
        return Factory(
            **{
                name: np.array(pair, dtype=np.float16).astype(np.float64)
                for name, pair in given.items()
            }
        )

    @model_validator(mode="after")
    def _of_first_generation(self) -> FactoryValues:
        check(self.made())
        return self


class Board(Entry):
    """A grid of diodes."""

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

    def made(self) -> twins.BoardTwin:
        """The board."""
        return twins.BoardTwin(**self.model_dump())


class Motion(Entry):
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

    def made(self) -> twins.MotionTwin:
        """The motion."""
        return twins.MotionTwin(**self.model_dump())


class Inertial(Entry):
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

    def made(self) -> twins.InertialTwin:
        """The sensors."""
        return twins.InertialTwin(**self.model_dump())


class Station(Entry):
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

    def made(self) -> twins.StationTwin:
        """The station."""
        factory = self.factory.made() if self.factory else None
        return twins.StationTwin(**self.model_dump(exclude={"factory"}), factory=factory)


class CalibrationTwin(Entry):
    """A simulated recording of a board of photodiodes before two base stations. Metres,
    degrees; the frame of everything is the housing of the master: x forwards, y to its left, z up.
    A rotation [alpha, beta, gamma] is Rz(gamma) Ry(beta) Rx(alpha)."""

    seed: Annotated[int, Whole(0, 2**63 - 1)]
    """The same seed gives the same recording."""
    setup: Text = ""
    """Name of one of `setups`, which has the keys that the twin does not set."""
    master: Station
    """The master."""
    slave: Station | None = None
    """The slave."""
    motion: Motion
    """Motion of the board."""
    board: Board = Board()
    """Diodes that face forwards (+x)."""
    inertial: Inertial | None = None
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

    def made(self, name: str) -> twins.LighthouseTwin:
        """The twin of that name."""
        parts = {"master", "slave", "motion", "board", "inertial"}
        return twins.LighthouseTwin(
            name=name,
            **self.model_dump(exclude=parts),
            master=self.master.made(),
            slave=self.slave.made() if self.slave else None,
            motion=self.motion.made(),
            board=self.board.made(),
            inertial=self.inertial.made() if self.inertial else None,
        )

    @model_validator(mode="after")
    def _together(self) -> CalibrationTwin:
        _check(self.made(""))
        return self


def _check(twin: twins.LighthouseTwin) -> None:
    """What stations, board and motion must have in common."""
    if twin.slave is not None:
        apart = float(np.linalg.norm(twin.slave.t - twin.master.t))
        if apart < 0.1:
            raise ValueError(f"slave.position_m: {apart:g} m apart, expected 0.1 m or more")
        if twin.slave.id == twin.master.id:
            raise ValueError("slave.id: the master's too, expected different ids")
        if twin.slave.mode == "b" or twin.master.mode != "b":
            raise ValueError(
                f"modes {twin.master.mode} + {twin.slave.mode}, expected b + c or b + A"
            )
    elif twin.master.mode != "A":
        raise ValueError("slave is missing, expected a slave, or a master in mode A")
    if any(twin.master.position_m) or any(twin.master.rotation_deg):
        raise ValueError("master: has a pose, expected none: it is the frame of all others")
    n = twin.board.columns * twin.board.rows
    if not 3 <= n <= WORD_BITS:
        raise ValueError(f"board: {n} diodes, expected 3 to {WORD_BITS}")
    moves = twin.motion.pattern != "still"
    if moves and not (twin.motion.speed_m_s > 0 and twin.motion.extent_m > 0):
        raise ValueError("motion: speed or extent is 0, expected more, or pattern still")
    for station, _, until in twin.blocked:
        if station >= len(twin.stations) or until > twin.duration_s + 1e-9:
            raise ValueError("blocked: no such station or time, expected [0 or 1, from, to]")


def calibration_twin(document: TwinsFile, name: str) -> CalibrationTwin:
    """A twin of the file of twins, with the keys it inherits from other entries."""
    return read_entry(CalibrationTwin, twin_entry(document, name), f"twin {name}")


def twin_from_mapping(mapping: Mapping[str, object], name: str = "twin") -> twins.LighthouseTwin:
    """A twin of its keys; setups and defaults are merged before."""
    return read_entry(CalibrationTwin, mapping, f"twin {name}").made(name)


def twin_entry(document: TwinsFile, name: str) -> object:
    """All keys of a twin: its own win over those of the twin that it is `like`, these over its
    setup's, and these over the defaults; nested keys one by one. A `factory` may name an entry of
    `factories`."""
    where = f"twin {name}"
    entries, setups = document["twins"], document.get("setups", {})
    factories = document.get("factories", {})
    if not isinstance(entries[name], Mapping):
        return entries[name]
    entry = dict(entries[name])
    if "like" in entry:
        like = entry.pop("like")
        if not isinstance(like, str) or like not in entries or "like" in entries[like]:
            raise Faults([f"{where}: like: {like!r}, expected a twin without a key like"])
        entry = _merged(entries[like], entry)
    setup = entry.get("setup")
    if setup is not None and not (isinstance(setup, str) and setup in setups):
        raise Faults([f"{where}: setup: {setup!r}, expected one of {', '.join(setups)}"])
    defaults = document.get("defaults", {}).get("calibration") or {}
    entry = _merged(_merged(defaults, setups[setup] if setup is not None else {}), entry)
    for role in ("master", "slave"):
        station = entry.get(role)
        if isinstance(station, Mapping) and isinstance(station.get("factory"), str):
            named = station["factory"]
            if named not in factories:
                known = ", ".join(factories)
                raise Faults([f"{where}: {role}.factory: {named!r}, expected one of {known}"])
            entry[role] = {**station, "factory": factories[named]}
    return entry


def _merged(low: Mapping[str, object], high: Mapping[str, object]) -> dict[str, object]:
    both = {**low, **high}
    for key, value in high.items():
        under = low.get(key)
        if isinstance(value, Mapping) and isinstance(under, Mapping):
            both[key] = {**under, **value}
    return both
