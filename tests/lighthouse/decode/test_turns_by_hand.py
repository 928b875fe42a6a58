"""Turns, hits and planes of one second-generation station, of times made by hand."""

from __future__ import annotations

import numpy as np
import pytest

from mocap_metrology.lighthouse.decode.turns import Light, find_turns

PERIOD_S = 949_000 / 48e6  # channel index 3
Row = tuple[int, float]  # diode, rotor in rad


def light(
    hits: list[list[Row]], n: int = 20, ppm: float = 0.0, late: dict[int, float] | None = None
):
    """A station that turns n times; the hits of the first turns."""
    period = PERIOD_S * (1 + 1e-6 * ppm)
    begin = 0.01 + period * np.arange(n)
    for turn, off in (late or {}).items():
        begin[turn] += off
    rows = [
        (d, 0.01 + period * (k + a / (2 * np.pi))) for k, own in enumerate(hits) for d, a in own
    ]
    diode, time = np.array(rows).T if rows else np.empty((2, 0))
    return Light(
        begin_channel=np.full(n, 3, np.int8),
        begin_s=begin,
        begin_bit=np.arange(n, dtype=np.int8) % 2,
        hit_channel=np.full(time.size, 3, np.int8),
        hit_diode=diode.astype(np.int16),
        hit_s=time,
        n_diodes=6,
        duration_s=n * period,
        resolution_s=1 / 48e6,
    )


@pytest.mark.parametrize(
    ("n", "ppm", "is_used"),
    [(12, 0, True), (11, 0, False), (20, 99, True), (20, 101, False), (20, -99, True)],
)
def test_a_station_has_twelve_begins_of_its_period(n: int, ppm: float, is_used: bool) -> None:
    turns, notes = find_turns(light([], n, ppm))
    assert len(turns) == is_used
    if is_used:
        assert turns[0].channel == 3
        assert turns[0].clock.cycle_s == pytest.approx(PERIOD_S * (1 + 1e-6 * ppm), rel=1e-12)
        assert turns[0].bit.tolist() == [k % 2 for k in range(n)]
    else:
        assert notes
