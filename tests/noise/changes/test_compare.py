"""Ratios, trends and coherences against scipy, rules written out, and Monte Carlo."""

import math

import numpy as np
import pytest
from scipy import signal, stats
from scipy.special import digamma, polygamma

from mocap_metrology.noise.allan.confidence import allan_curve
from mocap_metrology.noise.allan.variance import averaging_factors
from mocap_metrology.noise.changes.compare import (
    Curve,
    adev_ratio,
    adev_trend,
    coherence,
    ratios_to_mean,
    words_of,
)
from mocap_metrology.noise.changes.rows import curve_of, dated_curves, ratio_curves

RATE, ONE = 100.0, np.array([1.0])
TAUS = np.array([0.01, 0.1, 1.0, 10.0])
Rng = np.random.Generator


def curve(series: np.ndarray) -> Curve:
    found = allan_curve(series, RATE, averaging_factors(series.size, 40))
    return Curve(found.tau_s, found.deviation, found.edf)


def white(rng: Rng, n: int = 6000) -> np.ndarray:
    return rng.standard_normal(n)


def walk(rng: Rng, n: int = 6000) -> np.ndarray:
    return np.cumsum(rng.standard_normal(n))


@pytest.mark.parametrize("noise", [white, walk])
def test_intervals_hold_the_true_ratio(noise) -> None:
    """300 pairs: 95 % intervals hold in 92 to 98 %, three standard errors of the count; of equal
    noise, without a margin, 5 % at most are called changed at 5 % (and three standard errors)."""
    rng, held, called = np.random.default_rng(1), np.zeros(TAUS.size), 0
    for _ in range(300):
        new, old = curve(noise(rng)), curve(noise(rng))
        ratio = adev_ratio(Curve(new.tau_s, 1.3 * new.adev, new.edf), old, TAUS)
        held += (ratio.lower < 1.3) & (ratio.upper > 1.3)
        called += set(words_of(adev_ratio(new, old, TAUS), 0.0, 0.05)) != {"same"}
    assert np.all(held / 300 > 0.95 - 3.2 * math.sqrt(0.95 * 0.05 / 300)), held
    assert np.all(held / 300 < 0.985), held
    assert called / 300 < 0.05 + 3 * math.sqrt(0.05 * 0.95 / 300)


def with_knocks(rng: Rng, n: int = 9000) -> np.ndarray:
    """White noise of 1, and about three knocks of 2 s, of which none is like another."""
    series = rng.standard_normal(n)
    for start in rng.integers(0, n - 20, rng.poisson(3.0)):
        series[start : start + 20] += 5.0 * math.exp(rng.normal()) * rng.standard_normal(20)
    return series


def with_shifts(rng: Rng, n: int = 9000) -> np.ndarray:
    """White noise of 1, and about two shifts of 5 to 40 s."""
    series = rng.standard_normal(n)
    for start in rng.integers(0, n - 400, rng.poisson(2.0)):
        series[start : start + rng.integers(50, 400)] += 3.0 * rng.normal()
    return series


@pytest.mark.parametrize("noise", [with_knocks, with_shifts])
def test_what_comes_a_few_times_is_no_change(noise) -> None:
    """15 min at 10 Hz, and of every other pair an hour beside it: chance decides on the number of
    knocks. 60 pairs at 1 %: 3 at most (p 0.003 of more); 1.3 times all of it is found. Of the
    recordings beside their mean (Fisher's intervals: 78 and 67 %), too."""
    rng, taus, called, missed = np.random.default_rng(4), np.array([0.1, 1.0, 10.0, 100.0]), 0, 0
    others: list[Curve] = []

    def scattered(series: np.ndarray) -> Curve:
        found = allan_curve(series, 10.0, averaging_factors(series.size, 40)).as_scattered(series)
        return Curve(found.tau_s, found.deviation, found.edf, found.stretches)

    for k in range(60):
        series, other = noise(rng, 9000 * (1 + 3 * (k % 2))), scattered(noise(rng))
        others.append(other)
        words = words_of(adev_ratio(scattered(series), other, taus), 0.05, 0.01)
        called += bool({"better", "worse"} & set(words))
        worse = adev_ratio(scattered(1.3 * series), other, taus)
        missed += "worse" not in words_of(worse, 0.05, 0.01)
    assert called <= 3 and missed <= (36 if noise is with_knocks else 0), (called, missed)
    ratios = [r for k in range(0, 60, 4) for r in ratios_to_mean(others[k : k + 4], taus[1:3])]
    held = [(r.lower < 1) & (r.upper > 1) for r in ratios]
    assert np.mean(held) > 0.85, np.mean(held)


