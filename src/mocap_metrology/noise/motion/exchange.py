"""Labels of two markers that were exchanged for a while: each is where the other was."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

NEAR = 0.1  # of their distance, at most, that both are from each other's place
SAMPLED = 4096  # frames from which places are taken


@dataclass(frozen=True)
class Exchange:
    """labels; frames (n,) bool."""

    labels: tuple[str, str]
    frames: np.ndarray

    @property
    def share(self) -> float:
        """Share of the frames."""
        return float(self.frames.mean())


def put_right(labels: Sequence[str], position_mm: np.ndarray) -> list[Exchange]:
    """Exchange the labels back, in place, of (markers, 3, n) mm, and say where.

    Of markers that stay within a tenth of their distance of two places, which each has most of the
    time: what moves to and fro comes near the place of another only in passing.
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
    exchanges = []
    for at, a in enumerate(suspects):
        for b in suspects[at + 1 :]:
            near = NEAR * apart[a, b]
            frames = _distance_from(position_mm[a], place[b]) < near
            frames &= _distance_from(position_mm[b], place[a]) < near
            away = [
                (~frames & (_distance_from(position_mm[k], place[k]) >= near)).mean()
                for k in (a, b)
            ]
            if not frames.any() or max(away) > 0.01:
                continue
            position_mm[a][:, frames], position_mm[b][:, frames] = (
                position_mm[b][:, frames],
                position_mm[a][:, frames],
            )
            exchanges.append(Exchange((labels[a], labels[b]), frames))
    return exchanges


def _distance_from(position_mm: np.ndarray, place: np.ndarray) -> np.ndarray:
    """(n,) distance from a place, mm."""
    total = np.zeros(position_mm.shape[1])
    for axis, at in zip(position_mm, place, strict=True):
        total += np.square(axis - at, dtype=float)
    return np.sqrt(total)
