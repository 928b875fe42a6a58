"""Student's limits against scipy, random effects against a published example, effective numbers
against an autoregression; how often intervals hold."""

import math

import numpy as np
import pytest
from scipy import stats
from scipy.signal import lfilter

from mocap_metrology.accuracy.statistics import (
    effective_number,
    half_interval,
    random_effects,
    repeated,
)

# BCG trials [Colditz 1994] as in the documentation of metafor: log relative risks and their
# variances; DerSimonian & Laird: tau^2 0.3088, mean -0.7141; its confint: tau^2 0.1197 to 1.1115
BCG = np.array(
    [
        *[(-0.8893, 0.3256), (-1.5854, 0.1946), (-1.3481, 0.4154), (-1.4416, 0.0200)],
        *[(-0.2175, 0.0512), (-0.7861, 0.0069), (-1.6209, 0.2230), (0.0120, 0.0040)],
        *[(-0.4694, 0.0564), (-1.3713, 0.0730), (-0.3394, 0.0124), (0.4459, 0.5325)],
        (-0.0173, 0.0714),
    ]
)


def test_limits_are_those_of_scipy() -> None:
    values = [1.0, 1.3, 0.8, 1.1]
    found = repeated(values)
    ends = stats.t.interval(0.95, 3, np.mean(values), stats.sem(values))
    assert (found.k, found.value) == (4, pytest.approx(1.05))
    assert (found.lower, found.upper) == pytest.approx(ends)
    assert found.next_upper - found.value == pytest.approx(math.sqrt(5) * (ends[1] - 1.05))
    logs = repeated(values, positive=True)
    assert logs.value == pytest.approx(stats.gmean(values))
    assert logs.lower == pytest.approx(logs.value**2 / logs.upper)
    assert math.isnan(repeated([1.0, 2.0, math.nan]).lower)
    assert math.isnan(repeated([]).value)


def test_published_random_effects() -> None:
    found = random_effects(*BCG.T)
    assert found.between**2 == pytest.approx(0.3088, abs=2e-3)
    assert found.mean == pytest.approx(-0.7141, abs=2e-3)
    assert (found.between_lower**2, found.between_upper**2) == pytest.approx(
        (0.1197, 1.1115), abs=5e-3
    )
    one = random_effects([2.0], [0.1])
    assert one.mean == 2.0 and math.isnan(one.se)
    alike = random_effects([1.0, 1.001, 0.999], [1.0, 1.0, 1.0])
    assert alike.between == alike.between_lower == 0


@pytest.mark.parametrize("between", [0.0, 0.5, 3.0])
def test_intervals_hold(between: float) -> None:
    """1,000 sets of five values of unequal errors: mean and sd between in 92 to 98.5 % (sd 0 is on
    the edge: at least 95 %)."""
    rng = np.random.default_rng(3)
    errors = np.array([0.5, 1.0, 1.0, 1.5, 2.0])
    means, spreads = [], []
    for _ in range(1000):
        values = 7 + between * rng.standard_normal(5) + errors * rng.standard_normal(5)
        found = random_effects(values, errors**2)
        means.append(found.lower < 7 < found.upper)
        spreads.append(found.between_lower <= between <= found.between_upper)
    assert 0.92 <= np.mean(means) <= 0.985
    assert 0.92 <= np.mean(spreads) <= (0.985 if between else 1.0)


def autoregression(rng: np.random.Generator, phi: float, shape: tuple[int, ...]) -> np.ndarray:
    """Stationary x_k = phi x_k-1 + e_k of variance 1: tau = (1 + phi) / (1 - phi)."""
    white = rng.standard_normal(shape) * math.sqrt(1 - phi**2)
    white[..., 0] /= math.sqrt(1 - phi**2)
    return lfilter([1.0], [1.0, -phi], white)


@pytest.mark.parametrize("gaps", [False, True])
@pytest.mark.parametrize("phi", [-0.3, 0.0, 0.5, 0.95])
def test_of_an_autoregression(phi: float, gaps: bool) -> None:
    """100,000 values: to 10 %; gaps of 20 % in pieces leave the correlation time as it is. More
    than the number of values is not claimed for a series that alternates."""
    rng = np.random.default_rng(1)
    series = autoregression(rng, phi, (100_000,))
    if gaps:
        series[np.repeat(rng.random(2000) < 0.2, 50)] = np.nan
    n = int(np.isfinite(series).sum())
    expected = min(n * (1 - phi) / (1 + phi), n)
    assert effective_number(series) == pytest.approx(expected, rel=0.1)


def test_slow_noise_below_white_noise() -> None:
    """A hundredth of the variance, of 300 values each: tau = 1 + 0.02 * 300 / 1.01, nearly seven,
    which autocovariances of single values do not show."""
    rng = np.random.default_rng(8)
    slow = autoregression(rng, math.exp(-1 / 300), (20, 12_000))
    every = [effective_number(x) for x in 0.1 * slow + rng.standard_normal(slow.shape)]
    assert np.median(every) == pytest.approx(1730, rel=0.5)


def test_of_series_that_say_nothing() -> None:
    assert math.isnan(effective_number(np.array([1.0, np.nan])))
    assert effective_number(np.ones(50)) == 1.0
    assert effective_number(np.linspace(0, 1, 400)) < 5
    assert math.isnan(half_interval(np.linspace(0, 1, 400)))


@pytest.mark.parametrize("tau_s", [0.3, 1.0])
def test_interval_of_a_mean_holds(tau_s: float) -> None:
    """400 takes of 60 s at 100 Hz: in 92 to 98.5 %; taken for independent frames in under 40 %."""
    rng = np.random.default_rng(2)
    held, naive = [], []
    for series in autoregression(rng, math.exp(-0.01 / tau_s * 2), (400, 6000)):
        held.append(abs(series.mean()) < half_interval(series))
        naive.append(abs(series.mean()) < 1.96 * series.std(ddof=1) / math.sqrt(series.size))
    assert 0.92 <= np.mean(held) <= 0.985
    assert np.mean(naive) < 0.4
