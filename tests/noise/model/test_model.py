"""The noise model against series made by direct recipes, exact sums and textbook limits."""

import csv
import math

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.model.components import GaussMarkov, NoiseModel, PowerLaw, Sinusoid
from mocap_metrology.noise.model.curves import sinusoid_avar
from mocap_metrology.noise.model.synthesis import Cross, draw_pair
from tests.noise.model.textbook import allan_variance, density

RATE = 120.0
TAU0 = 1 / RATE
M = np.array([1, 2, 5, 30, 200, 1000])
LENGTH = 1 << 20


def white(rng):
    return rng.normal(0, math.sqrt(3.0 / (2 * TAU0)), LENGTH)


def random_walk(rng):
    return np.cumsum(rng.normal(0, math.sqrt(2 * np.pi**2 * TAU0 * 3.0), LENGTH))


def gauss_markov(T_c):
    def recipe(rng):
        from scipy.signal import lfilter

        phi, sigma = math.exp(-TAU0 / T_c), math.sqrt(0.2**2 * T_c / 2)
        drive = rng.normal(0, sigma * math.sqrt(1 - phi**2), LENGTH)
        return lfilter([1], [1, -phi], drive, zi=[phi * rng.normal(0, sigma)])[0]

    return recipe


def sinusoid(rng):
    return 0.7 * np.sin(2 * np.pi * 13.7 * TAU0 * np.arange(LENGTH) + rng.uniform(0, 6))


def shaped(alpha):
    def recipe(rng):  # stationary series, every bin of white noise weighted by f^(alpha/2)
        from scipy.fft import irfft, rfft

        bins = rfft(rng.normal(0, math.sqrt(3.0 / (2 * TAU0)), LENGTH))
        f = np.fft.rfftfreq(LENGTH, TAU0)
        f[0] = f[1]
        return irfft(bins * f ** (alpha / 2))

    return recipe


RECIPES = [
    (PowerLaw(-2, 3.0), random_walk),
    (PowerLaw(-1, 3.0), shaped(-1)),
    (PowerLaw(0, 3.0), white),
    (PowerLaw(1, 3.0), shaped(1)),
    (PowerLaw(2, 3.0), shaped(2)),
    (GaussMarkov(0.2, 0.004), gauss_markov(0.004)),
    (GaussMarkov(0.2, 0.01), gauss_markov(0.01)),
    (GaussMarkov(0.2, 2.0), gauss_markov(2.0)),
    (Sinusoid(0.7, 13.7), sinusoid),
]
NAMES = [f"{c}" for c, _ in RECIPES]


BROADBAND = [c for c, _ in RECIPES if not isinstance(c, Sinusoid)]


def mean_ratio(component, series):
    found = np.mean([[allan_variance(y, m) for m in M] for y in series], axis=0)
    return found / component.avar(M, RATE)


