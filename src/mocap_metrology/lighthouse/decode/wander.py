"""Wander of a rotor about the line through its begins.

The loop that holds a rotor lets it swing: begins of real stations are 200 to 370 ns off their line,
with periods of 12 to 15 turns, and are told with a white noise s of 15 to 120 ns. So the wander z
is taken for an autoregressive process of second order, and minimises

    sum (y_t - z_t)^2 + l sum (z_t - 2 r cos(w) z_t-1 + r^2 z_t-2)^2

over the turns t, of which some begins y_t are missing: the smoother of Whittaker (1923, Proc.
Edinb. Math. Soc. 41, 63), which has r = 1 and w = 0, and as quick. r, w, l and s are those of the
greatest likelihood, without anything known of z_1 and z_2. With W = 1 at turns of which a begin is
known, else 0, and D the combinations in the second sum, the error of z has the covariance
s^2 (W + l D'D)^-1. All hits of some turns share it, so many of them do not make it smaller.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import linalg, optimize
from scipy.interpolate import CubicSpline

from mocap_metrology.common.hampel import MAD_TO_SIGMA
from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.records import Clock

# Logits of r and of w / pi, log l: a swing, and a slow wander.
STARTS = (3.0, -2.0, 2.0), (6.0, -6.0, 6.0)
BOUNDS = (-4.0, 9.0), (-9.0, 0.0), (-5.0, 25.0)
NONE = (9.0, -9.0), (-4.0, -9.0)  # and the largest l: another line, and the one there is
LIKELIER = 15.0  # of -2 log likelihood: of three parameters by chance once in 500
SETTLED = {"xatol": 0.02, "fatol": 0.2, "maxfev": 400}
MOST = 6000  # turns from which all these are found
MANY = 401  # turns, in the middle of which an error knows no end
OUTLIER = 5.0  # standard deviations of a begin off the curve, which then is found without it


@dataclass(frozen=True)
class Wander:
    """s in seconds, 0 where begins show no wander; l; 2 r cos(w) and r^2."""

    begin_s: float = 0.0
    stiffness: float = 0.0
    swing: float = 0.0
    decay: float = 0.0

    def error_of(self, pull: Floats, turn: np.ndarray) -> Floats:
        """Covariance of pull' z in s^2, of the error of the wander at these turns, of all of which
        begins are known; pull (turns, n)."""
        known, which = np.unique(turn, return_inverse=True)
        at = np.zeros((int(known[-1] - known[0]) + 1, pull.shape[1]))
        np.add.at(at, known[which] - known[0], pull)
        found: Floats = self.begin_s**2 * at.T @ self._solved(known, at)[0]
        return found

    @property
    def variance(self) -> float:
        """Of its error at a turn, far from the first and the last one, in s^2."""
        turn = np.arange(MANY)
        return float(self.error_of((turn[:, None] == MANY // 2) * 1.0, turn)[0, 0])

    def curve(self, turn: np.ndarray, y: Floats) -> tuple[Floats, float, float]:
        """z at all turns from the first to the last of these, where begins are y; the least of the
        sum; log det (W + l D'D)."""
        all_y = np.zeros(int(turn[-1] - turn[0]) + 1)
        all_y[turn - turn[0]] = y
        z, log_det = self._solved(turn, all_y)
        off = z[2:] - self.swing * z[1:-1] + self.decay * z[:-2]
        square = np.sum((y - z[turn - turn[0]]) ** 2) + self.stiffness * np.sum(off**2)
        return z, float(square), log_det

    def _solved(self, turn: np.ndarray, y: Floats) -> tuple[Floats, float]:
        """(W + l D'D)^-1 y, W being of these turns, and the log of the determinant.

        From the last turn to the first: nothing holds the first two, from which a process that
        decays would let errors of rounding grow.
        """
        n, combined = len(y), (1.0, -self.swing, self.decay)
        band = np.zeros((3, n))
        for i, a in enumerate(combined):
            for j, b in enumerate(combined[: i + 1]):
                band[i - j, j : n - 2 + j] += self.stiffness * a * b
        band[0, n - 1 - (turn - turn[0])] += 1
        L = linalg.cholesky_banded(band, lower=True)
        return linalg.cho_solve_banded((L, True), y[::-1])[::-1], 2 * float(np.log(L[0]).sum())


@dataclass(frozen=True)
class TurnClock(Wander, Clock):
    """Line through the begins of turns of a station, and their wander about it."""


@dataclass(frozen=True)
class Late:
    """How late a rotor is in seconds, at all turns from `first` on."""

    first: int
    at_turns: Floats

    def __call__(self, turn: Floats) -> Floats:
        """At parts of turns, too: it swings on between two begins."""
        every = self.first + np.arange(self.at_turns.size)
        found: Floats = CubicSpline(every, self.at_turns)(np.clip(turn, every[0], every[-1]))
        return found


def wander(turn: np.ndarray, residual_s: Floats, resolution_s: float) -> tuple[Late, Wander]:
    """How late a rotor is, by rising turns and what their begins are off the line, and the model of
    it; not at all where that is below the resolution, or no likelier than the line."""
    every = np.arange(turn[0], turn[-1] + 1)
    spread = MAD_TO_SIGMA * float(np.median(np.abs(residual_s)))
    found, z = Wander(), np.zeros(every.size)
    if spread < 0.5 * resolution_s:
        return Late(int(turn[0]), z), found
    y, good = residual_s / spread, np.ones(turn.size, np.bool_)
    for _ in range(2):
        at = turn[good]
        likeliest = _likeliest(at[:MOST], y[good][:MOST])
        if likeliest is None:
            return Late(int(turn[0]), 0 * z), Wander()
        found = likeliest
        z = np.interp(every, np.arange(at[0], at[-1] + 1), found.curve(at, y[good])[0])
        off = np.abs(y - z[turn - turn[0]])
        good = off <= OUTLIER * MAD_TO_SIGMA * float(np.median(off))
        if good.all():
            break
    return Late(int(turn[0]), spread * z), replace(found, begin_s=spread * found.begin_s)


def _likeliest(turn: np.ndarray, y: Floats) -> Wander | None:
    """None where the line is as likely, or begins are too few to tell."""
    free, span = turn.size - 2, int(turn[-1] - turn[0]) - 1
    *bounds, (low, most) = BOUNDS
    most = min(most, 4 * np.log(span / np.pi))  # of half a wave within the turns

    def of(x: Sequence[float]) -> tuple[float, Wander]:
        r, w = 1 / (1 + np.exp(-x[0])), np.pi / (1 + np.exp(-x[1]))
        one = Wander(0.0, float(np.exp(x[2])), float(2 * r * np.cos(w)), float(r**2))
        try:
            _, square, log_det = one.curve(turn, y)
        except linalg.LinAlgError:  # rounding is more than begins far apart determine
            return np.inf, one
        found = replace(one, begin_s=float(np.sqrt(square / free)))
        return free * np.log(square) + log_det - span * x[2], found

    tried = [
        optimize.minimize(
            lambda x: of(x)[0],
            start,
            method="Nelder-Mead",
            bounds=[*bounds, (low, most)],
            options=SETTLED,
        )
        for start in STARTS
    ]
    cost, found = of(min(tried, key=lambda one: one.fun).x)
    line = min(of((*one, most))[0] for one in NONE)
    return found if cost < line - LIKELIER and np.isfinite(line) else None
