"""DCT periodogram: expectations against exact covariance matrices, not against our own spectra."""

import numpy as np
import pytest
from scipy.fft import dct
from scipy.linalg import toeplitz

from mocap_metrology.noise.fit.spectral import periodogram as module
from mocap_metrology.noise.fit.spectral.periodogram import (
    bins_of,
    gauss_markov_unit,
    power_law_unit,
)
from mocap_metrology.noise.model.components import FORMS

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
