"""The Gaussian model against its closed forms and the published table's own algebra."""

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import chisquare, gaussian_kde, kstest, norm

from mocap_metrology.noise.gaussian import two_markers as gaussian
from mocap_metrology.noise.gaussian.two_markers import (
    chi_squared_normal,
    correlation_time,
    drift,
    gaussian_model,
    kernel_density,
    median_drift,
)


def pair(rng, n, rho=0.8):
    common = rng.normal(size=n)
    first = 166.6 + 0.02 * (np.sqrt(rho) * common + np.sqrt(1 - rho) * rng.normal(size=n))
    second = 6.0 + 0.02 * (np.sqrt(rho) * common + np.sqrt(1 - rho) * rng.normal(size=n))
    return first, second


def test_algebra_of_table_4():
    rng = np.random.default_rng(1)
    first, second = pair(rng, 200_000)
    model = gaussian_model(first, second, first - second)
    assert model.rho_12 == pytest.approx(0.8, abs=0.005)
    assert model.sigma_12 == pytest.approx(model.rho_12 * model.sigma_1 * model.sigma_2)
    assert model.sigma_A1 == pytest.approx(np.sqrt(2) * model.sigma_1)
    assert model.sigma_B**2 == pytest.approx(model.sigma_1**2 + model.sigma_2**2)
    assert model.sigma_C == pytest.approx(model.sigma_L)  # here L is the plain difference
    assert model.mu_e == pytest.approx(model.mu_L)
    assert model.mu_e > 0


def test_only_frames_with_both_markers_count():
    rng = np.random.default_rng(2)
    first, second = pair(rng, 1000)
    length = first - second
    first[::3], second[::5] = np.nan, np.nan
    both = np.isfinite(first) & np.isfinite(second)
    model = gaussian_model(first, second, length)
    whole = gaussian_model(first[both], second[both], length[both])
    assert model == whole
    assert np.isnan(gaussian_model(first, np.full(1000, np.nan), length).mu_1)


@pytest.mark.parametrize("phi", [0.0, 0.5, 0.95])
def test_correlation_time_of_an_autoregression(phi):
    """AR(1): 1/2 + sum phi^k = (1 + phi) / (2 (1 - phi)), within 6 % from 400,000 samples. Of those
    that are left when one in ten is lost at random, each has a tenth fewer neighbours."""
    rng = np.random.default_rng(4)
    series = lfilter([1], [1, -phi], rng.normal(size=400_000))
    expected = (1 + phi) / (2 * (1 - phi))
    assert correlation_time(series) == pytest.approx(expected, rel=0.06)
    series[rng.random(series.size) < 0.1] = np.nan
    assert correlation_time(series) == pytest.approx(0.5 + 0.9 * (expected - 0.5), rel=0.06)


def test_correlation_time_of_a_few_samples_is_a_share_of_them() -> None:
    """Not less than that of white noise, and not more than all of them; two samples do not tell,
    and no number of equal ones."""
    assert correlation_time(np.full(60, 1000.1)) == 0.5
    series = np.random.default_rng(2).standard_normal(60)
    times = [correlation_time(series[:n]) for n in range(60)]
    assert times[:3] == [0.5, 0.5, 0.5]
    assert all(0.5 <= time <= max(n, 0.5) for n, time in enumerate(times))


@pytest.mark.filterwarnings("error")
def test_equal_values_are_not_tested() -> None:
    """Rounding puts the mean of most of these beside them."""
    for value in np.random.default_rng(1).uniform(-2000, 2000, 40):
        assert gaussian.gaussian_sample(np.full(3001, value), 30).null.size == 0


def white_and_slow(rng, white, T_c_s, share):
    """sqrt(1 - share) white + Gauss-Markov noise of that share of the variance, at 120 Hz."""
    phi = np.exp(-1 / (T_c_s * 120))
    steps = np.sqrt(1 - phi**2) * rng.normal(size=white.size)
    slow, _ = lfilter([1], [1, -phi], steps, zi=[phi * rng.normal()])
    return np.sqrt(1 - share) * white + np.sqrt(share) * slow


def p_value(series):
    return chi_squared_normal(series, series.mean(), series.std()).p_value


def test_chi_squared_of_independent_samples_is_that_of_scipy():
    """Of white noise, what surrogates give is the chi-squared distribution of bins - 3."""
    sample = 5 + 2 * np.random.default_rng(5).normal(size=4000)
    test = chi_squared_normal(sample, 5.0, 2.0, n_bins=20)
    counts, _ = np.histogram(sample, norm.ppf(np.linspace(0, 1, 21), 5.0, 2.0))
    scipys = chisquare(counts, ddof=2)
    assert (test.step, test.dof) == (1, 17)
    assert test.statistic == pytest.approx(scipys.statistic, rel=0.03)
    assert test.p_value == pytest.approx(scipys.pvalue, abs=0.05)


