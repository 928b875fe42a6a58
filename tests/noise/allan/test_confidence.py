"""Degrees of freedom and intervals against simulation, identification against known noise."""

import numpy as np
import pytest

from mocap_metrology.common.hampel import hampel, taken_at_most
from mocap_metrology.noise.allan.confidence import allan_curve, equivalent_dof, interval
from mocap_metrology.noise.allan.identification import noise_exponents
from mocap_metrology.noise.allan.variance import allan_variance, averaging_factors
from mocap_metrology.noise.fit.estimators import NoiseSettings, masked_curve
from mocap_metrology.noise.model.components import NoiseModel, PowerLaw


def power_law(rng, n: int, alpha: int, runs: int | None = None) -> np.ndarray:
    """Noise with S(f) ~ f^alpha by fractional differencing of white noise [Kasdin 1995]."""
    k = np.arange(1, 2 * n)
    weights = np.cumprod(np.r_[1.0, (k - 1 - alpha / 2) / k])
    shape = (2 * n,) if runs is None else (runs, 2 * n)
    white = rng.normal(size=shape)
    if alpha == 0:
        return white[..., n:]
    if alpha == -2:
        return np.cumsum(white, axis=-1)[..., n:]
    size = 4 * n
    product = np.fft.rfft(white, size) * np.fft.rfft(weights, size)
    return np.fft.irfft(product, size)[..., n : 2 * n]


@pytest.mark.parametrize("estimator", ["oadev", "mdev", "hdev"])
@pytest.mark.parametrize("alpha", [2, 1, 0, -1, -2])
def test_dof_equals_that_of_simulation(alpha, estimator):
    """2 mean^2 / variance of 2000 runs within 10 %, 20 % for few degrees of freedom, whose
    distribution is wide (standard error 3 to 9 %). Greenhall & Riley are up to 30 % off."""
    rng = np.random.default_rng(20 + alpha)
    n, m = 1024, np.array([1, 2, 4, 16, 100, 250])
    series = power_law(rng, n, alpha, runs=2000)
    variances = np.array([allan_variance(s, m, estimator).variance for s in series])
    simulated = 2 * variances.mean(axis=0) ** 2 / variances.var(axis=0)
    stated = [equivalent_dof(alpha, int(k), n, estimator) for k in m]
    np.testing.assert_allclose(stated[:4], simulated[:4], rtol=0.1)
    np.testing.assert_allclose(stated[4:], simulated[4:], rtol=0.2)


def test_dof_agrees_with_greenhall_and_riley_at_long_tau():
    """Empirical formulas for n phase points [Riley, SP 1065, table 5], good to a few per cent."""
    n, m = 3_888_001, 10_000
    white = (3 * (n - 1) / (2 * m) - 2 * (n - 2) / n) * 4 * m**2 / (4 * m**2 + 5)
    flicker = 5 * n**2 / (4 * m * (n + 3 * m))
    walk = (n - 2) / m * ((n - 1) ** 2 - 3 * m * (n - 1) + 4 * m**2) / (n - 3) ** 2
    assert equivalent_dof(0, m, n - 1) == pytest.approx(white, rel=0.02)
    assert equivalent_dof(-1, m, n - 1) == pytest.approx(flicker, rel=0.06)
    assert equivalent_dof(-2, m, n - 1) == pytest.approx(walk, rel=0.08)


@pytest.mark.parametrize("estimator", ["oadev", "mdev", "hdev"])
@pytest.mark.parametrize("alpha", [2, 1, 0, -1, -2])
def test_dof_of_long_series_is_that_of_the_whole_sum(alpha, estimator):
    """The sum over a thousand lags stands for that over all, to 0.4 %."""
    for m, n in ((700, 20_000), (3000, 20_000), (5000, 200_000)):
        whole = equivalent_dof(alpha, m, n, estimator, max_terms=10**6)
        assert equivalent_dof(alpha, m, n, estimator) == pytest.approx(whole, rel=0.004)
        for more in (0, 4):  # than those that a term is correlated over
            most = m * (4 if estimator == "hdev" else 3) + more
            assert equivalent_dof(alpha, m, n, estimator, max_terms=most) == whole


@pytest.mark.parametrize("alpha", [0, -2])
def test_intervals_cover(alpha):
    """The 68.3 % interval covers the truth in 62-75 % of 600 runs at each tau, 95 % in 92-98 %:
    three standard errors, and one percent more for few degrees of freedom."""
    rng = np.random.default_rng(30 + alpha)
    n, m = 2000, np.array([1, 8, 64, 300])
    truth = np.sqrt(1 / m if alpha == 0 else (2 * m**2 + 1) / (6 * m))
    covered = {0.683: np.zeros(m.size), 0.95: np.zeros(m.size)}
    for series in power_law(rng, n, alpha, runs=600):
        for confidence, count in covered.items():
            curve = allan_curve(series, 1.0, m, confidence=confidence)
            count += (curve.lower <= truth) & (truth <= curve.upper)
    assert ((covered[0.683] / 600 >= 0.62) & (covered[0.683] / 600 <= 0.75)).all()
    assert ((covered[0.95] / 600 >= 0.92) & (covered[0.95] / 600 <= 0.98)).all()


