"""Ratios, trends and coherences against what they must be by theory, by Monte Carlo."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.text.covariate import read_covariate
from mocap_metrology.noise.allan.confidence import allan_curve
from mocap_metrology.noise.allan.variance import averaging_factors
from mocap_metrology.noise.changes.compare import (
    Curve,
    adev_ratio,
    adev_trend,
    block_means,
    coherence,
    ratios_to_mean,
    words_of,
)
from mocap_metrology.noise.changes.covariate import Covariate, together

RATE = 100.0
TAUS = np.array([0.01, 0.1, 1.0, 10.0])


def curve(series: np.ndarray) -> Curve:
    found = allan_curve(series, RATE, averaging_factors(series.size, 40))
    return Curve(found.tau_s, found.deviation, found.edf)


def noise(kind: str, rng: np.random.Generator, n: int = 6000) -> np.ndarray:
    white = rng.standard_normal(n)
    return white if kind == "white" else np.cumsum(white)


@pytest.mark.parametrize("kind", ["white", "random walk"])
def test_intervals_hold_the_true_ratio(kind: str) -> None:
    """300 pairs: 95 % intervals hold in 92 to 98 %, three standard errors of the count."""
    rng = np.random.default_rng(1)
    held, pairs = np.zeros(TAUS.size), 300
    for _ in range(pairs):
        ratio = adev_ratio(curve(1.3 * noise(kind, rng)), curve(noise(kind, rng)), TAUS)
        held += (ratio.lower < 1.3) & (ratio.upper > 1.3)
    assert np.all(held / pairs > 0.95 - 3.2 * math.sqrt(0.95 * 0.05 / pairs)), held
    assert np.all(held / pairs < 0.985), held


def test_ratio_is_fishers() -> None:
    """One tau, by scipy's F distribution."""
    one = np.array([1.0])
    new, old = Curve(one, np.array([2.0]), np.array([7.0])), Curve(one, one, np.array([11.0]))
    ratio = adev_ratio(new, old, one, 0.9)
    f = stats.f(7, 11)
    assert ratio.value[0] == pytest.approx(2.0)
    assert ratio.lower[0] == pytest.approx(2 / math.sqrt(f.ppf(0.95)))
    assert ratio.upper[0] == pytest.approx(2 / math.sqrt(f.ppf(0.05)))
    assert ratio.p[0] == pytest.approx(2 * f.sf(4.0))


def test_a_variance_of_less_than_two_degrees_of_freedom_gives_no_ratio() -> None:
    """The mean of Fisher's F does not exist there."""
    tau = np.array([1.0, 2.0, 3.0])
    new = Curve(tau, np.ones(3), np.array([40.0, 2.0, 1.9]))
    for ratio in (
        adev_ratio(new, Curve(tau, np.ones(3), np.full(3, 50.0)), tau),
        adev_ratio(Curve(tau, np.ones(3), np.full(3, 50.0)), new, tau),
    ):
        assert np.isfinite(ratio.value).tolist() == [True, True, False]


def test_unchanged_series_are_rarely_called_changed() -> None:
    """alpha = 0.05 without a margin: at most 5 % of 400 pairs, plus three standard errors."""
    rng = np.random.default_rng(2)
    called = 0
    for _ in range(400):
        ratio = adev_ratio(curve(noise("white", rng)), curve(noise("white", rng)), TAUS)
        called += set(words_of(ratio, 0.0, 0.05)) != {"same"}
    assert called / 400 < 0.05 + 3 * math.sqrt(0.05 * 0.95 / 400)


def test_words_need_size_and_significance() -> None:
    rng = np.random.default_rng(3)
    old = curve(noise("white", rng, 60_000))
    words = {
        factor: words_of(
            adev_ratio(curve(factor * noise("white", rng, 60_000)), old, TAUS), 0.05, 0.01
        )
        for factor in (0.8, 0.98, 1.02, 1.2)
    }
    assert words[0.8][0] == words[0.8][1] == "better"
    assert words[1.2][0] == words[1.2][1] == "worse"
    assert words[0.98][0] == words[1.02][0] == "same"  # clear, and too small to matter
    short = [curve(1.2 * noise("white", rng)), curve(noise("white", rng))]
    assert words_of(adev_ratio(*short, TAUS), 0.05, 0.01)[3] == "same"  # large, and not clear
    assert words_of(adev_ratio(old, old, np.array([1e5])), 0.05, 0.01) == [""]