@pytest.mark.parametrize(
    "draw",
    [
        lambda rng: rng.normal(size=2000),
        lambda rng: white_and_slow(rng, rng.normal(size=2000), 1.0, 0.3),
        lambda rng: white_and_slow(rng, rng.normal(size=2000), 10.0, 0.9),
        lambda rng: 3 * rng.normal(size=2000) + np.cumsum(rng.normal(size=2000)) / 10,
        lambda rng: np.cumsum(rng.normal(size=2000)),
    ],
    ids=["white", "and slow", "mostly slow", "and random walk", "random walk"],
)
def test_p_is_uniform_on_gaussian_noise(draw, monkeypatch):
    """Whatever its time scales; Kolmogorov-Smirnov p > 0.01 of 60 recordings."""
    monkeypatch.setattr(gaussian, "SURROGATES", 99)
    p = [p_value(draw(np.random.default_rng([6, seed]))) for seed in range(60)]
    assert kstest(p, "uniform").pvalue > 0.01


@pytest.mark.parametrize("share", [0.0, 0.3])
def test_what_is_not_gaussian_is_rejected(share):
    """Under slow noise too, and a standard deviation that is not the series' own."""
    rng = np.random.default_rng(9)
    n = 60_000
    kinds = {
        "t": rng.standard_t(5, n) / np.sqrt(5 / 3),
        "uniform": rng.uniform(-1, 1, n) * np.sqrt(3),
        "bimodal": (rng.normal(size=n) + 1.5 * rng.choice([-1, 1], n)) / np.sqrt(3.25),
    }
    for name, white in kinds.items():
        assert p_value(white_and_slow(rng, white, 2.0, share)) < 0.01, name
    series = white_and_slow(rng, rng.normal(size=n), 2.0, share)
    assert chi_squared_normal(series, series.mean(), 1.1 * series.std()).p_value < 0.01


def test_few_independent_samples_are_told():
    walk = np.cumsum(np.random.default_rng(7).normal(size=5000))
    test = chi_squared_normal(walk, walk.mean(), walk.std())
    assert test.n_independent < 20
    for series in (np.full(9, np.nan), np.zeros(0), np.ones(300), np.arange(12.0)):
        assert np.isnan(chi_squared_normal(series, 0.0, 1.0).p_value)


def test_drift():
    t = np.arange(120 * 600) / 120.0
    rng = np.random.default_rng(8)
    series = 166.0 + 0.6 * t / 3600 + 0.01 * rng.normal(size=t.size)
    series[5000:9000] = np.nan
    found = drift(series, 120.0)
    assert found.per_hour == pytest.approx(0.6, abs=0.005)
    assert found.range == pytest.approx(0.1, abs=0.01)
    short = drift(series[:100], 120.0)  # less than ten seconds: means of a tenth
    assert short.block_s == pytest.approx(10 / 120)
    assert short.range < 0.03
    assert np.isnan(drift(np.full(9, np.nan), 120.0).range)


def test_density_is_scipys() -> None:
    rng = np.random.default_rng(1)
    series = np.concatenate([rng.normal(166.0, 0.3, 3000), rng.normal(167.5, 0.2, 1000)])
    found = kernel_density(np.append(series, [np.nan, np.inf]))
    theirs = gaussian_kde(series, bw_method=found.bandwidth / series.std(ddof=1))
    peak = found.density.max()
    assert np.abs(found.density - theirs(found.x)).max() < 3e-3 * peak
    assert np.trapezoid(found.density, found.x) == pytest.approx(1, abs=1e-3)
    theirs = gaussian_kde(series, bw_method="silverman")  # 1.06 s n^(-1/5), s not robust
    assert 0.5 < found.bandwidth / (theirs.factor * series.std(ddof=1)) < 1


@pytest.mark.parametrize("n", [0, 1, 2, 7, 30, 95, 1000])
def test_medians_as_numpy_makes_them(n: int) -> None:
    series = np.random.default_rng(n).normal(size=n)
    series[3::7] = np.nan
    found = median_drift(series, 20.0)
    width = round(found.block_s * 20)
    blocks = series[: n // width * width].reshape(-1, width)
    expected = np.ptp(np.nanmedian(blocks, axis=1)) if len(blocks) > 1 else np.nan
    assert found.range == pytest.approx(expected, nan_ok=True)
    assert width >= 5 or n < 10
