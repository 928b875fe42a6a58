"""Charts of a facility: published run lengths, exact distributions, simulated facilities;
a take in a few numbers."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mocap_metrology.accuracy.monitor import (
    ORDER,
    Chart,
    Limits,
    WatchLimits,
    chart,
    crossing,
    limits,
    words,
)
from mocap_metrology.accuracy.monitor_row import Row
from mocap_metrology.accuracy.monitor_take import Take, numbers, series_of, stretches, table
from mocap_metrology.common.errors import Refusal
from mocap_metrology.settings import Monitor

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from benchmarks.monitor import study

LIMITS = Limits(3.95, 7.7)
PLACE = WatchLimits(0.5, 0.1)


def of(values: np.ndarray, marked: int = 0, watched: WatchLimits = PLACE) -> Chart:
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


def test_a_shift_alarms_at_once_and_fails_at_the_second_take() -> None:
    x = np.r_[np.random.default_rng(4).normal(0, 0.1, 15), 1.0, 1.1, 0.9]
    found = of(x)
    assert found.baseline.sum() == 10
    assert found.beyond.tolist() == [False] * 15 + [True] * 3
    assert [word for word, _ in words(found)[-4:]] == ["pass", "alert", "failure", "failure"]


def test_every_second_take_beyond_the_tolerance_is_a_failure() -> None:
    x = np.random.default_rng(4).normal(0, 0.1, 22)
    x[12::2] += 1
    said = words(of(x))
    assert [word for word, _ in said[12:17]] == ["alert", "pass", "alert", "pass", "failure"]
    assert [since for _, since in said[16:]] == [12] * 6


def test_what_came_back_has_not_moved() -> None:
    """A summer of 0.4 mm, within the tolerance, is noted while it lasts, and not for months."""
    x = np.random.default_rng(4).normal(0, 0.05, 60)
    x[15:35] += 0.4
    found = of(x)
    assert found.cusum[39] > LIMITS.cusum
    assert found.drifting[25:35].all() and not found.drifting[39:].any()


def test_an_unchanged_baseline_has_no_change_within() -> None:
    """Of 300, of a scatter that is stated, and of one four times as large; a step of 1 mm in its
    middle is always found."""
    rng = np.random.default_rng(6)
    for scatter in (0.1, 0.4):
        assert sum(bool(of(x).parted[-1]) for x in rng.normal(0, scatter, (300, 11))) <= 6
    for x in rng.normal(0, 0.1, (30, 11)):
        assert of(x + (np.arange(11) >= 4)).parted[-1] == pytest.approx(1, abs=0.3)


@pytest.mark.parametrize(("shift", "rarer"), [(np.arange(11) % 2, 5), (np.arange(11) < 1, 1)])
def test_levels_of_a_baseline_are_no_scatter(shift: np.ndarray, rarer: int) -> None:
    """Of two operators by turns, and of a first take that was named as of the baseline; of 300
    unchanged ones, whose scatter is 20 times the stated one, 1 in 1,000 is called so."""
    rng = np.random.default_rng(7)
    for x in rng.normal(0, 0.05, (30, 11)):
        found = of(x + 2 * shift, marked=10)
        assert found.parted[-1] == pytest.approx(2, abs=0.2) and found.apart[-1] == rarer
        assert words(found)[-1][0] == "note"
    assert sum(bool(of(x, 10).parted[-1]) for x in rng.normal(0, 2, (300, 11))) <= 3


def test_a_drift_and_three_levels_of_a_baseline_are_said() -> None:
    """Of 1 mm over ten takes, and of three operators by turns; of 300 unchanged ones 1 in 100."""
    rng, at = np.random.default_rng(8), np.arange(12)
    for x in rng.normal(0, 0.1, (30, 12)):
        drifted, threefold = of(x + np.minimum(at, 9) / 9), of(x + at % 3)
        assert drifted.parted[-1] > 0.5  # or of a step, where that fits better
        assert threefold.scattered[-1] and words(threefold)[-1][0] == "note"
    unchanged = [of(x) for x in rng.normal(0, 0.15, (300, 12))]
    assert sum(bool(one.parted[-1] or one.scattered[-1]) for one in unchanged) <= 3


def test_a_take_beyond_the_tolerance_is_not_learnt() -> None:
    x = np.random.default_rng(5).normal(0, 0.1, 15)
    x[6] = 2.0
    found = of(x)
    assert not found.baseline[6]
    assert found.n_baseline[-1] == 10


def test_a_wild_take_among_the_first_five_is_not_learnt() -> None:
    """Else a shift of 1 mm would be within the tolerance of what that take made of the scatter; a
    step among them is no single take."""
    values = 0.05 * np.random.default_rng(6).standard_normal(14)
    values[2] += 5
    values[12:] += 1
    charted = of(values)
    assert charted.baseline.tolist() == [True, True, False, *[True] * 8, *[False] * 3]
    assert charted.beyond.tolist() == [False] * 12 + [True] * 2
    stepped = of(np.where(np.arange(14) < 4, 0.0, 3.0) + 0.05)
    assert not stepped.learning[-1]


def test_false_alarms_and_changes_that_are_found() -> None:
    """The study of benchmarks/monitor.py on fewer facilities, with the room that they need."""
    n = 120
    for name, *_, what, found, sign, asked in study(n, seed=3):
        share = np.clip(asked, 1, 99) / 100
        room = 100 * 2.6 * np.sqrt(share * (1 - share) / n)
        kept = found <= asked + room if sign == "<=" else found >= asked - room
        assert kept, f"{name}, {what}: {found:.1f} %"


PLACES = np.array([[0.0, 0, 0], [300, 0, 0], [0, 400, 0]])


def take(rng: np.random.Generator, seconds: float = 60, sigma: float = 0.05) -> Take:
    n = round(120 * seconds)
    positions = {
        label: place[:, None] + rng.normal(0, sigma, (3, n))
        for label, place in zip("ABC", PLACES, strict=True)
    }
    lengths = {"A-B": np.linalg.norm(positions["A"] - positions["B"], axis=0)}
    return numbers(positions, lengths, 120.0, 2.0)


def test_a_fitted_frame_may_turn_but_the_object_may_not_bend() -> None:
    rng = np.random.default_rng(3)
    first, takes = take(rng), []
    for k in range(20):
        places = PLACES + (np.array([[0, 0, 0], [5, 0, 0], [0, 0, 0]]) if k > 17 else 0)
        turned = Rotation.random(random_state=k).apply(places) + rng.normal(0, 500, 3)
        turned += rng.normal(0, 0.05, (3, 3))
        takes.append(replace(first, places_mm=dict(zip("ABC", turned.tolist(), strict=True))))
    how, days = Monitor(frame="fitted"), [f"2026-01-{k + 1:02d}" for k in range(20)]
    rows = [Row(day, day) for day in days]
    said = dict.fromkeys(days, "")  # the worst of each take's series
    for row in table(rows, stretches(rows, takes, how)):
        said[row["recording"]] = min(said[row["recording"]], row["word"], key=ORDER.index)
    said = list(said.values())
    assert said[:5] == ["learning"] * 5
    assert set(said[10:18]) == {"pass"}
    assert said[18:] == ["alert", "failure"]
    two = [replace(one, places_mm={"A": [0.0] * 3}) for one in takes]
    with pytest.raises(Refusal, match=r"monitor\.frame is fitted"):
        series_of(two, how)
