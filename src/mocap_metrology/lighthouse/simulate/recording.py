"""A simulated recording: flashes and sweeps of two base stations on a moving board, its dump, and
the truth.

Cycle k of the master begins at (k - start_cycle) cycle_s, its flash with it, the slave's 416.67 us
later. Cycles count from a period of four: 0, 1 the slave's sweeps of azimuth and elevation, 2, 3
the master's. A dump has 2 million words of 32 bit a second, bit d set where diode d sees light.
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from mocap_metrology.common.files import whole, write_csv
from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse import records
from mocap_metrology.lighthouse.batch.problem import GRAVITY_M_S2
from mocap_metrology.lighthouse.decode.ootx import accel_of, encode_frame
from mocap_metrology.lighthouse.rotation import exp, from_angles, log
from mocap_metrology.lighthouse.rotor import X, Z, angles, rotor_parameters
from mocap_metrology.lighthouse.simulate.motion import Motion, motion_of
from mocap_metrology.lighthouse.simulate.twin import InertialTwin, LighthouseTwin
from mocap_metrology.lighthouse.timing import CYCLE_S, SLAVE_OFFSET_S, code_of, flash_length

# Streams of random numbers, so that a twin with more noise has the same motion and dropouts.
NOISE, FAULTS, FLASHES, BITS, RISES, SENSORS = range(1, 7)
ROUNDS, CONVERGED_S = 50, 1e-12  # of the time of a hit: a turn of 0.4 nrad
# The laser can be seen in this part of a cycle: 4 ms +- 60 deg of turn.
FROM_S, TO_S = 1222.2e-6, 6777.8e-6
REFLECTED_LATER_S = (30e-6, 800e-6)  # before or after the direct hit
REFLECTED_WIDTH = (0.3, 0.9)  # of the direct pulse
FALSE_FLASH_S = (50e-6, 150e-6)
MOST_FALSE = 100_000  # of a recording, whatever its twin requests
SAMPLES_PER_S = 2_000_000
STEP_S = 1e-3  # of the differences: errors of 1e-6 of the acceleration of a hand
MOCAP = 5  # stream of random numbers
# Markers of a mount in the housing's frame, metres: around the front, above and behind it, no two
# distances alike, so that no other order of labels fits.
MOUNT_M = np.array(
    [
        [0.057, 0.067, 0.058],
        [0.035, -0.071, 0.053],
        [-0.057, 0.005, 0.085],
        [-0.065, -0.055, 0.024],
        [0.000, 0.084, -0.040],
    ]
)
PREFIXES = ("M", "S")  # of the labels: M1 ... on the master, S1 ... on the slave


@dataclass(frozen=True)
class Truth:
    """What an estimator should find."""

    R: np.ndarray | None  # housing of the slave in that of the master; None with one station
    t_m: np.ndarray | None
    t_optical_m: np.ndarray | None  # the same between the origins of the optics
    stations: tuple[records.Station, ...]  # id, mode, factory, way up
    rotors: np.ndarray  # (stations, 2, 10), as `rotor_parameters`, lasers included
    clocks: tuple[records.Clock, ...]
    board: np.ndarray  # (diodes, 3)
    motion: Motion  # .poses(time_s): R and p of the board in the master's frame
    hits: records.Hits  # without noise, row by row those of the recording


@dataclass(frozen=True)
class SimulatedSweeps:
    """A simulated recording; edges of pulses are not sampled yet."""

    twin: LighthouseTwin
    pulses: records.Pulses
    hits: records.Hits  # with noise; of direct light only
    truth: Truth


@dataclass(frozen=True)
class _Scene:
    """Stations, board and cycles of a twin; R (stations, 3, 3), t (stations, 3) in the master's
    frame."""

    twin: LighthouseTwin
    board: np.ndarray
    motion: Motion
    R: np.ndarray
    t: np.ndarray
    rotors: np.ndarray
    cycle: np.ndarray  # (n,)
    start_s: np.ndarray  # (stations, n)
    skip: np.ndarray  # (stations, n)
    bit: np.ndarray  # (stations, n)
    blocked: list[tuple[int, float, float]]


def simulate(twin: LighthouseTwin, seed: int | None = None) -> SimulatedSweeps:
    """Pulses, hits and truth of a twin of first-generation stations; seed: in place of its own."""
    seed = twin.seed if seed is None else seed
    faults = np.random.default_rng([seed, FAULTS])
    scene = _scene(twin, seed, _blocked_intervals(twin, faults))
    exact, noisy, other = _sweeps(scene, faults, np.random.default_rng([seed, NOISE]))
    flashes = _flashes(scene, np.random.default_rng([seed, FLASHES]))
    every = [flashes, other, (noisy.time_s - noisy.width_s / 2, noisy.width_s, noisy.diode)]
    start, length, diode = (np.concatenate(column) for column in zip(*every, strict=True))
    order = np.argsort(start, kind="stable")
    start, length, diode = start[order], length[order], diode[order].astype(np.int16)
    pulses = records.Pulses(start, length, diode, len(scene.board), twin.duration_s, 0.0)
    return SimulatedSweeps(twin, pulses, noisy, _truth(scene, exact))


def truth_json(simulation: SimulatedSweeps) -> dict[str, object]:
    """What an estimator should find, as a pose file: R and t_m of the slave's housing in the
    master's; t_optical_m between the origins of the optics; lasers_m (station, axis, 3) in the
    housings."""
    truth, twin = simulation.truth, simulation.twin
    keys = twin.model_dump()  # factory values as its stations state them
    for role, station in zip(records.ROLES, twin.stations, strict=False):
        keys[role]["factory"] = vars(station.optics) if station.factory else None
    return {
        "stations": {station.role: station.id for station in truth.stations},
        "R": None if truth.R is None else truth.R.tolist(),
        "t_m": None if truth.t_m is None else truth.t_m.tolist(),
        "t_optical_m": None if truth.t_optical_m is None else truth.t_optical_m.tolist(),
        "lasers_m": [station.lasers_m for station in twin.stations],
        "clocks": [vars(clock) for clock in truth.clocks],
        "twin": keys,
    }


def up_of(twin: LighthouseTwin) -> Floats:
    """The way up in the master's frame, which is tilted in the room."""
    return from_angles(*np.radians([*twin.tilt_deg, 0.0])).T @ [0.0, 0.0, 1.0]