@pytest.mark.parametrize("s", [2.0, 0.5])
def test_ratio_is_fishers(s: float) -> None:
    """One tau, by scipy's F distribution. The mean of F does not exist below two degrees of
    freedom: there is no ratio."""
    ratio = adev_ratio(Curve(ONE, s * ONE, 7 * ONE), Curve(ONE, ONE, 11 * ONE), ONE, 0.9)
    f = stats.f(7, 11)
    assert ratio.value[0] == pytest.approx(s)
    assert ratio.lower[0] == pytest.approx(s / math.sqrt(f.ppf(0.95)))
    assert ratio.upper[0] == pytest.approx(s / math.sqrt(f.ppf(0.05)))
    assert ratio.p[0] == pytest.approx(2 * min(f.sf(s**2), f.cdf(s**2)))
    tau = np.array([1.0, 2.0, 3.0])
    few, many = (Curve(tau, np.ones(3), np.array([40, 2, last])) for last in (1.9, 50))
    for ratio in (adev_ratio(few, many, tau), adev_ratio(many, few, tau)):
        assert np.isfinite(ratio.value).tolist() == [True, True, False]


def test_curves_are_lines_in_logarithms() -> None:
    """Up to 1 % beyond their ends; of one alone, and of none, too."""
    found = Curve(np.array([1.0, 100.0]), np.array([4.0, 1.0]), np.array([9.0, 100.0]))
    at = found.at(np.array([0.98, 0.992, 10.0, 100.9, 102.0]))
    np.testing.assert_allclose(at.adev, [math.nan, 4.0, 2.0, 1.0, math.nan])
    np.testing.assert_allclose(at.edf, [math.nan, 9.0, 30.0, 100.0, math.nan])
    assert np.isnan(Curve(ONE, ONE, ONE).at(np.array([2.0])).adev).all()
    assert np.isnan(Curve(ONE, 0 * ONE, 9 * ONE).usable().at(ONE).adev).all()


@pytest.mark.parametrize("noisy", [0.0, 1.0])
def test_trend_is_weighted_least_squares(noisy: float) -> None:
    """Of ln s, put right by the mean of ln chi-squared, with the weights 4 / trigamma(edf/2);
    errors times the scatter about the line where that exceeds 1; Student's t."""
    rng, days = np.random.default_rng(4), np.array([0, 20, 61, 95, 130, 180.0])
    edf = np.array([50, 60, 40, 80, 5, 60.0])
    adev = 1.03 ** (days / 30.4375) * np.exp(noisy * rng.standard_normal(6))
    y = np.log(adev) + (np.log(edf / 2) - digamma(edf / 2)) / 2
    root = np.sqrt(4 / polygamma(1, edf / 2))
    (slope, level), covariance = np.polyfit(days / 30.4375, y, 1, w=root, cov="unscaled")
    rest = root * (y - level - slope * days / 30.4375)
    scatter = math.sqrt(rest @ rest / 4)
    error = math.sqrt(covariance[0, 0]) * max(scatter, 1)
    reach = stats.t.ppf(0.95, 4) * error
    found = adev_trend(days, adev, edf, 0.9)
    assert [found.per_month, found.lower, found.upper] == pytest.approx(
        np.exp([slope, slope - reach, slope + reach])
    )
    assert found.p == pytest.approx(2 * stats.t.sf(abs(slope) / error, 4))
    assert (found.n, found.scatter) == (6, pytest.approx(scatter))


def test_trends_by_monte_carlo() -> None:
    """3 % a month, 30 % from day to day: 95 % intervals hold in 93.5 to 97.5 % of 1000. Recordings
    of 3 degrees of freedom, then of 30, of one system: the mean slope is zero (four standard
    errors; +0.7 % a month if ln s were taken as it is)."""
    rng, held, slopes = np.random.default_rng(4), 0, []
    days, edf = np.array([0, 20, 61, 95, 130, 180.0]), np.array([50, 60, 40, 80, 50, 60.0])
    months, few = 30.4375 * np.arange(20), np.repeat([3.0, 30.0], 10)
    for _ in range(1000):
        own = np.exp(0.3 * rng.standard_normal(6)) * np.sqrt(rng.chisquare(edf) / edf)
        trend = adev_trend(days, 1.03 ** (days / 30.4375) * own, edf, 0.95)
        held += trend.lower < 1.03 < trend.upper
        same = adev_trend(months, np.sqrt(rng.chisquare(few) / few), few, 0.95)
        slopes.append(math.log(same.per_month))
    assert 0.935 <= held / 1000 <= 0.975
    assert abs(np.mean(slopes)) < 4 * np.std(slopes) / math.sqrt(1000)


