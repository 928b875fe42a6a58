"""Covariance of Allan variances against exact sums for Gaussian vectors and against simulation."""

from __future__ import annotations

import numpy as np
import pytest

from mocap_metrology.noise.allan.confidence import equivalent_dof
from mocap_metrology.noise.allan.variance import allan_variance, averaging_factors
from mocap_metrology.noise.fit.allan.whitening import avar_covariance
from mocap_metrology.noise.model.components import GaussMarkov, NoiseModel, PowerLaw, Sinusoid
from mocap_metrology.noise.model.synthesis import Cross, draw_pair

RATE = 120.0
TAU0 = 1 / RATE
N = 600


def exact(sigma: np.ndarray, m: np.ndarray) -> np.ndarray:
    """Cov[y^T Q_a y, y^T Q_b y] = 2 tr(Q_a sigma Q_b sigma) of a Gaussian vector y (textbook),
    y^T Q_a y the overlapping Allan variance written out."""
    products = []
    for factor in m:
        rows = np.zeros((N - 2 * factor + 1, N))
        for i, row in enumerate(rows):
            row[i : i + factor], row[i + factor : i + 2 * factor] = -1 / factor, 1 / factor
        products.append(rows.T @ rows / (2 * len(rows)) @ sigma)
    return np.array([[2 * np.sum(a * b.T) for b in products] for a in products])


def sigma_of(model: NoiseModel) -> np.ndarray:
    """Covariance of N samples (random walk: from 0), from autocovariances in the time domain."""
    frames = np.arange(N)
    total = np.zeros((N, N))
    for part in model.components:
        if isinstance(part, GaussMarkov):
            lag = np.abs(np.subtract.outer(frames, frames)) * TAU0
            total += part.q_c**2 * part.T_c / 2 * np.exp(-lag / part.T_c)
        elif part.alpha == 0:
            total += np.eye(N) * part.h / (2 * TAU0)
        else:  # steps of variance 2 pi^2 tau0 h
            total += 2 * np.pi**2 * TAU0 * part.h * (1 + np.minimum.outer(frames, frames))
    return total


@pytest.mark.parametrize(
    ("model", "tolerance"),
    [
        (NoiseModel((PowerLaw(0, 2.0),)), 0.01),
        (NoiseModel((PowerLaw(0, 0.01), GaussMarkov(1.0, 0.1))), 0.01),
        (NoiseModel((PowerLaw(0, 0.01), GaussMarkov(1.0, 2.0))), 0.08),
        (NoiseModel((PowerLaw(-2, 1.0),)), 0.08),
    ],
    ids=["white", "fast", "slow", "random walk"],
)
def test_exact_sums(model: NoiseModel, tolerance: float) -> None:
    """Every element, relative to the two standard deviations; the ends of the series included: at
    N/7 to 8 %, and for noise that is not slower than the series to 1 % up to N/3."""
    longest = N // 3 if tolerance < 0.05 else N // 7
    m = np.unique(np.rint(np.geomspace(1, longest, 14)).astype(int))
    want = exact(sigma_of(model), m)
    have = avar_covariance(model, m, N, RATE)
    scale = np.sqrt(np.outer(np.diag(want), np.diag(want)))
    assert np.max(np.abs(have - want) / scale) < tolerance


def test_white_noise_has_the_known_degrees_of_freedom() -> None:
    n = 20000
    m = averaging_factors(n, 40)
    model = NoiseModel((PowerLaw(0, 1.0),))
    edf = 2 * model.avar(m, RATE) ** 2 / np.diag(avar_covariance(model, m, n, RATE))
    assert edf == pytest.approx([equivalent_dof(0, int(k), n) for k in m], rel=0.01)


def test_simulation() -> None:
    """A line too. Variances of 500 runs to 5 standard errors, correlations to 3.6 (0.16)."""
    model = NoiseModel((PowerLaw(0, 1.0), GaussMarkov(3.0, 0.3), Sinusoid(4.0, 7.3)))
    n, rng = 1 << 13, np.random.default_rng(5)
    m = averaging_factors(n, 25)
    drawn = []
    for _ in range(250):
        for series in draw_pair(model, model, Cross(), n, RATE, rng):
            phase = 2 * np.pi * (7.3 * TAU0 * np.arange(n) + rng.random())
            drawn.append(allan_variance(series + 4.0 * np.sin(phase), m).variance)
    want = np.cov(np.array(drawn).T)
    have = avar_covariance(model, m, n, RATE)
    assert np.diag(have) == pytest.approx(np.diag(want), rel=5 * np.sqrt(2 / 500))
    assert correlation(have) == pytest.approx(correlation(want), abs=0.16)
    without = avar_covariance(NoiseModel(model.broadband), m, n, RATE)
    assert have[5, 5] > 1.5 * without[5, 5]  # the sinusoid's part was tested


def correlation(covariance: np.ndarray) -> np.ndarray:
    sigma = np.sqrt(np.diag(covariance))
    return covariance / np.outer(sigma, sigma)


def test_given_degrees_of_freedom_set_the_diagonal_only() -> None:
    n = 10000
    m = averaging_factors(n, 30)
    model = NoiseModel((PowerLaw(0, 1.0), PowerLaw(-2, 1e-3)))
    edf = np.geomspace(5000, 2, m.size)
    have = avar_covariance(model, m, n, RATE, edf)
    assert np.diag(have) == pytest.approx(2 * model.avar(m, RATE) ** 2 / edf)
    assert correlation(have) == pytest.approx(correlation(avar_covariance(model, m, n, RATE)))


def test_nine_hours_stay_positive_definite() -> None:
    n = 9 * 3600 * 120
    m = averaging_factors(n)
    for alpha in (-2, -1, 0, 1, 2):
        covariance = avar_covariance(NoiseModel((PowerLaw(alpha, 1.0),)), m, n, RATE)
        assert np.linalg.eigvalsh(correlation(covariance)).min() > 1e-9, alpha