def _scene(twin: LighthouseTwin, seed: int, blocked: list[tuple[int, float, float]]) -> _Scene:
    stations, up = twin.stations, up_of(twin)
    R, t = np.array([s.R for s in stations]), np.array([s.t for s in stations])
    rotors = [rotor_parameters(s.optics, np.array(s.lasers_m), twin.rotors) for s in stations]
    last = np.ceil(twin.start_cycle + twin.duration_s / twin.cycle_s)
    cycle = np.arange(int(np.floor(twin.start_cycle)), int(last))
    master = (cycle - twin.start_cycle) * twin.cycle_s
    after = SLAVE_OFFSET_S * (twin.cycle_s / CYCLE_S) + 1e-6 * twin.slave_offset_us
    of_slave = (cycle & 2) == 0
    skip = np.array([of_slave, ~of_slave]) if len(stations) == 2 else np.zeros((1, cycle.size))
    rng = np.random.default_rng([seed, BITS])
    frames = [encode_frame(s.optics, s.id, s.mode, accel_of(s.R.T @ up)) for s in stations]
    bit = [frame[(cycle + rng.integers(frame.size)) % frame.size] for frame in frames]
    of_board = twin.board.positions(), motion_of(twin.motion, t, seed)
    start = np.array([master, master + after][: len(stations)])
    of_flash = cycle, start, skip.astype(np.int64), np.array(bit, dtype=np.int64)
    return _Scene(twin, *of_board, R, t, np.array(rotors), *of_flash, blocked)


def _truth(scene: _Scene, hits: records.Hits) -> Truth:
    twin, up = scene.twin, up_of(scene.twin)
    stations = tuple(
        records.Station(role, s.id, s.mode, s.optics, s.R.T @ up)
        for role, s in zip(records.ROLES, twin.stations, strict=False)
    )
    epochs = scene.start_s[:, 0] - scene.cycle[0] * twin.cycle_s
    clocks = tuple(records.Clock(e, twin.cycle_s, 1e-6 * twin.sync_jitter_us) for e in epochs)
    R = t = t_optical = None
    if twin.slave is not None:
        R, t = twin.slave.R, twin.slave.t
        t_optical = R @ twin.slave.optical_origin + t - twin.master.optical_origin
    return Truth(R, t, t_optical, stations, scene.rotors, clocks, scene.board, scene.motion, hits)


