"""Expected spread of means: against covariances written out, Allan variances, and Monte Carlo."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mocap_metrology.noise.assess.spread import (
    expected_spread,
    kind,
    measured_spread,
    measured_within,
    spread,
)
from mocap_metrology.noise.assess.uncertainty import Span, assess_series
from mocap_metrology.noise.model.components import (
    FORMS,
    Form,
    GaussMarkov,
    NoiseModel,
    PowerLaw,
    Sinusoid,
)
from mocap_metrology.noise.model.synthesis import circle_length, draw, increment_spectrum

RATE = 100.0
TAU0 = 1 / RATE
COMPONENTS = (
    PowerLaw(-2, 1e-6),
    PowerLaw(-1, 1e-5),
    PowerLaw(0, 1e-5),
    PowerLaw(1, 1e-7),
    PowerLaw(2, 1e-9),
    GaussMarkov(0.05, 0.02),
    GaussMarkov(0.05, 3.0),
    GaussMarkov(0.05, 1e4),
)


def written_out(component: PowerLaw | GaussMarkov, n: int, N: int, form: Form) -> float:
    """Mean over the N/n stretches of Var(mean of n - mean of N) = -sum w_i w_j D(i - j): weights
    that add up to 0, D(k) = Int S(f) (1 - cos 2 pi f k tau0) df the variogram."""
    nyquist, fine = 0.5 / TAU0, 1 << 18
    f = (np.arange(fine) + 0.5) / fine * nyquist
    edges = np.geomspace(1e-9, 40 * nyquist / fine, 20001)
    slow = (edges[1:] + edges[:-1]) / 2
    f, df = np.append(slow, f[40:]), np.append(np.diff(edges), np.full(fine - 40, nyquist / fine))
    power = component.psd(f, RATE, form=form) * df
    variogram = [2 * power @ np.sin(np.pi * f * k * TAU0) ** 2 for k in range(N)]
    lag = np.abs(np.subtract.outer(np.arange(N), np.arange(N)))
    D = np.array(variogram)[lag]
    weights = np.repeat(np.eye(N // n), n, axis=1) / n - 1 / N
    return float(np.mean([-(w @ D @ w) for w in weights]))


@pytest.mark.parametrize("component", COMPONENTS, ids=str)
@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(("n", "N", "within"), [(1, 64, 1e-4), (8, 64, 1e-4), (40, 120, 3e-3)])
def test_spread_is_that_of_the_covariances(
    component: PowerLaw | GaussMarkov, n: int, N: int, within: float, form: Form
) -> None:
    expected = written_out(component, n, N, form)
    assert spread(component, n, N, RATE, form) == pytest.approx(expected, rel=within)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("component", [*COMPONENTS, Sinusoid(0.2, 3.7)], ids=str)
def test_spread_is_half_the_sum_of_allan_variances(component: PowerLaw, form: Form) -> None:
    octaves = 2.0 ** np.arange(3, 10)
    expected = component.avar(octaves, RATE, form).sum() / 2
    assert spread(component, 8, 1024, RATE, form) == pytest.approx(expected, rel=2e-6)


def test_textbook_forms() -> None:
    """White: sigma^2 (1/n - 1/N). Random walk over a long stretch: a sixth of its steps' sum."""
    sigma, step = 0.03, 0.002
    white = PowerLaw(0, 2 * TAU0 * sigma**2)
    assert spread(white, 100, 10**6, RATE) == pytest.approx(sigma**2 / 100, rel=2e-4)
    walk = PowerLaw(-2, step**2 / (2 * math.pi**2 * TAU0))
    assert spread(walk, 1, 10**6, RATE) == pytest.approx(step**2 * 1e6 / 6, rel=1e-9)


def test_periodic_noise_is_gone_from_means_of_whole_periods() -> None:
    line = Sinusoid(0.1, 2.0)
    assert spread(line, 1, 100_000, RATE) == pytest.approx(0.1**2 / 2, rel=1e-6)
    assert spread(line, 50, 100_000, RATE) == pytest.approx(0.0, abs=1e-12)


def test_kinds_and_shares() -> None:
    model = NoiseModel((PowerLaw(0, 1e-5), GaussMarkov(0.05, TAU0 / 2), GaussMarkov(0.05, 1380.0)))
    assert [kind(c, RATE) for c in model.components] == [
        "white",
        "white",
        "correlated (T_c 1380 s)",
    ]
    found = expected_spread(model, 1, 10_000, RATE, 100_000)
    parts = [spread(c, 1, 10_000, RATE) for c in model.components]
    assert found.value**2 == pytest.approx(sum(parts))
    assert found.shares["white"] == pytest.approx(sum(parts[:2]) / sum(parts))
    assert sum(found.shares.values()) == pytest.approx(1.0)


def line_rows(A_s: float, error: float, **width: float) -> list[dict]:
    """Of noise.csv: white noise of 0.01 mm a frame and a line."""
    values = {"h_0": 2 * TAU0 * 0.01**2, "A_s": A_s, "f_0": 7.3} | width
    return [
        {"parameter": k, "value": v, "std_error": error, "status": "ok", "model": "sampled"}
        for k, v in values.items()
    ]


