"""S Table 1: printed formulas against numerical integration, and both against simulation."""

import math

import numpy as np
import pytest

from mocap_metrology.noise.model.components import ALPHAS
from mocap_metrology.noise.model.scale_factors import (
    MU,
    integrated_avar,
    mean_and_error,
    printed_scale,
    simulated_avar,
    slope_and_error,
    slope_weights,
)

F_H = 60.0
RATE = 2 * F_H
TAU0 = 1 / RATE


@pytest.mark.parametrize("alpha", [-2, -1, 0])
@pytest.mark.parametrize("tau", [0.003, 1.0, 700.0])
def test_unlimited_integral_is_the_printed_formula(alpha: int, tau: float) -> None:
    value, bound = integrated_avar(alpha, tau, math.inf)
    printed = printed_scale(alpha, tau, F_H) * tau ** MU[alpha]
    assert abs(value - printed) < max(bound, 1e-12 * printed)
    assert bound < 1e-9 * printed


def test_limited_integral_is_the_printed_formula_of_blue_and_violet() -> None:
    """For f_h tau >> 1, and to the digits that are printed: 1.038 stands for 3 gamma - ln 2."""
    tau = 1000 / F_H
    blue, _ = integrated_avar(1, tau, F_H)
    constant = 4 * math.pi**2 * tau**2 * blue - 3 * math.log(2 * math.pi * F_H * tau)
    assert constant == pytest.approx(3 * np.euler_gamma - math.log(2), abs=1e-6)
    assert round(constant, 3) == pytest.approx(1.038, abs=0.0011)
    violet, _ = integrated_avar(2, tau, F_H)
    assert violet == pytest.approx(printed_scale(2, tau, F_H) / tau**2, rel=1e-9)


@pytest.mark.parametrize("alpha", ALPHAS)
def test_integral_over_whole_and_broken_periods_agrees_with_a_fine_sum(alpha: int) -> None:
    for tau in (2.3 / F_H, 7 / F_H):
        f = (np.arange(400_000) + 0.5) * F_H / 400_000
        x = math.pi * f * tau
        total = 2 * np.sum(f ** float(alpha) * np.sin(x) ** 4 / x**2) * F_H / f.size
        assert integrated_avar(alpha, tau, F_H)[0] == pytest.approx(total, rel=1e-6)


@pytest.mark.parametrize("alpha", ALPHAS)
def test_simulated_averages_have_the_integral(alpha: int) -> None:
    """At one sample too, where point samples are up to 1.8 times off."""
    m = np.array([1, 5, 60])
    rng = np.random.default_rng(10 + alpha)
    found = simulated_avar(alpha, m, 1 << 13, RATE, 80, rng)
    mean, error = mean_and_error(found)
    exact = np.array([integrated_avar(alpha, float(t), F_H)[0] for t in m * TAU0])
    assert np.all(np.abs(mean - exact) < 3.5 * error)
    assert np.all(error < 0.03 * exact)
    weights = slope_weights(m * TAU0)
    slope, of_slope = slope_and_error(m * TAU0, found)
    assert abs(slope - weights @ np.log(exact)) < 3.5 * of_slope < 0.05


def test_error_of_a_slope_is_its_scatter() -> None:
    """400 times 60 realisations of chi-squared estimates, as Allan variances are."""
    rng = np.random.default_rng(3)
    tau, truth, edf = np.array([1.0, 10.0, 100.0]), np.array([1.0, 0.1, 0.01]), [300, 40, 8]
    found = [slope_and_error(tau, truth * rng.chisquare(edf, (60, 3)) / edf) for _ in range(400)]
    z = np.array([(slope + 1) / error for slope, error in found])
    assert abs(z.mean()) < 0.2
    assert 0.9 < z.std() < 1.12
