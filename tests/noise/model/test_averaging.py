"""Frames that are averages over the frame period: their spectra and Allan variances."""

import math
from dataclasses import replace

import numpy as np
import pytest
from mocap_workflow.recording_twins import twin_from_mapping

from mocap_metrology.noise.allan.variance import allan_variance
from mocap_metrology.noise.model.components import GaussMarkov, NoiseModel, PowerLaw, Sinusoid
from mocap_metrology.noise.model.synthesis import (
    Cross,
    circle_length,
    draw_pair,
    increment_spectrum,
)
from mocap_metrology.noise.twins.published import published_row
from mocap_metrology.noise.twins.simulate import Twin, simulate
from tests.noise.model.textbook import density

RATE = 120.0
TAU0 = 1 / RATE
M = np.array([1, 2, 3, 5, 10, 37, 100, 1000])
PARTS = [
    *(PowerLaw(alpha, 1.0) for alpha in (-2, -1, 0, 1, 2)),
    *(GaussMarkov(1.0, T_c) for T_c in (1e-4, 0.002, 0.0083, 0.0084, 0.3, 10.0, 2000.0)),
]


def by_integral(part, m):
    """2 Int S(f) sin^4(pi f m tau0) / (m sin(pi f tau0))^2 df by Gauss-Legendre."""
    x, w = np.polynomial.legendre.leggauss(20)
    edges = [0.0, *np.geomspace(1e-9, 1e-3, 60), *np.linspace(1e-3, 0.5, 4 * m + 40)[1:]]
    half = np.diff(edges)[:, None] / 2
    u = np.array(edges[:-1])[:, None] + half * (1 + x)
    gain = np.sin(np.pi * u * m) ** 4 / (m * np.sin(np.pi * u)) ** 2
    return 2 * np.sum(part.psd(u / TAU0, RATE, form="continuous") * gain * half * w) / TAU0


@pytest.mark.parametrize("part", PARTS, ids=str)
def test_allan_variance_of_the_spectrum_is_the_continuous_form_at_every_m(part):
    found = [by_integral(part, int(m)) for m in M]
    assert found == pytest.approx(part.avar(M, RATE, "continuous"), rel=1e-10)


@pytest.mark.parametrize(
    "part", [part for part in PARTS if getattr(part, "alpha", 0) <= 0], ids=str
)
def test_spectrum_is_the_folded_sum_of_what_an_average_leaves(part):
    f = np.array([1e-4, 0.3, 12.0, 41.0, 60.0])
    k = np.arange(-40_000, 40_001)[:, None] * 120.0
    seen = np.abs(f + k)
    folded = density(part, seen) * np.sinc(seen * TAU0) ** 2
    assert part.psd(f, RATE, form="continuous") == pytest.approx(folded.sum(axis=0), rel=2e-5)


def test_an_average_of_many_points_has_the_spectrum_of_averages():
    # 1 s and 8 frames of correlated noise and a random walk, from points 16 times as dense
    model = NoiseModel((GaussMarkov(1.0, 8 * TAU0), PowerLaw(-2, 0.01)))
    rng, runs, dense = np.random.default_rng(5), 60, 16
    found = []
    for _ in range(runs):
        fine, _ = draw_pair(model, model, Cross(), 6000 * dense, RATE * dense, rng)
        frames = fine.reshape(-1, dense).mean(axis=1)
        found.append(allan_variance(frames, M[:6]).variance)
    ratio = np.mean(found, axis=0) / model.avar(M[:6], RATE, "continuous")
    error = np.std(found, axis=0) / np.mean(found, axis=0) / math.sqrt(runs)
    assert np.all(np.abs(ratio - 1) < 4 * error + 0.002)  # 1/16 of a frame is a point yet
    assert abs(model.avar(1, RATE) / model.avar(1, RATE, "continuous") - 1) > 0.04


@pytest.mark.parametrize("part", PARTS, ids=str)
def test_expected_allan_variance_of_what_is_drawn(part):
    # The drawn circle of differences, bin by bin; T_c = 2000 s is far beyond 50 s
    n, model = 6001, NoiseModel((part,))
    length = circle_length(n)
    spectrum = increment_spectrum(model, length, RATE, form="continuous") / (length * TAU0)
    assert spectrum.min() >= 0
    spectrum[[0, -1]] /= 2
    u = np.arange(1, spectrum.size) / length
    for m in (1, 2, 10, n // 10, n // 3):
        gain = np.sin(np.pi * u * m) ** 4 / (2 * m**2 * np.sin(np.pi * u) ** 4)
        found = spectrum[0] * m**2 / 2 + spectrum[1:] @ gain
        tolerance = 2e-3 if part == PowerLaw(1, 1.0) else 1e-5
        assert found == pytest.approx(model.avar(m, RATE, "continuous"), rel=tolerance)


def test_twins_of_both_forms_have_the_curve_of_their_form():
    # y1 of T40-2, whose correlated term of 2.3 ms is a quarter of a frame: 1.76 times at m = 1
    entry = {"published": {"camera_type": "T40", "n_cameras": 2}, "seed": 1}
    model = published_row("T40", 2)["y1"]
    m, runs = np.array([1, 2, 5, 20, 100]), 12
    for form in ("continuous", "sampled"):
        twin = twin_from_mapping(entry | {"form": form}, "T")
        found = [
            allan_variance(simulate(replace(twin, seed=seed), 300).position_mm[0, 1], m).variance
            for seed in range(runs)
        ]
        ratio = np.mean(found, axis=0) / model.avar(m, RATE, form)
        error = np.std(found, axis=0) / np.mean(found, axis=0) / math.sqrt(runs)
        assert np.all(np.abs(ratio - 1) < 4 * error), (form, ratio)
        assert ratio[:3] == pytest.approx(1, abs=0.01)
    assert math.sqrt(model.avar(1, RATE) / model.avar(1, RATE, "continuous")) > 1.7


def test_a_sinusoid_is_averaged_too():
    line = Sinusoid(1.0, 45.0)
    assert line.recorded(RATE) == 1.0
    high = line.recorded(RATE, "continuous")
    assert high == pytest.approx(np.sinc(45 / 120))
    same = Sinusoid(high, 45.0).avar(M, RATE)
    assert same == pytest.approx(line.avar(M, RATE, "continuous"), rel=1e-9, abs=1e-15)
    models = dict.fromkeys(("x1", "y1", "z1", "x2", "y2", "z2"), NoiseModel((line,)))
    told = simulate(Twin("t", 1, models, form="continuous"), 10)
    assert told.position_mm[0, 0].std() * math.sqrt(2) == pytest.approx(high, rel=1e-3)
    assert told.truth["form"] == "continuous"
    assert told.truth["sinusoids"][0]["amplitude_mm"] == pytest.approx(high)
    assert told.truth["coefficients"]["x1"]["A_s"] == 1.0
