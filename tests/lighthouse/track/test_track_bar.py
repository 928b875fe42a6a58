"""Twins of a bar: two objects before the same stations, each with a clock of its own."""

import math
from dataclasses import replace

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.decode.chain import Decoded, decode_light
from mocap_metrology.lighthouse.decode.gates import Cleaning
from mocap_metrology.lighthouse.rotation import from_angles
from mocap_metrology.lighthouse.simulate.turns import (
    MadeTurns,
    TurnsTwin,
    simulate_turns,
    stations_around,
)
from mocap_metrology.lighthouse.simulate.twin import MotionTwin
from mocap_metrology.lighthouse.track.bar import clock_map

LENGTH_M = 0.26786
HEAD = from_angles(0.1, 0.0, 0.2), np.array([0.01, -0.005, 0.02])


def on_a_bar(seed: int, n: int = 2, **changes: object) -> list[MadeTurns]:
    """Two objects whose heads are `LENGTH_M` apart, the second turned half about the way up."""
    R, t, middle, up = stations_around(n, np.random.default_rng(seed))
    motion = MotionTwin(centre_m=tuple(middle), speed_m_s=0.5, extent_m=0.5, wobble_deg=15)
    turn, half = from_angles(0.0, 0.0, np.pi), np.array([LENGTH_M / 2, 0.0, 0.0])
    some = {"seed": seed, "R": R, "t": t, "channels": (0, 1, 6, 7)[:n], "motion": motion}
    some |= {"up": up, "duration_s": 6.0, **changes}
    mounts = [(np.eye(3), half - HEAD[1]), (turn, -half - turn @ HEAD[1])]
    return [
        simulate_turns(TurnsTwin(**some, mount=mount, receiver=k, clock_ppm=3.0 * k))
        for k, mount in enumerate(mounts)
    ]


def seen(made: MadeTurns) -> Decoded:
    return decode_light(made.light, made.twin.board, None, Cleaning(), "twin")


def later(found: Decoded, by_s: float, turns: int) -> Decoded:
    """By a clock that was started `by_s` earlier, and with other numbers of turns."""
    hits = replace(
        found.hits, time_s=found.hits.time_s + by_s, cycle=found.hits.cycle + np.int32(turns)
    )
    return replace(found, hits=hits)


def test_one_clock_in_the_other() -> None:
    """3 ppm and 1.7 s apart, with turns counted from elsewhere: to 0.1 us, with 100 ns of a
    begin."""
    made = on_a_bar(1)
    a, b = seen(made[0]), later(seen(made[1]), 1.7, 40)
    found = clock_map(a.hits, b.hits, [(0, 0), (1, 1)], 1.69)
    time_s = np.linspace(0, 6, 7)
    assert found.rate - 1 == pytest.approx(3e-6, abs=4e-6)
    assert np.abs(found(time_s) - time_s - 1.7).max() < 40e-6
    assert found.rms_s < 200e-9 and found.apart_s < 100e-9 and found.turns > 300
    with pytest.raises(Refusal, match="1 stations in common"):
        clock_map(a.hits, b.hits, [(0, 0)], math.nan)
    with pytest.raises(Refusal, match="0 differences of the clocks"):
        clock_map(a.hits, b.hits, [(0, 0), (1, 1)], 2.5)
    made = on_a_bar(1, n=4)
    a, b = seen(made[0]), later(seen(made[1]), 1.7, 40)
    alone = clock_map(a.hits, b.hits, [(k, k) for k in range(4)], math.nan)
    assert np.abs(alone(time_s) - time_s - 1.7).max() < 40e-6
