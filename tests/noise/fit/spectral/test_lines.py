"""Lines: found where they are, as exactly as theory allows, and not where they are not."""

from __future__ import annotations

import numpy as np
import pytest

from mocap_metrology.noise.fit.spectral.line import around, level
from mocap_metrology.noise.fit.spectral.lines import (
    find_lines,
    find_slow_lines,
    line_errors,
)

RATE = 120.0
TAU0 = 1 / RATE
N = 1 << 15


def sine(A_s: float, f_0: float, phase: float, n: int = N) -> np.ndarray:
    return A_s * np.sin(2 * np.pi * f_0 * TAU0 * np.arange(n) + phase)


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [(20, 29, 2.0), (6, 29, 2.0), (5, 29, 1.0), (20, 34, 2.0), (20, 35, 4.0), (5, 35, 2.5)],
)
def test_noise_beside_a_line_is_the_geometric_mean_of_both_sides(low, high, expected) -> None:
    """4 below and 1 above: of sides that have half of 10 coefficients, or else the median of what
    there is; medians are ln 2 of means."""
    power = np.log(2) * np.repeat([9.0, 4.0, 100.0, 1.0], [1, 19, 10, 10])
    power[low : high + 1] = 100.0
    assert around(power, low, high, 10) == pytest.approx(expected)


@pytest.mark.parametrize("offset", [0.0, 0.25, 0.5])
def test_amplitude_frequency_and_phase_reach_the_cramer_rao_bound(offset):
    rng = np.random.default_rng(2)
    duration = N * TAU0
    f_0 = (4000 + offset) / duration
    psd = 2 * TAU0  # of unit white noise
    found = []
    for _ in range(60):
        phase = rng.uniform(-np.pi, np.pi)
        lines = find_lines(rng.normal(size=N) + sine(0.1, f_0, phase), RATE)
        assert len(lines) == 1
        turn = np.angle(np.exp(1j * (lines[0].phase - phase)))
        found.append((lines[0].A_s - 0.1, lines[0].f_0 - f_0, turn))
    rms = np.sqrt(np.mean(np.square(found), axis=0))
    bounds = line_errors(0.1, psd, duration)
    assert 0.75 < rms[0] / bounds[0] < 1.3
    assert 0.75 < rms[1] / bounds[1] < 1.3
    assert rms[2] < 2.5 * 2 * bounds[0] / 0.1  # 2 sigma/(A sqrt n): phase at the start, f unknown


def test_noise_of_any_colour_has_no_lines():
    rng = np.random.default_rng(3)
    for _ in range(40):
        white = rng.normal(size=N)
        assert find_lines(white, RATE) == []
        assert find_lines(np.cumsum(white), RATE) == []
        assert find_lines(np.diff(white), RATE) == []


def test_slow_line_is_found_against_the_density_of_its_noise():
    rng = np.random.default_rng(6)
    f_0 = 31.3 / (N * TAU0)
    series = rng.normal(size=N) + sine(0.2, f_0, 0.7)
    lines = find_slow_lines(series, RATE, lambda f: np.full(f.size, 2 * TAU0), 9)
    assert len(lines) == 1
    assert np.isclose(lines[0].f_0, f_0, rtol=2e-3)
    assert np.isclose(lines[0].A_s, 0.2, atol=0.04)
    assert np.std(series - lines[0].wave(N, RATE)) < 1.01
    assert find_slow_lines(rng.normal(size=N), RATE, lambda f: np.full(f.size, 2 * TAU0), 9) == []


@pytest.mark.parametrize("slope", [-2, 0, 2])
def test_the_level_is_that_of_the_noise(slope):
    """Of coefficients with exponential distributions about a power law; a band of a quarter octave
    has 20 of them at first."""
    density = np.maximum(np.arange(40_000.0), 1) ** slope
    power = density * np.random.default_rng(5).exponential(size=density.size)
    off = np.log(level(power, np.arange(128, 40_000)) / density[128:])
    assert np.abs(off).max() < 1 and np.sqrt(np.mean(off**2)) < 0.1 and abs(off.mean()) < 0.05
