"""Twins of lighthouse recordings: two base stations, a board and how it moves, and what disturbs.

Every field is a key of config/twins.yaml, which explains them all.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.board import flat_board
from mocap_metrology.lighthouse.records import Factory
from mocap_metrology.lighthouse.rotation import from_angles
from mocap_metrology.lighthouse.rotor import VARIANTS, Variant, check
from mocap_metrology.lighthouse.simulate.reading import (
    check_keys,
    mapping_of,
    nested,
    number,
    number_in,
    numbers,
    numbers_in,
    one_of,
    read,
    text,
    whole,
    whole_in,
)
from mocap_metrology.lighthouse.timing import CYCLE_S

Point = tuple[float, float, float]
REFERENCES = ("truth", "mocap")  # what calibrations are compared with
PATTERNS = ("line", "arc", "circle", "hand", "still")
ORIGIN = (0.0, 0.0, 0.0)
WORD_BITS = 32  # diodes that a word of a dump has room for


def _factory(value: Any, where: str) -> Factory:
    given = mapping_of(value, where)
    names = tuple(Factory.__dataclass_fields__)
    check_keys(given, names, where)
    # As the station itself can state them: half floats.
    pairs = {k: np.float64(np.float16(numbers(v, f"{where}.{k}", 7, 2))) for k, v in given.items()}
    factory = Factory(**pairs)
    try:
        check(factory)
    except Refusal as error:
        raise Refusal(f"{where}: {error}") from None
    return factory


def _lasers(value: Any, where: str) -> tuple[Point, Point]:
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise Refusal(f"{where}: {value!r}, expected [[x, y, z], [x, y, z]] of axis 0 and axis 1")
    return tuple(numbers(v, where, 0.2, 3) for v in value)


def _blocked(value: Any, where: str) -> tuple[tuple[int, float, float], ...]:
    if not isinstance(value, list | tuple) or not all(
        isinstance(v, list | tuple) and len(v) == 3 for v in value
    ):
        raise Refusal(f"{where}: {value!r}, expected a list of [station, from_s, to_s]")
    out = []
    for station, start, end in value:
        start, end = number(start, where, 0, 60), number(end, where, 0, 60)
        if end <= start:
            raise Refusal(f"{where}: {start:g} to {end:g} s, expected an end after the start")
        out.append((whole(station, where, 0, 1), start, end))
    return tuple(out)


@dataclass(frozen=True, kw_only=True)
class BoardTwin:
    """A grid that faces along +x; its diodes may stand out of the plane, front or back, in a
    pattern drawn once for all twins."""

    columns: Annotated[int, whole_in(1, 32)] = 8
    rows: Annotated[int, whole_in(1, 32)] = 4
    width_m: Annotated[float, number_in(0.01, 2)] = 0.24
    height_m: Annotated[float, number_in(0.01, 2)] = 0.16
    out_of_plane_m: Annotated[float, number_in(0, 0.2)] = 0.0

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
    line, arc or circle drawn by hand goes astray; `wobble_deg` rms about each axis;
    `tremor_mm` and `tremor_deg` rms in each of the bands 3-5 and 8-10 Hz; `turn_deg` turns the
    board away from facing the stations.
    """

    pattern: Annotated[str, one_of(*PATTERNS)] = "hand"
    centre_m: Annotated[Point, numbers_in(20)]
    speed_m_s: Annotated[float, number_in(0, 5)] = 0.4
    extent_m: Annotated[float, number_in(0, 5)] = 0.3
    sway_m: Annotated[float, number_in(0, 1)] = 0.0
    wobble_deg: Annotated[float, number_in(0, 45)] = 8.0
    tremor_mm: Annotated[float, number_in(0, 10)] = 0.0
    tremor_deg: Annotated[float, number_in(0, 10)] = 0.0
    turn_deg: Annotated[Point, numbers_in(180)] = ORIGIN


@dataclass(frozen=True, kw_only=True)
class StationTwin:
    """A base station: pose of its housing in the master's, and its optics and lasers in there."""

    id: Annotated[int, whole_in(1, 2**32 - 1)]
    mode: Annotated[str, one_of("A", "b", "c")]
    position_m: Annotated[Point, numbers_in(20)] = ORIGIN
    rotation_deg: Annotated[Point, numbers_in(180)] = ORIGIN
    factory: Annotated[Factory | None, _factory] = None
    lasers_m: Annotated[tuple[Point, Point], _lasers] = (ORIGIN, ORIGIN)

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
class LighthouseTwin:
    """Everything a simulated recording is made of; the file of twins tells what each key means."""

    name: str
    seed: Annotated[int, whole_in(0, 2**63 - 1)]
    setup: Annotated[str, text] = ""
    master: Annotated[StationTwin, nested(StationTwin)]
    slave: Annotated[StationTwin | None, nested(StationTwin)] = None
    motion: Annotated[MotionTwin, nested(MotionTwin)]
    board: Annotated[BoardTwin, nested(BoardTwin)] = BoardTwin()
    variant: Annotated[str, one_of(*VARIANTS)] = "crazyflie"
    tilt_deg: Annotated[tuple[float, float], numbers_in(90, 2)] = (0.0, 0.0)
    duration_s: Annotated[float, number_in(0.02, 60)] = 8.0
    start_cycle: Annotated[float, number_in(0, 4)] = 0.0
    clock_ppm: Annotated[float, number_in(-1000, 1000)] = 0.0
    slave_offset_us: Annotated[float, number_in(-50, 50)] = 0.0
    sync_jitter_us: Annotated[float, number_in(0, 20)] = 0.0
    flash_shortfall_us: Annotated[float, number_in(0, 10.41)] = 5.2
    flash_bias_us: Annotated[float, number_in(-10, 10)] = 0.0
    flash_spread_us: Annotated[float, number_in(0, 5)] = 0.0
    aperture_mm: Annotated[float, number_in(0.1, 20)] = 3.0
    beam_us: Annotated[float, number_in(0, 20)] = 0.0
    common_urad: Annotated[float, number_in(0, 1e4)] = 0.0
    independent_urad: Annotated[float, number_in(0, 1e4)] = 0.0
    incidence_deg: Annotated[float, number_in(1, 90)] = 70.0
    dropout: Annotated[float, number_in(0, 1)] = 0.0
    reflections: Annotated[float, number_in(0, 1)] = 0.0
    missed_flashes: Annotated[float, number_in(0, 1)] = 0.0
    false_flashes_per_s: Annotated[float, number_in(0, 1000)] = 0.0
    blocked: Annotated[tuple[tuple[int, float, float], ...], _blocked] = ()
    occlusions_per_min: Annotated[float, number_in(0, 600)] = 0.0
    occlusion_s: Annotated[float, number_in(0.001, 60)] = 0.2
    reference: Annotated[str, one_of(*REFERENCES)] = "truth"
    mocap_noise_mm: Annotated[float, number_in(0, 10)] = 0.3
    mocap_frames: Annotated[int, whole_in(1, 100_000)] = 100
    mocap_rate_hz: Annotated[float, number_in(1, 10_000)] = 100.0
    mount_error_deg: Annotated[float, number_in(0, 10)] = 0.0

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


