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
from mocap_metrology.lighthouse.track.clocks import ClockMap, clock_map
from mocap_metrology.lighthouse.track.receiver import STEP_S, Calibrated, Track, track

FEWEST_STATIONS = 2  # that see an object at a moment
FEWEST_HITS = 3  # by which a station does


@dataclass(frozen=True)
class Object:
    """One object: its light, the stations as they are known to it, and its head R, t (m) on the
    board; host_s: zero of its clock by the computer's, NaN where it is not known."""

    scene: Scene
    known: Calibrated
    head: Pose
    host_s: float = math.nan


@dataclass(frozen=True)
class Heads:
    """Heads A and B at n moments `STEP_S` apart by the clock of A, NaN where either object was not
    seen by two stations: t_m (2, 3, n), R (2, n, 3, 3); sd_m (n,): of their distance."""

    time_s: Floats
    t_m: Floats
    R: Floats
    sd_m: Floats
    clock: ClockMap


def heads(a: Object, b: Object) -> Heads:
    """Track both objects. Raises `Refusal` where one cannot be, or clocks cannot be compared."""
    common = [name for name in a.scene.names if name in b.scene.names]
    index = [[list(one.scene.names).index(name) for name in common] for one in (a, b)]
    pairs, expected = list(zip(*index, strict=True)), a.host_s - b.host_s
    clock = clock_map(a.scene.hits, b.scene.hits, pairs, expected)
    inside = b.scene.hits.time_s.min(), b.scene.hits.time_s.max()
    own = a.scene.hits.time_s
    begin, end = (np.array(inside) - clock.offset_s) / clock.rate
    begin, end = max(begin, own.min()), min(end, own.max())
    if not end - begin > STEP_S:
        raise Refusal("bar: the objects are not seen at the same time; expected one recording")
    time_s = begin + STEP_S * np.arange(int((end - begin) / STEP_S))
    found = track(a.scene, a.known, time_s), track(b.scene, b.known, clock(time_s))
    turn = np.stack([one.R @ it.head[0] for one, it in zip(found, (a, b), strict=True)])
    lever = np.stack([one.R @ it.head[1] for one, it in zip(found, (a, b), strict=True)])
    place = np.stack([one.t_m for one in found]) + lever
    unseen = np.any(
        [(one.hits >= FEWEST_HITS).sum(axis=1) < FEWEST_STATIONS for one in found], axis=0
    )
    place[:, unseen] = np.nan
    sd = _sd(found, place, lever, a.known, index)
    return Heads(time_s, np.moveaxis(place, 2, 1), turn, sd, clock)


def _sd(
    found: Sequence[Track],
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
    own = sum(
        np.einsum("na,nab,nb->n", g, one.sd.covariance, g)
        for g, one in zip(gain, found, strict=True)
    )
    at = [_rows(members) for members in index]
    by = [
        np.einsum("na,nab->nb", g, one.sd.by_slave)[:, rows]
        for g, one, rows in zip(gain, found, at, strict=True)
    ]
    shared = known.covariance[np.ix_(at[0], at[0])]
    both = np.einsum("na,ab,nb->n", by[0], shared, by[1])
    return np.asarray(np.sqrt(np.maximum(own + 2 * both, 0.0)))


def _rows(members: Sequence[int]) -> np.ndarray:
    """Rows of these stations among those of all but the first, the reference."""
    others = POSE * (np.array([k for k in members if k > 0]) - 1)
    rows: np.ndarray = (others[:, None] + np.arange(POSE)).ravel()
    return rows
