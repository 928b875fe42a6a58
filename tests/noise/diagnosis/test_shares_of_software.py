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


def cyclic(depth: float, f: float, n: int = 60_000, seed: int = 1) -> np.ndarray:
    """Values whose second differences have a variance of 1 + depth cos(2 pi f t)."""
    t = np.arange(n) / RATE
    noise = np.random.default_rng(seed).standard_normal(n)
    second = np.sqrt(1 + depth * np.cos(2 * np.pi * f * t)) * noise
    return np.cumsum(np.cumsum(second))


def test_a_cycle_of_the_variance_and_none_of_a_line_at_twice_its_frequency() -> None:
    assert variance_cycle(cyclic(0.3, 13.7), RATE, 1e-4) == pytest.approx(13.7, abs=0.01)
    half = cyclic(1.0, 20.0, 6000)
    half[:2900] = np.nan
    assert variance_cycle(half, RATE, 1e-4) == pytest.approx(20.0, abs=0.1)
    assert variance_cycle(cyclic(0.0, 13.7), RATE, 1e-4) == 0.0
    x = np.random.default_rng(2).standard_normal(20_000)
    t = np.arange(x.size) / RATE
    for f in (7.0, 43.0):  # twice 43 Hz is seen at 14 Hz
        assert variance_cycle(x + 3 * np.sin(2 * np.pi * f * t), RATE, 1e-4) == 0.0


def test_a_running_median_repeats_values_and_a_file_of_steps_does_too() -> None:
    """A fifth of the values, of each axis for itself; changes of less than 0.003 mm beside them,
    unlike in a file whose least change is its step."""

    def axis(seed: int, least: float) -> np.ndarray:
        rng, n = np.random.default_rng(seed), 4000
        change = rng.choice([-1, 1], n) * rng.permutation(np.linspace(least, 6.0, n))
        change[rng.permutation(n)[: n // 5]] = 0.0
        return np.cumsum(change)

    axes = {name: axis(seed, 0.003) for seed, name in enumerate("xyz")}
    found = running_median(axes, 0.0)
    assert [one.series for one in found] == ["x", "y", "z"]
    assert found[0].value == pytest.approx(0.2, abs=0.02)
    assert not running_median({name: axis(seed, 3.0) for seed, name in enumerate("xyz")}, 0.0)
    assert not running_median(dict.fromkeys("xyz", axes["x"]), 0.0)  # they repeat together
