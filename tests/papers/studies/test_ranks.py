"""Rank correlations, medians and their intervals, against scipy, published numbers, simulation."""

import numpy as np
import pytest
from scipy.stats import binom, spearmanr

from mocap_metrology.papers.studies.findings import median_interval, rank_correlation


def test_rank_correlation_equals_that_of_scipy_with_ties() -> None:
    rng = np.random.default_rng(1)
    for n in (5, 40, 100):
        x, y = rng.integers(0, 4, n).astype(float), rng.normal(size=n).round(1)
        assert rank_correlation(x, y).value == pytest.approx(spearmanr(x, y).statistic, abs=1e-12)


def test_interval_is_the_published_one() -> None:
    """Data and result of the example of `ci.spear` in the R package statpsych (Bonett)."""
    y = [21, 4, 9, 12, 35, 18, 10, 22, 24, 1, 6, 8, 13, 16, 19]
    x = [67, 28, 30, 28, 52, 40, 25, 37, 44, 10, 14, 20, 28, 40, 51]
    found = rank_correlation(np.array(x, float), np.array(y, float))
    np.testing.assert_allclose(found, [0.8699639, 0.5840951, 0.9638297], atol=1e-6)


@pytest.mark.parametrize(("slope", "least", "most"), [(0.0, 0.93, 0.97), (0.5, 0.93, 0.99)])
def test_the_interval_covers_the_true_correlation(slope: float, least: float, most: float) -> None:
    """Five values of x with 20 y each, as in a study; the truth from 200,000 pairs."""
    rng = np.random.default_rng(2)

    def drawn(each: int) -> tuple[np.ndarray, np.ndarray]:
        x = np.repeat(np.arange(5.0), each)
        return x, slope * x + rng.normal(size=x.size)

    truth = spearmanr(*drawn(40000)).statistic
    found = np.array([rank_correlation(*drawn(20))[1:] for _ in range(1000)])
    inside = np.mean((found[:, 0] <= truth) & (truth <= found[:, 1]))
    assert least < inside < most


def test_without_variation_or_pairs_there_is_no_interval() -> None:
    assert np.isnan(rank_correlation(np.ones(5), np.arange(5.0))).all()
    assert rank_correlation(np.arange(3.0), np.array([1.0, 3, 2])).value == 0.5
    assert np.isnan(rank_correlation(np.arange(3.0), np.array([1.0, 3, 2]))[1:]).all()
    perfect = rank_correlation(np.arange(9.0), -np.arange(9.0))
    assert perfect.value == -1 and np.isnan(perfect[1:]).all()


@pytest.mark.parametrize(("n", "k"), [(6, 1), (20, 6), (100, 40)])
def test_the_interval_of_the_median_has_its_closed_form(n: int, k: int) -> None:
    """x_(k) and x_(n+1-k): the narrowest pair with P(k <= B < n + 1 - k) of 95 % at least."""
    found = median_interval(np.arange(1.0, n + 1)[::-1])
    assert found == ((n + 1) / 2, k, n + 1 - k)
    assert 1 - 2 * binom.cdf(k - 1, n, 0.5) >= 0.95 > 1 - 2 * binom.cdf(k, n, 0.5)


def test_the_interval_of_the_median_covers_it() -> None:
    rng = np.random.default_rng(3)
    found = [median_interval(rng.exponential(size=20)) for _ in range(2000)]
    inside = np.mean([one.lower <= np.log(2) <= one.upper for one in found])
    assert abs(inside - 0.9586) < 0.015  # 1 - 2 P(B <= 5), B binomial (20, 1/2)
    assert np.isnan(median_interval(np.arange(5.0))[1:]).all()
    assert np.isnan(median_interval(np.zeros(0))).all()
    assert np.isinf(median_interval(np.array([1.0, np.inf, np.inf])).value)