@pytest.mark.parametrize(("day_to_day", "most"), [(0.0, 1.0), (0.3, 0.975)])
def test_trend_of_known_slope(day_to_day: float, most: float) -> None:
    """ADEV grows by 3 % a month with chi-squared noise: 95 % intervals hold in 93.5 % of 1000 at
    least; more where nothing but the noise scatters, as scatter counts as 1 at least."""
    rng = np.random.default_rng(4)
    days = np.array([0, 20, 61, 95, 130, 180.0])
    edf = np.array([50, 60, 40, 80, 50, 60.0])
    truth = 1.03 ** (days / 30.4375)
    held = 0
    for _ in range(1000):
        own = np.exp(day_to_day * rng.standard_normal(days.size))
        trend = adev_trend(days, truth * own * np.sqrt(rng.chisquare(edf) / edf), edf)
        held += trend.lower < 1.03 < trend.upper
    assert 0.935 <= held / 1000 <= most
    assert adev_trend(days, truth, np.full(6, 50.0)).per_month == pytest.approx(1.03)
    with pytest.raises(Refusal, match="three or more"):
        adev_trend(days[:2], truth[:2], edf[:2])


def test_longer_recordings_are_not_worse() -> None:
    """Ten recordings of 3 degrees of freedom, then ten of 30, one system: the mean slope is zero
    (1000 simulations, four standard errors; +0.7 % a month if ln s were taken as it is)."""
    rng = np.random.default_rng(8)
    days, edf = 30.4375 * np.arange(20), np.repeat([3.0, 30.0], 10)
    slopes = np.array(
        [
            math.log(adev_trend(days, np.sqrt(rng.chisquare(edf) / edf), edf).per_month)
            for _ in range(1000)
        ]
    )
    assert abs(slopes.mean()) < 4 * slopes.std() / math.sqrt(slopes.size)


@pytest.mark.parametrize(("edf", "places"), [(60.0, 9), (4.0, 5)])
def test_equal_places_beside_their_mean(edf: float, places: int) -> None:
    """1000 times: 95 % intervals leave out 1 in 3.5 to 6.5 % (nine places beside the quietest of
    them: 15 %)."""
    rng = np.random.default_rng(10)
    one, out = np.array([1.0]), 0
    for _ in range(1000):
        adev = np.sqrt(rng.chisquare(edf, places) / edf)
        curves = [Curve(one, np.array([v]), np.array([edf])) for v in adev]
        out += sum(r.lower[0] > 1 or r.upper[0] < 1 for r in ratios_to_mean(curves, one))
    assert 0.035 < out / 1000 / places < 0.065


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


@pytest.mark.parametrize("n", [51, 60])
def test_every_length_has_its_windows(n: int) -> None:
    """1000 pairs at alpha = 0.01, lengths whose 2n/9 is odd: 1.7 % at most (with seven windows
    where eight were counted 1.8 to 2.4 %)."""
    rng = np.random.default_rng(11)
    false = 0
    for _ in range(1000):
        found = coherence(*rng.standard_normal((2, n)), 1.0, 0.01)
        false += bool((found.squared > found.threshold).any())
    assert false / 1000 < 0.017


@pytest.mark.parametrize(("kind", "n"), [("white", 60), ("white", 360), ("random walk", 360)])
def test_unrelated_series_are_rarely_coherent(kind: str, n: int) -> None:
    """1000 pairs at alpha = 0.05: false alarms in 3 to 8 %."""
    rng = np.random.default_rng(5)
    false = 0
    for _ in range(1000):
        found = coherence(noise(kind, rng, n), noise(kind, rng, n), 10.0, 0.05)
        false += bool((found.squared > found.threshold).any())
    assert 0.03 < false / 1000 < 0.08


