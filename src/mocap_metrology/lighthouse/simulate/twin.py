"""Twins of lighthouse recordings: two base stations, a board and how it moves, and what disturbs.

Every field is a key of config/twins.yaml; config/README.md explains them all.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mocap_metrology.lighthouse.board import flat_board
from mocap_metrology.lighthouse.records import Factory
from mocap_metrology.lighthouse.rotation import from_angles
from mocap_metrology.lighthouse.rotor import VARIANTS, Variant
from mocap_metrology.lighthouse.timing import CYCLE_S

Point = tuple[float, float, float]
REFERENCES = ("truth", "mocap")  # what calibrations are compared with
PATTERNS = ("line", "arc", "circle", "hand", "still")
ORIGIN = (0.0, 0.0, 0.0)
WORD_BITS = 32  # diodes that a word of a dump has room for


@dataclass(frozen=True, kw_only=True)
class BoardTwin:
    """A grid that faces along +x; its diodes may be out of the plane, front or back, in a
    pattern drawn once for all twins."""

    columns: int = 8
    rows: int = 4
    width_m: float = 0.24
    height_m: float = 0.16
    out_of_plane_m: float = 0.0

    def positions(self) -> np.ndarray:
        """Places of the diodes, (n, 3) in metres."""
        board = flat_board(self.columns, self.rows, self.width_m, self.height_m)
        if self.out_of_plane_m:
            signs = np.random.default_rng(99).choice([-1.0, 1.0], len(board))
            board[:, 0] = self.out_of_plane_m * signs
        return board


@dataclass(frozen=True, kw_only=True)
class MotionTwin:
    """Path of the board's centre in the master's frame, and how the board turns meanwhile.

    `speed_m_s` is the greatest speed of the path, `extent_m` its greatest extent along an axis
    (diameter of a circle, of a half circle for `arc`); `sway_m` rms along each axis, by which a
    line, arc or circle drawn by hand deviates; `wobble_deg` rms about each axis;
    `tremor_mm` and `tremor_deg` rms in each of the bands 3-5 and 8-10 Hz; `turn_deg` turns the
    board away from facing the stations.
    """

    pattern: str = "hand"
    centre_m: Point
    speed_m_s: float = 0.4
    extent_m: float = 0.3
    sway_m: float = 0.0
    wobble_deg: float = 8.0
    tremor_mm: float = 0.0
    tremor_deg: float = 0.0
    turn_deg: Point = ORIGIN


@dataclass(frozen=True, kw_only=True)
class StationTwin:
    """A base station: pose of its housing in the master's, and its optics and lasers in there."""

    id: int
    mode: str
    position_m: Point = ORIGIN
    rotation_deg: Point = ORIGIN
    factory: Factory | None = None
    lasers_m: tuple[Point, Point] = (ORIGIN, ORIGIN)

    @property
    def R(self) -> np.ndarray:
        """Rotation of the station's frame into the master's."""
        return from_angles(*np.radians(self.rotation_deg))

    @property
    def t(self) -> np.ndarray:
        """Origin of the station's frame in the master's, metres."""
        return np.array(self.position_m)

    @property
    def optical_origin(self) -> np.ndarray:
        """Where the optics have their origin in the housing, metres: axis 0 sees nothing of its
        laser's z, axis 1 nothing of its y; in depth the middle of both lasers."""
        first, second = np.array(self.lasers_m)
        return np.array([(first[0] + second[0]) / 2, first[1], second[2]])


@dataclass(frozen=True, kw_only=True)
class InertialTwin:
    """Gyroscope and accelerometer on the board at `place_m`: samples a second, noise densities in
    rad/s and m/s^2 per root of 1 Hz, standard deviations of their biases, of the accelerometer's
    scale, and of the place and orientation on the board; by how much they are late."""

    rate_hz: float = 1000.0
    gyro_density: float = 1.75e-4
    accel_density: float = 3e-3
    gyro_bias_rad_s: float = 0.02
    accel_bias_m_s2: float = 0.1
    accel_scale_error: float = 3e-3
    place_m: Point = ORIGIN
    place_error_mm: float = 1.0
    turn_error_deg: float = 0.5
    delay_ms: float = 3.0


@dataclass(frozen=True, kw_only=True)
class LighthouseTwin:
    """All parameters of a simulated recording; the file of twins describes each key."""

    name: str
    seed: int
    setup: str = ""
    master: StationTwin
    slave: StationTwin | None = None
    motion: MotionTwin
    board: BoardTwin = BoardTwin()
    inertial: InertialTwin | None = None
    variant: str = "crazyflie"
    tilt_deg: tuple[float, float] = (0.0, 0.0)
    duration_s: float = 8.0
    start_cycle: float = 0.0
    clock_ppm: float = 0.0
    slave_offset_us: float = 0.0
    sync_jitter_us: float = 0.0
    flash_shortfall_us: float = 5.2
    flash_bias_us: float = 0.0
    flash_spread_us: float = 0.0
    flash_rise_us: float = 0.0
    aperture_mm: float = 3.0
    beam_us: float = 0.0
    common_urad: float = 0.0
    independent_urad: float = 0.0
    incidence_deg: float = 70.0
    dropout: float = 0.0
    reflections: float = 0.0
    missed_flashes: float = 0.0
    false_flashes_per_s: float = 0.0
    blocked: tuple[tuple[int, float, float], ...] = ()
    occlusions_per_min: float = 0.0
    occlusion_s: float = 0.2
    reference: str = "truth"
    mocap_noise_mm: float = 0.3
    mocap_frames: int = 100
    mocap_rate_hz: float = 100.0
    mount_error_deg: float = 0.0

    @property
    def stations(self) -> tuple[StationTwin, ...]:
        """The master, and the slave where there is one."""
        return (self.master,) if self.slave is None else (self.master, self.slave)

    @property
    def cycle_s(self) -> float:
        """Length of a cycle by the clock of the recording."""
        return CYCLE_S * (1 + 1e-6 * self.clock_ppm)

    @property
    def rotors(self) -> Variant:
        """Which driver's formula the rotors obey."""
        return VARIANTS[self.variant]
