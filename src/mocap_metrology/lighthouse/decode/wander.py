"""Wander of a rotor about the line through its begins.

The loop that holds a rotor lets it swing: begins of real stations are 200 to 370 ns off their line,
with periods of 12 to 15 turns, and are told with a white noise s of 15 to 120 ns. So the wander z
is taken for an autoregressive process of second order, and minimises

    sum (y_t - z_t)^2 + l sum (z_t - 2 r cos(w) z_t-1 + r^2 z_t-2)^2

over the turns t, of which some begins y_t are missing, with the stationary distribution of z_1 and
z_2: the smoother of Whittaker (1923, Proc. Edinb. Math. Soc. 41, 63), which has r = 1 and w = 0,
and as quick. r, w, l and s are those of the greatest likelihood. With W = 1 at turns of which a
begin is known, else 0, and l Q / s^2 the inverse of the covariance of z, a band, the error of z has
the covariance s^2 (W + l Q)^-1. All hits of some turns share it, so many of them do not make it
smaller.
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
LIKELIER = 15.0  # of -2 log likelihood: of three parameters by chance once in 500
SETTLED = {"xatol": 0.02, "fatol": 0.2, "maxfev": 400}
MOST = 6000  # turns from which all these are found
BEYOND = 100  # turns before the first and after the last, in which a swing fades
MANY = 401  # turns, in the middle of which an error knows no end
OUTLIER = 5.0  # standard deviations of a begin off the curve, which then is found without it


@dataclass(frozen=True)
class Wander:
    """s in seconds, 0 where begins show no wander; l; 2 r cos(w) and r^2."""

    begin_s: float = 0.0
    stiffness: float = 0.0
    swing: float = 0.0
    decay: float = 0.0

    def curve(self, turn: np.ndarray, y: Floats, beyond: int = 0) -> tuple[Floats, float]:
        """z at all turns from the first to the last of these, where begins are y, and so many
        before and after; -2 log likelihood of y, s of the greatest, but for a constant."""
        at = turn - turn[0] + beyond
        all_y = np.zeros(int(at[-1]) + beyond + 1)
        all_y[at] = y
        z, log_det = self._solved(at, all_y)
        square = float(y @ (y - z[at]))  # (y - z)^2 and l z' Q z
        of_first = (1 - self.decay) ** 2 * ((1 + self.decay) ** 2 - self.swing**2)
        free = np.log(self.stiffness) * z.size + np.log(of_first)
        return z, float((turn.size - 2) * np.log(square) + log_det - free)

    def _solved(self, known: np.ndarray, y: Floats, share: float = 1.0) -> tuple[Floats, float]:
        """(W + l Q)^-1 y, W being `share` in these rows, and the log of the determinant."""
        n, combined = len(y), (self.decay, -self.swing, 1.0)
        band = np.zeros((3, n))
        for i, a in enumerate(combined):
            for j, b in enumerate(combined[: i + 1]):
                band[i - j, j : n - 2 + j] += self.stiffness * a * b
        band[0, :2] += self.stiffness * (1 - self.decay**2)
        band[1, 0] -= self.stiffness * self.swing * (1 - self.decay)
        band[0, known] += share
        L = linalg.cholesky_banded(band, lower=True)
        return linalg.cho_solve_banded((L, True), y), 2 * float(np.log(L[0]).sum())


@dataclass(frozen=True)
class TurnClock(Wander, Clock):
    """Line through the begins of turns of a station, and their wander about it; told: the first and
    the last turn of which the begin is known; share: of those between, about evenly."""

    told: tuple[int, int] = (0, 0)
    share: float = 1.0

    def error_of(self, pull: Floats, turn: np.ndarray) -> Floats:
        """Covariance of pull' e in s^2, e being the error of line and wander at these turns; pull
        (turns, n). With X = [1, t] and M = W + l Q, e has that of `Wander` and that of the line,

            s^2 (M^-1 + G (X' W G)^-1 G'),   G = X - M^-1 W X.
        """
        ends = np.r_[turn.min(), turn.max(), self.told]
        at = np.zeros((int(np.ptp(ends)) + 1, pull.shape[1]))
        np.add.at(at, turn - ends.min(), pull)
        X = np.column_stack([np.ones(len(at)), np.linspace(-1, 1, len(at))])
        known = np.arange(self.told[0], self.told[1] + 1) - ends.min()
        of_line, left, s = np.zeros_like(X), np.zeros_like(at), self.rms_s
        of_line[known], G = self.share * X[known], X
        if self.begin_s > 0:
            both, _ = self._solved(known, np.hstack([at, of_line]), self.share)
            left, G, s = both[:, :-2], X - both[:, -2:], self.begin_s
        moved = G.T @ at
        return s**2 * (at.T @ left + moved.T @ np.linalg.pinv(of_line.T @ G) @ moved)

    @property
    def variance(self) -> float:
        """Variance of the error of the clock at a turn far from the first and the last one, s^2."""
        turn, usual = np.arange(MANY), replace(self, told=(0, MANY - 1))
        return float(usual.error_of((turn[:, None] == MANY // 2) * 1.0, turn)[0, 0])


@dataclass(frozen=True)
class Delay:
    """How late a rotor is in seconds, at all turns from `first` on; as at the last one after it."""

    first: int
    at_turns: Floats

    def __call__(self, turn: Floats) -> Floats:
        """At parts of turns, too: it swings on between two begins."""
        every = self.first + np.arange(self.at_turns.size)
        return CubicSpline(every, self.at_turns)(np.clip(turn, every[0], every[-1]))


def wander(turn: np.ndarray, residual_s: Floats, resolution_s: float) -> tuple[Delay, Wander]:
    """How late a rotor is, by rising turns and what their begins are off the line, and the model of
    it; not at all where that is below the resolution, or no likelier than the line."""
    every = np.arange(turn[0] - BEYOND, turn[-1] + BEYOND + 1)
    spread = MAD_TO_SIGMA * float(np.median(np.abs(residual_s)))
    best, z = Wander(), np.zeros(every.size)
    if spread < 0.5 * resolution_s:
        return Delay(int(every[0]), z), best
    y, good = residual_s / spread, np.ones(turn.size, np.bool_)
    for _ in range(2):
        at = turn[good]
        likeliest = _likeliest(at[:MOST], y[good][:MOST])
        if likeliest is None:
            return Delay(int(every[0]), 0 * z), Wander()
        best = likeliest
        seen = np.arange(at[0] - BEYOND, at[-1] + BEYOND + 1)
        z = np.interp(every, seen, best.curve(at, y[good], BEYOND)[0])
        off = np.abs(y - z[turn - every[0]])
        good = off <= OUTLIER * MAD_TO_SIGMA * float(np.median(off))
        if good.all():
            break
    return Delay(int(every[0]), spread * z), replace(best, begin_s=spread * best.begin_s)


def _likeliest(turn: np.ndarray, y: Floats) -> Wander | None:
    """None where a line is as likely."""
    free = turn.size - 2

    def one(x: Sequence[float]) -> Wander:
        r, w = 1 / (1 + np.exp(-x[0])), np.pi / (1 + np.exp(-x[1]))
        return Wander(0.0, float(np.exp(x[2])), float(2 * r * np.cos(w)), float(r**2))

    def cost(x: Sequence[float]) -> float:
        try:
            return one(x).curve(turn, y)[1]
        except linalg.LinAlgError:  # rounding is more than begins far apart determine
            return np.inf

    best = min(
        (
            optimize.minimize(cost, start, method="Nelder-Mead", bounds=BOUNDS, options=SETTLED)
            for start in STARTS
        ),
        key=lambda tried: tried.fun,
    )
    off_line = y - np.polyval(np.polyfit(turn, y, 1), turn)
    if not best.fun < free * np.log(off_line @ off_line) - LIKELIER:
        return None
    model = one(best.x)
    square = float(y @ (y - model.curve(turn, y)[0][turn - turn[0]]))
    return replace(model, begin_s=float(np.sqrt(square / free)))
