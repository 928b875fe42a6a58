"""Levels that change at once or slowly, and tails, of noise whose truth is known."""

from __future__ import annotations

import numpy as np
import pytest

from mocap_metrology.noise.diagnosis.levels import Sides, blocks, changes, trends
from mocap_metrology.noise.diagnosis.outliers import heavy_tails

RATE, N = 100.0, 60_000
TIME = np.linspace(0, 1, N)
NONE = np.zeros(N // 100, bool)


def made(size: np.ndarray | float, seed: int = 0, n_series: int = 3) -> dict:
    rng = np.random.default_rng(seed)
    return {f"x{k}": 0.05 * size * rng.standard_normal(N) for k in range(1, n_series + 1)}


def levels(size: np.ndarray | float, seed: int = 0) -> dict:
    return {k: blocks(v, RATE) for k, v in made(size, seed).items()}


def test_a_fall_is_named_with_an_interval_that_holds() -> None:
    held = []
    for seed in range(8):
        found = trends(levels(1 - 0.15 * TIME, seed), NONE, [])
        assert [one.series for one in found] == ["x1", "x2", "x3"]
        assert all(one.steady for one in found)
        held += [one.lower < -0.15 < one.upper for one in found]
    assert sum(held) >= 20  # of 24, 95 % expected


def test_what_comes_back_is_a_change_and_no_fall() -> None:
    for one in trends(levels(1 + 0.2 * np.sin(2 * np.pi * TIME)), NONE, []):
        assert not one.steady
        assert one.greatest - one.least == pytest.approx(0.4, abs=0.12)


def test_constant_noise_has_no_trend_and_no_step() -> None:
    for seed in range(30):
        found = levels(1.0, 100 + seed)
        assert not trends(found, NONE, [])
        assert not changes(found, NONE, 300.0, 0.005)


@pytest.mark.parametrize("factor", [0.7, 1.1, 1.2, 2.0])
def test_a_step_is_a_step_and_no_trend(factor: float) -> None:
    found = levels(np.where(TIME > 0.6, factor, 1.0))
    (step,) = changes(found, NONE, 300.0, 0.005)
    assert step.time_s == pytest.approx(360.0, abs=20.0)
    assert not trends(found, NONE, [step.time_s])


def test_a_step_on_a_slope_is_both() -> None:
    found = levels((1 - 0.2 * TIME) * np.where(TIME > 0.5, 1.5, 1.0))
    (step,) = changes(found, NONE, 300.0, 0.005)
    assert step.time_s == pytest.approx(300.0, abs=20.0)
    for one in trends(found, NONE, [step.time_s]):
        assert one.change == pytest.approx(-0.2, abs=0.08)


def test_heavy_tails_of_known_kurtosis() -> None:
    """Laplace: 3, of the differences of two half as much; a Gaussian, whatever its level: none."""
    rng = np.random.default_rng(1)
    (found,) = heavy_tails({"x1": rng.laplace(size=N)}, 0.0)
    assert found.lower < 1.5 < found.upper + 0.1
    for seed in range(20):
        assert not heavy_tails(made(np.where(TIME > 0.5, 3.0, 1.0), seed), 1.5e-5)


def test_steps_of_the_file_and_repeated_frames_have_no_tails() -> None:
    series = made(1.0)
    assert not heavy_tails({k: np.round(v / 0.2) * 0.2 for k, v in series.items()}, 0.2)
    assert not heavy_tails({k: np.repeat(v[::2], 2) for k, v in series.items()}, 1.5e-5)
    assert not heavy_tails({"x1": np.full(N, np.nan), "x2": np.full(N, 3.0)}, 0.0)


@pytest.mark.parametrize(
    ("ratio", "lower", "upper", "word"),
    [
        (2.0, 1.2, 3.1, "changed"),
        (0.6, 0.4, 0.9, "changed"),
        (1.1, 0.9, 1.3, "alike"),
        (1.1, 0.7, 1.6, "undecided"),
        (np.nan, np.nan, np.nan, "unknown"),
    ],
)
def test_an_interval_that_holds_one_is_alike_only_where_it_is_narrow(
    ratio: float, lower: float, upper: float, word: str
) -> None:
    assert Sides("x1", 0.05, 0.05, 0.05, 0.05, ratio, lower, upper).word == word


def test_what_goes_up_and_down_does_not_rise() -> None:
    """A level that swings by a quarter over 4 min: no polynomial describes it, and its ends are
    none of the level. At the ends of a cubic it "rose" by 20 to 88 %."""
    t = np.arange(N) / RATE
    for seed in range(8):
        phase = np.random.default_rng(seed).uniform(0, 2 * np.pi)
        found = levels(1 + 0.25 * np.sin(2 * np.pi * t / 240 + phase), seed)
        for one in trends(found, NONE, []):
            assert one.direction == "changes" and one.lower < 0 < one.upper
            assert -0.4 < one.least <= 0 <= one.greatest < 0.67  # 0.75 / 1.25, 1.25 / 0.75
