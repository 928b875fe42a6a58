"""Gaps filled by conditional draws keep the spectrum; a straight line does not."""

from functools import partial

import numpy as np
import pytest

from mocap_metrology.noise.fit.spectral.gaps import bridged, filled
from mocap_metrology.noise.fit.spectral.periodogram import Stretch, periodogram
from mocap_metrology.noise.model.components import GaussMarkov, NoiseModel, PowerLaw
from mocap_metrology.noise.model.synthesis import Cross, draw_pair

RATE = 120.0
N = 1 << 17
MODEL = NoiseModel((PowerLaw(0, 1e-6), PowerLaw(-2, 1e-9), GaussMarkov(0.02, 0.1)))


def density(f):
    return MODEL.psd(f, RATE)


def test_a_slope_survives_frames_that_are_missing():
    """That of least squares has the standard error sigma sqrt(12 / n) over the whole series, though
    the density is of white noise alone."""
    n, sigma = 6000, 0.02
    for seed in range(3):
        rng = np.random.default_rng(seed)
        series = sigma * rng.standard_normal(n) + 1.5 * np.arange(n) / n
        series[1:-1][rng.random(n - 2) < 0.15] = np.nan
        whole = filled(series, lambda f: np.full_like(f, 2 * sigma**2 / 50), 50.0, rng)
        rise = n * np.polyfit(np.arange(n), whole, 1)[0]
        assert rise == pytest.approx(1.5, abs=4 * sigma * np.sqrt(12 / n))


def test_one_gap_of_a_random_walk_is_a_brownian_bridge():
    rng = np.random.default_rng(2)
    gap = 21
    steps = PowerLaw(-2, 1 / (2 * np.pi**2))  # of variance 1 at tau0 = 1
    middles = []
    for _ in range(400):
        walk = np.cumsum(rng.normal(size=200))
        broken = walk.copy()
        broken[90 : 90 + gap] = np.nan
        out = filled(broken, partial(steps.psd, frame_rate_hz=1.0), 1.0, rng)
        half = (walk[89] + walk[90 + gap]) / 2
        middles.append(out[90 + gap // 2] - half)
    # A bridge over gap + 1 steps has the variance (gap + 1)/4 in its middle
    assert abs(np.var(middles) / ((gap + 1) / 4) - 1) < 0.25
    assert abs(np.mean(middles)) < 4 * np.sqrt((gap + 1) / 4 / 400)


def test_spectrum_survives_five_percent_missing():
    rng = np.random.default_rng(3)
    series, _ = draw_pair(MODEL, MODEL, Cross(constant=0.0), N, RATE, rng)
    gone = rng.random(N) < 0.05
    gone[5000:5400] = True
    gone[[0, -1]] = False
    broken = np.where(gone, np.nan, series)
    level = {}
    for name, whole in (
        ("full", series),
        ("filled", filled(broken, density, RATE, rng)),
        ("bridged", bridged(broken)),
    ):
        data = periodogram([Stretch(whole)], RATE)
        fast = data.bins.centre_hz > 20
        ratio = data.psd / MODEL.psd(data.bins.centre_hz, RATE)
        level[name] = np.average(ratio[fast], weights=data.bins.n[fast])
    assert abs(level["filled"] / level["full"] - 1) < 0.004
    assert level["bridged"] / level["full"] < 0.95
