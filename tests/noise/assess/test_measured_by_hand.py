"""Measured variances of a few frames, computed by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mocap_metrology.noise.assess.measured import Measured, measured_spread, measured_within

X = np.array([0.0, 4, 0, 4, 0, 4, 1, 3, 1, 3, 1, 3, 90, 0, 0, 0, 0, 90])


def test_within_stretches_of_six_frames() -> None:
    """Variances 4.8, 1.2 and 2160; what is left over at the end does not count."""
    found = measured_within(np.append(X, [500.0, -500.0]), 6)
    parts = np.array([4.8, 1.2, 2160.0])
    assert found.variance == pytest.approx(parts.mean())
    each = 2 * parts.mean() ** 2 / parts.var(ddof=1)
    assert found.edf == pytest.approx(max(3 * min(each, 5.0), 1.0))
    assert measured_within(X[:12], 99).variance == pytest.approx(X[:12].var(ddof=1))


@pytest.mark.parametrize(("n_missing", "counts"), [(3, True), (4, False)])
def test_a_stretch_counts_with_half_of_its_frames(n_missing: int, counts: bool) -> None:
    series = X.copy()
    series[12 : 12 + n_missing] = np.nan
    left = series[12 + n_missing :]
    parts = [4.8, 1.2] + ([float(left.var(ddof=1))] if counts else [])
    assert measured_within(series, 6).variance == pytest.approx(np.mean(parts))


def test_two_frames_make_a_variance_and_one_none() -> None:
    assert measured_within(np.array([1.0, 3.0]), 2).variance == 2.0
    assert measured_within(np.array([1.0, 3.0, 1.0, 5.0]), 1).variance == 5.0  # of two at least
    one = np.array([1.0, np.nan, np.nan, 3.0])
    for series in (one[:1], one):
        assert math.isnan(measured_within(series, 2).variance)


def test_spread_of_means_about_their_mean() -> None:
    """Means of 2 of 8 frames: 2, 2, 4, 0: variance 2 with the number of them; half of the frames,
    and half of the means, must be there."""
    x = np.array([0.0, 4, 1, 3, 3, 5, 0, 0])
    assert measured_spread(x, 2, 8).variance == pytest.approx(np.var([2, 2, 4, 0]))
    assert measured_spread(np.tile(x, 3), 2, 8).variance == pytest.approx(2.0)
    x[1] = np.nan
    assert measured_spread(x, 2, 8).variance == pytest.approx(np.var([0, 2, 4, 0]))
    x[0] = np.nan
    assert measured_spread(x, 2, 8).variance == pytest.approx(np.var([2, 4, 0]))
    x[2:4] = np.nan
    assert measured_spread(x, 2, 8).variance == pytest.approx(np.var([4, 0]))
    x[4:6] = np.nan
    assert math.isnan(measured_spread(x, 2, 8).variance)
    assert math.isnan(measured_spread(X, 10, 19).variance)
    assert measured_spread(np.ones(8), 2, 8) == Measured(0.0, 1.0)
