"""How a board moves: sums of sines for its three coordinates and three angles, and an arc.

Everything is a closed form of time, so that a diode's position is known at the very time of a hit.

Light on the diodes: when each sweep hits each diode, by the rotor model along the path of the
board; occlusion; and light that is no direct hit.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.lighthouse.rotation import from_angles
from mocap_metrology.lighthouse.rotor import X, Y, Z, angle_gradient, turned
from mocap_metrology.lighthouse.simulate.twin import LighthouseTwin, MotionTwin

Sine = tuple[int, float, float, float]  # coordinate, amplitude, rad/s, phase

SCALED_OVER_S = 8.0  # a hand's path retains its speed and extent over this time
JITTER_HZ, TREMOR_HZ, SLOW_HZ = (3.0, 5.0), (8.0, 10.0), (0.1, 0.5)
SINES = 3  # of each coordinate of a hand, and of each angle
CONVERGED_S = 1e-12  # a turn of 0.4 nrad
# The laser can be seen in this part of a cycle: 4 ms +- 60 deg of turn.
FROM_S, TO_S = 1222.2e-6, 6777.8e-6
REFLECTED_LATER_S = (30e-6, 800e-6)  # before or after the direct hit
REFLECTED_WIDTH = (0.3, 0.9)  # of the direct pulse
FALSE_FLASH_S = (50e-6, 150e-6)
MOST_FALSE = 100_000  # of a recording, whatever its twin requests


class Motion(NamedTuple):
    """Pose of the board by time, in the frame of the master.

    p = centre + sums of sines + arc, R = facing Rz(c) Ry(b) Rx(a), with a, b, c sums of sines.
    """

    centre: np.ndarray  # (3,) m
    facing: np.ndarray  # (3, 3)
    sines: np.ndarray  # (n, 4): coordinate 0..5, amplitude in m or rad, rad/s, phase in rad
    arc: np.ndarray  # (10,): radius m, swing rad, rad/s, phase rad, two axes

    def poses(self, time_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rotations (n, 3, 3) and places (n, 3) in m of the board at some times."""
        times = np.atleast_1d(np.asarray(time_s, dtype=np.float64))
        return _poses(times, self)


def motion_of(twin: MotionTwin, stations: np.ndarray, seed: int) -> Motion:
    """The motion of a twin; `stations` are the places of the stations, (n, 3), that it faces."""
    rng = np.random.default_rng([seed, 0])
    centre = np.array(twin.centre_m)
    facing = facing_to(centre, stations) @ from_angles(*np.radians(twin.turn_deg))
    arc, sines = np.zeros(10), []
    if twin.pattern != "still":
        axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        path, arc = _path(twin, axes, rng)
        sines = [*path, *_slow(range(3, 6), math.radians(twin.wobble_deg), rng)]
        sines += _tremor(twin, rng)
        if twin.pattern != "hand":  # its path is no figure to go astray from
            sines += _slow(range(3), twin.sway_m, rng)
    table = np.array(sines, dtype=np.float64).reshape(-1, 4)
    return Motion(centre, facing, table, arc)


def facing_to(centre: np.ndarray, stations: np.ndarray) -> np.ndarray:
    """Rotation whose x axis looks from `centre` to the stations, between them; z stays upright."""
    ways = stations - centre
    x = (ways / np.linalg.norm(ways, axis=1, keepdims=True)).sum(axis=0)
    x /= np.linalg.norm(x)
    y = np.cross([0.0, 0.0, 1.0] if abs(x[2]) < 0.9 else [0.0, 1.0, 0.0], x)
    y /= np.linalg.norm(y)
    return np.column_stack([x, y, np.cross(x, y)])


