"""Welch's estimate against scipy's, and against known spectra with gaps."""

import numpy as np
import pytest
from scipy import signal

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.fit.spectral.welch import welch
from mocap_metrology.noise.series import all_series, coordinate_names, pair_name


def test_equals_scipy_without_gaps():
    series = np.cumsum(np.random.default_rng(1).normal(size=50_000))
    found = welch(series, 120.0, segment_s=20.0)
    f_hz, density = signal.welch(series, 120.0, nperseg=2400)
    np.testing.assert_allclose(found.f_hz, f_hz)
    np.testing.assert_allclose(found.psd, density, rtol=1e-12)
    assert found.n_segments == 40


def test_white_level_and_line_with_gaps():
    """sigma^2 = 4, 120 Hz: level 2 sigma^2 / 120 within 5 %; a 14.4 Hz line where it belongs."""
    rng = np.random.default_rng(3)
    t = np.arange(400_000) / 120
    series = 2 * rng.normal(size=t.size) + 0.5 * np.sin(2 * np.pi * 14.4 * t)
    for start in rng.integers(0, t.size, 40):
        series[start : start + 10] = np.nan
    series[100_000:150_000] = np.nan
    found = welch(series, 120.0, segment_s=60.0)
    assert found.f_hz[found.psd.argmax()] == pytest.approx(14.4, abs=0.02)
    quiet = np.abs(found.f_hz - 14.4) > 0.2
    assert np.median(found.psd[quiet]) == pytest.approx(2 * 4 / 120, rel=0.05)


def test_segments_shrink_until_one_is_complete_enough():
    series = np.full(10_000, np.nan)
    series[3000:3400] = np.random.default_rng(4).normal(size=400)
    assert 16 <= welch(series, 100.0).segment <= 400
    with pytest.raises(Refusal, match="fewer gaps"):
        welch(np.full(1000, np.nan), 100.0)


def test_distance_is_equation_12_with_differences():
    """A 3-4-12 cuboid: L = 13; printed with plus signs it would be far from that."""
    names = coordinate_names(2)
    assert names == ["x1", "y1", "z1", "x2", "y2", "z2"]
    coordinates = dict(zip(names, np.array([[10.0], [20], [30], [13], [24], [42]]), strict=True))
    series = dict(all_series(coordinates, [(1, 2)]))
    assert list(series) == [*names, "L"]
    assert series["L"] == pytest.approx(13.0)
    assert pair_name((1, 3), [(1, 2), (1, 3)]) == "L_1_3"
