"""Estimator `likelihood` on what recordings really hold: gaps, many lines, drift, resonance."""

import numpy as np
import pytest
from scipy.signal import lfilter

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.fit.estimates import Components
from mocap_metrology.noise.fit.spectral.likelihood import LikelihoodSettings, likelihood
from mocap_metrology.noise.fit.spectral.order import penalty
from mocap_metrology.noise.model.components import GaussMarkov, NoiseModel, PowerLaw
from mocap_metrology.noise.model.synthesis import Cross, draw_pair

RATE, N = 120.0, 1 << 17
TAU0 = 1 / RATE
MODEL = NoiseModel((PowerLaw(-2, 4e-9), PowerLaw(0, 1e-6), GaussMarkov(0.02, 0.3)))


def drawn(seed: int, n: int = N) -> np.ndarray:
    return draw_pair(MODEL, MODEL, Cross(constant=0.0), n, RATE, np.random.default_rng(seed))[0]


def sine(A_s: float, f_0: float, phase: float = 0.5, n: int = N) -> np.ndarray:
    return A_s * np.sin(2 * np.pi * f_0 * TAU0 * np.arange(n) + phase)


def with_gaps(series: np.ndarray, share: float, seed: int) -> np.ndarray:
    gone = np.random.default_rng(seed).random(series.size) < share
    gone[[0, -1]] = False
    return np.where(gone, np.nan, series)


def by_name(run):
    return {c.parameter: c for c in run.estimate.coefficients}


@pytest.mark.parametrize("share", [0.03, 0.3])
def test_gaps_in_white_noise_make_no_other_noise(share):
    found = []
    for seed in range(4):
        series = np.random.default_rng(seed).normal(size=N // 2)
        run = likelihood(with_gaps(series, share, 100 + seed), RATE)
        h_0 = by_name(run)["h_0"]
        found.append((set(run.estimate.values) == {"h_0"}, (h_0.value - 2 * TAU0) / h_0.std_error))
    assert sum(alone for alone, _ in found) >= 3, found
    assert abs(np.mean([z for _, z in found])) < 2, found


def test_amplitude_of_a_line_does_not_suffer_from_gaps():
    errors = []
    for seed in range(5):
        series = drawn(20 + seed, 1 << 16) + sine(0.003, 50.0, n=1 << 16)
        found = by_name(likelihood(with_gaps(series, 0.05, seed), RATE))
        errors.append((found["A_s"].value - 0.003) / found["A_s"].std_error)
    assert abs(np.mean(errors)) < 3 / np.sqrt(5), errors  # five of unit variance
    assert np.std(errors) < 2


def test_many_lines_are_all_taken_out():
    series = drawn(5) + sum(sine(0.012 + 0.001 * k, 3.3 + 5 * k) for k in range(10))
    run = likelihood(series, RATE)
    found = by_name(run)
    assert len(run.lines) == 10
    assert abs(found["h_0"].value - 1e-6) < 4 * found["h_0"].std_error
    assert run.estimate.note.startswith("further lines, removed before the fit: ")
    assert run.estimate.note.endswith(" and 1 more")
    few = likelihood(series, RATE, settings=LikelihoodSettings(max_lines=3))
    assert "the largest number searched for" in few.estimate.note
    assert {c.status for c in few.estimate.coefficients if c.detected} <= {"misfit", "at_bound"}


def test_slow_line_and_its_error():
    f_0 = 40.3 / (N * TAU0)
    errors = []
    for seed in range(4):
        found = by_name(likelihood(drawn(40 + seed) + sine(0.3, f_0), RATE))
        errors.append((found["A_s"].value - 0.3) / found["A_s"].std_error)
        assert abs(found["T_c1"].value - 0.3) < 4 * found["T_c1"].std_error
    assert np.sqrt(np.mean(np.square(errors))) < 2, errors


def test_odd_and_even_frames_apart_is_a_line_at_nyquist():
    series = drawn(6) + 0.0011 * (-1.0) ** np.arange(N)
    found = by_name(likelihood(series, RATE))
    assert found["f_0"].value == pytest.approx(60)
    assert found["A_s"].value == pytest.approx(0.0011, rel=0.1)
    assert abs(found["h_0"].value - 1e-6) < 4 * found["h_0"].std_error


def resonance(seed: int) -> np.ndarray:
    """A damped oscillator of 14 Hz and Q = 50, driven by noise: a peak, and no line."""
    a, w = np.exp(-np.pi * 14 / 50 * TAU0), 2 * np.pi * 14 * TAU0
    driven = np.random.default_rng(seed).normal(size=N)
    return lfilter([1.0], [1.0, -2 * a * np.cos(w), a * a], driven)


@pytest.mark.parametrize("odd", ["swing", "resonance"])
def test_what_the_model_cannot_describe_is_a_misfit(odd):
    series = drawn(7)
    swing = np.sin(np.pi * np.arange(N) / N) ** 8  # out and back once, as no line or warm-up goes
    run = likelihood(series + {"swing": 3 * swing, "resonance": 1e-3 * resonance(8)}[odd], RATE)
    assert "the model does not describe the spectrum" in run.estimate.note
    for c in run.estimate.coefficients:
        assert c.status in ("misfit", "at_bound", "not_converged", "not_detected")
        assert np.isnan(c.upper_95) or c.detected
    assert "misfit" not in {c.status for c in likelihood(series, RATE).estimate.coefficients}


def test_wrong_settings_are_refused():
    with pytest.raises(Refusal, match="criterion 'AIC', expected one of bic, aicc"):
        penalty("AIC", 100.0)
    with pytest.raises(Refusal, match="expected alphas out of"):
        Components((3,))
    with pytest.raises(Refusal, match="no component to fit"):
        likelihood(drawn(1, 1 << 14), RATE, Components((), 0))
