"""Which pulses of a Crazyflie's deck are of one sweep of one station."""

from __future__ import annotations

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.decode.crazyflie import _light

RATE_HZ = 24e6
Row = tuple[int, int, int]  # sensor, channel, offset
GOOD: list[Row] = [(0, 3, 50_000), (1, -1, 0), (2, 3, 0), (3, -1, 0)]
WRONG: dict[str, list[Row]] = {
    "two channels": [(0, 3, 50_000), (1, 5, 0), (2, 3, 0)],
    "no channel": [(0, -1, 50_000), (1, -1, 0)],
    "no such channel": [(0, 16, 50_000), (1, -1, 0)],
    "no time in the turn": [(0, 3, 0), (1, 3, 0)],
    "two times in the turn": [(0, 3, 50_000), (1, 3, 50_010)],
    "a sensor twice": [(0, 3, 50_000), (1, 3, 0), (1, 3, 0)],
}


def decoded(*groups: list[Row], apart: int = 100_000, within: int = 300) -> object:
    rows = [
        (sensor, channel, offset, apart * k + within * i)
        for k, group in enumerate(groups)
        for i, (sensor, channel, offset) in enumerate(group)
    ]
    order = np.random.default_rng(1).permutation(len(rows))
    sensor, channel, offset, stamp = np.array(rows)[order].T
    return _light(sensor, channel, offset, stamp + 10**6, stamp % 2, [], "a.bin")


@pytest.mark.parametrize("fault", WRONG)
def test_a_sweep_that_is_of_no_single_station_is_left_out(fault: str) -> None:
    light = decoded(GOOD, WRONG[fault], [(1, 7, 90_000)])
    n = len(WRONG[fault])
    assert light.hit_channel.tolist() == [3, 3, 3, 3, 7]
    assert light.hit_diode.tolist() == [0, 1, 2, 3, 1]
    assert (light.hit_s * RATE_HZ).tolist() == pytest.approx([0, 300, 600, 900, 200_000])
    assert light.begin_channel.tolist() == [3, 7]
    assert (light.begin_s * RATE_HZ).tolist() == pytest.approx([-50_000, 110_000])
    assert light.notes == (f"{n} of {n + 5} pulses are of sweeps of no single station",)
    with pytest.raises(Refusal, match="no sweep with one channel and one time in the turn"):
        decoded(WRONG[fault])


@pytest.mark.parametrize(("apart", "sweeps"), [(9_999, 1), (10_000, 2)])
def test_pulses_of_one_sweep_are_less_than_417_us_apart(apart: int, sweeps: int) -> None:
    """10,000 ticks; of one sweep two times in the turn are one too many."""
    groups = [[(0, 3, 50_000)], [(1, 3, 0)]]
    light = decoded(*groups, apart=apart)
    assert light.hit_s.size == (2 if sweeps == 1 else 1)
    assert light.n_diodes == 4
    assert light.duration_s == pytest.approx(apart / RATE_HZ)
