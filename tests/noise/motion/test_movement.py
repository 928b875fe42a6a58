"""Detection of movement: recordings with markers at rest, and with moving markers."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mocap_metrology.noise.motion.movement import UNKNOWN, movement
from mocap_metrology.noise.twins.published import published_row
from mocap_metrology.noise.twins.simulate import simulate
from mocap_metrology.noise.twins.twin import Twin

RATE, SIGMA = 100.0, 0.05
N = 30_000  # five minutes
T = np.arange(N) / RATE
Draw = Callable[[np.random.Generator], np.ndarray]


def walk(rng: np.random.Generator, mm_per_root_hour: float, n: int = N) -> np.ndarray:
    return np.cumsum(rng.normal(size=n)) * mm_per_root_hour / np.sqrt(3600 * RATE)


def slow(rng: np.random.Generator, sigma: float, T_c: float) -> np.ndarray:
    """Gauss-Markov, an AR(1) series."""
    from scipy.signal import lfilter

    phi = np.exp(-1 / (T_c * RATE))
    return lfilter([sigma * np.sqrt(1 - phi**2)], [1, -phi], rng.normal(size=N))


def telegraph(rng: np.random.Generator) -> np.ndarray:
    return SIGMA * (-1.0) ** np.cumsum(rng.random(N) < 1 / (20 * RATE))


def shake(_rng: np.random.Generator) -> np.ndarray:
    """Of two seconds, 3 mm, after which all is as before."""
    t = np.maximum(T - 100, 0)
    return 3 * np.exp(-t / 0.5) * np.sin(2 * np.pi * 3 * t)


STILL: dict[str, Draw] = {
    "white": lambda rng: np.zeros(N),
    "walk": lambda rng: walk(rng, 0.255),
    "walk of 5 mm": lambda rng: walk(rng, 20.0),
    "correlated": lambda rng: slow(rng, 1.0, 100.0),
    "drift": lambda rng: 0.3 * T / 300,
    "warm-up": lambda rng: 1.0 * np.exp(-T / 60) + walk(rng, 0.1),
    "cycle": lambda rng: 0.5 * np.sin(2 * np.pi * T / 300),
    "mains": lambda rng: 0.3 * np.sin(2 * np.pi * 49.99 * T),
    "t4": lambda rng: SIGMA * rng.standard_t(4, N),
    "louder later": lambda rng: np.where(T > 150, SIGMA, 0) * rng.normal(size=N),
    "telegraph": telegraph,
    "shake": shake,
}
MOVED: dict[str, Draw] = {
    "pushed by 2 mm": lambda rng: 2.0 * (rng.uniform(30, 270) < T),
    "pushed in a walk": lambda rng: 2.0 * (rng.uniform(30, 270) < T) + walk(rng, 3.0),
    "5 sigma": lambda rng: 5 * SIGMA * (rng.uniform(30, 270) < T),
    "5 sigma in a drift": lambda rng: 5 * SIGMA * (rng.uniform(30, 270) < T) + 0.3 * T / 300,
    "slowly by hand": lambda rng: 4.0 * np.clip((T - rng.uniform(30, 200)) / 30, 0, 1),
    "slides": lambda rng: 4.0 * T / 300,
    "sways": lambda rng: 3.0 * np.sin(2 * np.pi * 0.3 * T),
    "walks": lambda rng: 1000 * np.abs(T % 20 - 10) + 20 * np.sin(2 * np.pi * 1.8 * T),
    "carried": lambda rng: np.cumsum(slow(rng, 30.0, 1.0)) / RATE,
}


@pytest.mark.parametrize("kind", STILL)
def test_noise_is_no_movement(kind: str) -> None:
    for seed in range(3):
        rng = np.random.default_rng([seed, len(kind)])
        found = movement(STILL[kind](rng) + SIGMA * rng.normal(size=N), RATE)
        assert found.size_mm == 0 and not found.moves


@pytest.mark.parametrize("kind", MOVED)
def test_movement_is_named(kind: str) -> None:
    for seed in range(3):
        rng = np.random.default_rng([seed, len(kind)])
        assert movement(MOVED[kind](rng) + SIGMA * rng.normal(size=N), RATE).moves


def test_a_jump_has_its_size_its_interval_and_its_time() -> None:
    rng, held = np.random.default_rng(1), 0
    for _ in range(40):
        at = rng.uniform(30, 270)
        found = movement(0.4 * (at < T) + SIGMA * rng.normal(size=N), RATE)
        assert found.size_mm == pytest.approx(0.4, rel=0.15)
        assert found.time_s == pytest.approx(at, abs=4)
        held += found.lower_95 < 0.4 < found.upper_95
    assert held >= 34  # the largest of many is a little high


def test_a_gait_of_three_seconds_and_a_swing() -> None:
    rng = np.random.default_rng(2)
    t = np.arange(300) / RATE
    gait = 1200 * t + 20 * np.sin(2 * np.pi * 1.8 * t)
    assert movement(gait + SIGMA * rng.normal(size=300), RATE).moves
    assert movement(30 * np.sin(4 * np.pi * t) + SIGMA * rng.normal(size=300), RATE).moves
    assert not movement(SIGMA * rng.normal(size=300), RATE).moves


def test_coarse_steps_passed_by_a_drift_are_none() -> None:
    rng = np.random.default_rng(3)
    for q in (0.05, 0.1):
        position = walk(rng, 0.3) + 0.01 * rng.normal(size=N) + rng.uniform(0, q)
        assert not movement(np.round(position / q) * q, RATE, step_mm=q).moves
        pushed = np.round((position + 2.0 * (T > 100)) / q) * q
        assert movement(pushed, RATE, step_mm=q).moves


def test_gaps_and_outliers_neither_move_nor_hide_a_push() -> None:
    rng = np.random.default_rng(4)
    still = SIGMA * rng.normal(size=N)
    still[rng.integers(0, N, 30)] = 1e9
    still[10_000:14_000] = np.nan
    assert not movement(still, RATE).moves
    assert movement(still + 2.0 * (T > 200), RATE).moves
    assert movement(np.full(N, np.nan), RATE).size_mm is UNKNOWN.size_mm
    assert not movement(still[:50], RATE).moves


@pytest.mark.parametrize("cameras", [2, 3, 5])
def test_the_walk_of_published_systems_is_none(cameras: int) -> None:
    position = simulate(
        Twin("p", 3, published_row("Bonita", cameras), duration_s=300.0)
    ).position_mm
    assert not any(movement(axis, 120.0).moves for marker in position for axis in marker)


@pytest.mark.parametrize("point", [1, 10, 21])
def test_a_still_tracker_is_still(samples: Path, point: int) -> None:
    file = samples / f"static_vive_pose/20201001_Exp1_measurementPoint{point}.txt"
    position = 1000 * np.loadtxt(file)[:, [3, 7, 11]].T
    assert not any(movement(axis, 250.0).moves for axis in position)
