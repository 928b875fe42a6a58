"""The clock of one object in that of another, by turns of stations that both saw.

    t_b = offset + rate t_a

A hit at time t and angle a in turn c of a station of the second generation says when this turn
began, b_c = t - T (a + P) / 2 pi, P being the angle of its plane. Both objects have numbers of
turns of their own. Stations turn at different rates, so that only the right difference of numbers
lets all of them agree. Two stations can agree again seconds away, where the difference of their
periods has drifted by a step of the pattern: the computer's time then tells which it is.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.decode.turns import PLANE_RAD
from mocap_metrology.lighthouse.records import Hits

FARTHEST_S = 4.0  # between the zeros of two clocks, where nothing is known of them
NEAR_S = 0.1  # of the computer's time: lines come milliseconds late
AGREE_S = 3e-6  # stations about one offset; their wander is 0.3 us
FEWEST_TURNS = 30  # of a station that both saw


@dataclass(frozen=True)
class ClockMap:
    """t_b = offset_s + rate t_a; rms_s: of the turns about it; apart_s: largest difference of the
    means of two stations; turns: how many both saw."""

    offset_s: float
    rate: float
    rms_s: float
    apart_s: float
    turns: int

    def __call__(self, time_s: Floats) -> Floats:
        """Times of the second clock."""
        found: Floats = self.offset_s + self.rate * time_s
        return found


@dataclass(frozen=True)
class _Begins:
    """Turns of a station that an object saw: number, begin, and the line through them."""

    turn: np.ndarray
    begin_s: Floats
    period_s: float
    epoch_s: float


def _begins(hits: Hits) -> _Begins:
    part = (hits.angle_rad + PLANE_RAD[hits.axis]) / (2 * np.pi)
    period, epoch = np.polyfit(hits.cycle + part, hits.time_s, 1)
    turn, first = np.unique(hits.cycle, return_index=True)
    return _Begins(turn, (hits.time_s - period * part)[first], float(period), float(epoch))


def clock_map(a: Hits, b: Hits, stations: Sequence[tuple[int, int]], expected_s: float) -> ClockMap:
    """Of two objects; stations: their indices in the hits of either, of those that both name;
    expected_s: the offset by the computer's time, NaN where it is not known.

    Raises `Refusal` where fewer than two are seen by both, or no offset lets them agree.
    """
    both = []
    for i, j in stations:
        own = [h.take(h.station == s) for h, s in ((a, i), (b, j))]
        if min(np.unique(h.cycle).size for h in own) >= FEWEST_TURNS:
            both.append((_begins(own[0]), _begins(own[1])))
    if len(both) < 2:
        raise Refusal(
            f"bar: the objects see {len(both)} stations in common; expected two, whose turns tell"
            " one clock from the other"
        )
    middle = float(np.median([x.begin_s[x.turn.size // 2] for x, _ in both]))
    # Begin of the turn of the same number by the second clock, less that by the first, at `middle`.
    off = np.array(
        [y.epoch_s + y.period_s * (middle - x.epoch_s) / x.period_s - middle for x, y in both]
    )
    period = np.array([y.period_s for _, y in both])
    about, within = (0.0, FARTHEST_S) if math.isnan(expected_s) else (expected_s, NEAR_S)
    first = np.arange(-within // period[0], within // period[0] + 2)
    offset = off[0] + period[0] * (first + np.round((about - off[0]) / period[0]))
    number = np.round((offset[:, None] - off) / period)
    apart = np.ptp(off + number * period, axis=1)
    if (found := np.flatnonzero(apart <= AGREE_S)).size != 1:
        raise Refusal(
            f"bar: {found.size} differences of the clocks let the turns of {len(both)} stations"
            f" agree within {1e6 * AGREE_S:g} us, up to {within:g} s from {about:.3f} s; expected"
            " one, of objects in one recording"
        )
    pairs = [_common(x, y, int(k)) for (x, y), k in zip(both, number[found[0]], strict=True)]
    t_a, t_b = (np.concatenate(times) for times in zip(*pairs, strict=True))
    if t_a.size < FEWEST_TURNS:
        raise Refusal(f"bar: the objects see {t_a.size} turns in common; expected {FEWEST_TURNS}")
    rate, start = np.polyfit(t_a - middle, t_b - t_a, 1)
    means = [float(np.mean(y - x - start - rate * (x - middle))) for x, y in pairs if x.size]
    left = t_b - t_a - start - rate * (t_a - middle)
    rms = float(np.sqrt(np.mean(left**2)))
    return ClockMap(
        float(start - rate * middle), 1.0 + float(rate), rms, float(np.ptp(means)), t_a.size
    )


def _common(x: _Begins, y: _Begins, number: int) -> tuple[Floats, Floats]:
    """Begins of the turns that both saw."""
    _, i, j = np.intersect1d(x.turn + number, y.turn, assume_unique=True, return_indices=True)
    return x.begin_s[i], y.begin_s[j]
