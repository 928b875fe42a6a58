"""Simulated Lighthouse recordings with the properties of those that the shared data lack.

`flight`: a Crazyflie's deck of four diodes, 30 x 15 mm, that lies level and flies through a room
before two stations 4.3 m apart, 2.3 to 5 m away, looking down. `real_flight`: one as recorded by
others, whose deck is larger than its file, with stretches of a large misfit and wrong sweeps.
`hand`: a board carried by hand.
Rotors have the factory values of real stations; angles jitter by 53 urad a sweep, common to its
diodes, and by 30 urad a hit.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from mocap_workflow.calibration_twins import calibration_twin, twin_from_mapping

from benchmarks import ROOT
from mocap_metrology.common.entries import TwinsFile, load_twins
from mocap_metrology.lighthouse.records import Hits
from mocap_metrology.lighthouse.rotation import from_angles, to_angles
from mocap_metrology.lighthouse.simulate.motion import facing_to
from mocap_metrology.lighthouse.simulate.recording import SimulatedSweeps, simulate

BASELINE_M = 4.3
NEAREST_M, FARTHEST_M = 2.3, 5.0
SEEN = 0.7  # of the sweeps: a level deck is seen at a slant
DECK = {"columns": 2, "rows": 2, "width_m": 0.015, "height_m": 0.030}
JITTER = {"common_urad": 53.0, "independent_urad": 30.0}


@cache
def _twins() -> TwinsFile:
    return load_twins(str(ROOT / "config/twins.yaml"))


def factories() -> list[dict[str, Any]]:
    """Factory values of the eight real stations of config/twins.yaml."""
    return list(_twins()["factories"].values())


def listed(name: str) -> SimulatedSweeps:
    """A recording of a twin of config/twins.yaml."""
    return simulate(calibration_twin(_twins(), name))


def _looking(place: np.ndarray, at: np.ndarray, roll: float) -> np.ndarray:
    """Rotation whose x axis looks from `place` at a point, turned about it."""
    return facing_to(place, at[None]) @ from_angles(roll, 0, 0)


def _angles_deg(R: np.ndarray) -> list[float]:
    return np.degrees(to_angles(R)).tolist()


def _twin(
    places: np.ndarray,
    turns: list[np.ndarray],
    centre: np.ndarray,
    R_board: np.ndarray,
    rng: np.random.Generator,
    **others: Any,
) -> SimulatedSweeps:
    """A recording from places and turns in the room; the twin's frame is the master's."""
    R, t = turns[0], places[0]
    own = (places - t) @ R
    middle = (centre - t) @ R
    first, second = rng.choice(len(factories()), 2, replace=False)
    turn = facing_to(middle, own).T @ (R.T @ R_board)
    depths = others.pop("depths_m", (0.0, 0.0))
    master, slave = (
        {"id": 11 + k, "mode": "bc"[k], "factory": factories()[own_values]}
        | {"lasers_m": [[d / 2, 0.0, 0.0], [-d / 2, 0.0, 0.0]]}
        for k, (own_values, d) in enumerate(zip((first, second), depths, strict=True))
    )
    slave |= {"position_m": own[1].tolist(), "rotation_deg": _angles_deg(R.T @ turns[1])}
    motion = others.pop("motion") | {"centre_m": middle.tolist(), "turn_deg": _angles_deg(turn)}
    mapping = {
        "seed": int(rng.integers(1 << 40)),
        **{"master": master, "slave": slave, "motion": motion, "tilt_deg": _angles_deg(R)[:2]},
        "start_cycle": float(rng.uniform(0, 4)),
        "clock_ppm": float(rng.uniform(-40, 40)),
        **JITTER,
        **others,
    }
    return simulate(twin_from_mapping(mapping))


def flight(
    seed: int,
    variant: str = "libsurvive",
    seconds: float | None = None,
    depths_m: tuple[float, float] = (0.0, 0.0),
    **motions: Any,
) -> SimulatedSweeps:
    """A flight of 8 to 60 s; drawn again until all distances are those of the docstring. depths_m:
    between the lasers of each station; motions: keys of its motion."""
    rng = np.random.default_rng([seed, 4])
    if seconds is None:
        seconds = float(np.exp(rng.uniform(np.log(8), np.log(60))))
    while True:
        around = rng.uniform(0, 2 * np.pi) + np.array([0.0, np.radians(rng.uniform(75, 110))])
        far = BASELINE_M / 2 / np.sin((around[1] - around[0]) / 2)
        height = rng.uniform(2.3, 3.2, 2)
        places = np.column_stack([far * np.cos(around), far * np.sin(around), height])
        places[1] = places[0] + (places[1] - places[0]) * BASELINE_M / np.linalg.norm(
            places[1] - places[0]
        )
        centre = np.r_[rng.uniform(-0.5, 0.5, 2), rng.uniform(0.5, 1.1)]
        turns = [
            _looking(p, np.r_[rng.uniform(-0.3, 0.3, 2), 0.7], rng.normal(0, 0.05)) for p in places
        ]
        level = facing_up(rng.uniform(0, 2 * np.pi))
        motion = {
            "pattern": "hand",
            "extent_m": float(rng.uniform(0.8, 1.6)),
            "speed_m_s": float(rng.uniform(0.3, 0.9)),
            "wobble_deg": float(rng.uniform(2, 5)),
            "tremor_deg": 0.2,
            "tremor_mm": 0.2,
        } | motions
        made = _twin(
            places, turns, centre, level, rng, motion=motion, board=DECK, variant=variant,
            duration_s=seconds, depths_m=depths_m,
        )  # fmt: skip
        _, path = made.truth.motion.poses(np.linspace(0, seconds, 200))
        ways = np.linalg.norm(path[:, None] - np.array([s.t for s in made.twin.stations]), axis=2)
        seen = len(made.hits) / (4 * 60 * seconds * 2)
        if ways.min() >= NEAREST_M and ways.max() <= FARTHEST_M and seen >= SEEN:
            return made


@dataclass(frozen=True)
class RealFlight:
    """A flight, its hits with what went wrong, the board as its file has it, and how many times as
    large the deck is."""

    made: SimulatedSweeps
    hits: Hits
    board: np.ndarray
    scale: float


def real_flight(seed: int, depths_m: tuple[float, float] = (0.0, 0.0)) -> RealFlight:
    """A flight of 15 to 60 s, in part at up to 2.7 m/s, with a deck 0.5 to 1.3 % larger than its
    file. Of its first third 20 to 50 % are stretches with a misfit of 400 to 600 urad, half of it
    of the diode and half of the hit, in which single poses are mirrored as often as not, and a
    station loses the deck for 1 to 3 stretches but for a tenth of its hits, which are wrong. 1 to
    5 % of all sweeps are wrong: half by up to 50 mrad, half those of 33 to 330 ms before."""
    rng = np.random.default_rng([seed, 7])
    seconds = float(np.exp(rng.uniform(np.log(15), np.log(60))))
    speed = float(np.exp(rng.uniform(np.log(0.4), np.log(2.7))))
    made = flight(seed, rng.choice(["libsurvive", "crazyflie"]), seconds, depths_m, speed_m_s=speed,
                  extent_m=float(rng.uniform(1.0, 1.8)))  # fmt: skip
    hits, scale = made.hits, 1 + rng.uniform(0.005, 0.013)
    angle, kept = hits.angle_rad.copy(), np.ones(len(hits), bool)
    for from_s, to_s in _stretches(rng, seconds / 3, rng.uniform(0.2, 0.5)):
        own = (hits.time_s >= from_s) & (hits.time_s < to_s)
        misfit = 1e-6 * rng.uniform(400, 600) / np.sqrt(2)
        by_diode = rng.normal(size=(2, 2, len(made.truth.board)))
        off = by_diode[hits.station, hits.axis, hits.diode] + rng.normal(size=len(hits))
        angle[own] += misfit * off[own]
    for _ in range(rng.integers(1, 4)):
        from_s, lasts = rng.uniform(0, seconds / 3), rng.uniform(0.2, 1.5)
        own = hits.station == rng.integers(2)
        own &= (hits.time_s >= from_s) & (hits.time_s < from_s + lasts)
        kept[own] = rng.random(own.sum()) < 0.1
        angle[own] += rng.choice([-1, 1], own.sum()) * rng.uniform(2e-3, 5e-2, own.sum())
    angle = wrong_sweeps(replace(hits, angle_rad=angle), rng, rng.uniform(0.01, 0.05))
    hits = replace(hits, angle_rad=angle).take(kept)
    return RealFlight(made, hits, made.truth.board / scale, scale)


def _stretches(
    rng: np.random.Generator, end_s: float, share: float
) -> Iterator[tuple[float, float]]:
    """Stretches of 0.3 to 1.5 s before end_s that cover a share of the time, nearly."""
    left = share * end_s
    while left > 0:
        lasts = min(rng.uniform(0.3, 1.5), left)
        from_s = rng.uniform(0, end_s - lasts)
        left -= lasts
        yield from_s, from_s + lasts


def wrong_sweeps(hits: Hits, rng: np.random.Generator, share: float) -> np.ndarray:
    """Angles of which those of a share of the sweeps are wrong, all diodes alike: half by up to
    50 mrad, half those of the same axis 33 to 330 ms before."""
    order, first = hits.by_sweep()
    ends, angle = np.append(first[1:], order.size), hits.angle_rad.copy()
    known = {(c, s, a, d): k for k, (c, s, a, d) in enumerate(
        zip(hits.cycle, hits.station, hits.axis, hits.diode, strict=True))}  # fmt: skip
    for k in np.flatnonzero(rng.random(first.size) < share):
        own = order[first[k] : ends[k]]
        if rng.random() < 0.5:
            angle[own] += rng.choice([-1, 1]) * rng.uniform(1e-3, 5e-2)
            continue
        back = 4 * rng.integers(1, 11)
        for h in own:
            old = known.get((hits.cycle[h] - back, hits.station[h], hits.axis[h], hits.diode[h]))
            angle[h] = angle[h] if old is None else hits.angle_rad[old]
    return angle


def facing_up(yaw: float) -> np.ndarray:
    """Rotation of a level deck: its board's x axis points up."""
    return from_angles(0, 0, yaw) @ np.array([[0.0, 0, -1], [0, 1, 0], [1, 0, 0]])