def test_what_goes_with_temperature_is_found() -> None:
    """9 h, 0.004 mm per degree, 200 s behind, in a random walk: gain to 10 %, lag to 60 s."""
    rng = np.random.default_rng(6)
    rate, n = 2.0, 9 * 3600 * 2
    time = np.arange(n) / rate
    kelvin = np.sin(2 * np.pi * time / 3300) + 0.3 * np.sin(2 * np.pi * time / 1370)
    later = np.sin(2 * np.pi * (time - 200) / 3300) + 0.3 * np.sin(2 * np.pi * (time - 200) / 1370)
    series = (
        0.004 * later + 2e-5 * np.cumsum(rng.standard_normal(n)) + 0.01 * rng.standard_normal(n)
    )
    row = together(series, rate, Covariate("temperature_c", time[::120], kelvin[::120]), 0.01)
    assert row["word"] == "goes with it"
    assert row["gain_mm_per_unit"] == pytest.approx(0.004, rel=0.1)
    assert row["lag_s"] == pytest.approx(200, abs=60)
    other = together(rng.standard_normal(n), rate, Covariate("t", time[::120], kelvin[::120]), 0.01)
    assert other["word"] == "unrelated"


def test_noise_of_the_sensor_averages_out() -> None:
    """9 h, a sample each second with noise of four times the swing: gain to 10 % all the same (of
    single samples, one a block, it would be half)."""
    rng = np.random.default_rng(9)
    rate, n = 2.0, 9 * 3600 * 2
    time = np.arange(n) / rate
    swing = np.sin(2 * np.pi * time / 3300)
    seen = swing[::2] + 4 * rng.standard_normal(n // 2)
    series = 0.004 * swing + 0.01 * rng.standard_normal(n)
    row = together(series, rate, Covariate("temperature_c", time[::2], seen), 0.01)
    assert row["gain_mm_per_unit"] == pytest.approx(0.004, rel=0.1)
    assert row["coherence"] > 0.9


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time_s,c\n0,1\n60,x\n", "line 3: expected two numbers"),
        ("t,c\n0,1\n", "columns t, c; expected time_s and one other"),
        ("time_s,c\n0,1\n0,2\n", "time_s must increase"),
        ("", "expected a CSV file"),
    ],
)
def test_bad_covariates(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "room.csv"
    path.write_text(text)
    with pytest.raises(Refusal, match=f"room.csv.*{message}"):
        read_covariate(path)


def test_block_means() -> None:
    values = np.array([1, 3, np.nan, 5, np.nan, np.nan, np.nan, 8, 9])
    np.testing.assert_array_equal(block_means(values, 4), [3, np.nan])


def two_levels(rng: np.random.Generator) -> np.ndarray:
    """White noise on two levels two standard deviations apart, for about 120 and 8 s in turn."""
    dwell = rng.exponential([120.0, 8.0], (40, 2)).ravel()
    state = np.searchsorted(np.cumsum(dwell) - rng.uniform(0, 128), np.arange(90_000) / RATE) % 2
    return rng.normal(0, 1, 90_000) + 2 * state


def waxing(rng: np.random.Generator) -> np.ndarray:
    """White noise whose level goes up and down by a quarter over 4 min."""
    level = 1 + 0.25 * np.sin(2 * np.pi * (np.arange(90_000) / RATE / 240 + rng.uniform()))
    return level * rng.normal(0, 1, 90_000)


def changed_pairs(draw, factor: float = 1.0) -> int:
    """Of 24 pairs of recordings, of which the second is louder by a factor."""
    m, count = averaging_factors(90_000), 0
    for run in range(24):
        rng = np.random.default_rng([run, 7])
        first, second = (scale * draw(rng) for scale in (1.0, factor))
        curves = [allan_curve(x, RATE, m).as_scattered(x) for x in (second, first)]
        ratio = adev_ratio(*(Curve(c.tau_s, c.deviation, c.edf) for c in curves), TAUS)
        count += any(word in ("better", "worse") for word in words_of(ratio, 0.05, 0.01))
    return count


@pytest.mark.parametrize("draw", [two_levels, waxing])
def test_noise_that_comes_and_goes_is_no_change(draw) -> None:
    """At 1 %; by degrees of freedom of stationary noise 17 of 24 pairs of two levels changed."""
    assert changed_pairs(draw) <= 1


def test_louder_noise_is_a_change() -> None:
    assert changed_pairs(lambda rng: rng.normal(0, 1, 90_000), 1.2) == 24
