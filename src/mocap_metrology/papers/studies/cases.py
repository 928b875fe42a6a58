"""Simulated recordings of a study: one circumstance is set, the others are those of a base case.

Base case: board of 32 diodes, flat, 3 m from both stations, which are 2 m apart; moved by hand at
up to 0.4 m/s. Drawn for each recording, as J VII varies them: direction of the board, side and
orientation of the slave, extent and wobble of the motion, start and clock.

Noise is that of real sweeps at 2 MHz: 53 urad in common to the hits of a sweep, 49 urad of each
hit (30 of its own and 38 of quantisation). Rotors are ideal but for the places of their lasers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.records import Hits
from mocap_metrology.lighthouse.rotation import from_angles
from mocap_metrology.lighthouse.simulate.recording import simulate
from mocap_metrology.lighthouse.simulate.twin import LighthouseTwin, MotionTwin, StationTwin

COMMON_URAD, HIT_URAD = 53.0, 49.0
DROPOUT = 0.05
SWAY_M = 0.04  # of a line, arc or circle drawn by hand
TREMOR_MM, TREMOR_DEG = 0.05, 0.014


@dataclass(frozen=True)
class Case:
    """Circumstances of a recording. distance_m: of the board from both stations; laser_offset_mm:
    of each laser from the middle of its station, in a direction drawn for each."""

    distance_m: float = 3.0
    baseline_m: float = 2.0
    speed_m_s: float = 0.4
    pattern: str = "hand"
    n_diodes: int = 32
    laser_offset_mm: float = 0.0


@dataclass(frozen=True)
class Drawn:
    """A simulated recording and its truth: R, t between the origins of the optics; lasers_m
    (station, axis, 3) and origins_m (station, 3) of the optics in the housings."""

    hits: Hits
    board: Floats
    R: Floats
    t_optical_m: Floats
    lasers_m: Floats
    origins_m: Floats


def draw(case: Case, duration_s: float, rng: np.random.Generator) -> Drawn:
    """A recording of these circumstances."""
    simulation = simulate(twin_of(case, duration_s, rng))
    truth, stations = simulation.truth, simulation.twin.stations
    assert truth.R is not None and truth.t_optical_m is not None
    hits, board = of_diodes(simulation.hits, truth.board, spread_out(truth.board, case.n_diodes))
    return Drawn(
        hits,
        board,
        truth.R,
        truth.t_optical_m,
        np.array([station.lasers_m for station in stations]),
        np.array([station.optical_origin for station in stations]),
    )


def twin_of(case: Case, duration_s: float, rng: np.random.Generator) -> LighthouseTwin:
    """The recording with all its parameters."""
    centre, place, angles = _scene(case, rng)
    motion = MotionTwin(
        pattern=case.pattern,
        centre_m=_point(centre),
        speed_m_s=case.speed_m_s,
        extent_m=rng.uniform(0.2, 0.5),
        sway_m=SWAY_M,
        wobble_deg=rng.uniform(6, 14),
        tremor_mm=TREMOR_MM,
        tremor_deg=TREMOR_DEG,
    )
    lasers = rng.normal(size=(2, 2, 3))
    lasers *= 1e-3 * case.laser_offset_mm / np.linalg.norm(lasers, axis=2, keepdims=True)
    master, slave = ((_point(first), _point(second)) for first, second in lasers)
    return LighthouseTwin(
        seed=int(rng.integers(2**31)),
        master=StationTwin(id=1, mode="b", lasers_m=master),
        slave=StationTwin(
            id=2, mode="c", position_m=_point(place), rotation_deg=_point(angles), lasers_m=slave
        ),
        motion=motion,
        duration_s=duration_s,
        start_cycle=rng.uniform(0, 4),
        clock_ppm=rng.normal(0, 20),
        common_urad=COMMON_URAD,
        independent_urad=HIT_URAD,
        dropout=DROPOUT,
    )


def _scene(case: Case, rng: np.random.Generator) -> tuple[Floats, Floats, Floats]:
    """Centre of the board, place and angles (deg) of the slave: an isosceles triangle with the
    board at its tip, about level, before the master."""
    azimuth, elevation, level = np.radians(rng.uniform([-15, -10, -20], [15, 10, 20]))
    R = from_angles(level, -elevation, azimuth)
    at_board = 2 * math.asin(case.baseline_m / (2 * case.distance_m))
    side = rng.choice([-1, 1])
    centre = case.distance_m * R[:, 0]
    place = centre - case.distance_m * (
        math.cos(at_board) * R[:, 0] + side * math.sin(at_board) * R[:, 1]
    )
    way = (centre - place) / case.distance_m
    yaw, pitch = np.degrees([math.atan2(way[1], way[0]), -math.asin(way[2])])
    return centre, place, np.array([0, pitch, yaw]) + rng.uniform([-26, -10, -10], [26, 10, 10])


def _point(values: Floats) -> tuple[float, float, float]:
    x, y, z = values.tolist()
    return x, y, z


def spread_out(board: Floats, count: int) -> np.ndarray:
    """`count` diodes of a board (n, 3) by index, from the first on: each the one that is farthest
    from those before it, so that few diodes still span the board."""
    chosen = [0]
    distance = np.linalg.norm(board - board[0], axis=1)
    while len(chosen) < min(count, len(board)):
        chosen.append(int(distance.argmax()))
        distance = np.minimum(distance, np.linalg.norm(board - board[chosen[-1]], axis=1))
    return np.sort(chosen)


def of_diodes(hits: Hits, board: Floats, chosen: np.ndarray) -> tuple[Hits, Floats]:
    """Hits and places of some diodes, numbered anew."""
    number = np.full(len(board), -1, dtype=hits.diode.dtype)
    number[chosen] = np.arange(len(chosen))
    seen = hits.take(number[hits.diode] >= 0)
    seen.diode[:] = number[seen.diode]
    return seen, board[chosen]
