"""A take in a few numbers: white noise and known places; the series of many takes."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mocap_metrology.accuracy.monitor import ORDER
from mocap_metrology.accuracy.monitor_row import Row
from mocap_metrology.accuracy.monitor_rows import table
from mocap_metrology.accuracy.monitor_take import Take, judge, numbers, series_of, stretches
from mocap_metrology.common.errors import Refusal
from mocap_metrology.settings import Monitor

PLACES = np.array([[0.0, 0, 0], [300, 0, 0], [0, 400, 0]])


def take(rng: np.random.Generator, seconds: float = 60, sigma: float = 0.05) -> Take:
    n = round(120 * seconds)
    positions = {
        label: place[:, None] + rng.normal(0, sigma, (3, n))
        for label, place in zip("ABC", PLACES, strict=True)
    }
    lengths = {"A-B": np.linalg.norm(positions["A"] - positions["B"], axis=0)}
    return numbers(positions, lengths, 120.0, 2.0)


def test_of_white_noise() -> None:
    """sigma / sqrt(m) at m frames; the mean of three markers."""
    found = take(np.random.default_rng(1))
    assert found.jitter_mm == pytest.approx(0.05, rel=0.02)
    assert found.wander_mm == pytest.approx(0.05 / np.sqrt(240), rel=0.15)
    assert found.wander_df == pytest.approx(28, abs=0.1)
    assert found.places_mm["B"] == pytest.approx([300, 0, 0], abs=0.005)
    assert found.lengths_mm["A-B"] == pytest.approx(300, abs=0.005)


def test_the_wander_of_short_takes_is_not_judged() -> None:
    takes = [take(np.random.default_rng(k), seconds=20) for k in range(8)]
    days = [f"2026-01-0{k}" for k in range(1, 9)]
    by_name = {one.series.name: one for one in judge(takes, days, [False] * 8, Monitor())}
    assert by_name["wander"].at.size == 0
    assert by_name["jitter"].words[-1] == ("provisional", None)


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


def test_a_stream_that_repeats_itself_is_a_changed_jitter() -> None:
    takes = [take(np.random.default_rng(k)) for k in range(12)]
    takes[-1] = replace(takes[-1], jitter_mm=0.0)
    days = [f"2026-01-{k + 1:02d}" for k in range(12)]
    (jitter, *_) = judge(takes, days, [False] * 12, Monitor())
    assert jitter.words[-1] == ("alert", None)
