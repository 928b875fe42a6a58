"""Noise of more than one kind or size is no step, shift or wander."""

import math

import numpy as np
import pytest
from scipy import signal

from benchmarks.sentences._kinds import gauss_markov
from benchmarks.sentences.signatures import RATE
from mocap_metrology.noise.diagnosis.signatures import signature


def test_a_walk_and_correlated_noise_are_no_step() -> None:
    """Neither alone explains both, and a step beside one of them would."""
    n, rng = 4000, np.random.default_rng(7)
    y = rng.normal(0, 0.01, n) + gauss_markov(2.6, 0.02)(rng, n, 10.0)
    found = signature(y + np.cumsum(rng.normal(0, 0.05 / math.sqrt(n), n)), 10.0, 7)
    assert found is not None and not found.kinds


@pytest.mark.parametrize(
    ("seed", "T_c", "times", "n", "loud"),
    [
        (6, 2, 5, 30_000, lambda u: (u > 0.3) & (u < 0.45)),
        (8, 1, 4, 60_000, lambda u: (u > 0.3) & (u < 0.45)),
        (10, 1, 4, 60_000, lambda u: (u > 0.3) & (u < 0.45)),
        (12, 30, 6, 90_000, lambda u: np.exp(-u / 0.1)),
    ],
)
def test_correlated_noise_that_is_louder_for_a_while_is_no_shift(seed, T_c, times, n, loud) -> None:
    """Blocks that are quiet among loud ones by chance, and noise across those that are left out."""
    rng, share = np.random.default_rng([seed, 8]), math.exp(-1 / (T_c * RATE))
    size = 1 + (times - 1) * loud(np.arange(n) / n)
    driven = size * rng.normal(0, 0.03 * math.sqrt(1 - share**2), n)
    found = signature(
        signal.lfilter([1], [1, -share], driven) + size * rng.normal(0, 0.001, n), RATE
    )
    assert found is not None and not found.kinds


def loud(rng: np.random.Generator) -> np.ndarray:
    """Noise whose size varies by exp(0.4 g), g normal and correlated over 2 s."""
    size = np.exp(0.4 * gauss_markov(2.0, 1.0)(rng, 15_000, 50.0))
    return 0.02 * size * rng.standard_normal(15_000)


def gusts(rng: np.random.Generator) -> np.ndarray:
    """Of a wall that swings at 1.6 Hz, whose means over a second are loud in some."""
    shaking = signal.lfilter([0.1], [1, -1.9 * np.cos(0.2), 0.9025], rng.normal(size=15_000))
    gust = np.maximum(gauss_markov(12.0, 0.05)(rng, 15_000, 50.0), 0)
    return gust * shaking + 0.02 * rng.standard_normal(15_000)


@pytest.mark.parametrize("draw", [loud, gusts])
def test_blocks_that_are_loud_are_no_wander(draw) -> None:
    for seed in range(5):
        found = signature(draw(np.random.default_rng([seed, 5])), 50.0)
        assert found is not None and not found.possible and not found.kinds


def test_an_approach_within_the_first_blocks_is_no_step() -> None:
    """Of 0.8 s, which blocks of a second do not show; four of these eight were called a step."""
    rng, t = np.random.default_rng(4), np.arange(9000) / 10
    for _ in range(8):
        found = signature(0.02 * rng.standard_normal(9000) + 0.3 * np.exp(-t / 0.8), 10.0)
        assert found is not None and not found.kinds


def test_a_slow_step_is_not_several() -> None:
    """Two shifts, of which the second takes some 5 s, are not four or five."""
    rng, t = np.random.default_rng(1), np.arange(20_000) / 100
    slow = 0.017 / (1 + np.exp(128 - t))
    for _ in range(3):
        moved = 0.011 * (t > 38.4) + slow
        found = signature(0.01 * rng.standard_normal(t.size) + moved, 100.0)
        assert found is not None and "step" not in found.kinds
