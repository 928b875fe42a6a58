"""Limits that rules of the noise apply at, on the shortest series that reach them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mocap_metrology.noise.assess.spread import measured_within
from mocap_metrology.noise.diagnosis import dynamic, export, levels
from mocap_metrology.noise.diagnosis.periodic import mains_of
from mocap_metrology.noise.gaussian.two_markers import correlation_time, kernel_density
from mocap_metrology.noise.motion.place import evenness


def test_one_valid_sample_has_the_least_correlation_time() -> None:
    """1/2, that of white noise: the sum over lags has no term."""
    assert correlation_time(np.array([math.nan, 3.0, math.nan])) == 0.5
    assert correlation_time(np.array([])) == 0.5


def test_a_constant_series_has_no_density() -> None:
    for series in ([2.0, 2.0, 2.0], [2.0], []):
        found = kernel_density(np.array(series))
        assert found.x.size == found.density.size == 0 and found.bandwidth == 0


def test_a_block_with_half_its_frames_missing_does_not_count() -> None:
    """Of the first block 4 of 10 frames are there, and they scatter by a metre."""
    far = np.r_[[0.0, 1e3, 0.0, 1e3], np.full(6, math.nan)]
    near = np.tile([-1.0, 1.0], 5)
    found = measured_within(np.r_[far, near, near], 10)
    assert found.variance == pytest.approx(np.var(near, ddof=1))
    both = measured_within(np.r_[far[:5], near[:5], near, near], 10)
    assert both.variance > 1e4  # 9 of 10 are


def test_blocks_of_a_slow_camera_have_two_frames() -> None:
    """At one frame a second no block of a second has a variance."""
    found = levels.blocks(np.array([1.0, 3.0, 5.0, 9.0]), 1.0)
    assert found.mean.tolist() == [2.0, 7.0]
    assert found.variance.tolist() == [2.0, 8.0]


def test_the_level_of_bands_is_that_of_the_one_sided_density() -> None:
    """White noise of variance s^2 has 2 s^2 / rate, and ordinates of median ln 2 times that."""
    white = np.random.default_rng(5).normal(0, 0.3, 120_000)
    found = export.bands(white, 120.0)
    expected = 2 * 0.09 / 120 * math.log(2)
    assert found is not None
    assert found.middle == pytest.approx(expected, rel=0.05)
    assert found.top == pytest.approx(expected, rel=0.05)
    assert np.median(found.psd) == pytest.approx(expected, rel=0.05)


def test_the_ratio_of_a_burst_is_that_of_its_variances() -> None:
    """Ten seconds of three times the noise: nine times the Allan variance."""
    rate, rng = 100.0, np.random.default_rng(6)
    series = rng.normal(0, 0.02, 60_000)
    series[30_000:31_000] *= 3
    first = dynamic.dynamic_allan(series, rate)[0]
    assert first.tau_s == 1 / rate
    begin = np.arange(first.ratio.size) * first.hop_s
    inside = (begin > 300) & (begin + first.window_s < 310)
    assert np.mean(first.ratio[inside]) == pytest.approx(9, rel=0.15)
    assert np.nanmedian(first.ratio) == pytest.approx(1, rel=0.05)


def test_two_cells_can_differ_and_one_cannot() -> None:
    row = {"dof": 400.0, "sigma_mm": 0.1, "deviation_mm": 0.0}
    other = row | {"sigma_mm": 0.3, "deviation_mm": 0.2}
    assert all(map(math.isnan, evenness([row]).values()))
    found = evenness([row, other])
    assert found["worst_over_best"] == pytest.approx(3)
    assert found["bend_mm"] == pytest.approx(0.2 / 2**0.5)
    assert found["p"] < 1e-6


@pytest.mark.parametrize(("f_0", "mains"), [(50.1, 50), (50.3, None), (49.7, None), (100.3, 50)])
def test_mains_are_named_within_four_thousandths(f_0: float, mains: float | None) -> None:
    """EN 50160: 50 Hz within 1 % for 99.5 % of a year, so a little more is of another cause."""
    found = mains_of(f_0, 1000.0)
    assert (found and found.mains_hz) == mains


def test_frames_on_one_polynomial_are_as_many_as_chance_does_not_make() -> None:
    """Differences of order p of n frames on one are n - p zeros, each by chance in one of ten."""
    for order in (1, 2, 3):
        rule = export.Rule(order, 0.01, 0.1)
        assert 0.1 ** (rule.least - order + 2) <= export.CHANCE * 1.000001
        assert 0.1 ** (rule.least - order + 1) > export.CHANCE