PARTS = ("factories", "defaults", "setups", "twins")


def twin_entry(document: Mapping[str, Any], name: str) -> dict[str, Any]:
    """All keys of a twin of `{factories, defaults, setups, twins}`, see config/twins.yaml.

    Its own win over those of the twin named by `like`, these over its setup's, and these over the
    defaults; nested keys one by one. A `factory` may name an entry of `factories`.
    """
    parts = {
        part: mapping_of(document.get(part) or {}, f"lighthouse twins: {part}") for part in PARTS
    }
    where = f"twin {name}"
    entry = dict(mapping_of(parts["twins"][name], where))
    if "like" in entry:
        like = entry.pop("like")
        if like not in parts["twins"] or "like" in mapping_of(parts["twins"][like], f"twin {like}"):
            raise Refusal(f"{where}: like: {like!r}, expected a twin that is like no other")
        entry = _merged(parts["twins"][like], entry)
    setup = entry.get("setup")
    if setup is not None and setup not in parts["setups"]:
        raise Refusal(f"{where}: setup: {setup!r}, expected one of {', '.join(parts['setups'])}")
    site = mapping_of(parts["setups"][setup], f"setup {setup}") if setup is not None else {}
    entry = _merged(_merged(parts["defaults"], site), entry)
    for role in ("master", "slave"):
        station = entry.get(role)
        if isinstance(station, Mapping) and isinstance(station.get("factory"), str):
            named = station["factory"]
            if named not in parts["factories"]:
                known = ", ".join(map(str, parts["factories"]))
                raise Refusal(f"{where}: {role}.factory: {named!r}, expected one of {known}")
            entry[role] = {**station, "factory": parts["factories"][named]}
    return entry


def _merged(low: Mapping[str, Any], high: Mapping[str, Any]) -> dict[str, Any]:
    both = {**low, **high}
    for key, value in high.items():
        if isinstance(value, Mapping) and isinstance(low.get(key), Mapping):
            both[key] = {**low[key], **value}
    return both


def twin_from_mapping(mapping: Mapping[str, Any], name: str = "twin") -> LighthouseTwin:
    """A twin of its keys, those of `LighthouseTwin`; setups and defaults are merged before.

    Raises `Refusal` naming the twin and the key: unknown, missing, or no possible value.
    """
    where = f"twin {name}"
    twin = read(LighthouseTwin, mapping, where, name=name)
    if twin.slave is not None:
        apart = float(np.linalg.norm(twin.slave.t - twin.master.t))
        if apart < 0.1:
            raise Refusal(f"{where}: slave.position_m: {apart:g} m apart, expected 0.1 m or more")
        if twin.slave.id == twin.master.id:
            raise Refusal(f"{where}: slave.id: the master's too, expected different ids")
        if twin.slave.mode == "b" or twin.master.mode != "b":
            raise Refusal(
                f"{where}: modes {twin.master.mode} + {twin.slave.mode}, expected b + c or b + A"
            )
    elif twin.master.mode != "A":
        raise Refusal(f"{where}: slave is missing, expected a slave, or a master in mode A")
    if any(twin.master.position_m) or any(twin.master.rotation_deg):
        raise Refusal(f"{where}: master: has a pose, expected none: it is the frame of all others")
    n = twin.board.columns * twin.board.rows
    if not 3 <= n <= WORD_BITS:
        raise Refusal(f"{where}: board: {n} diodes, expected 3 to {WORD_BITS}")
    moves = twin.motion.pattern != "still"
    if moves and not (twin.motion.speed_m_s > 0 and twin.motion.extent_m > 0):
        raise Refusal(f"{where}: motion: speed or extent is 0, expected more, or pattern still")
    for station, _, until in twin.blocked:
        if station >= len(twin.stations) or until > twin.duration_s + 1e-9:
            raise Refusal(f"{where}: blocked: no such station or time, expected [0 or 1, from, to]")
    return twin