def _path(
    twin: MotionTwin, axes: np.ndarray, rng: np.random.Generator
) -> tuple[list[Sine], np.ndarray]:
    """Sines and arc of the path; `axes` are random and orthonormal, in columns."""
    arc, radius = np.zeros(10), twin.extent_m / 2
    start, omega = rng.uniform(0, 2 * np.pi), twin.speed_m_s / radius
    if twin.pattern == "hand":
        return _hand_motion(twin, rng), arc
    if twin.pattern == "arc":
        swing = np.pi / 2
        arc[:] = radius, swing, omega / swing, start, *axes[:, 0], *axes[:, 1]
        return [], arc
    sines = [(i, radius * axes[i, 0], omega, start) for i in range(3)]
    if twin.pattern == "circle":
        sines += [(i, radius * axes[i, 1], omega, start + np.pi / 2) for i in range(3)]
    return sines, arc


def _hand_motion(twin: MotionTwin, rng: np.random.Generator) -> list[Sine]:
    """Three sines a coordinate, scaled until speed and extent are the twin's."""
    amplitude = rng.uniform(0.3, 1.0, (3, SINES)) * twin.extent_m / 2
    omega = rng.uniform(0.3, 1.0, (3, SINES)) * 2 * twin.speed_m_s / twin.extent_m
    phase = rng.uniform(0, 2 * np.pi, (3, SINES))
    times = np.linspace(0, SCALED_OVER_S, 801)
    for _ in range(60):
        angles = omega[..., None] * times + phase[..., None]
        extent = np.ptp((amplitude[..., None] * np.sin(angles)).sum(axis=1), axis=1).max()
        amplitude *= twin.extent_m / extent
        velocity = ((amplitude * omega)[..., None] * np.cos(angles)).sum(axis=1)
        omega *= np.sqrt(twin.speed_m_s / np.linalg.norm(velocity, axis=0).max())
    return [(i, amplitude[i, j], omega[i, j], phase[i, j]) for i in range(3) for j in range(SINES)]


def _band(
    coordinate: int, rms: float, band: tuple[float, float], count: int, rng: np.random.Generator
) -> list[Sine]:
    """Sines of one coordinate with this rms together, frequencies drawn from a band in Hz."""
    share = rng.uniform(0.3, 1.0, count)
    amplitude = math.sqrt(2) * rms * share / np.linalg.norm(share)
    omega, phase = 2 * np.pi * rng.uniform(*band, count), rng.uniform(0, 2 * np.pi, count)
    return [(coordinate, a, w, p) for a, w, p in zip(amplitude, omega, phase, strict=True)]


def _slow(coordinates: range, rms: float, rng: np.random.Generator) -> list[Sine]:
    return [sine for i in coordinates for sine in _band(i, rms, SLOW_HZ, SINES, rng)]


def _tremor(twin: MotionTwin, rng: np.random.Generator) -> list[Sine]:
    sines = []
    for coordinate in range(6):
        rms = 1e-3 * twin.tremor_mm if coordinate < 3 else math.radians(twin.tremor_deg)
        if rms:
            sines += _band(coordinate, rms, JITTER_HZ, 1, rng)
            sines += _band(coordinate, rms, TREMOR_HZ, 1, rng)
    return sines


@njit
def pose_at(t: float, motion: Motion, R: np.ndarray, p: np.ndarray) -> None:
    """Pose at a time, into R (3, 3) and p (3,)."""
    centre, facing, sines, arc = motion.centre, motion.facing, motion.sines, motion.arc
    q = np.zeros(6)
    for i in range(sines.shape[0]):
        q[int(sines[i, 0])] += sines[i, 1] * math.sin(sines[i, 2] * t + sines[i, 3])
    turn = arc[1] * math.sin(arc[2] * t + arc[3])
    along, across = arc[0] * math.sin(turn), arc[0] * (math.cos(turn) - 1.0)
    for i in range(3):
        p[i] = centre[i] + q[i] + along * arc[4 + i] + across * arc[7 + i]
    ca, cb, cg = math.cos(q[3]), math.cos(q[4]), math.cos(q[5])
    sa, sb, sg = math.sin(q[3]), math.sin(q[4]), math.sin(q[5])
    for i in range(3):
        f, g, h = facing[i, 0], facing[i, 1], facing[i, 2]
        R[i, 0] = f * cg * cb + g * sg * cb - h * sb
        R[i, 1] = f * (cg * sb * sa - sg * ca) + g * (sg * sb * sa + cg * ca) + h * cb * sa
        R[i, 2] = f * (cg * sb * ca + sg * sa) + g * (sg * sb * ca - cg * sa) + h * cb * ca


