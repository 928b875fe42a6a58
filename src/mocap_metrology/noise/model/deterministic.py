"""The part of a series that is no noise: a straight line and an exponential warm-up.

    x(t) = drift t + A_w exp(-t / T_w),  t from the first frame

drift in mm/h, A_w in mm (positive where the series falls towards its end), T_w in s. It has no
spectrum: it happens once, at the start, where a random walk happens all the time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.types import Floats

PARAMETERS = ("drift", "A_w", "T_w")
UNITS = {"drift": "mm/h", "A_w": "mm", "T_w": "s"}
HOUR = 3600.0
MIDDLES = (np.arange(512) + 0.5) / 512  # places of an average over time
HORIZONS = 16  # every so many of them where a horizon begins


@dataclass(frozen=True)
class Deterministic:
    """drift: mm/h; A_w: mm; T_w: s; zero where there is none."""

    drift: float = 0.0
    A_w: float = 0.0
    T_w: float = 0.0

    @property
    def empty(self) -> bool:
        """Whether there is nothing."""
        return self.drift == 0 and self.A_w == 0

    @property
    def name(self) -> str:
        """What a reader calls it."""
        return "warm-up" if self.drift == 0 else "drift"

    def at(self, t: np.ndarray) -> np.ndarray:
        """x(t), mm, at t (any shape) in s from the first frame."""
        t = np.asarray(t, float)
        x = self.drift / HOUR * t
        return x + self.A_w * np.exp(-t / self.T_w) if self.A_w else x

    def means(self, start: Floats, duration: float) -> Floats:
        """Means of x over start ... start + duration, s."""
        start = np.asarray(start, float)
        x = self.drift / HOUR * (start + duration / 2)
        if not self.A_w:
            return x
        return x + self.A_w * np.exp(-start / self.T_w) * _decay(np.array(duration / self.T_w))

    def avar(self, tau: np.ndarray, duration: float) -> Floats:
        """Allan variance, mm^2, at tau (k,) of a series of `duration` s, overlapping: half the mean
        square of the difference of adjacent means, over all starts. With a = tau / T_w that
        difference is d + B exp(-start / T_w), d = drift tau, B = -A_w (1 - exp(-a))^2 / a; a line
        has d^2 / 2."""
        tau = np.atleast_1d(np.asarray(tau, float))
        d = self.drift / HOUR * tau
        if not self.A_w:
            return d**2 / 2
        a = tau / self.T_w
        B = -self.A_w * np.expm1(-a) ** 2 / a
        starts = np.maximum(duration - 2 * tau, 0.0) / self.T_w
        return (d**2 + 2 * d * B * _decay(starts) + B**2 * _decay(2 * starts)) / 2

    def variance_of_means(self, mean_s: float, horizon_s: float, duration_s: float) -> float:
        """Mean square, mm^2, of what means over `mean_s` are from the mean of `horizon_s`, over all
        horizons of a recording of `duration_s`: the deterministic part of `assess.spread.spread`.
        A line has drift^2 (horizon^2 - mean^2) / 12."""
        horizon_s = min(horizon_s, duration_s)
        count = int(horizon_s / mean_s * (1 + 1e-9)) if mean_s > 0 else 0
        if self.empty or count < 2:
            return 0.0
        which = np.floor(MIDDLES * count) if count > MIDDLES.size else np.arange(count)
        places = MIDDLES[::HORIZONS] if duration_s > horizon_s else np.zeros(1)
        first = (places * (duration_s - horizon_s))[:, None]
        means = self.means(first + which * mean_s, mean_s)
        return float(np.mean((means - means.mean(axis=1, keepdims=True)) ** 2))


def _decay(x: Floats) -> Floats:
    """Mean of exp(-u) over 0 ... x, (1 - exp(-x)) / x; 1 at zero."""
    return np.where(x > 0, -np.expm1(-x) / np.where(x > 0, x, 1.0), 1.0)
