"""The filter against its definition, computed window by window with numpy's median."""

from __future__ import annotations

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.hampel import MAD_TO_SIGMA, hampel, white_level_kept


def by_definition(series, half_window, n_sigma, least_mad=0.0):
    values, outlier = series.copy(), np.zeros(series.size, bool)
    for i in np.flatnonzero(np.isfinite(series)):
        window = series[max(0, i - half_window) : i + half_window + 1]
        window = window[np.isfinite(window)]
        median = np.median(window)
        mad = max(np.median(np.abs(window - median)), least_mad)
        if abs(series[i] - median) > n_sigma * MAD_TO_SIGMA * mad:
            values[i], outlier[i] = median, True
    return values, outlier


def spiky(rng, n):
    return rng.normal(size=n) + 20 * rng.normal(size=n) * (rng.random(n) < 0.05)


CASES = {
    "spikes": lambda rng: spiky(rng, 700),
    "shorter than a window": lambda rng: spiky(rng, 100),
    "three samples": lambda rng: np.array([0.0, 1.0, 50.0]),
    "one sample": lambda rng: np.array([3.0]),
    "ramp": lambda rng: np.linspace(0, 1e3, 600),
    "steps": lambda rng: np.repeat(rng.normal(size=12), 50),
    "rounded": lambda rng: np.round(spiky(rng, 700)),
    "constant": lambda rng: np.full(300, 166.59),
    "random gaps": lambda rng: np.where(rng.random(700) < 0.4, np.nan, spiky(rng, 700)),
    "long gap": lambda rng: np.r_[spiky(rng, 200), np.full(400, np.nan), spiky(rng, 200)],
    "infinite": lambda rng: np.where(rng.random(700) < 0.05, -np.inf, spiky(rng, 700)),
    "all missing": lambda rng: np.full(50, np.nan),
    "large offset": lambda rng: 1e6 + spiky(rng, 700),
}


@pytest.mark.parametrize("half_window", [1, 2, 17, 120])
@pytest.mark.parametrize("case", CASES)
def test_equals_definition_bit_for_bit(case, half_window):
    series = CASES[case](np.random.default_rng(7))
    for n_sigma in (3.0, 1.0):
        values, outlier = by_definition(series, half_window, n_sigma)
        cleaned = hampel(series, half_window, n_sigma)
        np.testing.assert_array_equal(cleaned.outlier, outlier)
        np.testing.assert_array_equal(cleaned.values, values)


def test_sampled_from_a_long_series_with_ends():
    """Nine minutes at 120 Hz: bit-equal at both ends and at 300 random places."""
    rng = np.random.default_rng(11)
    series = (np.cumsum(rng.normal(size=64_800)) * 1e-3 + spiky(rng, 64_800)).astype(np.float32)
    series = series.astype(float)
    cleaned = hampel(series, 120)
    places = np.r_[0:150, series.size - 150 : series.size, rng.integers(0, series.size, 300)]
    for i in places:
        window = series[max(0, i - 120) : i + 121]
        median = np.median(window)
        limit = 3.0 * MAD_TO_SIGMA * np.median(np.abs(window - median))
        assert cleaned.outlier[i] == (abs(series[i] - median) > limit)
        assert cleaned.values[i] == (median if cleaned.outlier[i] else series[i])


def test_actions():
    series = np.random.default_rng(1).normal(size=1000)
    series[[0, 500, 999]] = 40.0
    replaced, masked = hampel(series, 50), hampel(series, 50, action="mask")
    off = hampel(series, 50, action="off")
    assert replaced.outlier[[0, 500, 999]].all()
    assert np.isnan(masked.values).sum() == replaced.outlier.sum() == masked.outlier.sum()
    np.testing.assert_array_equal(off.values, series)
    assert off.share == 0.0
    assert np.abs(replaced.values).max() < 5


def test_half_a_step_is_the_least_mad():
    """Two thirds of the samples on one step: the MAD is 0, yet the next step is no outlier."""
    series = np.where(np.arange(3000) % 3 == 0, 0.01, 0.0)
    assert hampel(series, 120).share > 0.3
    assert hampel(series, 120, resolution=0.01).share == 0.0
    _, outlier = by_definition(series, 120, 3.0, least_mad=0.005)
    assert not outlier.any()


@pytest.mark.parametrize("half_window", [30, 120])
def test_what_clean_gaussian_noise_loses(half_window):
    """Share replaced within 5 %, variance left within 0.3 %; at 241 samples 0.34 % and 0.966."""
    series = np.random.default_rng(2).normal(size=400_000)
    cleaned = hampel(series, half_window)
    share, kept = white_level_kept(3.0, half_window)
    assert cleaned.share == pytest.approx(share, rel=0.05)
    assert cleaned.values.var() / series.var() == pytest.approx(kept, abs=0.003)
    if half_window == 120:
        assert (share, kept) == (pytest.approx(0.0034, abs=5e-5), pytest.approx(0.966, abs=5e-4))
    masked = hampel(series, half_window, action="mask").values
    _, left = white_level_kept(3.0, half_window, "mask")
    assert np.nanvar(masked) / series.var() == pytest.approx(left, abs=0.003)
    assert white_level_kept(3.0, half_window, "off") == (0.0, 1.0)
    assert np.isnan(white_level_kept(3.0, 3)).all()
    share, kept = white_level_kept(3.0, 10**9)
    assert share == pytest.approx(0.0026998, abs=1e-6)  # two-sided 3-sigma tail
    assert kept == pytest.approx(0.9707, abs=1e-4)  # variance of N(0, 1) within 3 sigma, tails at 0


@pytest.mark.parametrize("action", ["mask", "replace"])
@pytest.mark.parametrize("resolution", [0.0, 0.5])
@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_gross_outliers_among_known_ones(case, resolution, action):
    """Those of a higher threshold lie among those of a lower one: with gaps, ends, ties."""
    series = np.round(case(np.random.default_rng(7)), 2)
    known = hampel(series, 30, 3.0, resolution=resolution).outlier
    every = hampel(series, 30, 6.0, action, resolution)
    among = hampel(series, 30, 6.0, action, resolution, known)
    np.testing.assert_array_equal(among.outlier, every.outlier)
    np.testing.assert_array_equal(among.values, every.values)
    _, outlier = by_definition(series, 30, 6.0, 0.5 * resolution)
    np.testing.assert_array_equal(among.outlier, outlier)


@pytest.mark.parametrize("wrong", [{"action": "drop"}, {"half_window": 0}, {"n_sigma": 0.0}])
def test_refusals(wrong):
    with pytest.raises(Refusal, match="expected"):
        hampel(np.zeros(5), **{"half_window": 2, **wrong})
