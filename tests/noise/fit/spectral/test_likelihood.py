"""Estimator `likelihood`: truth recovered, order chosen, gaps, many lines, resonance, bounds."""

from functools import lru_cache

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.fit.estimates import Components
from mocap_metrology.noise.fit.spectral.intervals import law_limit
from mocap_metrology.noise.fit.spectral.likelihood import check_series, likelihood
from mocap_metrology.noise.fit.spectral.order import choose, fit_known, penalty
from mocap_metrology.noise.fit.spectral.periodogram import Periodogram, bins_of
from mocap_metrology.noise.fit.spectral.whittle import Likelihood, crlb, spectrum_of
from mocap_metrology.noise.model.components import GaussMarkov, NoiseModel, PowerLaw
from mocap_metrology.noise.model.synthesis import Cross, draw_pair

RATE = 120.0
TAU0, N = 1 / RATE, 1 << 17
NINE_HOURS = 3_888_000
# Truth of a published comparison of fitting programs: white, random walk, two correlated terms
TRUTH = NoiseModel(
    (PowerLaw(-2, 4e-10), PowerLaw(0, 1e-6), GaussMarkov(0.012, 0.3), GaussMarkov(0.002, 6.0))
)
MEDIUM = NoiseModel((PowerLaw(-2, 4e-9), PowerLaw(0, 1e-6), GaussMarkov(0.02, 0.3)))


def drawn(model: NoiseModel, n: int, seed: int) -> Likelihood:
    """The likelihood of a periodogram drawn from its distribution."""
    bins = bins_of(n, RATE)
    weight = bins.n.astype(float)
    bounds = (TAU0 / 2, n * TAU0 / 5)
    flat = Likelihood(Periodogram(bins, np.ones(weight.size), weight), bounds)
    psd = flat.density(spectrum_of(model)) * np.random.default_rng(seed).chisquare(weight) / weight
    return Likelihood(Periodogram(bins, psd, weight), bounds)