def simulated(component, runs):
    """Pairs of independent series of the project's simulator."""
    model, rng = NoiseModel((component,)), np.random.default_rng(21)
    for _ in range(runs // 2):
        yield from draw_pair(model, model, Cross(), LENGTH, RATE, rng)


@pytest.mark.parametrize(("component", "recipe"), RECIPES, ids=NAMES)
def test_sampled_allan_variance_of_a_directly_made_series(component, recipe):
    ratio = mean_ratio(component, [recipe(np.random.default_rng(20))])
    # 2 %, or four standard errors of a million frames: 12 % at m = 1000
    assert np.all(np.abs(ratio - 1) < np.maximum(0.02, 4 * np.sqrt(M / LENGTH)))


@pytest.mark.study
@pytest.mark.parametrize(("component", "recipe"), RECIPES, ids=NAMES)
def test_sampled_allan_variance_within_2_percent_up_to_m_1000(component, recipe):
    rng = np.random.default_rng(20)  # 17 million frames: standard error at m = 1000 about 1 %
    assert mean_ratio(component, (recipe(rng) for _ in range(16))) == pytest.approx(1, abs=0.02)


@pytest.mark.study
@pytest.mark.parametrize("component", BROADBAND, ids=str)
def test_simulated_allan_variance_within_2_percent_up_to_m_1000(component):
    assert mean_ratio(component, simulated(component, 16)) == pytest.approx(1, abs=0.02)


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


@pytest.mark.parametrize(
    "component",
    [PowerLaw(-2, 2.0), PowerLaw(0, 2.0), *(GaussMarkov(0.3, T) for T in (0.002, 0.01, 0.3, 20))],
    ids=str,
)
def test_closed_form_is_the_integral_of_the_sampled_spectrum(component):
    # midpoint sums of a periodic integrand converge exponentially; 20 s is 2400 frames
    u = (np.arange(200_000) + 0.5) / 400_000
    density = component.psd(u / TAU0, RATE)
    for m in (1, 2, 10, 300, 1000):
        gain = np.sin(np.pi * u * m) ** 4 / (m * np.sin(np.pi * u)) ** 2
        integral = 2 * (density @ gain) / (400_000 * TAU0)
        assert component.avar(m, RATE) == pytest.approx(integral, rel=1e-9)


@pytest.mark.parametrize("T_c", [0.001, 0.01, 0.3, 10])
def test_spectrum_integrates_to_the_variance_and_is_the_folded_one(T_c):
    part = GaussMarkov(0.3, T_c)
    u = (np.arange(100_000) + 0.5) / 200_000
    assert part.psd(u / TAU0, RATE).sum() / (200_000 * TAU0) == pytest.approx(part.variance)
    f = np.array([0.01, 1.0, 25.0, 60.0])
    aliases = np.arange(-20_000, 20_001)[:, None] * 120.0
    # what lies beyond the last alias falls as 1/f^2
    rest = 2 * 2 * part.q_c**2 / (2 * np.pi) ** 2 / (120 * 20_000.5 * 120)
    folded = density(part, f + aliases).sum(0) + rest
    assert part.psd(f, RATE) == pytest.approx(folded, rel=1e-6)


def test_white_integrates_to_its_variance_and_random_walk_is_folded():
    f = (np.arange(1000) + 0.5) * 0.06
    assert PowerLaw(0, 3.0).psd(f, RATE).sum() * 0.06 == pytest.approx(3.0 / (2 * TAU0))
    f, aliases = f[::40], np.arange(-20_000, 20_001)[:, None] * 120.0
    rest = 2 / (120 * 20_000.5 * 120)
    folded = (1 / (f + aliases) ** 2).sum(0) + rest
    assert PowerLaw(-2, 1.0).psd(f, RATE) == pytest.approx(folded, rel=1e-9)


@pytest.mark.parametrize("T_c", [1e-5, 0.01, 1.0, 300.0, 2000.0, 1e7])
def test_gauss_markov_keeps_its_digits(T_c):
    part = GaussMarkov(0.02, T_c)
    # half the variance of a first difference
    assert part.avar(1, RATE) == pytest.approx(part.variance * -math.expm1(-TAU0 / T_c), rel=1e-12)
    # over the whole range the two branches of the series join smoothly and never go negative
    m = np.unique(np.geomspace(1, 1.3e6, 400).astype(int))
    assert np.all(part.avar(m, RATE) > 0) and np.all(part.avar(m, RATE, "continuous") > 0)


def test_gauss_markov_limits():
    m = np.array([1, 10, 100])
    walk = PowerLaw(-2, 0.02**2 / (2 * np.pi**2))
    slow = GaussMarkov(0.02, 1e6)
    for form in ("sampled", "continuous"):
        assert slow.avar(m, RATE, form) == pytest.approx(walk.avar(m, RATE, form), rel=1e-5)
    fast = GaussMarkov(0.02, 1e-5)
    assert fast.avar(m, RATE) == pytest.approx(fast.variance / m)
    long = np.array([100_000])
    plateau = PowerLaw(0, 2 * (0.02 * 0.01) ** 2)
    point = GaussMarkov(0.02, 0.01)
    assert point.avar(long, RATE, "continuous") == pytest.approx(plateau.avar(long, RATE), rel=1e-4)
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


def test_sinusoid_slow_line_and_zero():
    slow = Sinusoid(2.0, 1e-4)
    for form in ("sampled", "continuous"):
        assert slow.avar(5, RATE, form) == pytest.approx((2e-4 * np.pi * 5 * TAU0 * 2) ** 2 / 4)
    assert Sinusoid(1.0, 12.0).avar(10, RATE) == pytest.approx(0, abs=1e-25)
    assert Sinusoid(1.0, 120.0).avar(3, RATE) == 0


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


@pytest.mark.parametrize("form", ["sampled", "continuous"])
@pytest.mark.parametrize("f_0", [0.7, 14.4, 59.0])
def test_the_envelope_of_a_sinusoid_touches_its_allan_variance(f_0: float, form: str) -> None:
    """Beyond six periods: nowhere below it, and within 1 % of its greatest values, which lie at odd
    multiples of half a period. Below six periods it is the Allan variance itself."""
    line, m = Sinusoid(0.02, f_0), np.arange(1, 40_000)
    exact, drawn = line.avar(m, RATE, form), sinusoid_avar(line, m, RATE, form)
    periods = m * f_0 / RATE
    assert np.array_equal(drawn[periods <= 6], exact[periods <= 6])
    far = periods > 6
    assert np.all(exact[far] <= drawn[far] * (1 + 1e-9))
    assert np.max(exact[far] / drawn[far]) == pytest.approx(1, abs=0.01)
