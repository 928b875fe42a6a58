"""Two objects on one stiff bar, each tracked alone: where their heads are at common moments.

With head h of an object, w = R h and u the direction from head A to head B, an error (dt, dr) of an
object's pose changes the distance by u . dt + (w x u) . dr, of A with the other sign. Errors of two
objects are independent but for that of the stations, which moves both.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.batch.kernel import POSE
from mocap_metrology.lighthouse.calibrate.scene import Pose, Scene
from mocap_metrology.lighthouse.decode.turns import PLANE_RAD
from mocap_metrology.lighthouse.records import Hits
from mocap_metrology.lighthouse.track.receiver import STEP_S, Calibrated, Track, track

FEWEST_STATIONS = 2  # that see an object at a moment
FEWEST_HITS = 3  # by which a station does
FARTHEST_S = 4.0  # between the zeros of two clocks, where nothing is known of them
NEAR_S = 0.1  # of the computer's time: lines come milliseconds late
AGREE_S = 3e-6  # stations about one offset; their wander is 0.3 us
FEWEST_TURNS = 30  # of a station that both saw


@dataclass(frozen=True)
class Object:
    """One object: its light, the stations as they are known to it, and its head R, t (m) on the
    board; host_s: zero of its clock by the computer's, NaN where it is not known."""

    scene: Scene
    known: Calibrated
    head: Pose
    host_s: float = math.nan


@dataclass(frozen=True)
class BarEnds:
    """Heads A and B at n moments `STEP_S` apart by the clock of A, NaN where either object was not
    seen by two stations: t_m (2, 3, n), R (2, n, 3, 3); sd_m (n,): of their distance."""

    time_s: Floats
    t_m: Floats
    R: Floats
    sd_m: Floats
    clock: ClockMap


def heads(a: Object, b: Object) -> BarEnds:
    """Track both objects. Raises `Refusal` where one cannot be, or clocks cannot be compared."""
    common = [name for name in a.scene.names if name in b.scene.names]
    index = [[list(one.scene.names).index(name) for name in common] for one in (a, b)]
    pairs, expected = list(zip(*index, strict=True)), a.host_s - b.host_s
    clock = clock_map(a.scene.hits, b.scene.hits, pairs, expected)
    inside = b.scene.hits.time_s.min(), b.scene.hits.time_s.max()
    hit_s = a.scene.hits.time_s
    begin, end = (np.array(inside) - clock.offset_s) / clock.rate
    begin, end = max(begin, hit_s.min()), min(end, hit_s.max())
    if not end - begin > STEP_S:
        raise Refusal("bar: the objects are not seen at the same time; expected one recording")
    time_s = begin + STEP_S * np.arange(int((end - begin) / STEP_S))
    tracks = track(a.scene, a.known, time_s), track(b.scene, b.known, clock(time_s))
    turn = np.stack([one.R @ it.head[0] for one, it in zip(tracks, (a, b), strict=True)])
    lever = np.stack([one.R @ it.head[1] for one, it in zip(tracks, (a, b), strict=True)])
    place = np.stack([one.t_m for one in tracks]) + lever
    unseen = np.any(
        [(one.hits >= FEWEST_HITS).sum(axis=1) < FEWEST_STATIONS for one in tracks], axis=0
    )
    place[:, unseen] = np.nan
    sd = _sd(tracks, place, lever, a.known, index)
    return BarEnds(time_s, np.moveaxis(place, 2, 1), turn, sd, clock)


def _sd(
    tracks: Sequence[Track],
    place: Floats,
    lever: Floats,
    known: Calibrated,
    index: Sequence[Sequence[int]],
) -> Floats:
    """Standard deviation (n,) of the distance; index: of the common stations among those of either
    object, in the order of A."""
    way = place[1] - place[0]
    u = way / np.linalg.norm(way, axis=1, keepdims=True)
    gain = [s * np.hstack([u, np.cross(w, u)]) for s, w in zip((-1, 1), lever, strict=True)]
    alone = sum(
        np.einsum("na,nab,nb->n", g, one.sd.covariance, g)
        for g, one in zip(gain, tracks, strict=True)
    )
    # Rows of these stations among those of all but the first, the reference.
    first = [POSE * (np.array([k for k in members if k > 0]) - 1) for members in index]
    at = [(begin[:, None] + np.arange(POSE)).ravel() for begin in first]
    by = [
        np.einsum("na,nab->nb", g, one.sd.by_slave)[:, rows]
        for g, one, rows in zip(gain, tracks, at, strict=True)
    ]
    shared = known.covariance[np.ix_(at[0], at[0])]
    both = np.einsum("na,ab,nb->n", by[0], shared, by[1])
    return np.asarray(np.sqrt(np.maximum(alone + 2 * both, 0.0)))


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
        return self.offset_s + self.rate * time_s


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
    """The clock of object b in that of a, t_b = offset + rate t_a, by turns of stations that both
    saw. A hit at time t and angle a in turn c of a station of the second generation says when this
    turn began, b_c = t - T (a + P) / 2 pi, P being the angle of its plane. Each object counts turns
    in its own way. Stations turn at different rates, so that only the right difference of numbers
    lets all of them agree. Two stations can agree again seconds away, where the difference of their
    periods has drifted by a step of the pattern: the computer's time then tells which it is.
    stations: their indices in the hits of either, of those that both name;
    expected_s: the offset by the computer's time, NaN where it is not known.

    Raises `Refusal` where fewer than two are seen by both, or no offset lets them agree.
    """
    both = []
    for i, j in stations:
        shared = [h.take(h.station == s) for h, s in ((a, i), (b, j))]
        if min(np.unique(h.cycle).size for h in shared) >= FEWEST_TURNS:
            both.append((_begins(shared[0]), _begins(shared[1])))
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
    if (agreeing := np.flatnonzero(apart <= AGREE_S)).size != 1:
        raise Refusal(
            f"bar: {agreeing.size} differences of the clocks let the turns of {len(both)} stations"
            f" agree within {1e6 * AGREE_S:g} us, up to {within:g} s from {about:.3f} s; expected"
            " one, of objects in one recording"
        )
    pairs = []  # begins of the turns that both saw
    for (x, y), k in zip(both, number[agreeing[0]], strict=True):
        rows = np.intersect1d(x.turn + int(k), y.turn, assume_unique=True, return_indices=True)
        pairs.append((x.begin_s[rows[1]], y.begin_s[rows[2]]))
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
