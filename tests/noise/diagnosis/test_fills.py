"""Stretches without noise are told; noise of no kind is."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, make_interp_spline

from mocap_metrology.noise.diagnosis.export import filled, filled_frames, rules

N, SIGMA = 30_000, 0.05
STARTS = np.arange(1000, 29_000, 2000)


def noise(seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return SIGMA * rng.standard_normal(N) + np.cumsum(0.01 * rng.standard_normal(N)) + 160


def with_gaps_filled(x: np.ndarray, size: int, how: str) -> tuple[np.ndarray, np.ndarray]:
    gone = np.zeros(N, bool)
    for first in STARTS:
        gone[first : first + size] = True
    at, gap = np.flatnonzero(~gone), np.flatnonzero(gone)
    out = x.copy()
    if how == "linear":
        out[gap] = np.interp(gap, at, x[at])
    elif how == "held":
        out[gap] = np.repeat(x[STARTS - 1], size)
    else:
        spline = CubicSpline(at, x[at]) if how == "cubic" else make_interp_spline(at, x[at], 5)
        out[gap] = spline(gap)
    return out, gone


@pytest.mark.parametrize("how", ["linear", "held", "cubic", "quintic"])
@pytest.mark.parametrize("size", [15, 100])
def test_fills_are_found_and_nothing_else(how: str, size: int) -> None:
    x, gone = with_gaps_filled(noise(), size, how)
    found = filled(np.float32(x), 1.5e-5)
    assert (found & gone).sum() >= 0.9 * gone.sum()
    assert (found & ~gone).sum() <= 0.01 * gone.sum() + 2 * STARTS.size


def test_the_least_length_is_that_of_the_rules() -> None:
    for rule, how in zip(rules(SIGMA, 0.0), ("linear", "cubic", "quintic"), strict=True):
        x, gone = with_gaps_filled(noise(1), rule.least + 2, how)
        assert (filled(x, 0.0) & gone).sum() > 0.9 * gone.sum()
        short, _ = with_gaps_filled(noise(1), rule.least - 4, how)
        assert filled(short, 0.0).sum() < 0.2 * gone.sum()


def test_long_straight_fills_are_told_in_hundredths_of_a_millimetre() -> None:
    x, gone = with_gaps_filled(noise(2), 100, "linear")
    found = filled(np.round(x, 2), 0.01)
    assert (found & gone).sum() >= 0.9 * gone.sum()


@pytest.mark.parametrize("step", [1e-4, 0.01, 0.05, 0.1, 0.3])
def test_steps_of_the_file_are_no_fill(step: float) -> None:
    """Constant for long in coarse files, and straight."""
    x = step * np.round(noise(3) / step)
    assert not filled(x, step).any()
    slow = step * np.round((160 + np.linspace(0, 0.5, N)) / step)
    assert not filled(slow, step).any()


def test_hidden_steps_and_repeated_frames_are_no_fill() -> None:
    x = noise(4)
    assert not filled(0.1 * np.round(x / 0.1), 1e-3).any()
    assert not filled(np.repeat(x[::2], 2), 1.5e-5).any()
    again = np.random.default_rng(0).choice(N - 1, 600, replace=False) + 1
    x[again] = x[again - 1]
    assert not filled(x, 1.5e-5).any()


def test_heavy_tails_and_smooth_data_are_no_fill() -> None:
    rng = np.random.default_rng(5)
    for x in (rng.standard_t(3, N), rng.laplace(size=N), np.cumsum(rng.standard_normal(N))):
        assert not filled(0.02 * x, 1.5e-5).any()
    smooth = np.convolve(noise(6), np.hanning(21) / 10, "valid")
    assert not filled(np.float32(smooth), 1.5e-5).any()


def test_a_marker_is_filled_in_all_coordinates() -> None:
    x, gone = with_gaps_filled(noise(7), 30, "linear")
    position = np.array([[x, noise(8), noise(9)], [noise(10), noise(11), noise(12)]])
    found = filled_frames(position, 1.5e-5)
    assert found.shape == (2, N) and not found[1].any()
    assert (found[0] & gone).sum() == gone.sum()
    position[:, :, 5000:6000] = np.nan
    assert not filled_frames(position, 1.5e-5)[:, 5001:5999].any()


def test_constant_short_and_missing_series() -> None:
    assert not filled(np.full(1000, 3.0), 0.01).any()
    assert not filled(np.full(1000, np.nan), 0.01).any()
    assert not filled(np.arange(5.0), 0.0).any()
    assert not filled(np.empty(0), 0.0).any()


def test_short_splines_in_coarse_steps_are_filled() -> None:
    """Splines over gaps of 15 to 60 frames, noise of twenty steps of the file: all are found but
    for frames at their ends, and of ten recordings without none."""
    rng = np.random.default_rng(12)
    series = 500 + 0.02 * rng.standard_normal(40_000)
    truth = np.zeros(series.size, bool)
    for start in range(1000, 39_000, 1000):
        stop = start + int(rng.integers(15, 60))
        known = np.r_[start - 12 : start, stop : stop + 12]
        series[start:stop] = CubicSpline(known, series[known])(np.arange(start, stop))
        truth[start:stop] = True
    found = filled(np.round(series, 3), 1e-3)
    assert (found & truth).sum() > 0.97 * truth.sum()
    assert (found & ~truth).sum() < 0.05 * truth.sum()
    for seed in range(10):
        noise = 0.02 * np.random.default_rng(seed).standard_normal(40_000)
        assert not filled(np.round(500 + noise + np.cumsum(noise / 20), 3), 1e-3).any()
