"""How a board moves: sums of sines for its three coordinates and three angles, and an arc.

Everything is a closed form of time, so that a diode's position is known at the very time of a hit.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mocap_metrology.lighthouse.rotation import from_angles
from mocap_metrology.lighthouse.simulate.twin import MotionTwin

Sine = tuple[int, float, float, float]  # coordinate, amplitude, rad/s, phase

SCALED_OVER_S = 8.0  # a hand's path retains its speed and extent over this time
JITTER_HZ, TREMOR_HZ, SLOW_HZ = (3.0, 5.0), (8.0, 10.0), (0.1, 0.5)
SINES = 3  # of each coordinate of a hand, and of each angle


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
        q = np.zeros((6, times.size))
        for coordinate, amplitude, omega, phase in self.sines:
            q[int(coordinate)] += amplitude * np.sin(omega * times + phase)
        radius, swing, omega, phase, *axes = self.arc
        turn = swing * np.sin(omega * times + phase)
        on_arc = radius * np.outer(np.sin(turn), axes[:3])
        on_arc += radius * np.outer(np.cos(turn) - 1, axes[3:])
        return self.facing @ from_angles(*q[3:]), self.centre + q[:3].T + on_arc


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