def test_intervals_cover_under_gaps():
    """20 % missing at random: the 68.3 % interval covers the truth in 63 % of 400 runs or more, and
    no deviation is zero."""
    rng = np.random.default_rng(33)
    m = np.array([1, 10, 100, 400])
    covered, runs = np.zeros(m.size), np.zeros(m.size)
    for _ in range(400):
        series = rng.normal(size=2000)
        series[rng.random(2000) < 0.2] = np.nan
        curve = allan_curve(series, 1.0, m)
        place = np.searchsorted(m, curve.m)
        truth = 1 / np.sqrt(curve.m)
        covered[place] += (curve.lower <= truth) & (truth <= curve.upper)
        runs[place] += 1
        assert (curve.variance > 0).all()
    assert (covered / runs >= 0.63).all()
    assert (runs >= 380).all()


def test_interval_is_chi_squared():
    from scipy.stats import chi2

    lower, upper = interval(np.array([4.0]), np.array([7.5]), 0.9)
    assert lower[0] == pytest.approx(np.sqrt(4 * 7.5 / chi2.ppf(0.95, 7.5)))
    assert upper[0] == pytest.approx(np.sqrt(4 * 7.5 / chi2.ppf(0.05, 7.5)))


@pytest.mark.parametrize("estimator", ["oadev", "hdev"])
@pytest.mark.parametrize("alpha", [2, 1, 0, -1, -2])
def test_noise_is_identified(alpha, estimator):
    """At every tau with 100 window means or more; blue noise is told from white at the first alone,
    as the folded part of its window means is nearly white."""
    series = power_law(np.random.default_rng(40 + alpha), 30_000, alpha)
    m = np.array([1, 2, 5, 20, 100, 300])
    found = noise_exponents(series, m, estimator)
    if alpha == 1:
        assert found[0] == alpha
    else:
        np.testing.assert_array_equal(found, alpha)


def test_chance_makes_no_blue_noise_of_white():
    """600 series of 3000 samples: no exponent above 0, and on average over them the degrees of
    freedom that their scatter has, 2 mean^2 / variance, within 20 % (it is known to 7 %). When the
    exponent could rise with tau, one in 60 was called blue or violet, and they came out 34 % too
    many."""
    m = averaging_factors(3000, 12)
    curves = [
        allan_curve(np.random.default_rng([s, 4]).normal(size=3000), 1.0, m) for s in range(600)
    ]
    assert max(c.alpha.max() for c in curves) == 0
    variance = np.array([c.variance for c in curves])
    simulated = 2 * variance.mean(axis=0) ** 2 / variance.var(axis=0)
    given = np.mean([c.edf for c in curves], axis=0)
    np.testing.assert_allclose(given, simulated, rtol=0.2)


def test_exponent_departs_where_chance_does_not_explain_it():
    """Down to 40 window means: flicker noise is taken for another in at most 25 % of 300 series
    at any of 15 taus, and the walk that white noise ends in is found in 95 % or more."""
    m = averaging_factors(4000, 12, max_fraction=1 / 40)
    flicker = power_law(np.random.default_rng(9), 4000, -1, runs=300)
    assert np.mean([(noise_exponents(series, m) != -1).any() for series in flicker]) <= 0.25
    white, walk = np.random.default_rng(10).normal(size=(2, 300, 4000))
    found = [noise_exponents(s, m) for s in white + 0.1 * np.cumsum(walk, axis=1)]
    assert np.mean([(f[0], f[-1]) == (0, -2) for f in found]) >= 0.95


def test_intervals_of_a_cleaned_curve_know_what_the_filter_took() -> None:
    """White noise and a walk, cleaned as in S: the raised interval holds the truth at least as
    often as it says; without that, at few frames, never. Of the masked series it holds as it is."""
    rng, settings, tau0 = np.random.default_rng(5), NoiseSettings(), 1 / 120
    model = NoiseModel((PowerLaw(0, 2 * 0.02**2 * tau0), PowerLaw(-2, 1e-9)))
    held = {kind: [] for kind in ("masked", "cleaned", "raised")}
    for _ in range(12):
        n = 60_000
        steps = np.sqrt(2 * np.pi**2 * 1e-9 * tau0) * rng.normal(size=n)
        series = 0.02 * rng.normal(size=n) + np.cumsum(steps)
        _, masked = masked_curve(series, 120, settings)
        cleaned = allan_curve(hampel(series, 120, 3.0, "replace").values, 120.0, masked.m)
        raised = cleaned.with_upper_raised(taken_at_most(3.0, 120))
        truth = np.sqrt(model.avar(masked.m, 120))
        short = masked.m <= 10
        for kind, one in (("masked", masked), ("cleaned", cleaned), ("raised", raised)):
            held[kind] += ((one.lower <= truth) & (truth <= one.upper))[short].tolist()
    assert np.mean(held["cleaned"]) < 0.2
    assert np.mean(held["raised"]) > 0.683
    assert 0.5 < np.mean(held["masked"]) < 0.85
