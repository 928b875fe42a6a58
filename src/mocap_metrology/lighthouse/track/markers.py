"""Markers that motion capture saw, a tracked board, and what brings one to the other."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from typing import Any

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.types import Floats

NEAR, NEAR_S = 1.6, 0.035  # frames, or time: between are moments that were seen
CLEANINGS = 6
CLEAN_TIMES, CLEAN_M = 12.0, 5e-3  # off the path, or the distance: times the noise, and at least
FILLED_S, STRAIGHT_M = 0.1, 5e-7  # longer, and with smaller second differences: not measured
NOT_RIGID_M, NOT_RIGID = 0.02, 0.02  # change of a distance in half of the frames, also over it


@dataclass(frozen=True)
class Markers:
    """Places (markers, 3, frames) in m, NaN where one was not seen; frame 0 is at time 0.

    not_rigid: share of the frames left out in which distances are not those of the other frames.
    """

    labels: tuple[str, ...]
    rate_hz: float
    place_m: Floats
    not_rigid: float = 0.0

    def cleaned(self) -> Markers:
        """Without places that are held or filled in while a marker is not seen, that leave the
        path of their neighbours for a frame or two, and without frames in which the markers are not
        where they are on the rigid receiver, as where two are exchanged. Raises `Refusal` where
        they are on none."""
        return self._measured()._on_paths()._rigid()

    def _measured(self) -> Markers:
        """Without the origin, and without stretches that are straight to the last digit."""
        place = np.where((self.place_m == 0).all(axis=1, keepdims=True), np.nan, self.place_m)
        least = max(math.ceil(FILLED_S * self.rate_hz), 3)
        for xyz in place:
            bend = np.full(xyz.shape[1], np.inf)
            bend[1:-1] = np.abs(xyz[:, 2:] - 2 * xyz[:, 1:-1] + xyz[:, :-2]).max(axis=0)
            straight = bend < STRAIGHT_M
            begins = np.flatnonzero(np.diff(straight, prepend=~straight[:1]))
            length = np.diff(np.append(begins, straight.size))
            straight &= np.repeat(length >= least, length)
            xyz[:, np.convolve(straight, np.ones(3), mode="same") > 0] = np.nan  # with its ends
        return replace(self, place_m=place)

    def _rigid(self) -> Markers:
        n, frames = len(self.labels), self.place_m.shape[2]
        wrong, together = np.zeros((2, frames), dtype=bool)
        change = np.full(n, np.nan)  # of the distance to the marker that keeps it best
        for i, j in combinations(range(n), 2):
            apart = np.linalg.norm(self.place_m[i] - self.place_m[j], axis=0)
            if not (known := np.isfinite(apart)).any():
                continue
            middle = np.median(apart[known])
            off = np.abs(apart - middle)
            usual = np.median(off[known])
            change[[i, j]] = np.fmin(change[[i, j]], usual if usual > NOT_RIGID * middle else 0.0)
            steps = np.abs(np.diff(apart[known]))  # which a marker that slips once leaves small
            noise = min(usual, float(np.median(steps))) if steps.size else usual
            wrong |= off > max(CLEAN_TIMES * noise, CLEAN_M)
            together |= known
        if names := [self.labels[k] for k in np.flatnonzero(change > NOT_RIGID_M)]:
            raise Refusal(
                f"receiver: no marker keeps its distance from {' or '.join(names)} within"
                f" {1e3 * NOT_RIGID_M:g} mm in half of the frames; expected markers on one body"
            )
        share = float(wrong.sum() / max(together.sum(), 1))
        return replace(self, place_m=np.where(wrong, np.nan, self.place_m), not_rigid=share)

    def _on_paths(self) -> Markers:
        """The markers without frames that are far off the cubic through two frames to each side."""
        place = self.place_m.copy()
        for _ in range(CLEANINGS):
            off = np.zeros(place.shape[::2])
            inner = 4 * (place[..., 1:-3] + place[..., 3:-1]) - place[..., :-4] - place[..., 4:]
            off[:, 2:-2] = np.linalg.norm(place[..., 2:-2] - inner / 6, axis=1)
            off = np.nan_to_num(off)
            usual = np.array([np.median(row[row > 0]) if row.any() else 0.0 for row in off])
            limit = np.maximum(CLEAN_TIMES * usual, CLEAN_M)[:, None]
            peak = (off >= np.roll(off, 1, axis=1)) & (off >= np.roll(off, -1, axis=1))
            wrong = peak & (off > limit)
            if not wrong.any():
                break
            place[np.broadcast_to(wrong[:, None], place.shape)] = np.nan
        return replace(self, place_m=place)

    @cached_property
    def _seen(self) -> np.ndarray:
        return np.flatnonzero(np.isfinite(self.place_m).all(axis=(0, 1)))

    @property
    def known_s(self) -> float:
        """How long all were seen, from one frame to the next."""
        steps = np.diff(self._seen)
        return float(steps[steps <= self._near].sum()) / self.rate_hz

    @property
    def _near(self) -> float:
        return max(NEAR, NEAR_S * self.rate_hz)

    @cached_property
    def _spline(self) -> Any:
        from scipy.interpolate import CubicSpline

        return CubicSpline(self._seen, np.moveaxis(self.place_m[:, :, self._seen], 2, 0))

    @property
    def duration_s(self) -> float:
        return (self.place_m.shape[2] - 1) / self.rate_hz

    def at(self, time_s: Floats) -> tuple[Floats, Floats]:
        """Places and velocities (n, markers, 3) by cubic splines; NaN but between two frames near
        each other that have all markers."""
        spline, frames, at = self._spline, self._seen, time_s * self.rate_hz
        after = np.clip(np.searchsorted(frames, at), 1, frames.size - 1)
        inside = (at >= frames[after - 1]) & (at <= frames[after])
        inside &= frames[after] - frames[after - 1] <= self._near
        at = np.where(inside, at, np.nan)
        return spline(at), spline(at, 1) * self.rate_hz


@dataclass(frozen=True)
class Tracked:
    """Poses of a board at moments of one step, NaN where unknown: R (n, 3, 3), t (n, 3) in m; noise
    (n,): standard deviation of a coordinate, in m."""

    time_s: Floats
    R: Floats
    t_m: Floats
    noise_m: Floats


@dataclass(frozen=True)
class Alignment:
    """What brings a track to motion capture, by the formula of `mocap`; lever (markers, 3) in m."""

    A: Floats
    b_m: Floats
    offset_s: float
    rate: float
    lever_m: Floats
    middle_s: float
    scale: float = 1.0

    def time(self, time_s: Floats) -> Floats:
        """Times of motion capture that belong to times of the track, in s."""
        return self.offset_s + time_s + self.rate * (time_s - self.middle_s)

    def values(self) -> Floats:
        """Offset, rate, lever and scale, in one row."""
        return np.r_[self.offset_s, self.rate, self.lever_m.ravel(), self.scale]
