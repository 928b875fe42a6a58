"""Ordinary least squares against other optimisers of the same sum."""

from __future__ import annotations

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.fit.allan.baselines import levenberg_marquardt
from mocap_metrology.noise.fit.estimates import Components
from mocap_metrology.noise.model.components import NoiseModel

RATE = 120.0
M = np.unique(np.round(np.logspace(0, np.log10(1_296_000), 116))).astype(int)
TRUTH = NoiseModel.from_coefficients({"h_-2": 4e-10, "h_0": 1e-6, "q_c1": 0.012, "T_c1": 0.3})


@pytest.mark.parametrize("form", ["continuous", "sampled"])
def test_recovers_the_truth(form):
    avar = TRUTH.avar(M, RATE, form)
    found = levenberg_marquardt(M, avar, RATE, Components.of(TRUTH), 1, form)
    assert found.values == pytest.approx(TRUTH.coefficients(), rel=1e-3)
    assert {c.status for c in found.coefficients} == {"ok"}
    assert found.estimator == "levenberg-marquardt" and found.form == form


def test_power_laws_alone_are_unweighted_non_negative_least_squares():
    from scipy.optimize import nnls

    rng = np.random.default_rng(3)
    truth = NoiseModel.from_coefficients({"h_-2": 4e-10, "h_-1": 1e-6, "h_0": 1e-6})
    avar = truth.avar(M, RATE, "continuous") * np.exp(0.05 * rng.normal(size=M.size))
    alphas = (-2, -1, 0)
    curves = [
        NoiseModel.from_coefficients({f"h_{a}": 1.0}).avar(M, RATE, "continuous") for a in alphas
    ]
    # nnls on columns of one size: h_-2 and h_-1 differ by 1e9
    matrix = np.array(curves).T / 1e-6
    size = np.linalg.norm(matrix, axis=0)
    h, residual = nnls(matrix / size, avar / 1e-6)
    found = levenberg_marquardt(M, avar, RATE, Components(alphas, 0), 2)
    assert found.cost == pytest.approx((residual * 1e-6) ** 2 / np.mean(avar**2), rel=1e-4)
    for alpha, expected in zip(alphas, h / size, strict=True):
        if expected > 1e-3 * getattr(truth.components[alpha + 2], "h", 0):
            assert found.values[f"h_{alpha}"] == pytest.approx(expected, rel=1e-3)


def test_the_largest_variances_decide():
    """A small variance changed tenfold moves this fit by little, where it would wreck another."""
    avar = TRUTH.avar(M, RATE, "continuous")
    broken = np.where(np.arange(M.size) == np.argmin(avar), 10 * avar, avar)
    found = levenberg_marquardt(M, broken, RATE, Components.of(TRUTH), 1)
    assert found.values["h_-2"] == pytest.approx(4e-10, rel=0.02)


def test_same_seed_same_numbers():
    avar = TRUTH.avar(M, RATE)
    first, again = (levenberg_marquardt(M, avar, RATE, Components.of(TRUTH), 4) for _ in range(2))
    assert first.values == again.values and first.cost == again.cost


def test_absent_component_is_at_its_bound():
    white = NoiseModel.from_coefficients({"h_0": 1e-6}).avar(M, RATE)
    found = levenberg_marquardt(M, white, RATE, Components((-2, 0), 0), 5)
    assert {c.parameter: c.status for c in found.coefficients}["h_-2"] == "at_bound"


def test_bad_input_is_refused():
    avar = TRUTH.avar(M, RATE)
    with pytest.raises(Refusal, match="nan, expected a number > 0"):
        levenberg_marquardt(M, np.where(M == 2, np.nan, avar), RATE, Components.of(TRUTH), 1)
    with pytest.raises(Refusal, match="3 Allan variances for 4 coefficients"):
        levenberg_marquardt(M[:3], avar[:3], RATE, Components.of(TRUTH), 1)
    with pytest.raises(Refusal, match="0 starts"):
        levenberg_marquardt(M, avar, RATE, Components.of(TRUTH), 1, starts=0)
