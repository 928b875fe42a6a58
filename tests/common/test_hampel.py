"""The filter against its definition, computed window by window with numpy's median."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.hampel import (
    MAD_TO_SIGMA,
    hampel,
    mask_half_window,
    share_of_rounded,
    taken_at_most,
    white_level_kept,
)


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


@st.composite
def series(draw) -> np.ndarray:
    """Noise with spikes, ramps, steps, ties, gaps and infinite samples; of any length."""
    n, rng = draw(st.integers(1, 400)), np.random.default_rng(draw(st.integers(0, 9999)))
    values = rng.normal(size=n) + 20 * rng.normal(size=n) * (rng.random(n) < 0.05)
    values += draw(st.sampled_from([0.0, 1e6])) + draw(st.sampled_from([0, 1])) * np.arange(n)
    if draw(st.booleans()):
        values += 5 * np.repeat(rng.normal(size=n // 50 + 1), 50)[:n]
    values = values.round(draw(st.sampled_from([0, 1, 15])))
    if draw(st.booleans()):
        values[:] = values[0]
    values[rng.random(n) < draw(st.sampled_from([0, 0.4, 1.0]))] = np.nan
    values[rng.random(n) < draw(st.sampled_from([0, 0.05]))] = -np.inf
    values[n // 3 : n // 3 + draw(st.sampled_from([0, 100]))] = np.nan
    return values


@settings(max_examples=300)
@given(
    values=series(),
    half_window=st.integers(1, 140),
    n_sigma=st.sampled_from([1.0, 3.0, 6.0]),
    resolution=st.sampled_from([0.0, 0.1, 1.0]),
)
def test_equals_its_definition_bit_for_bit(values, half_window, n_sigma, resolution):
    """Of outliers among those of a lower threshold, too, and whatever becomes of them."""
    expected, outlier = by_definition(values, half_window, n_sigma, resolution / 2)
    known = hampel(values, half_window, n_sigma / 2, resolution=resolution).outlier
    for among in (None, known):
        replaced = hampel(values, half_window, n_sigma, "replace", resolution, among)
        masked = hampel(values, half_window, n_sigma, "mask", resolution, among)
        for cleaned in (replaced, masked):
            np.testing.assert_array_equal(cleaned.outlier, outlier)
            assert cleaned.n_valid == np.isfinite(values).sum()
        np.testing.assert_array_equal(replaced.values, expected)
        np.testing.assert_array_equal(masked.values, np.where(outlier, np.nan, values))
        share = outlier.sum() / max(replaced.n_valid, 1)
        assert replaced.share == share or (np.isnan(replaced.share) and replaced.n_valid == 0)
    off = hampel(values, half_window, n_sigma, "off")
    np.testing.assert_array_equal(off.values, values)
    assert not off.outlier.any()


@pytest.mark.parametrize("half_window", [30, 120])
def test_what_clean_gaussian_noise_loses(half_window):
    """Share replaced within 5 %, variance left within 0.3 %; at 241 samples 0.34 % and 0.966."""
    noise = np.random.default_rng(2).normal(size=400_000)
    cleaned = hampel(noise, half_window)
    share, kept = white_level_kept(3.0, half_window)
    assert cleaned.share == pytest.approx(share, rel=0.05)
    assert cleaned.values.var() / noise.var() == pytest.approx(kept, abs=0.003)
    if half_window == 120:
        assert (share, kept) == (pytest.approx(0.0034, abs=5e-5), pytest.approx(0.966, abs=5e-4))
        assert taken_at_most(3.0, 120) == pytest.approx(0.034, abs=5e-4)
    masked = hampel(noise, half_window, action="mask").values
    _, left = white_level_kept(3.0, half_window, "mask")
    assert np.nanvar(masked) / noise.var() == pytest.approx(left, abs=0.003)


@pytest.mark.parametrize("sigma", [1.3, 2.0, 3.0])
def test_what_noise_in_steps_loses(sigma):
    """Of noise of two steps the stored MAD is one, and six times as many frames are replaced."""
    rounded = np.round(sigma * np.random.default_rng(1).normal(size=60_000) + 0.3)
    share = share_of_rounded(rounded, 120, 3.0, 1.0)
    assert share == pytest.approx(hampel(rounded, 120, resolution=1.0).share, rel=0.2, abs=3e-4)


def test_of_two_values_a_step_apart_nothing_is_replaced():
    """Both are half a step from their median, which no share of the noise says anything of."""
    assert share_of_rounded(np.array([0.0, 0.1]), 120, 3.0, 0.1) == 0.0


def test_windows_too_short_for_a_scale():
    """From 15 frames to each side on there is an expectation; a mask has at least these."""
    assert white_level_kept(3.0, 14, "off") == (0.0, 1.0)
    assert np.isnan(white_level_kept(3.0, 14)).all() and np.isfinite(white_level_kept(3, 15)).all()
    assert taken_at_most(3.0, 1) == taken_at_most(3.0, 15) == 1 - white_level_kept(3.0, 15)[1]
    found = [mask_half_window(1.0, rate) for rate in (14.4, 15.4, 15.6, 100)]
    assert found == [15, 15, 16, 100]
    assert mask_half_window(0.5, 100) == 50


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"half_window": 0}, "hampel: half window 0, n_sigma 3.0; expected >= 1 and > 0"),
        ({"n_sigma": 0.0}, "hampel: half window 1, n_sigma 0.0; expected >= 1 and > 0"),
    ],
)
def test_refusals(wrong, said):
    with pytest.raises(Refusal) as refused:
        hampel(np.zeros(5), **{"half_window": 1, **wrong})
    assert str(refused.value) == said
