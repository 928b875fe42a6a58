"""Simulated Lighthouse recordings with the properties of those that the shared data lack.

`flight`: a Crazyflie's deck of four diodes, 30 x 15 mm, that lies level and flies through a room
before two stations 4.3 m apart, 2.3 to 5 m away, looking down. `hand`: a board carried by hand.
Rotors have the factory values of real stations; angles jitter by 53 urad a sweep, common to its
diodes, and by 30 urad a hit.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from mocap_metrology.lighthouse.rotation import from_angles, to_angles
from mocap_metrology.lighthouse.simulate.motion import facing_to
from mocap_metrology.lighthouse.simulate.recording import Made, simulate

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "workflow"))
from mocap_workflow.calibration_twins import calibration_twin, twin_from_mapping

ROOT = Path(__file__).resolve().parents[1]
BASELINE_M = 4.3
NEAREST_M, FARTHEST_M = 2.3, 5.0
SEEN = 0.7  # of the sweeps: a level deck is seen at a slant
DECK = {"columns": 2, "rows": 2, "width_m": 0.015, "height_m": 0.030}
JITTER = {"common_urad": 53.0, "independent_urad": 30.0}


def factories() -> list[dict[str, Any]]:
    """Factory values of the eight real stations of config/twins.yaml."""
    document = yaml.safe_load((ROOT / "config/twins.yaml").read_text(encoding="utf-8"))
    return list(document["factories"].values())


def listed(name: str) -> Made:
    """A recording of a twin of config/twins.yaml."""
    document = yaml.safe_load((ROOT / "config/twins.yaml").read_text(encoding="utf-8"))
    return simulate(calibration_twin(document, name))


def _looking(place: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Upright rotation whose x axis looks from `place` at a point."""
    return facing_to(place, at[None])


def _angles_deg(R: np.ndarray) -> list[float]:
    return np.degrees(to_angles(R)).tolist()


def _twin(
    places: np.ndarray,
    turns: list[np.ndarray],
    centre: np.ndarray,
    R_board: np.ndarray,
    rng: np.random.Generator,
    **others: Any,
) -> Made:
    """A recording from places and turns in the room; the twin's frame is the master's."""
    R, t = turns[0], places[0]
    own = (places - t) @ R
    middle = (centre - t) @ R
    first, second = rng.choice(len(factories()), 2, replace=False)
    turn = facing_to(middle, own).T @ (R.T @ R_board)
    motion = others.pop("motion") | {
        "centre_m": middle.tolist(),
        "turn_deg": _angles_deg(turn),
    }
    mapping = {
        "seed": int(rng.integers(1 << 40)),
        "master": {"id": 11, "mode": "b", "factory": factories()[first]},
        "slave": {
            "id": 12,
            "mode": "c",
            "factory": factories()[second],
            "position_m": own[1].tolist(),
            "rotation_deg": _angles_deg(R.T @ turns[1]),
        },
        "motion": motion,
        "tilt_deg": _angles_deg(R)[:2],
        "start_cycle": float(rng.uniform(0, 4)),
        "clock_ppm": float(rng.uniform(-40, 40)),
        **JITTER,
        **others,
    }
    return simulate(twin_from_mapping(mapping))


def flight(seed: int, variant: str = "libsurvive", seconds: float | None = None) -> Made:
    """A flight of 8 to 60 s; drawn again until all distances are those of the docstring."""
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
            _looking(p, np.r_[rng.uniform(-0.3, 0.3, 2), 0.7])
            @ from_angles(rng.normal(0, 0.05), 0, 0)
            for p in places
        ]
        level = facing_up(rng.uniform(0, 2 * np.pi))
        motion = {
            "pattern": "hand",
            "extent_m": float(rng.uniform(0.8, 1.6)),
            "speed_m_s": float(rng.uniform(0.3, 0.9)),
            "wobble_deg": float(rng.uniform(2, 5)),
            "tremor_deg": 0.2,
            "tremor_mm": 0.2,
        }
        made = _twin(
            places, turns, centre, level, rng, motion=motion, board=DECK, variant=variant,
            duration_s=seconds,
        )  # fmt: skip
        _, path = made.truth.motion.poses(np.linspace(0, seconds, 200))
        ways = np.linalg.norm(path[:, None] - np.array([s.t for s in made.twin.stations]), axis=2)
        seen = len(made.hits) / (4 * 60 * seconds * 2)
        if ways.min() >= NEAREST_M and ways.max() <= FARTHEST_M and seen >= SEEN:
            return made


def facing_up(yaw: float) -> np.ndarray:
    """Rotation of a level deck: its board's x axis points up."""
    return from_angles(0, 0, yaw) @ np.array([[0.0, 0, -1], [0, 1, 0], [1, 0, 0]])


def hand(seed: int, variant: str = "libsurvive", seconds: float = 8.0, **board: Any) -> Made:
    """A board of 24 x 16 cm (or as named) by hand, 2 to 4 m before stations 1.5 to 3.2 m apart;
    drawn again until all its diodes are in the view of both, as a rule."""
    rng = np.random.default_rng([seed, 5])
    while True:
        apart, far = rng.uniform(1.5, 3.2), rng.uniform(2.0, 3.6)
        places = np.array([[0, apart / 2, 0], [0, -apart / 2, 0]]) + rng.normal(0, 0.15, (2, 3))
        centre = np.array([far, *rng.normal(0, 0.2, 2)])
        turns = [
            _looking(p, centre + rng.normal(0, 0.15, 3)) @ from_angles(rng.normal(0, 0.2), 0, 0)
            for p in places
        ]
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
