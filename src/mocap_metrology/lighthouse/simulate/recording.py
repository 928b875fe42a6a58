"""A simulated recording: flashes and sweeps of two base stations on a moving board, its dump, and
the truth.

Cycle k of the master begins at (k - start_cycle) cycle_s, its flash with it, the slave's 416.67 us
later. Cycles count from a period of four: 0, 1 the slave's sweeps of azimuth and elevation, 2, 3
the master's. A dump has 2 million words of 32 bit a second, bit d set where diode d sees light.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.common.files import whole
from mocap_metrology.common.types import Floats, Row
from mocap_metrology.lighthouse.decode.ootx import accel_of, encode_frame
from mocap_metrology.lighthouse.records import ROLES, Clock, Factory, Hits, Pulses, Station
from mocap_metrology.lighthouse.rotation import from_angles
from mocap_metrology.lighthouse.rotor import rotor_parameters
from mocap_metrology.lighthouse.simulate.light import (
    FROM_S,
    TO_S,
    blocked_intervals,
    false_flashes,
    is_open,
    reflections,
    swept_board,
)
from mocap_metrology.lighthouse.simulate.motion import Motion, motion_of
from mocap_metrology.lighthouse.simulate.twin import LighthouseTwin, MotionTwin, StationTwin
from mocap_metrology.lighthouse.timing import CYCLE_S, SLAVE_OFFSET_S, code_of, flash_length

# Streams of random numbers, so that a twin with more noise has the same motion and dropouts.
NOISE, FAULTS, FLASHES, BITS, RISES, SENSORS = range(1, 7)
SAMPLES_PER_S = 2_000_000


@dataclass(frozen=True)
class Truth:
    """What an estimator should find."""

    R: np.ndarray | None  # housing of the slave in that of the master; None with one station
    t_m: np.ndarray | None
    t_optical_m: np.ndarray | None  # the same between the origins of the optics
    stations: tuple[Station, ...]  # id, mode, factory, way up
    rotors: np.ndarray  # (stations, 2, 10), as `rotor_parameters`, lasers included
    clocks: tuple[Clock, ...]
    board: np.ndarray  # (diodes, 3)
    motion: Motion  # .poses(time_s): R and p of the board in the master's frame
    hits: Hits | None = None  # without noise, row by row those of the recording


@dataclass(frozen=True)
class Made:
    """A simulated recording; edges of pulses are not sampled yet."""

    twin: LighthouseTwin
    pulses: Pulses
    hits: Hits  # with noise; of direct light only
    truth: Truth


@dataclass(frozen=True)
class _Cycles:
    number: np.ndarray  # (n,)
    start_s: np.ndarray  # (stations, n)
    skip: np.ndarray  # (stations, n)
    bit: np.ndarray  # (stations, n)


def simulate(twin: LighthouseTwin, seed: int | None = None) -> Made:
    """Draw the recording of a twin; `seed` replaces the twin's own."""
    seed = twin.seed if seed is None else seed
    places = np.array([station.t for station in twin.stations])
    board, motion = twin.board.positions(), motion_of(twin.motion, places, seed)
    told = _stations(twin)
    cycles = _cycles(twin, np.random.default_rng([seed, BITS]))
    rng = np.random.default_rng([seed, FAULTS])
    intervals = blocked_intervals(twin, rng)
    truth = _truth(twin, told, board, motion, cycles)
    exact, noisy, other = _sweeps(twin, truth, cycles, intervals, rng, seed)
    flashes = _flashes(twin, truth, cycles, intervals, np.random.default_rng([seed, FLASHES]))
    light = [flashes, other, (noisy.time_s - noisy.width_s / 2, noisy.width_s, noisy.diode)]
    start, length, diode = (np.concatenate(column) for column in zip(*light, strict=True))
    order = np.argsort(start, kind="stable")
    pulses = Pulses(
        start[order], length[order], diode[order].astype(np.int16), len(board), twin.duration_s, 0.0
    )
    return Made(twin, pulses, noisy, replace(truth, hits=exact))


def truth_json(made: Made) -> dict[str, object]:
    """What an estimator should find, as a pose file that a calibration can be compared with.

    R and t_m: the slave's housing in the master's; t_optical_m: between the origins of the optics;
    lasers_m (station, axis, 3) in the housings.
    """
    truth, twin = made.truth, made.twin
    return {
        "stations": {station.role: station.id for station in truth.stations},
        "R": None if truth.R is None else truth.R.tolist(),
        "t_m": None if truth.t_m is None else truth.t_m.tolist(),
        "t_optical_m": None if truth.t_optical_m is None else truth.t_optical_m.tolist(),
        "lasers_m": [station.lasers_m for station in twin.stations],
        "clocks": [vars(clock) for clock in truth.clocks],
        "twin": _keys(twin),
    }


