"""What software leaves in frames: the white share of a spectrum, a cycle of the variance."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mocap_metrology.noise.diagnosis.export import Bands
from mocap_metrology.noise.diagnosis.software import running_median, variance_cycle, white_share

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


def repeating(share: float, n: int = 4000, seed: int = 3) -> np.ndarray:
    """Of n values so many repeat the one before; the others differ from it by 0.5 to 1.5."""
    rng = np.random.default_rng(seed)
    change = rng.choice([-1, 1], n) * rng.uniform(0.5, 1.5, n)
    change[rng.permutation(n)[: round(share * n)]] = 0.0
    return np.cumsum(change)


@pytest.mark.parametrize(
    ("share", "step", "n", "is_told"),
    [
        *((0.2, 0.0, 4000, False), (0.2, 0.04, 4000, False)),  # changes of 0.5 are steps
        *((0.095, 0.0, 4000, False), (0.2, 0.0, 2400, False)),
    ],
)
def test_values_that_repeat_by_the_steps_of_a_file_are_of_no_median(share, step, n, is_told):
    axes = {axis: repeating(share, n, seed) for seed, axis in enumerate("xyz")}
    assert bool(running_median(axes, step)) == is_told


@pytest.mark.parametrize(
    ("share", "step", "n", "is_told"),
    [
        *((0.2, 0.0, 4000, True), (0.2, 0.145, 4000, True), (0.2, 0.155, 4000, False)),
        *((0.11, 0.0, 4000, True), (0.09, 0.0, 4000, False)),
        *((0.2, 0.0, 2560, True), (0.2, 0.0, 2440, False)),  # 2000 changes at least
    ],
)
def test_a_running_median_repeats_a_tenth_of_its_values(share, step, n, is_told) -> None:
    """Beyond what the steps of the file do: one of at most a twentieth of the median change."""

    def axis(seed: int) -> np.ndarray:
        values = np.diff(repeating(share, n, seed), prepend=0.0)
        size = np.random.default_rng(seed + 9).permutation(np.linspace(0.003, 6.0, n))
        return np.cumsum(np.sign(values) * size)

    axes = {name: axis(seed) for seed, name in enumerate("xyz")}
    found = running_median(axes, step)
    assert bool(found) == is_told
    if found:
        assert [one.series for one in found] == ["x", "y", "z"]
        assert found[0].value == pytest.approx(share, abs=0.02)
    assert not running_median(dict.fromkeys("xyz", axis(0)), step)  # they repeat together