def _sweeps(
    scene: _Scene, faults: np.random.Generator, noise: np.random.Generator
) -> tuple[records.Hits, records.Hits, tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Hits without and with noise, and pulses (start, length, diode) of reflections."""
    twin = scene.twin
    every, lit = _lit_sweeps(scene)
    off = twin.common_urad * noise.standard_normal((len(lit), 1))
    off = 1e-6 * (off + twin.independent_urad * noise.standard_normal(lit.shape))
    received = faults.random(lit.shape) >= twin.dropout
    exact, off = every.take(lit.ravel()), off[lit]
    time_s = exact.time_s + off * twin.cycle_s / np.pi
    noisy = replace(exact, time_s=time_s, angle_rad=exact.angle_rad + off)
    middle, length, diode = _reflections(twin, time_s, noisy.width_s, noisy.diode, faults)
    rows = np.flatnonzero(received[lit])
    rows = rows[np.argsort(exact.time_s[rows], kind="stable")]
    return exact.take(rows), noisy.take(rows), (middle - length / 2, length, diode)


def _lit_sweeps(scene: _Scene) -> tuple[records.Hits, np.ndarray]:
    """Every sweep on every diode, row by row, and which of them (sweeps, diodes) give light.

    Sweeps hit a diode at t = start + (theta(p(t)) + pi/2) cycle / pi, solved by fixed-point
    iteration through the moving pose; it converges by (speed across) / (377 rad/s range) a step,
    below 1/100 for any board.
    """
    twin, n = scene.twin, len(scene.board)
    every = []
    for k, (R, t) in enumerate(zip(scene.R, scene.t, strict=True)):
        at = np.flatnonzero(scene.skip[k] == 0)
        cycle, begin = (np.repeat(x[at], n) for x in (scene.cycle, scene.start_s[k]))
        diode, axis = np.tile(np.arange(n), at.size), cycle & 1
        then, angle = begin + twin.cycle_s / 2, np.zeros(begin.size)
        for _ in range(ROUNDS):
            R_board, place = scene.motion.poses(then)
            way = np.einsum("nij,nj->ni", R_board, scene.board[diode]) + place - t
            point = way @ R
            angle = angles(point, scene.rotors[k])[np.arange(axis.size), axis]
            before, then = then, begin + (angle + np.pi / 2) * twin.cycle_s / np.pi
            if np.abs(then - before).max(initial=0) < CONVERGED_S:
                break
        way = (point - scene.rotors[k, axis, X : Z + 1]) @ R.T  # from the laser
        range_m = np.linalg.norm(way, axis=1)
        facing = -np.einsum("ni,ni->n", R_board[:, :, 0], way) / range_m
        width = 1e-3 * twin.aperture_mm * twin.cycle_s / (np.pi * range_m) + 1e-6 * twin.beam_us
        since = (then - begin) * (CYCLE_S / twin.cycle_s)
        lit = (since >= FROM_S) & (since <= TO_S)
        lit &= facing > np.cos(np.radians(twin.incidence_deg))
        lit &= (then - width / 2 >= 0) & (then + width / 2 <= twin.duration_s)
        lit &= _is_open(scene.blocked, np.full(then.size, k), then)
        hits = records.Hits.of(
            np.full(then.size, k), axis, cycle, diode, time_s=then, angle_rad=angle
        )
        every.append((replace(hits, width_s=width), lit))
    swept, seen = zip(*every, strict=True)
    return records.Hits.joined(swept), np.concatenate(seen).reshape(-1, n)


def _flashes(scene: _Scene, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pulses (start, length, diode) of flashes, false ones included."""
    twin, shape, n = scene.twin, scene.start_s.shape, len(scene.board)
    code = code_of(scene.cycle & 1, scene.bit, scene.skip)
    length = flash_length(code) + 1e-6 * (twin.flash_bias_us - twin.flash_shortfall_us)
    start = scene.start_s + 1e-6 * twin.sync_jitter_us * rng.standard_normal(shape)
    station = np.arange(shape[0])[:, None]
    lit = _is_open(scene.blocked, station, start) & (rng.random(shape) >= twin.missed_flashes)
    lit &= (start + length > 0) & (start < twin.duration_s)
    flash, diode = np.nonzero(_faces(scene, np.nonzero(lit)[0], start[lit]))
    spread = 1e-6 * twin.flash_spread_us * rng.standard_normal(flash.size)
    false_start, false_length = _false_flashes(twin, rng)
    of_diodes = np.random.default_rng([twin.seed, RISES])  # in every recording the same
    rise = 1e-6 * of_diodes.uniform(0, twin.flash_rise_us, n)[diode]
    return (
        np.concatenate([start[lit][flash] + rise, np.repeat(false_start, n)]),
        np.concatenate([length[lit][flash] + spread - rise, np.repeat(false_length, n)]),
        np.concatenate([diode, np.tile(np.arange(n), false_start.size)]),
    )


def _faces(scene: _Scene, station: np.ndarray, time_s: np.ndarray) -> np.ndarray:
    """Which diodes (n, diodes) look at the station at these times, and are before it."""
    R, p = scene.motion.poses(time_s)
    way = scene.t[station][:, None] - (scene.board @ R.transpose(0, 2, 1) + p[:, None])
    toward = np.einsum("nij,ni->nj", way.transpose(0, 2, 1), R[:, :, 0])
    limit = np.cos(np.radians(scene.twin.incidence_deg)) * np.linalg.norm(way, axis=2)
    return (toward > limit) & (np.einsum("nij,nj->ni", way, scene.R[station, :, 0]) < 0)


def _blocked_intervals(
    twin: LighthouseTwin, rng: np.random.Generator
) -> list[tuple[int, float, float]]:
    """Times (station, from, to) in which a station cannot be seen: those of the twin, and
    occlusions that come at random (Poisson) and last exponentially."""
    intervals = list(twin.blocked)
    for station in range(len(twin.stations)):
        n = rng.poisson(twin.occlusions_per_min * twin.duration_s / 60)
        begin = rng.uniform(0, twin.duration_s, n)
        intervals += [
            (station, b, b + d)
            for b, d in zip(begin, rng.exponential(twin.occlusion_s, n), strict=True)
        ]
    return intervals


def _is_open(
    intervals: list[tuple[int, float, float]], station: np.ndarray, time_s: np.ndarray
) -> np.ndarray:
    """True where nothing is between the station and the board, by station and time."""
    seen = np.ones(time_s.shape, dtype=bool)
    for which, begin, end in intervals:
        seen &= ~((station == which) & (time_s >= begin) & (time_s < end))
    return seen


def _reflections(
    twin: LighthouseTwin,
    time_s: np.ndarray,
    width_s: np.ndarray,
    diode: np.ndarray,
    rng: np.random.Generator,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Middle, width and diode of second pulses: shorter ones, some time before or after a hit."""
    chosen = np.flatnonzero(rng.random(time_s.size) < twin.reflections)
    apart = rng.uniform(*REFLECTED_LATER_S, chosen.size) * rng.choice([-1.0, 1.0], chosen.size)
    width = width_s[chosen] * rng.uniform(*REFLECTED_WIDTH, chosen.size)
    return time_s[chosen] + apart, width, diode[chosen]


def _false_flashes(twin: LighthouseTwin, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Start and length of light of other origin that all diodes see."""
    n = min(rng.poisson(twin.false_flashes_per_s * twin.duration_s), MOST_FALSE)
    return rng.uniform(0, twin.duration_s, n), rng.uniform(*FALSE_FLASH_S, n)


def words_of(pulses: records.Pulses) -> np.ndarray:
    """Samples k at k/2e6 s, uint32 (duration * 2e6,): bit d is set where start <= t < start +
    length of a pulse on diode d, so that an edge is seen at the next sample. Pulses that overlap
    merge; what lies before or after the recording is cut off."""
    words = np.zeros(round(pulses.duration_s * SAMPLES_PER_S), dtype=np.uint32)
    first = np.maximum(np.ceil(pulses.start_s * SAMPLES_PER_S), 0).astype(np.int64)
    end = np.ceil((pulses.start_s + pulses.length_s) * SAMPLES_PER_S).astype(np.int64)
    bit = np.uint32(1) << pulses.diode.astype(np.uint32)
    for k in range(first.size):
        words[first[k] : max(end[k], 0)] |= bit[k]
    return words


def write_dump(path: str | Path, pulses: records.Pulses) -> None:
    """Write the words as a raw dump, little-endian, whole or not at all."""
    words = words_of(pulses).astype("<u4", copy=False)
    with whole(path) as part:
        words.tofile(part)


def sensed(
    motion: Motion, up: np.ndarray, twin: InertialTwin, duration_s: float, rng: np.random.Generator
) -> records.Inertial:
    """What the sensors of a board record, by central differences of the motion over 2 ms, with
    bias, scale, another orientation than stated, and white noise; up (3,): the way up in the frame
    of the motion."""
    time_s = np.arange(0.0, duration_s, 1 / twin.rate_hz)
    then = time_s - 1e-3 * twin.delay_ms
    before, now, after = (motion.poses(then + shift) for shift in (-STEP_S, 0.0, STEP_S))
    place = np.array(twin.place_m) + 1e-3 * twin.place_error_mm * rng.standard_normal(3)
    q = [p + R @ place for R, p in (before, now, after)]
    a = (q[0] - 2 * q[1] + q[2]) / STEP_S**2 + GRAVITY_M_S2 * up
    force = np.einsum("nji,nj->ni", now[0], a)
    rate = log(np.swapaxes(before[0], 1, 2) @ after[0]) / (2 * STEP_S)
    M = exp(np.radians(twin.turn_error_deg) * rng.standard_normal(3))
    bias_w, bias_f = (
        sd * rng.standard_normal(3) for sd in (twin.gyro_bias_rad_s, twin.accel_bias_m_s2)
    )
    scale = 1 + twin.accel_scale_error * rng.standard_normal()
    root = np.sqrt(twin.rate_hz / 2)  # of the bandwidth
    noise_w, noise_f = (
        root * density * rng.standard_normal(rate.shape)
        for density in (twin.gyro_density, twin.accel_density)
    )
    force = (force @ M + bias_f) / scale + noise_f
    return records.Inertial(time_s, rate @ M + bias_w + noise_w, force, np.array(twin.place_m))


@dataclass(frozen=True)
class MountRecording:
    """What the motion-capture system delivers."""

    labels: tuple[str, ...]  # the master's, then the slave's
    positions_mm: np.ndarray  # (markers, 3, frames), in the system's own frame
    rate_hz: float


def simulate_mounts(twin: LighthouseTwin, seed: int) -> MountRecording:
    """Markers of both stations over `mocap_frames`, in a frame drawn for each recording. A mount
    that is turned by `mount_error_deg`, about an axis of its own, is so in all recordings of the
    setup."""
    rng = np.random.default_rng([seed, MOCAP])
    R_world, t_world = exp(rng.normal(size=3) * 2), rng.uniform(-3, 3, 3)
    of_setup = np.random.default_rng([zlib.crc32(twin.setup.encode()), MOCAP])
    labels, places = list[str](), []
    for prefix, station in zip(PREFIXES, twin.stations, strict=False):
        labels += [f"{prefix}{i + 1}" for i in range(len(MOUNT_M))]
        axis = of_setup.normal(size=3)
        turned = exp(np.radians(twin.mount_error_deg) * axis / np.linalg.norm(axis))
        in_master = MOUNT_M @ (station.R @ turned).T + station.t
        places.append(in_master @ R_world.T + t_world)
    still = 1e3 * np.concatenate(places)[:, :, None]
    noise = twin.mocap_noise_mm * rng.standard_normal((*still.shape[:2], twin.mocap_frames))
    return MountRecording(tuple(labels), still + noise, twin.mocap_rate_hz)


def write_mounts(path: str | Path, labels: Sequence[str]) -> None:
    """Write the known geometry of mounts as CSV: label, x_m, y_m, z_m in the housing's frame."""
    places = np.tile(MOUNT_M, (len(labels) // len(MOUNT_M), 1)).tolist()
    rows = zip(labels, *zip(*places, strict=True), strict=True)
    write_csv(path, [dict(zip(("label", "x_m", "y_m", "z_m"), row, strict=True)) for row in rows])
