"""Detection of movement: recordings with markers at rest, and with moving markers."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.signal import lfilter

from mocap_metrology.noise.gaussian.two_markers import drift
from mocap_metrology.noise.motion.movement import most_moving, movement, movements

RATE, SIGMA = 100.0, 0.05
N = 30_000  # five minutes
T = np.arange(N) / RATE
AT_REST = (2.0, 3600.0)  # range_mm, horizon_s
Draw = Callable[[np.random.Generator], np.ndarray]


def walk(rng: np.random.Generator, mm_per_root_hour: float, n: int = N) -> np.ndarray:
    return np.cumsum(rng.normal(size=n)) * mm_per_root_hour / np.sqrt(3600 * RATE)


def slow(rng: np.random.Generator, sigma: float, T_c: float) -> np.ndarray:
    """Gauss-Markov, an AR(1) series."""
    phi = np.exp(-1 / (T_c * RATE))
    return lfilter([sigma * np.sqrt(1 - phi**2)], [1, -phi], rng.normal(size=N))


SHAKE = np.maximum(T - 100, 0)  # two seconds, 3 mm, after which all is as before
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
    "telegraph": lambda rng: SIGMA * (-1.0) ** np.cumsum(rng.random(N) < 1 / (20 * RATE)),
    "shake": lambda rng: 3 * np.exp(-SHAKE / 0.5) * np.sin(2 * np.pi * 3 * SHAKE),
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


@pytest.mark.parametrize("kind", [*STILL, *MOVED])
def test_noise_is_no_movement_and_movement_is_named(kind: str) -> None:
    for seed in range(3):
        rng = np.random.default_rng([seed, len(kind)])
        made = (STILL | MOVED)[kind](rng) + SIGMA * rng.normal(size=N)
        found = movement(made, RATE, *AT_REST)
        assert found.moves is (kind in MOVED) is (found.size_mm > 0)


def test_correlated_noise_that_is_louder_for_a_while_does_not_move() -> None:
    louder = np.where(abs(T - 150) < 50, 4.0, 1.0)
    for seed in range(30):
        made = louder * slow(np.random.default_rng(seed), SIGMA, 3.0)
        assert not movement(made, RATE, *AT_REST).moves


@pytest.mark.parametrize("step_mm", [0.0, 0.1])
def test_a_jump_has_its_size_its_interval_and_its_time(step_mm: float) -> None:
    """From four standard deviations of a frame and the step of the file on."""
    rng, held, least = np.random.default_rng(1), 0, 4 * math.hypot(SIGMA, step_mm)
    for _ in range(40):
        at = rng.uniform(30, 270)
        noise = SIGMA * rng.normal(size=N)
        found = movement(1.3 * least * (at < T) + noise, RATE, *AT_REST, step_mm=step_mm)
        assert found.size_mm == pytest.approx(1.3 * least, rel=0.2)
        assert found.time_s == pytest.approx(at, abs=4)
        held += found.lower_95 < 1.3 * least < found.upper_95
        middle = (found.lower_95 + found.upper_95) / 2
        assert middle == pytest.approx(found.size_mm)
        assert not movement(0.8 * least * (at < T) + noise, RATE, *AT_REST, step_mm=step_mm).moves
    assert held >= 34  # the largest of many is a little high
    # Without noise from a thousandth of the range on that matters, 2 mm
    assert [movement(size * (T > 150), RATE, *AT_REST).moves for size in (0.0019, 0.0021)] == [
        False,
        True,
    ]


@pytest.mark.filterwarnings("error")
def test_wrong_samples_and_gaps_move_no_marker() -> None:
    """One of 1e9 mm in a second makes its mean 1e7 mm, and its median nothing."""
    still = 0.01 * np.random.default_rng(3).normal(size=(3, 6000))
    still[0, 1234] = 1e9
    still[1, 10::100] = -1e9
    assert drift(still[0], 100.0).range > 1e6
    assert most_moving(movements({"A": still}, 100.0, *AT_REST)) == {}
    still[2, 1000:4000] = np.nan
    still[2, 2000] = 1e9  # alone in its second
    still[:, ::2] = np.nan
    assert most_moving(movements({"A": still}, 100.0, *AT_REST)) == {}
    still[1, 3001:] += 3.0
    axis, most = most_moving(movements({"A": still}, 100.0, *AT_REST))["A"]
    assert (axis, most.size_mm) == ("y", pytest.approx(2.99, abs=0.005))
    assert most.time_s == pytest.approx(30.25, abs=0.005)
    assert most_moving(movements({"A": np.full((3, 500), np.nan)}, 100.0, *AT_REST)) == {}