@lru_cache(maxsize=2)
def series_of(model: NoiseModel, n: int, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return draw_pair(model, model, Cross(constant=0.0), n, RATE, rng)[0]


def by_name(run):
    return {c.parameter: c for c in run.estimate.coefficients}


def test_published_truth_from_a_whole_simulated_series():
    run = likelihood(series_of(TRUTH, NINE_HOURS, 4), RATE, Components.of(TRUTH))
    found = by_name(run)
    assert abs(found["h_0"].value / 1e-6 - 1) < 0.01
    assert abs(found["T_c1"].value / 0.3 - 1) < 0.10
    assert abs(found["T_c2"].value / 6.0 - 1) < 0.10
    assert found["h_-2"].lower_95 <= 4e-10 <= found["h_-2"].upper_95
    assert run.estimate.form == "sampled"
    assert all(c.status == "ok" for c in run.estimate.coefficients)


def test_errors_are_at_the_cramer_rao_bound_and_intervals_cover():
    names, values = [*TRUTH.coefficients()], TRUTH.coefficients()
    bounds = crlb(TRUTH, NINE_HOURS, RATE)
    errors = []
    for seed in range(150):
        fit = fit_known(drawn(TRUTH, NINE_HOURS, 100 + seed), (-2, 0), 2).spectrum
        found = [*fit.h.values(), *np.stack([np.sqrt(fit.q2), fit.T_c], axis=1).ravel()]
        errors.append([(v - values[k]) / bounds[k] for v, k in zip(found, names, strict=True)])
    rms = np.sqrt(np.mean(np.square(errors), axis=0))
    # 150 runs tell a root mean square to 6 %
    assert np.all(rms < 1.2), dict(zip(names, rms, strict=True))
    assert np.all(rms > 0.8)


def test_crlb_of_a_gauss_markov_process_is_that_of_an_ar1():
    n, T_c = 200_000, 0.1
    phi = np.exp(-TAU0 / T_c)
    found = crlb(NoiseModel((GaussMarkov(0.02, T_c),)), n, RATE)
    # AR(1): var(phi) = (1 - phi^2)/n, and dphi/dT_c = phi tau0/T_c^2
    expected = np.sqrt((1 - phi**2) / n) / (phi * TAU0 / T_c**2)
    assert np.isclose(found["T_c1"], expected, rtol=0.01)


def test_upper_limit_holds_in_95_of_100():
    """h_-1 is there, but too small to be detected: its limit is above it in about 95 %."""
    model = NoiseModel((PowerLaw(-1, 2e-7), PowerLaw(0, 1e-4)))
    held, undetected = 0, 0
    for seed in range(200):
        data = drawn(model, 1 << 17, seed)
        fit = choose(data, (-1, 0), 0)
        if -1 not in fit.spectrum.h:
            undetected += 1
            held += law_limit(data, fit, -1, 0.0) > 2e-7
    assert undetected > 80
    assert 0.9 <= held / undetected <= 1.0


def test_gross_outliers_masked_do_not_bias():
    from mocap_metrology.common.hampel import hampel

    series = series_of(MEDIUM, 1 << 18, 9).astype(np.float32).astype(float)
    rng = np.random.default_rng(10)
    spiked = series.copy()
    spiked[rng.integers(0, series.size, 300)] += rng.choice([-1, 1], 300) * 0.5
    masked = hampel(spiked, 120, 6.0, "mask").values
    clean = by_name(likelihood(series, RATE, Components.of(MEDIUM)))
    found = by_name(likelihood(masked, RATE, Components.of(MEDIUM)))
    assert abs(found["h_0"].value / clean["h_0"].value - 1) < 0.002


def test_levels_of_a_coarse_file_have_no_noise() -> None:
    """Two, with a gap between."""
    series = np.repeat([1.0, np.nan, 1.5], [4000, 3000, 4000])
    with pytest.raises(Refusal, match="all samples of each stretch are equal"):
        likelihood(series, 100.0)


@pytest.mark.parametrize(
    ("series", "resolution", "said"),
    [(np.ones(999), 0.0, "999 valid samples, expected at least 1000"),
     (np.full(5000, 2.5), 0.0, "all samples are equal, expected a series with noise"),
     (np.full(5000, 2.5), 0.01, "all samples are equal: the file's resolution (0.01) hides"),
     (np.where(np.arange(5000) % 5 < 3, np.nan, np.arange(5000.0)), 0.0,
      "60.0 % of the samples are missing, expected at most half")],
)  # fmt: skip
def test_refusals_are_one_clear_line(series, resolution, said):
    with pytest.raises(Refusal, match="^" + said.replace("(", r"\(").replace(")", r"\)")) as e:
        check_series(series, resolution)
    assert "\n" not in str(e.value)


def test_only_short_stretches_are_refused():
    series = np.random.default_rng(1).normal(size=3200)
    series[990:2200] = np.nan
    with pytest.raises(Refusal, match="no 1000 valid samples without a gap of more than 1200"):
        likelihood(series[:3190], RATE)
    assert likelihood(series, RATE).estimate.values  # the second stretch has 1000


def sine(A_s: float, f_0: float, phase: float = 0.5, n: int = N) -> np.ndarray:
    return A_s * np.sin(2 * np.pi * f_0 * TAU0 * np.arange(n) + phase)


def with_gaps(series: np.ndarray, share: float, seed: int) -> np.ndarray:
    gone = np.random.default_rng(seed).random(series.size) < share
    gone[[0, -1]] = False
    return np.where(gone, np.nan, series)


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


@pytest.mark.parametrize("first", [1 << 12, 7 << 12])
def test_lines_are_those_of_the_longest_stretch(first):
    """Of seven eighths of the recording, before or after a long gap; 60 times the noise in it, in
    the shorter one about as much as chance makes."""
    n = 1 << 15
    series = np.random.default_rng(3).normal(size=n) + sine(np.sqrt(4 * 60 / n), 17.3)[:n]
    series = np.insert(series, first, np.full(6000, np.nan))
    (line,) = likelihood(series, RATE).lines
    assert line.f_0 == pytest.approx(17.3, abs=2 * RATE / n)


def test_slow_line_and_its_error():
    """Beside a warm-up, too."""
    f_0, warm_up = 40.3 / (N * TAU0), 10 * np.exp(-12 * np.arange(N) / N)
    errors = []
    for seed in range(4):
        series = series_of(MEDIUM, N, 40 + seed) + sine(0.3, f_0) + warm_up * (seed % 2)
        found = by_name(likelihood(series, RATE))
        errors.append((found["A_s"].value - 0.3) / found["A_s"].std_error)
        assert abs(found["T_c1"].value - 0.3) < 4 * found["T_c1"].std_error
    assert np.sqrt(np.mean(np.square(errors))) < 2, errors


def test_wrong_settings_are_refused():
    with pytest.raises(Refusal, match="criterion 'AIC', expected one of bic, aicc"):
        penalty("AIC", 100.0)
    with pytest.raises(Refusal, match="expected alphas out of"):
        Components((3,))
    with pytest.raises(Refusal, match="no component to fit"):
        likelihood(series_of(MEDIUM, 1 << 14, 1), RATE, Components((), 0))
