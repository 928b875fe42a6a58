"""Student's limits against scipy, random effects against a published example and Monte Carlo."""

import math

import numpy as np
import pytest
from scipy import stats

from mocap_metrology.accuracy.components import random_effects, repeated

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
    """2,000 sets of five values of unequal errors: mean and sd between in 92 to 98.5 % (sd 0 is on
    the edge: at least 95 %)."""
    rng = np.random.default_rng(3)
    errors = np.array([0.5, 1.0, 1.0, 1.5, 2.0])
    means, spreads = [], []
    for _ in range(2000):
        values = 7 + between * rng.standard_normal(5) + errors * rng.standard_normal(5)
        found = random_effects(values, errors**2)
        means.append(found.lower < 7 < found.upper)
        spreads.append(found.between_lower <= between <= found.between_upper)
    assert 0.92 <= np.mean(means) <= 0.985
    assert 0.92 <= np.mean(spreads) <= (0.985 if between else 1.0)