def _keys(twin: LighthouseTwin) -> Row:
    """All keys of a twin; factory values as its stations state them."""
    keys = twin.model_dump()
    for role, station in zip(ROLES, twin.stations, strict=False):
        keys[role]["factory"] = vars(station.optics) if station.optics else None
    return keys


def _stations(twin: LighthouseTwin) -> tuple[Station, ...]:
    """Data that each station transmits; the way up follows from the tilt of the master in the
    room."""
    up = up_of(twin)
    return tuple(
        Station(role, s.id, s.mode, s.optics or Factory(), s.R.T @ up)
        for role, s in zip(ROLES, twin.stations, strict=False)
    )


def up_of(twin: LighthouseTwin) -> Floats:
    """The way up in the master's frame, which is tilted in the room."""
    return from_angles(*np.radians([*twin.tilt_deg, 0.0])).T @ [0.0, 0.0, 1.0]


def _cycles(twin: LighthouseTwin, rng: np.random.Generator) -> _Cycles:
    first = int(np.floor(twin.start_cycle))
    last = int(np.ceil(twin.start_cycle + twin.duration_s / twin.cycle_s))
    number = np.arange(first, last)
    master = (number - twin.start_cycle) * twin.cycle_s
    after = SLAVE_OFFSET_S * (twin.cycle_s / CYCLE_S) + 1e-6 * twin.slave_offset_us
    own = (number & 2) == 0  # cycles of the slave's sweeps
    stations, up = twin.stations, up_of(twin)
    skip = np.array([own, ~own]) if len(stations) == 2 else np.zeros((1, number.size))
    frames = [
        encode_frame(s.optics or Factory(), s.id, s.mode, accel_of(s.R.T @ up)) for s in stations
    ]
    bit = [frame[(number + rng.integers(frame.size)) % frame.size] for frame in frames]
    start = np.array([master, master + after][: len(stations)])
    return _Cycles(number, start, skip.astype(np.int64), np.array(bit, dtype=np.int64))


def _truth(
    twin: LighthouseTwin,
    told: tuple[Station, ...],
    board: np.ndarray,
    motion: Motion,
    cycles: _Cycles,
) -> Truth:
    rotors = [rotor_parameters(s.optics, np.array(s.lasers_m), twin.rotors) for s in twin.stations]
    epochs = cycles.start_s[:, 0] - cycles.number[0] * twin.cycle_s
    clocks = tuple(Clock(e, twin.cycle_s, 1e-6 * twin.sync_jitter_us) for e in epochs)
    R = t = t_optical = None
    if twin.slave is not None:
        R, t = twin.slave.R, twin.slave.t
        t_optical = R @ twin.slave.optical_origin + t - twin.master.optical_origin
    return Truth(R, t, t_optical, told, np.array(rotors), clocks, board, motion)


