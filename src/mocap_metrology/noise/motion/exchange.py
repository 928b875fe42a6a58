"""Labels of two or three markers that were exchanged for a while: each is where another was."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import combinations, permutations

import numpy as np

NEAR = 0.1  # of the distance of two places, at most, that a marker is from its own, or the other
PASSING = 0.01  # of the frames, at most, in which it is at none
SAMPLED = 4096  # frames from which places are taken


@dataclass(frozen=True)
class Exchange:
    """labels, each where the next was, the last where the first; frames (n,) bool."""

    labels: tuple[str, ...]
    frames: np.ndarray

    @property
    def share(self) -> float:
        """Share of the frames."""
        return float(self.frames.mean())


def put_right(labels: Sequence[str], position_mm: np.ndarray) -> list[Exchange]:
    """Exchange the labels of two or three markers back, in place, of (markers, 3, n) mm, and say
    where.

    Of markers that stay within a tenth of their distance of their places, which each has most of
    the time: what moves to and fro comes near the place of another only in passing.
    """
    some = position_mm[:, :, :: max(position_mm.shape[2] // SAMPLED, 1)].astype(float)
    known = np.isfinite(some).all(axis=1)
    place = np.full((len(labels), 3), np.nan)
    for k, mask in enumerate(known):
        if mask.any():
            place[k] = np.median(some[k][:, mask], axis=1)
    apart = np.linalg.norm(place[:, None] - place[None], axis=2)
    np.fill_diagonal(apart, np.nan)
    farthest = [
        np.nanmax(_distance_from(*one), initial=0.0) for one in zip(position_mm, place, strict=True)
    ]
    nearest = np.min(apart, axis=1, initial=np.inf, where=np.isfinite(apart))
    suspects = np.flatnonzero(farthest > (1 - NEAR) * nearest).tolist()
    away = {k: _distance_from(position_mm[k], place[k]) >= NEAR * nearest[k] for k in suspects}
    visits = {
        (a, b): np.flatnonzero(_distance_from(position_mm[a], place[b]) < NEAR * apart[a, b])
        for a, b in permutations(suspects, 2)
    }
    found: dict[tuple[int, ...], np.ndarray] = {}
    for cycle in _cycles(suspects):
        ways = [visits[pair] for pair in zip(cycle, cycle[1:] + cycle[:1], strict=True)]
        if all(way.size for way in ways):
            found[cycle] = reduce(np.intersect1d, ways)
            for k in cycle:
                away[k][found[cycle]] = False
    busy = {k for k in suspects if away[k].mean() > PASSING}
    exchanges = []
    for cycle, at in found.items():
        if at.size and not busy.intersection(cycle):
            frames = np.zeros(position_mm.shape[2], bool)
            frames[at] = True
            given = {k: position_mm[k][:, at] for k in cycle}
            for a, b in zip(cycle, cycle[1:] + cycle[:1], strict=True):
                position_mm[b][:, at] = given[a]
            exchanges.append(Exchange(tuple(labels[k] for k in cycle), frames))
    return exchanges


def _cycles(of: Sequence[int]) -> list[tuple[int, ...]]:
    """Pairs, and threes in both directions."""
    threes = [(a, *rest) for a, b, c in combinations(of, 3) for rest in ((b, c), (c, b))]
    return [*combinations(of, 2), *threes]


def _distance_from(position_mm: np.ndarray, place: np.ndarray) -> np.ndarray:
    """(n,) distance from a place, mm."""
    total = np.zeros(position_mm.shape[1])
    for axis, at in zip(position_mm, place, strict=True):
        total += np.square(axis - at, dtype=float)
    return np.sqrt(total)
