"""Markers that motion capture saw, a tracked board, and what brings one to the other."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.types import Floats

FEWEST_FRAMES = 4
NEAR = 1.6  # frames: a moment between two that were seen
CLEANINGS = 6
CLEAN_TIMES, CLEAN_M = 12.0, 5e-3  # off the path: times the median, and at least


@dataclass(frozen=True)
class Markers:
    """Places (markers, 3, frames) in m, NaN where one was not seen; frame 0 is at time 0."""

    labels: tuple[str, ...]
    rate_hz: float
    place_m: Floats

    def cleaned(self) -> Markers:
        """Without places that leave the path of their neighbours for a frame or two, as those of
        another marker do: by the cubic through two frames to each side."""
        place = self.place_m.copy()
        for _ in range(CLEANINGS):
            off = np.zeros(place.shape[::2])
            inner = 4 * (place[..., 1:-3] + place[..., 3:-1]) - place[..., :-4] - place[..., 4:]
            off[:, 2:-2] = np.linalg.norm(place[..., 2:-2] - inner / 6, axis=1)
            off = np.nan_to_num(off)
            usual = np.array([np.median(own[own > 0]) if own.any() else 0.0 for own in off])
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

    @cached_property
    def _spline(self) -> Any:
        from scipy.interpolate import CubicSpline

        if self._seen.size < FEWEST_FRAMES:
            names = ", ".join(self.labels)
            raise Refusal(f"receiver: {names} are seen together in {self._seen.size} frames")
        return CubicSpline(self._seen, np.moveaxis(self.place_m[:, :, self._seen], 2, 0))

    @property
    def duration_s(self) -> float:
        """From the first frame to the last."""
        return (self.place_m.shape[2] - 1) / self.rate_hz

    def at(self, time_s: Floats) -> tuple[Floats, Floats]:
        """Places and velocities (n, markers, 3) by cubic splines; NaN but between two frames that
        have all markers."""
        spline, frames, at = self._spline, self._seen, time_s * self.rate_hz
        after = np.clip(np.searchsorted(frames, at), 1, frames.size - 1)
        inside = (at >= frames[after - 1]) & (at <= frames[after])
        inside &= frames[after] - frames[after - 1] <= NEAR
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
        """Of motion capture, at times of the track."""
        found: Floats = self.offset_s + time_s + self.rate * (time_s - self.middle_s)
        return found

    def values(self) -> Floats:
        """Offset, rate, lever and scale, in one row."""
        return np.r_[self.offset_s, self.rate, self.lever_m.ravel(), self.scale]
