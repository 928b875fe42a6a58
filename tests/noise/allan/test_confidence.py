"""Degrees of freedom and intervals against simulation, identification against known noise."""

import numpy as np
import pytest

from mocap_metrology.common.hampel import hampel, taken_at_most
from mocap_metrology.noise.allan.confidence import allan_curve, equivalent_dof
from mocap_metrology.noise.allan.identification import noise_exponents
from mocap_metrology.noise.allan.variance import allan_variance
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
@pytest.mark.parametrize("alpha", [2, 0, -2])
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
    # White phase noise: differences of second order m frames apart have covariances 6, -4, 1
    assert equivalent_dof(2, m, n - 1) == pytest.approx((n - 2 * m) * 36 / 70, rel=0.01)
    assert equivalent_dof(0, m, n - 1) == pytest.approx(white, rel=0.02)
    assert equivalent_dof(-1, m, n - 1) == pytest.approx(flicker, rel=0.06)
    assert equivalent_dof(-2, m, n - 1) == pytest.approx(walk, rel=0.08)


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
    if alpha < 1:
        series[[*range(2000, 2500), *range(7000, 30_000, 97)]] = np.nan
        np.testing.assert_array_equal(noise_exponents(series, m, estimator), alpha)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("estimator", ["oadev", "hdev", "mdev"])
def test_a_parabola_without_noise_has_exponents(estimator) -> None:
    """Of its second differences only rounding is left, of a lag-1 autocorrelation of -1."""
    series, m = np.round((np.arange(3000) / 3000) ** 2 + 100, 9), np.arange(40, 60)
    assert all(-4 <= noise_exponents(series, m[[k]], estimator)[0] <= 2 for k in range(m.size))


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
