"""The mean of all frames against closed forms and simulated means."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.signal import lfilter

from mocap_metrology.noise.assess.mean import mean_of_all
from mocap_metrology.noise.fit.estimates import deterministic_of, model_of, rows
from mocap_metrology.noise.fit.spectral.likelihood import likelihood
from mocap_metrology.noise.model.components import GaussMarkov, NoiseModel, PowerLaw
from mocap_metrology.noise.model.deterministic import Deterministic

RATE, N = 100.0, 60_000
SIGMA, T_C = 0.02, 1.0
NONE = Deterministic()


def correlated(rng: np.random.Generator, n: int = N) -> np.ndarray:
    """White noise and a Gauss-Markov process, of SIGMA each."""
    phi = math.exp(-1 / (T_C * RATE))
    steps = SIGMA * math.sqrt(1 - phi**2) * rng.standard_normal(n)
    steps[0] = SIGMA * rng.standard_normal()
    return SIGMA * rng.standard_normal(n) + lfilter([1], [1, -phi], steps)


def truth(n: int = N) -> tuple[float, float]:
    """Variance of a frame and of the mean, by the sum over all lags."""
    k = np.arange(1, n)
    lags = float(np.sum((1 - k / n) * np.exp(-k / (T_C * RATE))))
    return 2 * SIGMA**2, SIGMA**2 / n * (2 + 2 * lags)


def test_of_a_model_by_the_sum_over_lags() -> None:
    white, slow = PowerLaw(0, 2 * SIGMA**2 / RATE), GaussMarkov(SIGMA * math.sqrt(2 / T_C), T_C)
    model = NoiseModel((white, slow))
    series = correlated(np.random.default_rng(1))
    found = mean_of_all(series, RATE, model, NONE, 0.01)
    frame, mean = truth()
    assert found.u_mm == pytest.approx(math.sqrt(mean), rel=2e-3)
    assert found.n_eff == pytest.approx(frame / mean, rel=3e-3)
    assert found.correlation_s * found.n_eff == pytest.approx(found.duration_s)
    assert found.n_eff_lower_95 < found.n_eff < found.n_eff_upper_95
    assert found.expanded_mm == pytest.approx(found.k * found.u_mm)
    longer = mean_of_all(series, RATE, model, NONE, 0.005)
    assert longer.length_s == pytest.approx(4 * found.length_s)


def test_intervals_hold_and_values_are_near() -> None:
    """20 recordings of 10 min, fitted: 17 or more intervals of 95 % hold, 18 values are within
    20 %, where two standard errors are 14 %."""
    frame, mean = truth()
    held = near = 0
    for seed in range(20):
        series = correlated(np.random.default_rng([seed, 3]))
        fitted = rows("x1", likelihood(series, RATE).estimate)
        found = mean_of_all(series, RATE, model_of(fitted), deterministic_of(fitted), 0.01)
        held += found.n_eff_lower_95 <= frame / mean <= found.n_eff_upper_95
        near += abs(found.n_eff / (frame / mean) - 1) < 0.2
    assert held >= 17 and near >= 18


def test_without_a_model_by_batches() -> None:
    """The expanded uncertainty holds the true mean, 0, in 95 % of 200: 183 or more."""
    held = 0
    for seed in range(200):
        series = correlated(np.random.default_rng([seed, 4]), 20_000)
        found = mean_of_all(series, RATE, None, NONE, 0.01)
        assert found.dof == 19
        held += abs(series.mean()) <= found.expanded_mm
    assert held >= 183


@pytest.mark.parametrize(
    ("model", "part"),
    [
        (NoiseModel((PowerLaw(0, 1e-5), PowerLaw(-2, 1e-8))), NONE),
        (NoiseModel((PowerLaw(0, 1e-5), PowerLaw(-1, 1e-6))), NONE),
        (NoiseModel((PowerLaw(0, 1e-5),)), Deterministic(drift=1e-4)),
    ],
)
def test_no_mean_of_what_never_settles(model: NoiseModel, part: Deterministic) -> None:
    found = mean_of_all(np.zeros(N), RATE, model, part, 0.01)
    assert found.duration_s == 600
    assert math.isnan(found.n_eff) and math.isnan(found.length_s)