@njit
def _poses(times: np.ndarray, motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    R, p = np.empty((times.size, 3, 3)), np.empty((times.size, 3))
    for i in range(times.size):
        pose_at(times[i], motion, R[i], p[i])
    return R, p


class SweptBoard(NamedTuple):
    """Hits of sweeps on diodes without any noise; all (sweeps, diodes)."""

    time_s: np.ndarray
    angle_rad: np.ndarray
    range_m: np.ndarray  # from the laser to the diode
    cos_incidence: np.ndarray  # of the light on the diode, 1 from straight ahead


@njit
def swept_board(
    start_s: np.ndarray,
    station: np.ndarray,
    axis: np.ndarray,
    cycle_s: float,
    motion: Motion,
    board: np.ndarray,
    Rs: np.ndarray,
    ts: np.ndarray,
    rotors: np.ndarray,
) -> SweptBoard:
    """Hits of sweeps that begin at start_s (n,), of `station` (n,) and `axis` (n,).

    t = start + (theta(p(t)) + pi/2) cycle / pi, solved for each diode by fixed-point iteration
    through the moving pose; it converges by (speed across) / (377 rad/s range) a step, below 1/100
    for any board. Rs (stations, 3, 3) and ts (stations, 3): poses in the master's frame; rotors
    (stations, 2, 10) as `rotor_parameters`.
    """
    shape = (start_s.size, board.shape[0])
    time, theta = np.empty(shape), np.empty(shape)
    distance, incidence = np.empty(shape), np.empty(shape)
    R, p, none = np.empty((3, 3)), np.empty(3), np.empty(0)
    per_rad = cycle_s / math.pi
    for i in range(shape[0]):
        s, k = station[i], axis[i]
        laser = rotors[s, k]
        t = start_s[i] + cycle_s / 2
        for d in range(shape[1]):  # from the neighbour's time on
            for _ in range(50):
                pose_at(t, motion, R, p)
                a, b, c = turned(R, board[d, 0], board[d, 1], board[d, 2])
                a, b, c = a + p[0] - ts[s, 0], b + p[1] - ts[s, 1], c + p[2] - ts[s, 2]
                x, y, z = turned(Rs[s].T, a, b, c)
                angle = angle_gradient(k, x, y, z, laser, none)[0]
                before, t = t, start_s[i] + (angle + math.pi / 2) * per_rad
                if abs(t - before) < CONVERGED_S:
                    break
            time[i, d], theta[i, d] = t, angle
            x, y, z = x - laser[X], y - laser[Y], z - laser[Z]
            distance[i, d] = math.sqrt(x * x + y * y + z * z)
            toward = 0.0  # board's x axis in the station's frame, times the way to the laser
            for j in range(3):
                toward -= R[j, 0] * (Rs[s, j, 0] * x + Rs[s, j, 1] * y + Rs[s, j, 2] * z)
            incidence[i, d] = toward / distance[i, d]
    return SweptBoard(time, theta, distance, incidence)


def blocked_intervals(
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


def is_open(
    intervals: list[tuple[int, float, float]], station: np.ndarray, time_s: np.ndarray
) -> np.ndarray:
    """True where nothing is between the station and the board, by station and time."""
    seen = np.ones(time_s.shape, dtype=bool)
    for which, begin, end in intervals:
        seen &= ~((station == which) & (time_s >= begin) & (time_s < end))
    return seen


def reflections(
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


def false_flashes(twin: LighthouseTwin, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Start and length of light of other origin that all diodes see."""
    n = min(rng.poisson(twin.false_flashes_per_s * twin.duration_s), MOST_FALSE)
    return rng.uniform(0, twin.duration_s, n), rng.uniform(*FALSE_FLASH_S, n)
