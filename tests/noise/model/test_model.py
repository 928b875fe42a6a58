"""The noise model against integrals of its spectra, exact sums, textbook limits and S Table 1."""

import csv
import math

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.model.components import ALPHAS, FORMS, GaussMarkov, NoiseModel, PowerLaw
from mocap_metrology.noise.model.scale_factors import (
    MU,
    integrated_avar,
    mean_and_error,
    printed_scale,
    simulated_avar,
    slope_and_error,
    slope_weights,
)
from tests.noise.model.textbook import density

RATE = 120.0
TAU0 = 1 / RATE
M = np.array([1, 2, 3, 5, 10, 37, 100, 1000])
LAWS = [PowerLaw(alpha, 1.0) for alpha in (-2, -1, 0, 1, 2)]
TERMS = [GaussMarkov(1.0, T_c) for T_c in (1e-4, 0.002, 0.0083, 0.0084, 0.3, 10.0, 2000.0)]
FOLDED = [*LAWS[:1], *TERMS]  # by points; other laws end at half of the frame rate


def lag_sum(alpha: int, m: int) -> float:
    """Exact AVAR of f^alpha band-limited at Nyquist, tau0 = 1: 2/m^2 sum of c_k R(k) over |k| < 2m,
    R the autocovariance (Cin for flicker), sin^4(m x)/sin^2(x) = sum of c_k cos(2 k x)."""
    from scipy.special import sici

    k = np.arange(1.0, 2 * m + 1)
    c = np.where(k <= m, m / 2 - 0.75 * k, -(2 * m - k) / 4)
    if alpha == -1:
        r0, r = 0.0, -(np.euler_gamma + np.log(np.pi * k) - sici(np.pi * k)[1])
    elif alpha == 1:
        r0, r = 1 / 8, np.where(k % 2 == 1, -2.0, 0.0) / (2 * np.pi * k) ** 2
    else:
        r0, r = 1 / 24, np.where(k % 2 == 1, -1.0, 1.0) / (2 * np.pi * k) ** 2
    return 2 / m**2 * (m / 2 * r0 + 2 * math.fsum(c * r))


@pytest.mark.parametrize("alpha", [-1, 1, 2])
def test_band_limited_noise_against_the_exact_sum_over_lags(alpha):
    m = [1, 2, 3, 7, 63, 64, 65, 66, 100, 1001, 20_000, 1_300_000]
    exact = [lag_sum(alpha, k) for k in m]
    assert PowerLaw(alpha, 1.0).avar(m, 1.0) == pytest.approx(exact, rel=2e-7)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("part", LAWS + TERMS, ids=str)
def test_allan_variance_is_the_integral_over_the_spectrum(part, form):
    """2 Int S(f) sin^4(pi f m tau0) / (m sin(pi f tau0))^2 df by Gauss-Legendre."""
    x, w = np.polynomial.legendre.leggauss(20)
    for m in M:
        edges = [0.0, *np.geomspace(1e-9, 1e-3, 60), *np.linspace(1e-3, 0.5, 4 * m + 40)[1:]]
        half = np.diff(edges)[:, None] / 2
        u = np.array(edges[:-1])[:, None] + half * (1 + x)
        gain = np.sin(np.pi * u * m) ** 4 / (m * np.sin(np.pi * u)) ** 2
        found = 2 * np.sum(part.psd(u / TAU0, RATE, form=form) * gain * half * w) / TAU0
        assert found == pytest.approx(part.avar(m, RATE, form), rel=2e-8)


@pytest.mark.parametrize(
    ("part", "form"),
    [(part, "sampled") for part in FOLDED] + [(p, "continuous") for p in LAWS[:3] + TERMS],
    ids=str,
)
def test_spectrum_is_the_folded_sum_of_what_points_and_averages_leave(part, form):
    f = np.array([1e-4, 0.3, 12.0, 41.0, 60.0])
    seen = np.abs(f + np.arange(-40_000, 40_001)[:, None] * RATE)
    power = density(part, seen) * (np.sinc(seen * TAU0) ** 2 if form == "continuous" else 1)
    expected = power.sum(axis=0)
    if form == "sampled":  # beyond the last alias the density falls as 1/f^2
        last = 40_000.5 * RATE
        expected += 2 * last / RATE * density(part, np.array(last))
    assert part.psd(f, RATE, form=form) == pytest.approx(expected, rel=2e-5)


