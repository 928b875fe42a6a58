"""Light on the diodes: when each sweep hits each diode, by the rotor model along the path of
the board; occlusion; and light that is no direct hit.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.lighthouse.rotor import X, Y, Z, angle
from mocap_metrology.lighthouse.simulate.motion import Motion, pose_at
from mocap_metrology.lighthouse.simulate.twin import LighthouseTwin

CONVERGED_S = 1e-12  # a turn of 0.4 nrad
# The laser can be seen in this part of a cycle: 4 ms +- 60 deg of turn.
FROM_S, TO_S = 1222.2e-6, 6777.8e-6
REFLECTED_LATER_S = (30e-6, 800e-6)  # before or after the direct hit
REFLECTED_WIDTH = (0.3, 0.9)  # of the direct pulse
FALSE_FLASH_S = (50e-6, 150e-6)
MOST_FALSE = 100_000  # of a recording, whatever its twin requests


class SweptBoard(NamedTuple):
    """Hits of sweeps on diodes without any noise; all (sweeps, diodes)."""

    time_s: np.ndarray
    angle_rad: np.ndarray
    range_m: np.ndarray  # from the laser to the diode
    cos_incidence: np.ndarray  # of the light on the diode, 1 from straight ahead


@njit
def _in_station(
    R: np.ndarray, p: np.ndarray, diode: np.ndarray, Rs: np.ndarray, ts: np.ndarray
) -> tuple[float, float, float]:
    """Rs^T (R diode + p - ts)."""
    a = R[0, 0] * diode[0] + R[0, 1] * diode[1] + R[0, 2] * diode[2] + p[0] - ts[0]
    b = R[1, 0] * diode[0] + R[1, 1] * diode[1] + R[1, 2] * diode[2] + p[1] - ts[1]
    c = R[2, 0] * diode[0] + R[2, 1] * diode[1] + R[2, 2] * diode[2] + p[2] - ts[2]
    return (
        Rs[0, 0] * a + Rs[1, 0] * b + Rs[2, 0] * c,
        Rs[0, 1] * a + Rs[1, 1] * b + Rs[2, 1] * c,
        Rs[0, 2] * a + Rs[1, 2] * b + Rs[2, 2] * c,
    )


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
    R, p = np.empty((3, 3)), np.empty(3)
    per_rad = cycle_s / math.pi
    for i in range(shape[0]):
        s, k = station[i], axis[i]
        laser = rotors[s, k]
        t = start_s[i] + cycle_s / 2
        for d in range(shape[1]):  # from the neighbour's time on
            for _ in range(50):
                pose_at(t, motion, R, p)
                x, y, z = _in_station(R, p, board[d], Rs[s], ts[s])
                found = angle(k, x, y, z, laser)
                before, t = t, start_s[i] + (found + math.pi / 2) * per_rad
                if abs(t - before) < CONVERGED_S:
                    break
            time[i, d], theta[i, d] = t, found
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