def hand(
    seed: int, variant: str = "libsurvive", seconds: float = 8.0, **board: Any
) -> SimulatedSweeps:
    """A board of 24 x 16 cm (or as named) by hand, 2 to 4 m before stations 1.5 to 3.2 m apart;
    drawn again until all its diodes are in the view of both, as a rule."""
    rng = np.random.default_rng([seed, 5])
    while True:
        apart, far = rng.uniform(1.5, 3.2), rng.uniform(2.0, 3.6)
        places = np.array([[0, apart / 2, 0], [0, -apart / 2, 0]]) + rng.normal(0, 0.15, (2, 3))
        centre = np.array([far, *rng.normal(0, 0.2, 2)])
        turns = [_looking(p, centre + rng.normal(0, 0.15, 3), rng.normal(0, 0.2)) for p in places]
        facing = facing_to(centre, places) @ from_angles(*rng.normal(0, 0.15, 3))
        motion = {
            "pattern": "hand",
            "extent_m": float(rng.uniform(0.3, 0.6)),
            "speed_m_s": float(rng.uniform(0.2, 0.6)),
            "wobble_deg": float(rng.uniform(6, 14)),
        }
        made = _twin(
            places, turns, centre, facing, rng, motion=motion, board=board, variant=variant,
            duration_s=seconds,
        )  # fmt: skip
        if len(made.hits) > 0.8 * 60 * seconds * 2 * len(made.truth.board):
            return made