@pytest.mark.parametrize("T_c", [1e-5, 0.01, 1.0, 300.0, 2000.0, 1e7])
def test_gauss_markov_keeps_its_digits(T_c):
    part = GaussMarkov(0.02, T_c)
    # half the variance of a first difference
    assert part.avar(1, RATE) == pytest.approx(part.variance * -math.expm1(-TAU0 / T_c), rel=1e-12)
    # over the whole range the two branches of the series join smoothly and never go negative
    m = np.unique(np.geomspace(1, 1.3e6, 400).astype(int))
    assert np.all(part.avar(m, RATE) > 0) and np.all(part.avar(m, RATE, "continuous") > 0)


def test_gauss_markov_landmarks():
    point = GaussMarkov(0.02, 0.01)
    # point samples of T_c = 10 ms: 1.82 times the textbook form at one frame, 1.06 for ever
    ratio = point.avar([1, 100_000], RATE) / point.avar([1, 100_000], RATE, "continuous")
    assert ratio == pytest.approx([1.82, 1.06], abs=0.005)
    # peak of the textbook form: 0.4365 q_c sqrt(T_c) at 1.893 T_c
    peak = math.sqrt(GaussMarkov(1.0, 1.0).avar(1, 1 / 1.893, "continuous"))
    assert peak == pytest.approx(0.4365, abs=1e-4)


def test_continuous_forms_are_table_1_of_the_paper(reference):
    path = reference / "powerlaw_table1.csv"
    with path.open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    tau = np.array([1, 7, 300]) * TAU0
    names = {"pi": np.pi, "ln": np.log, "tau": tau, "f_h": 60.0}
    for row in rows:
        text = row["formula"].replace("^", "**").replace(row["coefficient"], "2.5")
        published = eval(text, {"__builtins__": {}}, names) * np.ones(3)
        found = PowerLaw(int(row["alpha"]), 2.5).avar([1, 7, 300], RATE, "continuous")
        assert found == pytest.approx(published, rel=2e-4)  # 1.038 is printed with 4 digits


def test_sampled_forms_tend_to_known_multiples_of_the_textbook_ones():
    m = np.array([1_000_000])
    for alpha, ratio in ((-2, 1.0), (-1, 1.0), (0, 1.0), (2, 2 * math.log(2))):
        part = PowerLaw(alpha, 1.0)
        assert part.avar(m, 1.0) / part.avar(m, 1.0, "continuous") == pytest.approx(ratio, rel=1e-6)
    blue = PowerLaw(1, 1.0)
    extra = (blue.avar(m, 1.0) - blue.avar(m, 1.0, "continuous")) * 4 * np.pi**2 * m**2
    assert extra == pytest.approx(1.645, abs=1e-3)


def test_sum_coefficients_scale_and_order():
    named = {"h_-2": 1e-9, "h_0": 1e-6, "q_c1": 0.01, "T_c1": 6.0, "q_c2": 0.02, "T_c2": 0.1}
    named |= {"A_s": 1e-3, "f_0": 14.4}
    model = NoiseModel.from_coefficients(named)
    assert model.coefficients() == named
    assert model.ordered().coefficients()["T_c1"] == 0.1
    m = np.array([[1, 10], [100, 1000]])
    assert model.avar(m, RATE) == pytest.approx(sum(c.avar(m, RATE) for c in model.components))
    assert model.scaled(3).avar(m, RATE) == pytest.approx(9 * model.avar(m, RATE))
    f = np.array([0.1, 60.0])
    assert model.psd(f, RATE) == pytest.approx(sum(c.psd(f, RATE) for c in model.broadband))
    assert NoiseModel().avar(m, RATE) == pytest.approx(0)
    assert NoiseModel.from_coefficients({"h_2": 0.0}).psd(f, RATE) == pytest.approx(0)