def test_ratio_to_the_mean_of_two_is_the_root_of_their_ratio() -> None:
    """Closed form; and a place that does not reach a tau does not count there."""
    tau = np.array([1.0, 10.0])
    a = Curve(tau, np.array([2.0, 3.0]), np.array([7.0, 5.0]))
    b = Curve(tau[:1], np.array([1.0]), np.array([11.0]))
    both, between = ratios_to_mean([a, b], tau), adev_ratio(a, b, tau)
    for name in ("value", "lower", "upper"):
        expected = np.sqrt(getattr(between, name))
        np.testing.assert_allclose(getattr(both[0], name), expected, rtol=1e-6)
    np.testing.assert_allclose(both[0].value * both[1].value, [1, np.nan])
    three = ratios_to_mean([a, b, Curve(tau, np.array([4.0, 6.0]), np.array([9.0, 9.0]))], tau)
    assert [r.value[0] for r in three] == pytest.approx([1, 0.5, 2])
    assert [r.value[1] for r in three] == pytest.approx([0.5**0.5, np.nan, 2**0.5], nan_ok=True)


@pytest.mark.parametrize("n", [36, 51, 60, 361])
def test_coherence_is_that_of_scipy(n: int) -> None:
    """Of eight or more Hann windows of an even length that overlap by half, less a straight line;
    independent windows by Welch 1967, of the lowest frequency 1.3 fewer; thresholds by Carter 1987
    and Bonferroni. y is 3 x of three samples before: gain 3, lag three steps."""
    rng = np.random.default_rng(n)
    y, x = rng.standard_normal((2, n))
    found = coherence(y, x, 2.0, 0.05)
    length = 2 * n // 9 // 2 * 2
    f, squared = signal.coherence(x, y, 0.5, nperseg=length, detrend="linear")
    keep = slice(1, length // 2)
    np.testing.assert_allclose(found.f_hz, f[keep])
    np.testing.assert_allclose(found.squared, squared[keep])
    windows = len(range(0, n - length + 1, length // 2))
    independent = windows / (1 + 2 * (1 / 6) ** 2 * (windows - 1) / windows)
    count = np.array([independent - 1.3] + [independent] * (found.f_hz.size - 1))
    expected = (1 - found.threshold) ** (count - 1) * found.f_hz.size
    np.testing.assert_allclose(expected, 0.05)
    long = rng.standard_normal(4003)
    found = coherence(3 * long[:-3], long[3:], 1.0)
    middle = slice(5, 40)
    np.testing.assert_allclose(found.gain[middle], 3, rtol=0.1)
    behind = found.phase_rad[middle] / (2 * np.pi * found.f_hz[middle])
    np.testing.assert_allclose(behind, 3, atol=0.2)


def columns(adev_mm: np.ndarray, edf: np.ndarray, name: str = "x1") -> dict[str, np.ndarray]:
    """Of two series, the other 0.1 mm throughout; mdev is left alone."""
    n = adev_mm.size
    return {
        "series": np.repeat([name, name, "L"], n),
        "estimator": np.repeat(["oadev", "mdev", "oadev"], n),
        "tau_s": np.tile(np.geomspace(0.01, 1.0, n), 3),
        "adev_mm": np.concatenate([adev_mm, 9 + 0 * adev_mm, 0.1 + 0 * adev_mm]),
        "edf": np.tile(edf, 3).astype(float),
    }


def test_dated_curves_are_in_um_with_intervals_of_chi_squared() -> None:
    taus = np.array([0.01, 0.1, 1.0, 10.0])
    allan = {
        "a": columns(np.full(9, 0.02), np.full(9, 40)),
        "b": columns(np.full(9, 0.03), np.full(9, 20)),
    }
    found = dated_curves(["a", "b"], ["2026-01-02", "2026-02-02"], allan, ["x1", "L"], taus, 0.9)
    assert found["tau_s"].tolist() == [0.01, 0.1, 1.0] * 4
    own = found[found["series"] == "x1"]
    assert own["adev"].tolist() == pytest.approx([20.0] * 3 + [30.0] * 3)
    assert [d.month for d in own["date"]] == [1] * 3 + [2] * 3
    for rows, edf in ((own[:3], 40), (own[3:], 20)):
        for end, q in (("lower", 0.95), ("upper", 0.05)):
            expected = rows["adev"] * math.sqrt(edf / stats.chi2.ppf(q, edf))
            assert rows[end].tolist() == pytest.approx(expected.tolist())


def test_curves_of_ratios_over_the_times_that_both_reach() -> None:
    new, old = (columns(adev * np.ones(9), 40 * np.ones(9)) for adev in (0.03, 0.02))
    old["tau_s"] = 3 * old["tau_s"]
    found = ratio_curves(new, old, 0.9)
    assert set(found["series"]) == {"x1", "L"}
    own = found[found["series"] == "x1"]
    assert (own["tau_s"].min(), own["tau_s"].max()) == pytest.approx((0.03, 1.0))
    assert len(own) == 60
    expected = adev_ratio(curve_of(new, "x1"), curve_of(old, "x1"), own["tau_s"].to_numpy(), 0.9)
    assert own["value"].tolist() == pytest.approx(expected.value.tolist())
    assert own["value"].median() == pytest.approx(1.5, rel=0.05)
    old["tau_s"] = 200 * old["tau_s"]
    assert ratio_curves(new, old, 0.9).empty
