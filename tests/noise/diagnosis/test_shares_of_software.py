"""What software leaves in frames: the white share of a spectrum, a cycle of the variance."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mocap_metrology.noise.diagnosis.export import Bands
from mocap_metrology.noise.diagnosis.software import variance_cycle, white_share

RATE = 100.0
F = np.geomspace(9.0, 48.0, 12)


def bands(walk: float, white: float, n: int = 12) -> Bands:
    """Of a random walk's increments h / W and white noise; W = 4 sin^2(pi f / rate)."""
    psd = walk / (4 * np.sin(np.pi * F / RATE) ** 2) + white
    return Bands(F[-n:], psd[-n:], 0.0, 0.0, 0.0)


@pytest.mark.parametrize(("walk", "white"), [(0.0, 1.0), (1.0, 0.0), (1.0, 0.05), (3.0, 2.0)])
def test_white_share_is_that_of_the_last_band(walk: float, white: float) -> None:
    at_end = walk / (4 * math.sin(math.pi * 0.48) ** 2) + white
    assert white_share(bands(walk, white), RATE, 0.0) == pytest.approx(white / at_end, abs=1e-9)


def test_rounding_is_no_white_noise_of_the_frames() -> None:
    """Of a step s it has the density 2 s^2 / (12 rate), of which a median over a bin shows ln 2;
    a step that is 0.15 of the density hides all else."""
    step, density = 0.3, 2 * 0.3**2 / 12 / RATE * math.log(2)
    found = white_share(bands(100 * density, 5 * density), RATE, step)
    at_end = 100 * density / (4 * math.sin(math.pi * 0.48) ** 2) + 5 * density
    assert found == pytest.approx(4 * density / at_end, rel=1e-6)
    assert white_share(bands(100 * density, 0.5 * density), RATE, step) == 0.0
    for share, is_known in ((0.149, True), (0.151, False)):
        assert math.isfinite(white_share(bands(0.0, density / share), RATE, step)) == is_known


def test_less_than_an_eighth_octave_does_not_tell() -> None:
    assert math.isfinite(white_share(bands(1.0, 1.0, 8), RATE, 0.0))
    assert math.isnan(white_share(bands(1.0, 1.0, 7), RATE, 0.0))
    assert math.isnan(white_share(bands(0.0, 0.0), RATE, 0.0))


def cyclic(depth: float, f: float, n: int = 60_000, seed: int = 1) -> np.ndarray:
    """Values whose second differences have a variance of 1 + depth cos(2 pi f t)."""
    t = np.arange(n) / RATE
    noise = np.random.default_rng(seed).standard_normal(n)
    second = np.sqrt(1 + depth * np.cos(2 * np.pi * f * t)) * noise
    return np.cumsum(np.cumsum(second))


@pytest.mark.parametrize(("depth", "is_found"), [(0.0, False), (0.1, False), (0.3, True)])
def test_a_cycle_of_the_variance_from_a_depth_of_a_seventh(depth: float, is_found: bool) -> None:
    found = variance_cycle(cyclic(depth, 13.7), RATE, 1e-4)
    assert found == (pytest.approx(13.7, abs=0.01) if is_found else 0.0)


@pytest.mark.parametrize(("f", "is_found"), [(1.9, False), (2.1, True), (49.9, True)])
def test_cycles_of_fifty_frames_at_most(f: float, is_found: bool) -> None:
    assert (variance_cycle(cyclic(0.8, f), RATE, 1e-4) > 0) == is_found


def test_a_line_makes_no_cycle_at_twice_its_frequency() -> None:
    x = np.random.default_rng(2).standard_normal(20_000)
    t = np.arange(x.size) / RATE
    for f in (7.0, 43.0):  # twice 43 Hz is seen at 14 Hz
        assert variance_cycle(x + 3 * np.sin(2 * np.pi * f * t), RATE, 1e-4) == 0.0


def test_of_2000_differences_of_which_half_are_there() -> None:
    for n, is_found in ((2003, True), (2001, False)):
        assert (variance_cycle(cyclic(1.0, 20.0, n), RATE, 1e-4) > 0) == is_found
    values = cyclic(1.0, 20.0, 6000)
    values[:2900] = np.nan
    assert variance_cycle(values, RATE, 1e-4) == pytest.approx(20.0, abs=0.1)
    values[:3100] = np.nan
    assert variance_cycle(values, RATE, 1e-4) == 0.0
