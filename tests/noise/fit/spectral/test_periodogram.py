"""DCT periodogram: expectations against exact covariance matrices, not against our own spectra."""

import numpy as np
import pytest
from scipy.fft import dct
from scipy.linalg import toeplitz

from mocap_metrology.noise.fit.spectral import periodogram as module
from mocap_metrology.noise.fit.spectral.periodogram import (
    Stretch,
    bins_of,
    edges,
    gauss_markov_unit,
    periodogram,
    power_law_unit,
)
from mocap_metrology.noise.model.components import FORMS, PowerLaw

RATE = 100.0
TAU0 = 1 / RATE


def expected_exactly(covariance: np.ndarray) -> np.ndarray:
    """2 tau0 E[c_k^2], k = 1 ..., by transforming the covariance matrix on both sides."""
    half = dct(covariance, type=2, norm="ortho", axis=0)
    return 2 * TAU0 * np.diag(dct(half, type=2, norm="ortho", axis=1))[1:]


@pytest.fixture
def single(monkeypatch):
    """One coefficient a bin."""
    monkeypatch.setattr(module, "BINS_PER_DECADE", 10_000)


@pytest.mark.usefixtures("single")
def test_white_noise_is_exact():
    white = expected_exactly(np.eye(512) / (2 * TAU0))
    assert np.allclose(power_law_unit(bins_of(512, RATE), 0), white, rtol=1e-12)


@pytest.mark.usefixtures("single")
@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("share", [1e-5, 0.0005, 0.002, 0.02, 0.1, 0.25])
def test_expectation_is_that_of_the_covariance(share, form):
    """exp(-|t| / T_c) of points, and its integrals over two frames and over one; min(i, j) steps of
    a random walk, of averages 1/2 more, and i + 1/3 of a frame with itself. The correction at the
    ends is that of the continuous process, to 0.5 %."""
    n = 1024
    T_c, lag = share * n * TAU0, np.arange(n)
    a = TAU0 / T_c
    covariance, walk = np.exp(-a * lag), np.minimum.outer(lag, lag).astype(float)
    if form == "continuous":
        covariance *= 4 * np.sinh(a / 2) ** 2 / a**2
        covariance[0] = 2 * (a + np.expm1(-a)) / a**2
        walk += 0.5 - np.eye(n) / 6
    bins = bins_of(n, RATE, form)
    assert np.all(bins.n == 1)
    exact = expected_exactly(T_c / 2 * toeplitz(covariance))
    assert np.allclose(gauss_markov_unit(bins, T_c), exact, rtol=0.005)
    exact = expected_exactly(2 * np.pi**2 * TAU0 * walk)
    tolerance = 1e-3 if form == "continuous" else 1e-8
    assert np.allclose(power_law_unit(bins, -2), exact, rtol=tolerance)


@pytest.mark.parametrize("alpha", [-1, 1, 2])
def test_wide_bins_hold_the_mean_of_their_coefficients(alpha):
    n = 100_000
    bins = bins_of(n, RATE)
    each = PowerLaw(alpha, 1.0).psd(np.arange(1, n) / (2 * n * TAU0), RATE)
    edge = edges(n)
    mean = np.add.reduceat(each, edge[:-1] - 1) / np.diff(edge)
    assert np.allclose(power_law_unit(bins, alpha), mean, rtol=2e-3)
    wide = bins.n > 100
    assert np.allclose(power_law_unit(bins, alpha)[wide], mean[wide], rtol=1e-6)


def test_coefficients_outside_the_bands_hold_their_power():
    """Two stretches of white noise: Parseval, bins without holes, and a band left out."""
    parts = [np.random.default_rng(k).normal(size=n) for k, n in ((1, 10_007), (2, 4096))]
    data = periodogram([Stretch(x, 0.5, 100) for x in parts], RATE)
    bins, slow = data.bins, data.slow
    assert bins.span_s == pytest.approx(100.07) and np.array_equal(data.weight, bins.n * 0.5)
    first = bins.duration_s > 50
    for own, x in ((first, parts[0]), (~first, parts[1])):
        total = (data.psd * bins.n)[own].sum() / (2 * TAU0)
        assert total == pytest.approx(x.var() * x.size, rel=1e-12)
        assert bins.n[own].sum() == x.size - 1
        assert np.allclose(bins.f_upper_hz[own][:-1], bins.f_lower_hz[own][1:])
        assert 0 < bins.f_hz[own].min() < bins.f_hz[own].max() < RATE / 2
    alone = gauss_markov_unit(bins_of(4096, RATE), 3.0)
    assert np.array_equal(gauss_markov_unit(bins, 3.0)[-alone.size :], alone)
    for k, x in enumerate(parts):
        c = np.sqrt(2 * TAU0) * dct(x, norm="ortho")
        own = slow.n == x.size
        assert slow.value[own] == pytest.approx(c[slow.k[own]], abs=1e-12)
        assert slow.k[own].size > 1900 and np.allclose(slow.start_s, 1.0)
        inside = bins.n[slow.bin[own]] > 0
        assert inside.all() and np.all(np.isclose(bins.duration_s[slow.bin[own]], x.size * TAU0)), k
    band = (10.0, 12.0)
    without = periodogram([Stretch(parts[0], bands=[band])], RATE)
    whole = periodogram([Stretch(parts[0])], RATE)
    assert set(whole.slow.start_s.tolist()) == {0.0}
    at = (without.bins.f_lower_hz > band[0]) & (without.bins.f_upper_hz < band[1])
    away = (without.bins.f_upper_hz < band[0]) | (without.bins.f_lower_hz > band[1])
    assert at.any() and np.all(without.weight[at] < 1e-5 * without.bins.n[at])
    assert np.allclose(without.psd[away], whole.psd[away], rtol=1e-12)
    assert np.array_equal(without.weight[away], whole.weight[away])
    c, f = dct(parts[0], norm="ortho")[1:], np.arange(1, parts[0].size) / (2 * parts[0].size * TAU0)
    left = 2 * TAU0 * np.sum(c[(f < band[0]) | (f > band[1])] ** 2)
    used = without.weight > 0.01
    assert np.sum((without.psd * without.weight)[used]) == pytest.approx(left, rel=1e-12)
