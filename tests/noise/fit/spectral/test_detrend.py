"""Straight line and warm-up under the noise: columns, estimates, what is no drift, gaps."""

import numpy as np
import pytest
from scipy.fft import dct

from mocap_metrology.noise.allan.variance import allan_variance
from mocap_metrology.noise.fit.spectral.detrend import Designs
from mocap_metrology.noise.fit.spectral.likelihood import likelihood
from mocap_metrology.noise.fit.spectral.periodogram import Stretch, periodogram
from mocap_metrology.noise.model.components import NoiseModel, PowerLaw
from mocap_metrology.noise.model.deterministic import HOUR, Deterministic
from mocap_metrology.noise.model.synthesis import Cross, draw_pair

RATE, N = 100.0, 60_000
TAU0 = 1 / RATE
T = np.arange(N) * TAU0
WHITE = PowerLaw(0, 5e-5)


def noise(seed: int, *more: PowerLaw) -> np.ndarray:
    model = NoiseModel((WHITE, *more))
    return draw_pair(model, model, Cross(constant=0.0), N, RATE, np.random.default_rng(seed))[0]


def found(series: np.ndarray) -> dict:
    return {c.parameter: c for c in likelihood(series, RATE).estimate.coefficients}


@pytest.mark.parametrize("start", [0, 7000])
def test_columns_are_the_cosine_transforms_of_line_and_exponential(start):
    n = 5001
    t = (start + np.arange(n)) * TAU0
    for x, column in (
        (t / HOUR, lambda of: of.line),
        (np.exp(-t / 11), lambda of: of.warm_up(11.0)),
        (np.exp(-t / 0.5), lambda of: of.warm_up(np.array([2.0, 0.5]))[1]),
    ):
        designs = Designs(periodogram([Stretch(x, start=start)], RATE))
        expected = np.sqrt(2 * TAU0) * dct(x, norm="ortho")[designs.slow.k]
        assert np.allclose(column(designs), expected, atol=1e-9 * np.abs(expected).max())


def test_a_line_is_a_drift_and_no_random_walk():
    """0.2 mm in 10 min; at 8b8d0af h_-2 = 3e-8 with a 95 % interval far from 0."""
    held, walks, widths = 0, 0, []
    for seed in range(5):
        by_name = found(noise(seed) + 0.2 * T / 600)
        drift = by_name["drift"]
        assert drift.detected and not by_name["A_w"].detected
        held += drift.lower_95 <= 1.2 <= drift.upper_95
        walks += by_name["h_-2"].detected
        widths.append((drift.upper_95 - drift.lower_95) / (2 * 1.96 * drift.crlb))
        assert drift.std_error == pytest.approx(drift.crlb)
    assert held == 5
    assert walks == 0
    assert np.median(widths) < 1.5


def test_a_warm_up_has_its_size_and_its_time():
    held = 0
    for seed in range(4):
        by_name = found(noise(seed) - 0.3 * np.exp(-T / 60))
        A_w, T_w = by_name["A_w"], by_name["T_w"]
        assert A_w.detected and T_w.detected and not by_name["h_-2"].detected
        held += A_w.lower_95 <= -0.3 <= A_w.upper_95 and T_w.lower_95 <= 60 <= T_w.upper_95
    assert held == 4


@pytest.mark.parametrize("alpha, h", [(0, 0.0), (-1, 1.5e-5), (-2, 5e-7), (-2, 2e-8)])
def test_noise_alone_is_no_drift(alpha, h):
    more = [PowerLaw(alpha, h)] if h else []
    false = 0
    for seed in range(4):
        by_name = found(noise(100 + seed, *more))
        false += by_name["drift"].detected or by_name["A_w"].detected
        assert by_name["drift"].detected or by_name["drift"].upper_95 > 0
    assert false <= 1


def test_a_walk_under_a_line_keeps_its_coefficient():
    """The walk is 0.1 mm in 10 min, the line 0.5 mm; restricted likelihood keeps h_-2 unbiased."""
    ratios = []
    for seed in range(4):
        alone = noise(seed, PowerLaw(-2, 5e-7))
        values = [found(x)["h_-2"].value for x in (alone, alone + 0.5 * T / 600)]
        ratios.append(values[1] / values[0])
    assert np.nanmedian(ratios) == pytest.approx(1, abs=0.03)


def test_allan_variance_and_spread_of_the_part_itself():
    part = Deterministic(drift=3.6, A_w=0.4, T_w=50.0)
    x, m = part.at(T), np.array([1, 10, 100, 1000, 10_000])
    expected = allan_variance(x, m).variance
    assert part.avar(m * TAU0, N * TAU0) == pytest.approx(expected, rel=1e-2)
    blocks = x[:30_000].reshape(-1, 100).mean(axis=1)
    expected = np.mean((blocks - blocks.mean()) ** 2)
    assert part.variance_of_means(1.0, 300.0, 300.0) == pytest.approx(expected, rel=0.01)
    line = Deterministic(drift=3.6)
    assert line.variance_of_means(1.0, 300.0, 900.0) == pytest.approx(1e-6 * (300**2 - 1) / 12)
    assert line.avar(np.array([2.0]), 600.0) == pytest.approx(2e-3**2 / 2)