@pytest.mark.parametrize("wide", [True, False])
def test_a_wide_line_is_as_uncertain_as_its_row_says(wide: bool) -> None:
    """68 % interval of the scatter of a frame. Of a wide line: as far as sqrt(sigma^2 + A_s^2 / 2)
    scatters if A_s does by its row; of a sinusoid, whose row is passed over: by sqrt(S / T)
    [Rife & Boorstyn 1974]."""
    rng, A_s, error, sigma = np.random.default_rng(3), 0.02, 0.0012, 0.01
    series = rng.normal(0, sigma, 60_000) + A_s * np.sin(2 * np.pi * 7.3 * TAU0 * np.arange(60_000))
    empty = {k: np.array([]) for k in ("tau_s", "adev_mm", "adev_lower_mm", "adev_upper_mm", "edf")}
    rows = line_rows(A_s, error, **({"width_f": 0.02} if wide else {}))
    found = assess_series(series, rows, empty, Span(RATE))
    assert found.basis == "model"
    error = error if wide else math.sqrt(2 * TAU0 * sigma**2 / 600)
    heights = rng.normal(A_s, error, 100_000)
    levels = sigma**2 * (1 + rng.normal(0, math.sqrt(2 / 60_000), 100_000))
    expected = np.std(np.log(levels + heights**2 / 2)) / 2
    for end, sign in (("upper", 1), ("lower", -1)):
        ratio = getattr(found, f"sigma_frame_{end}_mm") / found.sigma_frame_mm
        assert math.log(ratio) == pytest.approx(sign * expected, rel=0.03)


MIXED = NoiseModel((PowerLaw(-2, 2e-7), PowerLaw(0, 2e-5), GaussMarkov(0.05, 0.3)))


def series_of(model: NoiseModel, n: int, seed: int) -> np.ndarray:
    rng, length = np.random.default_rng(seed), circle_length(n)
    return draw(increment_spectrum(model, length, RATE), n, length, RATE, rng)


MODELS = {
    "white": NoiseModel((PowerLaw(0, 2e-5),)),
    "walk": NoiseModel((PowerLaw(-2, 2e-7),)),
    "correlated": NoiseModel((GaussMarkov(0.05, 0.3),)),
    "mixed": MIXED,
}


@pytest.mark.parametrize("name", MODELS)
def test_measured_spread_is_the_expected_one_on_average(name: str) -> None:
    """400 recordings of 40 s; four standard errors of the mean square, and the degrees of freedom
    say how much it scatters: within 30 %, or 55 % where there are but two or three (a walk)."""
    n, N, runs = 100, 2000, 400
    found = [measured_spread(series_of(MODELS[name], 4000, seed), n, N) for seed in range(runs)]
    squares = np.array([m.variance for m in found])
    truth = sum(spread(c, n, N, RATE) for c in MODELS[name].components)
    assert squares.mean() == pytest.approx(truth, abs=4 * squares.std() / math.sqrt(runs))
    dof = 2 * squares.mean() ** 2 / squares.var()
    assert np.median([m.edf for m in found]) == pytest.approx(dof, rel=0.55)


def test_frames_within_a_second() -> None:
    """Sample variance within 100 frames, and the scatter its degrees of freedom promise, which take
    neighbouring seconds for independent."""
    found = [measured_within(series_of(MIXED, 4000, seed), 100) for seed in range(200)]
    truth = sum(spread(c, 1, 100, RATE) for c in MIXED.components) * 100 / 99
    values = np.array([m.variance for m in found])
    assert values.mean() == pytest.approx(truth, rel=0.01)
    dof = 2 * values.mean() ** 2 / values.var()
    assert np.mean([m.edf for m in found]) == pytest.approx(dof, rel=0.5)


def test_gaps_cost_no_bias() -> None:
    squares, truth = [], sum(spread(c, 100, 2000, RATE) for c in MIXED.components)
    for seed in range(200):
        series = series_of(MIXED, 4000, seed)
        series[np.random.default_rng(seed).random(4000) < 0.2] = math.nan
        squares.append(measured_spread(series, 100, 2000).variance)
    assert np.mean(squares) == pytest.approx(truth, rel=0.1)


@pytest.mark.parametrize("slow", [PowerLaw(-2, 1e-7), GaussMarkov(0.02, 60.0)], ids=str)
@pytest.mark.parametrize("n", [1, 100])
def test_intervals_of_what_is_measured_hold_the_truth(slow: PowerLaw, n: int) -> None:
    """68 % intervals in 200 recordings of 6 min: wander that drowns in white noise has a corner in
    its spectrum, yet they hold the truth in 58 to 82 % (three standard errors, and room for the
    levels of the spectrum being estimates)."""
    rng, N = np.random.default_rng(21), 36_000
    model = NoiseModel((slow, PowerLaw(0, 1e-6), GaussMarkov(0.02, 0.3)))
    length = circle_length(N)
    spectrum = increment_spectrum(model, length, RATE)
    truth = math.sqrt(sum(spread(c, n, N, RATE) for c in model.components))
    held = 0
    for _ in range(200):
        low, high = measured_spread(draw(spectrum, N, length, RATE, rng), n, N).interval(0.683)
        held += low <= truth <= high
    assert 0.58 <= held / 200 <= 0.82
