"""Kernel densities against scipy's, and the law of the number of cameras."""

import math

import numpy as np
import pytest
from scipy.stats import gaussian_kde

from mocap_metrology.noise.cameras.scaling import fit_scaling
from mocap_metrology.noise.gaussian.two_markers import kernel_density


def test_density_is_scipys() -> None:
    rng = np.random.default_rng(1)
    series = np.concatenate([rng.normal(166.0, 0.3, 3000), rng.normal(167.5, 0.2, 1000)])
    found = kernel_density(np.append(series, [np.nan, np.inf]))
    theirs = gaussian_kde(series, bw_method=found.bandwidth / series.std(ddof=1))
    peak = found.density.max()
    assert np.abs(found.density - theirs(found.x)).max() < 3e-3 * peak
    assert np.trapezoid(found.density, found.x) == pytest.approx(1, abs=1e-3)
    theirs = gaussian_kde(series, bw_method="silverman")  # 1.06 s n^(-1/5), s not robust
    assert 0.5 < found.bandwidth / (theirs.factor * series.std(ddof=1)) < 1


def test_a_constant_has_no_density() -> None:
    assert kernel_density(np.ones(5)).x.size == 0
    assert kernel_density(np.full(5, np.nan)).x.size == 0


def test_error_of_the_exponent_covers_as_often_as_it_says() -> None:
    """One standard error on 5 degrees of freedom: 63.7 %."""
    rng = np.random.default_rng(4)
    n = np.array([2, 3, 4, 5, 6, 8, 10])
    fits = [fit_scaling(n, np.exp(rng.normal(0, 0.2, 7)) / np.sqrt(n)) for _ in range(1000)]
    inside = np.mean([abs(fit.exponent + 0.5) < fit.exponent_error for fit in fits])
    assert abs(inside - 0.637) < 0.05


def test_what_cannot_be_fitted_is_not() -> None:
    assert fit_scaling(np.array([4, 4]), np.array([0.1, 0.2])) is None
    assert fit_scaling(np.array([2, 4]), np.array([np.nan, 0.2])) is None
    two = fit_scaling(np.array([2, 8]), np.array([0.2, 0.1]))
    assert two.exponent == pytest.approx(-0.5)
    assert math.isnan(two.exponent_error)
