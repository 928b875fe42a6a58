"""Straight line and warm-up under the noise: columns, estimates, what is no drift, gaps."""

import numpy as np
import pytest
from scipy.fft import dct

from mocap_metrology.noise.fit.spectral.detrend import Designs
from mocap_metrology.noise.fit.spectral.likelihood import likelihood
from mocap_metrology.noise.fit.spectral.periodogram import Stretch, periodogram
from mocap_metrology.noise.model.components import NoiseModel, PowerLaw
from mocap_metrology.noise.model.deterministic import HOUR
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


def test_a_walk_under_a_line_keeps_its_coefficient():
    """The walk is 0.1 mm in 10 min, the line 0.5 mm; restricted likelihood keeps h_-2 unbiased."""
    ratios = []
    for seed in range(4):
        alone = noise(seed, PowerLaw(-2, 5e-7))
        values = [found(x)["h_-2"].value for x in (alone, alone + 0.5 * T / 600)]
        ratios.append(values[1] / values[0])
    assert np.nanmedian(ratios) == pytest.approx(1, abs=0.03)
