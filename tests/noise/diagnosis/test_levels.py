"""Levels that change at once or slowly, of noise whose truth is known; rules written out."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from mocap_metrology.noise.diagnosis.levels import (
    Blocks,
    Sides,
    Trend,
    blocks,
    changes,
    compare,
    log_levels,
    trends,
)

RATE, N = 100.0, 60_000
TIME = np.linspace(0, 1, N)
NONE = np.zeros(N // 100, bool)


def made(size: np.ndarray | float, seed: int = 0, n_series: int = 3) -> dict:
    rng = np.random.default_rng(seed)
    return {f"x{k}": 0.05 * size * rng.standard_normal(N) for k in range(1, n_series + 1)}


def levels(size: np.ndarray | float, seed: int = 0) -> dict:
    return {k: blocks(v, RATE) for k, v in made(size, seed).items()}


def test_a_fall_is_named_with_an_interval_that_holds() -> None:
    held = []
    for seed in range(8):
        found = trends(levels(1 - 0.15 * TIME, seed), NONE, [])
        assert [one.series for one in found] == ["x1", "x2", "x3"]
        assert all(one.steady for one in found)
        held += [one.lower < -0.15 < one.upper for one in found]
    assert sum(held) >= 20  # of 24, 95 % expected


def test_what_comes_back_is_a_change_and_no_fall() -> None:
    for one in trends(levels(1 + 0.2 * np.sin(2 * np.pi * TIME)), NONE, []):
        assert not one.steady
        assert one.greatest - one.least == pytest.approx(0.4, abs=0.12)


def test_constant_noise_has_no_trend_and_no_step() -> None:
    for seed in range(30):
        found = levels(1.0, 100 + seed)
        assert not trends(found, NONE, [])
        assert not changes(found, NONE, 300.0, 0.005)


@pytest.mark.parametrize("factor", [0.7, 1.1, 1.2, 2.0])
def test_a_step_is_a_step_and_no_trend(factor: float) -> None:
    found = levels(np.where(TIME > 0.6, factor, 1.0))
    (step,) = changes(found, NONE, 300.0, 0.005)
    assert step.time_s == pytest.approx(360.0, abs=20.0)
    assert not trends(found, NONE, [step.time_s])


def test_a_step_on_a_slope_is_both() -> None:
    found = levels((1 - 0.2 * TIME) * np.where(TIME > 0.5, 1.5, 1.0))
    (step,) = changes(found, NONE, 300.0, 0.005)
    assert step.time_s == pytest.approx(300.0, abs=20.0)
    for one in trends(found, NONE, [step.time_s]):
        assert one.change == pytest.approx(0.8 * 1.5 - 1, abs=0.08)  # from begin to end


NEAR = st.sampled_from([0.6, 2 / 3, 0.67, 0.999, 1.0, 1.001, 1.49, 1.5, 1.51])


@given(NEAR, NEAR, st.booleans())
def test_an_interval_that_holds_one_is_alike_where_it_is_narrow(x: float, y: float, known) -> None:
    """Within a factor of 1.5."""
    lower, upper = min(x, y), max(x, y)
    found = Sides("x1", 0.05, 0.05, 0.05, 0.05, 1.1 if known else math.nan, lower, upper)
    narrow = "alike" if lower >= 2 / 3 and upper <= 1.5 else "undecided"
    changed = lower > 1 or upper < 1
    assert found.word == (("changed" if changed else narrow) if known else "unknown")
    assert found.changed is changed


CHANGES = st.sampled_from([-0.2, -0.1, -0.0999, -0.01, 0.0, 0.01, 0.0999, 0.1, 0.2])


@given(CHANGES, CHANGES, CHANGES, CHANGES, CHANGES)
def test_direction_and_extent_of_a_trend(change, lower, upper, least, greatest) -> None:
    """Steady where the interval lacks zero and half of the range, or more, is left in the end."""
    found = Trend("x1", change, lower, upper, least, greatest)
    span = greatest - least
    steady = (lower > 0 or upper < 0) and abs(change) >= span / 2
    assert found.direction == (("falls" if change < 0 else "rises") if steady else "changes")
    assert found.extent == (abs(change) if steady else span)
    assert found.matters is ((abs(change) if steady else max(greatest, -least)) >= 0.1)


@given(st.lists(st.sampled_from([1.0, 2.0, 5.0, math.nan]), max_size=40), st.integers(1, 5))
def test_blocks_and_their_logarithms_are_those_of_a_loop(values: list, rate: int) -> None:
    """Of a second, two frames at least; with half of a block, and of ten blocks, there."""
    size = max(rate, 2)
    rows = [values[k : k + size] for k in range(0, len(values) - size + 1, size)]
    known = [[v for v in row if not math.isnan(v)] for row in rows]
    enough = [len(k) >= size / 2 for k in known]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # a single value has no variance
        found = blocks(np.array(values), float(rate))
    pairs = list(zip(known, enough, strict=True))
    np.testing.assert_allclose(found.mean, [np.mean(k) if e else math.nan for k, e in pairs])
    one = [np.var(k, ddof=1) if e and len(k) > 1 else math.nan for k, e in pairs]
    np.testing.assert_allclose(found.variance, one)
    assert found.start_s.tolist() == [k * size / rate for k in range(len(rows))]
    out_of = np.arange(len(values)) % 7 == 3
    g = [math.nan if o or not v > 0 else math.log(v) for v, o in zip(values, out_of, strict=True)]
    tens = [[v for v in g[k : k + 10] if not math.isnan(v)] for k in range(0, len(g) - 9, 10)]
    points = [np.mean(t) if len(t) >= 5 else math.nan for t in tens]
    np.testing.assert_allclose(log_levels(np.array(values), out_of), points)


def test_the_ratio_of_two_sides_and_its_interval() -> None:
    """Means of 120 variances, a tenth apart; 95 % intervals hold the ratio in 90 to 99 % of 300,
    whether or not the variances are correlated with the next. In closed form of white noise of
    100 frames: ln ratio has the variance (2 / 99) / 120 / 2. Below five blocks: none."""
    rng = np.random.default_rng(4)
    for correlation in (0.0, 0.4):
        held, reach = 0, []
        for _ in range(300):
            noise = rng.chisquare(99, (2, 121)) / 99
            variance = (noise[:, 1:] + correlation * noise[:, :-1]) / (1 + correlation)
            one, other = (
                Blocks(np.zeros(120), s * v, 1.0) for s, v in zip((1, 1.21), variance, strict=True)
            )
            found = compare("x1", one, other, 0.05)
            assert found.ratio == pytest.approx(other.fast_sd / one.fast_sd)
            held += found.lower < 1.1 < found.upper
            reach.append(math.log(found.upper / found.lower) / 2)
        assert 0.9 * 300 <= held <= 0.99 * 300
        if not correlation:
            expected = stats.t.ppf(0.975, 119) * math.sqrt(2 / 99 / 120 / 2)
            assert np.median(reach) == pytest.approx(expected, rel=0.1)
    for n in (4, 5):
        few = Blocks(np.arange(float(n)), np.arange(1.0, n + 1), 1.0)
        found = compare("x1", few, few, 0.05)
        assert math.isfinite(found.ratio) is (n == 5)
        assert found.sd_before == pytest.approx(math.sqrt(np.mean(few.variance) + np.var(few.mean)))
    part = few.between(1.0, 4.0, np.arange(5) == 2)
    assert part.mean.tolist() == [1.0, 3.0] and math.isnan(few.between(0, 1).sd)


def test_twelve_points_have_a_trend_and_eleven_have_none() -> None:
    """Logarithms of variances that rise by 6 from end to end: the standard deviation by e^3."""
    rng = np.random.default_rng(3)
    variance = np.repeat(np.exp(0.5 * np.arange(12.0) + rng.normal(0, 0.05, 12)), 10)
    for n, count in ((120, 1), (119, 0)):
        found = trends({"x": Blocks(0 * variance[:n], variance[:n], 1.0)}, np.zeros(n, bool), [])
        assert len(found) == count
        assert all(one.change == pytest.approx(math.expm1(3), rel=0.1) for one in found)


def test_what_goes_up_and_down_does_not_rise() -> None:
    """A level that swings by a quarter over 4 min: no polynomial describes it, and its ends are
    none of the level. At the ends of a cubic it "rose" by 20 to 88 %."""
    t = np.arange(N) / RATE
    for seed in range(8):
        phase = np.random.default_rng(seed).uniform(0, 2 * np.pi)
        found = levels(1 + 0.25 * np.sin(2 * np.pi * t / 240 + phase), seed)
        for one in trends(found, NONE, []):
            assert one.direction == "changes" and one.lower < 0 < one.upper
            assert -0.4 < one.least <= 0 <= one.greatest < 0.67  # 0.75 / 1.25, 1.25 / 0.75