@pytest.mark.parametrize(
    ("coefficients", "words"),
    [
        ({"h_3": 1.0}, "'h_3', expected h_-2 ... h_2"),
        ({"q_c1": 1.0}, "T_c1"),
        ({"A_s": 1.0}, "f_0"),
        ({"h_0": -1.0}, "h_0 = -1.0, expected a number >= 0"),
        ({"h_0": float("nan")}, "h_0 = nan"),
        ({"h_0": "1"}, "h_0: '1', expected a number"),
        ({"q_c1": 1.0, "T_c1": 0.0}, "T_c = 0.0, expected a number > 0"),
    ],
)
def test_coefficients_that_make_no_model_are_refused(coefficients, words):
    with pytest.raises(Refusal) as refusal:
        NoiseModel.from_coefficients(coefficients)
    assert words in str(refusal.value)


F_H = RATE / 2


@pytest.mark.parametrize("alpha", [-2, -1, 0])
@pytest.mark.parametrize("tau", [0.003, 1.0, 700.0])
def test_unlimited_integral_is_the_printed_formula(alpha: int, tau: float) -> None:
    value, bound = integrated_avar(alpha, tau, math.inf)
    printed = printed_scale(alpha, tau, F_H) * tau ** MU[alpha]
    assert abs(value - printed) < max(bound, 1e-12 * printed)
    assert bound < 1e-9 * printed


def test_limited_integral_is_the_printed_formula_of_blue_and_violet() -> None:
    """For f_h tau >> 1, and to the digits that are printed: 1.038 stands for 3 gamma - ln 2."""
    tau = 1000 / F_H
    blue, _ = integrated_avar(1, tau, F_H)
    constant = 4 * math.pi**2 * tau**2 * blue - 3 * math.log(2 * math.pi * F_H * tau)
    assert constant == pytest.approx(3 * np.euler_gamma - math.log(2), abs=1e-6)
    assert round(constant, 3) == pytest.approx(1.038, abs=0.0011)
    violet, _ = integrated_avar(2, tau, F_H)
    assert violet == pytest.approx(printed_scale(2, tau, F_H) / tau**2, rel=1e-9)


@pytest.mark.parametrize("alpha", ALPHAS)
def test_integral_over_whole_and_broken_periods_agrees_with_a_fine_sum(alpha: int) -> None:
    for tau in (2.3 / F_H, 7 / F_H):
        f = (np.arange(400_000) + 0.5) * F_H / 400_000
        x = math.pi * f * tau
        total = 2 * np.sum(f ** float(alpha) * np.sin(x) ** 4 / x**2) * F_H / f.size
        assert integrated_avar(alpha, tau, F_H)[0] == pytest.approx(total, rel=1e-6)


@pytest.mark.parametrize("alpha", ALPHAS)
def test_simulated_averages_have_the_integral(alpha: int) -> None:
    """At one sample too, where point samples are up to 1.8 times off."""
    m = np.array([1, 5, 60])
    rng = np.random.default_rng(10 + alpha)
    found = simulated_avar(alpha, m, 1 << 13, RATE, 80, rng)
    mean, error = mean_and_error(found)
    exact = np.array([integrated_avar(alpha, float(t), F_H)[0] for t in m * TAU0])
    assert np.all(np.abs(mean - exact) < 3.5 * error)
    assert np.all(error < 0.03 * exact)
    weights = slope_weights(m * TAU0)
    slope, of_slope = slope_and_error(m * TAU0, found)
    assert abs(slope - weights @ np.log(exact)) < 3.5 * of_slope < 0.05
    without = [slope_and_error(m * TAU0, np.delete(found, k, axis=0))[0] for k in range(len(found))]
    assert of_slope == pytest.approx(math.sqrt(len(found) - 1) * np.std(without), rel=0.05)