def _sweeps(
    twin: LighthouseTwin,
    truth: Truth,
    cycles: _Cycles,
    intervals: list[tuple[int, float, float]],
    rng: np.random.Generator,
    seed: int,
) -> tuple[Hits, Hits, tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Hits without and with noise, and pulses (start, length, diode) of reflections."""
    whole, lit = _lit_sweeps(twin, truth, cycles, intervals)
    noise = np.random.default_rng([seed, NOISE])
    off = twin.common_urad * noise.standard_normal((len(lit), 1))
    off = 1e-6 * (off + twin.independent_urad * noise.standard_normal(lit.shape))
    kept = rng.random(lit.shape) >= twin.dropout
    exact, off = whole.take(lit.ravel()), off[lit]
    noisy = replace(
        exact,
        time_s=exact.time_s + off * twin.cycle_s / np.pi,
        angle_rad=exact.angle_rad + off,
    )
    middle, length, diode = reflections(twin, noisy.time_s, noisy.width_s, noisy.diode, rng)
    rows = np.flatnonzero(kept[lit])
    rows = rows[np.argsort(exact.time_s[rows], kind="stable")]
    return exact.take(rows), noisy.take(rows), (middle - length / 2, length, diode)


def _lit_sweeps(
    twin: LighthouseTwin,
    truth: Truth,
    cycles: _Cycles,
    intervals: list[tuple[int, float, float]],
) -> tuple[Hits, np.ndarray]:
    """Every sweep on every diode, row by row, and which of them (sweeps, diodes) give light."""
    station, at = np.nonzero(cycles.skip == 0)
    number, start = cycles.number[at], cycles.start_s[station, at]
    poses = np.array([s.R for s in twin.stations]), np.array([s.t for s in twin.stations])
    swept = swept_board(
        start, station, number & 1, twin.cycle_s, truth.motion, truth.board, poses, truth.rotors
    )
    width = sweep_width(swept.range_m, 1e-3 * twin.aperture_mm, twin.cycle_s, 1e-6 * twin.beam_us)
    since = (swept.time_s - start[:, None]) * (CYCLE_S / twin.cycle_s)
    lit = (since >= FROM_S) & (since <= TO_S)
    lit &= swept.cos_incidence > np.cos(np.radians(twin.incidence_deg))
    lit &= (swept.time_s - width / 2 >= 0) & (swept.time_s + width / 2 <= twin.duration_s)
    lit &= is_open(intervals, station[:, None], swept.time_s)
    n = lit.shape[1]
    hits = Hits(
        np.repeat(station.astype(np.int8), n),
        np.repeat((number & 1).astype(np.int8), n),
        np.repeat(number.astype(np.int32), n),
        np.tile(np.arange(n, dtype=np.int16), len(lit)),
        swept.time_s.ravel(),
        swept.angle_rad.ravel(),
        width.ravel(),
    )
    return hits, lit


def sweep_width(
    range_m: np.ndarray, aperture_m: float, cycle_s: float, beam_s: float = 0.0
) -> np.ndarray:
    """Seconds a sweep is on a diode: aperture / (range pi / cycle) + beam, 8 us for 3 mm at 1 m."""
    return aperture_m / (range_m * np.pi / cycle_s) + beam_s


def _flashes(
    twin: LighthouseTwin,
    truth: Truth,
    cycles: _Cycles,
    intervals: list[tuple[int, float, float]],
    rng: np.random.Generator,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pulses (start, length, diode) of flashes, false ones included."""
    shape = cycles.start_s.shape
    code = code_of(cycles.number & 1, cycles.bit, cycles.skip)
    length = flash_length(code) + 1e-6 * (twin.flash_bias_us - twin.flash_shortfall_us)
    start = cycles.start_s + 1e-6 * twin.sync_jitter_us * rng.standard_normal(shape)
    station = np.arange(shape[0])[:, None]
    lit = is_open(intervals, station, start) & (rng.random(shape) >= twin.missed_flashes)
    lit &= (start + length > 0) & (start < twin.duration_s)
    faces = _faces(twin, truth, np.nonzero(lit)[0], start[lit])
    flash, diode = np.nonzero(faces)
    spread = 1e-6 * twin.flash_spread_us * rng.standard_normal(flash.size)
    false_start, false_length = false_flashes(twin, rng)
    n = len(truth.board)
    own = np.random.default_rng([twin.seed, RISES])  # of the diodes, in every recording the same
    rise = 1e-6 * own.uniform(0, twin.flash_rise_us, n)[diode]
    return (
        np.concatenate([start[lit][flash] + rise, np.repeat(false_start, n)]),
        np.concatenate([length[lit][flash] + spread - rise, np.repeat(false_length, n)]),
        np.concatenate([diode, np.tile(np.arange(n), false_start.size)]),
    )


def _faces(
    twin: LighthouseTwin, truth: Truth, station: np.ndarray, time_s: np.ndarray
) -> np.ndarray:
    """Which diodes (n, diodes) look at the station at these times, and are before it."""
    R, p = truth.motion.poses(time_s)
    places = np.array([s.t for s in twin.stations])[station]
    ahead = np.array([s.R[:, 0] for s in twin.stations])[station]
    way = places[:, None] - (truth.board @ R.transpose(0, 2, 1) + p[:, None])
    toward = np.einsum("nij,ni->nj", way.transpose(0, 2, 1), R[:, :, 0])
    limit = np.cos(np.radians(twin.incidence_deg)) * np.linalg.norm(way, axis=2)
    return (toward > limit) & (np.einsum("nij,nj->ni", way, ahead) < 0)


def words_of(pulses: Pulses) -> np.ndarray:
    """Samples k at k/2e6 s, uint32 (duration * 2e6,): bit d is set where start <= t < start +
    length of a pulse on diode d, so that an edge is seen at the next sample. Pulses that overlap
    merge; what lies before or after the recording is cut off."""
    words = np.zeros(round(pulses.duration_s * SAMPLES_PER_S), dtype=np.uint32)
    _set_bits(words, pulses.start_s, pulses.length_s, pulses.diode.astype(np.int64))
    return words


def write_dump(path: str | Path, pulses: Pulses) -> None:
    """Write the words as a raw dump, little-endian, whole or not at all."""
    words = words_of(pulses).astype("<u4", copy=False)
    with whole(path) as part:
        words.tofile(part)


@njit
def _set_bits(
    words: np.ndarray, start_s: np.ndarray, length_s: np.ndarray, diode: np.ndarray
) -> None:
    for i in range(start_s.size):
        first = max(math.ceil(start_s[i] * SAMPLES_PER_S), 0)
        end = min(math.ceil((start_s[i] + length_s[i]) * SAMPLES_PER_S), words.size)
        bit = np.uint32(1) << np.uint32(diode[i])
        for k in range(first, end):
            words[k] |= bit


def warm_up() -> None:
    """Compile the kernels."""
    station = StationTwin(id=1, mode="A")
    motion = MotionTwin(centre_m=(2.0, 0.0, 0.0))
    twin = LighthouseTwin(seed=0, master=station, motion=motion, duration_s=0.05)
    words_of(simulate(twin).pulses)
