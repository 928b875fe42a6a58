"""The Gaussian model against its closed forms and the published table's own algebra."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import chisquare, norm

from mocap_metrology.noise.gaussian import (
    along_pair,
    chi_squared_normal,
    correlation_time,
    drift,
    gaussian_model,
)


def pair(rng, n, rho=0.8):
    common = rng.normal(size=n)
    first = 166.6 + 0.02 * (np.sqrt(rho) * common + np.sqrt(1 - rho) * rng.normal(size=n))
    second = 6.0 + 0.02 * (np.sqrt(rho) * common + np.sqrt(1 - rho) * rng.normal(size=n))
    return first, second


def test_algebra_of_table_4():
    rng = np.random.default_rng(1)
    first, second = pair(rng, 200_000)
    model = gaussian_model(first, second, first - second)
    assert model.rho_12 == pytest.approx(0.8, abs=0.005)
    assert model.sigma_12 == pytest.approx(model.rho_12 * model.sigma_1 * model.sigma_2)
    assert model.sigma_A1 == pytest.approx(np.sqrt(2) * model.sigma_1)
    assert model.sigma_B**2 == pytest.approx(model.sigma_1**2 + model.sigma_2**2)
    assert model.sigma_C == pytest.approx(model.sigma_L)  # here L is the plain difference
    assert model.mu_e == pytest.approx(model.mu_L)
    assert model.mu_e > 0


def test_only_frames_with_both_markers_count():
    rng = np.random.default_rng(2)
    first, second = pair(rng, 1000)
    length = first - second
    first[::3], second[::5] = np.nan, np.nan
    both = np.isfinite(first) & np.isfinite(second)
    model = gaussian_model(first, second, length)
    whole = gaussian_model(first[both], second[both], length[both])
    assert model == whole
    assert np.isnan(gaussian_model(first, np.full(1000, np.nan), length).mu_1)


def test_along_the_line_sigma_c_is_that_of_the_distance():
    """Markers 100 mm apart along (2, -1, 2)/3: axis x mistakes sigma_C, the line does not."""
    rng = np.random.default_rng(3)
    line = np.array([2, -1, 2]) / 3
    a = 0.05 * rng.normal(size=(3, 50_000))
    b = 0.03 * rng.normal(size=(3, 50_000)) * [[3], [1], [1]] + 100 * line[:, None]
    length = np.linalg.norm(b - a, axis=0)
    model = gaussian_model(*along_pair(a, b), length)
    assert model.sigma_C == pytest.approx(model.sigma_L, rel=1e-3)
    assert model.mu_e == pytest.approx(100, abs=0.01)
    assert gaussian_model(a[0], b[0], length).sigma_C > 1.2 * model.sigma_L


@pytest.mark.parametrize("phi", [0.0, 0.5, 0.95])
def test_correlation_time_of_an_autoregression(phi):
    """AR(1): 1/2 + sum phi^k = (1 + phi) / (2 (1 - phi)), within 6 % from 400,000 samples."""
    rng = np.random.default_rng(4)
    series = lfilter([1], [1, -phi], rng.normal(size=400_000))
    expected = (1 + phi) / (2 * (1 - phi))
    assert correlation_time(series) == pytest.approx(expected, rel=0.06)
    series[rng.random(series.size) < 0.1] = np.nan
    assert correlation_time(series) == pytest.approx(expected, rel=0.06)


def test_chi_squared_agrees_with_scipy():
    sample = 5 + 2 * np.random.default_rng(5).normal(size=50_000)
    test = chi_squared_normal(sample, 5.0, 2.0, n_bins=20)
    edges = norm.ppf(np.linspace(0, 1, 21), 5.0, 2.0)
    counts, _ = np.histogram(sample[:: test.step], edges)
    assert test.statistic == pytest.approx(chisquare(counts).statistic)
    assert test.p_value == pytest.approx(chisquare(counts).pvalue)


def test_level_of_the_chi_squared_test():
    """Correlated Gaussian series, true parameters: 5 % tests reject 2-9 % of 400 runs; without
    thinning they would reject nearly all. A wrong sigma (+10 %) is found."""
    rng = np.random.default_rng(6)
    thinned = 0
    for _ in range(400):
        series = lfilter([np.sqrt(1 - 0.9**2)], [1, -0.9], rng.normal(size=20_000))
        thinned += chi_squared_normal(series[500:], 0.0, 1.0).p_value < 0.05
    assert 0.02 <= thinned / 400 <= 0.09
    assert chi_squared_normal(rng.normal(size=20_000), 0.0, 1.1).p_value < 1e-6


def test_chi_squared_says_when_it_cannot():
    walk = np.cumsum(np.random.default_rng(7).normal(size=5000))
    test = chi_squared_normal(walk, walk.mean(), walk.std())
    assert np.isnan(test.statistic)
    assert test.n_independent < 20
    assert np.isnan(chi_squared_normal(np.full(9, np.nan), 0.0, 1.0).p_value)


def test_drift():
    t = np.arange(120 * 600) / 120.0
    rng = np.random.default_rng(8)
    series = 166.0 + 0.6 * t / 3600 + 0.01 * rng.normal(size=t.size)
    series[5000:9000] = np.nan
    found = drift(series, 120.0)
    assert found.per_hour == pytest.approx(0.6, abs=0.005)
    assert found.range == pytest.approx(0.1, abs=0.01)
    short = drift(series[:100], 120.0)  # less than ten seconds: means of a tenth
    assert short.block_s == pytest.approx(10 / 120)
    assert short.range < 0.03
    assert np.isnan(drift(np.full(9, np.nan), 120.0).range)
