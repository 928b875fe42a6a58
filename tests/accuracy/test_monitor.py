"""Charts of a facility: published run lengths, exact distributions, simulated facilities."""

import sys
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from mocap_metrology.accuracy.monitor import Chart, Limits, Watched, chart, crossing, limits, words

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from benchmarks.monitor import not_capable, study

LIMITS = Limits(3.95, 7.7)
PLACE = Watched(0.5, 0.1)


def of(values: np.ndarray, marked: int = 0, watched: Watched = PLACE) -> Chart:
    return chart(
        np.asarray(values), range(len(values)), np.arange(len(values)) < marked, watched, LIMITS
    )


@pytest.mark.parametrize(("limit", "published"), [(4.0, 335.4), (5.0, 930.9)])
def test_run_length_of_the_cusum_is_the_published_one(limit: float, published: float) -> None:
    """Average run length of a one-sided CUSUM with k = 0.5, twice that of both sides, 168 and 465
    (Montgomery, Introduction to Statistical Quality Control, table 9.3), which falls
    geometrically."""
    early, late = (1 - crossing(limit, steps, clip=50.0) for steps in (100, 200))
    decay = (late / early) ** (1 / 100)
    assert early / decay**100 / (1 - decay) == pytest.approx(published, rel=0.03)


def test_limits_for_six_series() -> None:
    found = limits(6, 0.05, 50)
    assert (found.q, found.cusum) == pytest.approx((3.95, 7.7), abs=0.06)
    assert limits(9, 0.05, 50).q > found.q
    assert limits(9, 0.05, 50).cusum > found.cusum


def test_limits_hold_in_simulation() -> None:
    """Of 4,000 simulated sets of six unchanged series 5 % leave the limits, half of them each."""
    rng = np.random.default_rng(1)
    z = rng.standard_normal((4000, 12, 50))  # both sides apart: the limit shares them
    limit = limits(6, 0.05, 50)
    c, most = np.zeros((4000, 12)), np.zeros((4000, 12))
    for k in range(50):
        c = np.maximum(0, c + np.clip(z[:, :, k], -2.5, 2.5) - 0.5)
        most = np.maximum(most, c)
    assert np.mean((most > limit.cusum).any(1)) == pytest.approx(0.025, abs=0.008)
    assert np.mean((z > limit.q).any((1, 2))) == pytest.approx(0.025, abs=0.008)


def test_q_is_normal_whatever_the_baseline() -> None:
    rng = np.random.default_rng(2)
    q = np.array([of(rng.normal(7, 3, 6), 5).q[5] for _ in range(4000)])
    assert stats.kstest(q, "norm").pvalue > 0.01


def test_a_shift_alarms_at_once_and_fails_at_the_second_take() -> None:
    x = np.r_[np.random.default_rng(4).normal(0, 0.1, 15), 1.0, 1.1, 0.9]
    found = of(x)
    assert found.baseline.sum() == 10
    assert found.beyond.tolist() == [False] * 15 + [True] * 3
    assert [word for word, _ in words(found)[-4:]] == ["pass", "alert", "failure", "failure"]


def test_a_take_beyond_the_tolerance_is_not_learnt() -> None:
    x = np.random.default_rng(5).normal(0, 0.1, 15)
    x[6] = 2.0
    found = of(x)
    assert not found.baseline[6]
    assert found.n_baseline[-1] == 10


def test_a_scattering_series_says_what_it_can_be_watched_for() -> None:
    x = np.random.default_rng(7).normal(0, 0.4, 20)
    found = of(x, 10)
    assert not found.capable[-1]
    assert found.watchable[-1] == pytest.approx(3.5 * found.scatter[-1])
    assert found.band[-1] > found.watchable[-1] > 0.5


def test_false_alarms_and_changes_that_are_found() -> None:
    """The study of benchmarks/monitor.py on fewer facilities, with the room that they need."""
    n = 120
    for name, *_, what, found, sign, asked in study(n, seed=3):
        share = np.clip(asked, 1, 99) / 100
        room = 100 * 2.6 * np.sqrt(share * (1 - share) / n)
        kept = found <= asked + room if sign == "<=" else found >= asked - room
        assert kept, f"{name}, {what}: {found:.1f} %"


def test_most_facilities_are_not_capable_of_watching_their_jitter() -> None:
    jitter, place, length = not_capable(100, seed=3)
    assert jitter > 50 > length > 5
    assert place < 30
