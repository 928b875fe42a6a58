"""Levels of fast noise over the recording: did one become another at once, or slowly?

A point is the mean logarithm of the variances of ten blocks of a second. A change at once is a step
between two straight lines that fits better than a smooth curve, a quintic; all else that constant
noise does not explain is slow.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from mocap_metrology.common.hampel import MAD_TO_SIGMA
from mocap_metrology.noise.diagnosis.sides import Blocks

JOINED_BLOCKS = 10  # blocks whose logarithmic mean is one point
LEAST_POINTS = 6  # a side, or of a trend
SHORTER = (1, 2, 4)  # parts of the reach that a step is looked at over, until lines describe it
SURER_VARIANCES = 10.0  # variances of a point by which a step must fit better than a smooth curve
ADEQUATE_VARIANCES = 1.7  # variance of the residuals over that of the points, at most
INADEQUATE = 1e-3  # chance of residuals so large or so alike about a polynomial that describes them
FEWEST_PARTS = 10  # of a recording whose levels no polynomial describes
DEGREES = (1, 2, 3)  # of the polynomials that slow changes are fitted with
ENDS = 2  # degrees more, of which the ends are: the bias of the best may exceed its error
TREND_CHANCE = 0.001  # that any series of a recording is reported as changing and is not
LEAST_CHANGE = 0.02  # that is reported
MATTERS = 0.1  # relative change from which a reader is warned


@dataclass(frozen=True)
class Change:
    """A lasting change of the level of fast noise; p: probability of such a one anywhere in the
    recording by chance, at most."""

    time_s: float
    series: str
    p: float


@dataclass(frozen=True)
class Trend:
    """A slow change of the level of fast noise over the recording. change: relative, of the sd at
    the end to the start, with its 95 % interval; least, greatest: relative to the start, in
    between; part_s: where no polynomial describes it, the time over which these are means."""

    series: str
    change: float
    lower: float
    upper: float
    least: float
    greatest: float
    part_s: float = math.nan

    @property
    def steady(self) -> bool:
        """Whether it falls or rises, by an interval without zero, and does not come back."""
        sure = math.isnan(self.part_s) and (self.lower > 0 or self.upper < 0)
        return sure and abs(self.change) >= (self.greatest - self.least) / 2

    @property
    def direction(self) -> Literal["falls", "rises", "changes"]:
        """`changes` where it comes back."""
        if not self.steady:
            return "changes"
        return "falls" if self.change < 0 else "rises"

    @property
    def extent(self) -> float:
        """The size by which the largest of several trends is found."""
        return abs(self.change) if self.steady else self.greatest - self.least

    @property
    def matters(self) -> bool:
        """Whether a reader is warned."""
        size = abs(self.change) if self.steady else max(self.greatest, -self.least)
        return size >= MATTERS


def changes(
    levels: Mapping[str, Blocks], out_of: np.ndarray, side_s: float, false_alarm: float
) -> list[Change]:
    """Lasting changes of level at once in any series, the surest first, none within two minutes of
    another.

    Medians of the points over `side_s` before and after every one are compared, with the scatter of
    their differences from one to the next (Student's t, Bonferroni over points and series); where
    they differ, `abrupt` decides. out_of (k,): blocks in events.
    """
    points = {name: log_levels(one.about_line, out_of) for name, one in levels.items()}
    length = next(iter(levels.values())).length_s * JOINED_BLOCKS
    reach = max(round(side_s / length), LEAST_POINTS)
    candidates = []
    n_tests = sum(max(g.size - 2 * LEAST_POINTS + 1, 0) for g in points.values())
    for name, g in points.items():
        seen: dict[int, float] = {}
        for at, p in _contrasts(g, reach):
            if p * n_tests < false_alarm:
                place = _split(g, at, reach)
                if place not in seen:
                    seen[place] = max(p, abrupt(g, place, reach))
        candidates += [
            Change(place * length, name, min(p * n_tests, 1.0))
            for place, p in seen.items()
            if p * n_tests < false_alarm
        ]
    apart = min(2 * LEAST_POINTS * length, side_s)
    chosen: list[Change] = []
    for one in sorted(candidates, key=lambda c: c.p):
        if all(abs(one.time_s - other.time_s) >= apart for other in chosen):
            chosen.append(one)
    return chosen


def abrupt(g: np.ndarray, place: int, reach: int) -> float:
    """p of the jump between two parallel lines before and after `place`, (n,) points; 1 where a
    quintic describes them better, or where neither does over any reach."""
    from scipy.special import stdtr

    scale, dof = _scatter(g)
    for part in SHORTER:
        near = max(reach // part, LEAST_POINTS)
        k = np.arange(max(place - near, 0), min(place + near, g.size))
        k = _whole(k[np.isfinite(g[k])], place)
        t = (k - place + 0.5) / near
        if min((t < 0).sum(), (t > 0).sum()) < LEAST_POINTS - 1:
            return 1.0
        step = np.stack([np.ones(k.size), t, t > 0], axis=1)
        smooth = np.stack([t**power for power in range(6)], axis=1)
        with_step, value, error = _fit(step, g[k], scale)
        without, _, _ = _fit(smooth, g[k], scale)
        if with_step <= ADEQUATE_VARIANCES * scale**2 * (k.size - 4):
            return (
                2 * float(stdtr(dof, -abs(value[2]) / error[2]))
                if (without - with_step > SURER_VARIANCES * scale**2)
                else 1.0
            )
    return 1.0


def _whole(k: np.ndarray, place: int) -> np.ndarray:
    """Those of the points k that are not beside a change at a place, which may be within them."""
    return k[(k < place - 1) | (k > place)]


def _fit(x: np.ndarray, y: np.ndarray, scale: float) -> tuple[float, np.ndarray, np.ndarray]:
    """Sum of squared residuals, coefficients, and their standard errors."""
    value = np.linalg.lstsq(x, y, rcond=None)[0]
    error = scale * np.sqrt(np.diag(np.linalg.pinv(x.T @ x)))
    rest = y - x @ value
    return float(rest @ rest), value, error


def trends(
    levels: Mapping[str, Blocks], out_of: np.ndarray, steps_s: Sequence[float]
) -> list[Trend]:
    """Slow changes of level in any series. out_of (k,): blocks in events; steps_s: times of changes
    at once, which are fitted too: they alone are no trend, but beside one they are in its numbers.
    """
    told = []
    for name, one in levels.items():
        g = log_levels(one.about_line, out_of)
        places = [round(s / one.length_s / JOINED_BLOCKS) for s in steps_s]
        trend = _trend(name, g, places, TREND_CHANCE / len(levels), one.length_s)
        if trend and max(abs(trend.least), abs(trend.greatest)) >= LEAST_CHANGE:
            told.append(trend)
    return told


def _trend(
    name: str, g: np.ndarray, places: Sequence[int], chance: float, block_s: float
) -> Trend | None:
    """The trend by the polynomial of the least BIC, or None where an F test does not distinguish it
    from constant noise."""
    from scipy.special import fdtrc, ndtr, stdtrit

    k = np.flatnonzero(np.isfinite(g))
    for place in places:
        k = _whole(k, place)
    if k.size < 2 * LEAST_POINTS:
        return None
    scale, dof = _scatter(g)
    if not scale > 0:
        return None
    t = (k + 0.5) / g.size
    steps = [(k >= place).astype(float) for place in places]
    fits = {}
    for degree in range(DEGREES[-1] + ENDS + 1):
        x = np.stack([np.ones(k.size), *steps, *(t**n for n in range(1, degree + 1))], axis=1)
        rest, value, _ = _fit(x, g[k], scale)
        fits[degree] = rest, value, x
    best = min(DEGREES, key=lambda n: fits[n][0] / scale**2 + n * math.log(k.size))
    rest, value, x = fits[best]
    ratio = (fits[0][0] - rest) / best / scale**2
    if not fdtrc(best, dof, ratio) * len(DEGREES) < chance:
        return None
    off = g[k] - x @ value
    r_1 = float(np.clip(off[1:] @ off[:-1] / max(off @ off, 1e-300), 0, 0.9))
    left = k.size - x.shape[1]
    spread = max(rest / left, scale**2) * (1 + r_1) / (1 - r_1)
    _, value, x = fits[best + ENDS]
    powers = np.arange(1, best + ENDS + 1)
    ends = np.concatenate([[0.0], np.ones(x.shape[1] - 1)])
    error = math.sqrt(spread * float(ends @ np.linalg.pinv(x.T @ x) @ ends))
    change = float(ends @ value)
    reach = float(stdtrit(max(k.size - x.shape[1], 1), 0.975)) * error
    at = np.linspace(0, 1, 101)[:, None]
    curve = at**powers @ value[-powers.size :]
    curve += (at * g.size >= np.array(places)) @ value[1 : -powers.size] if places else 0.0
    part_s = math.nan
    large, alike = fdtrc(left, dof, rest / left / scale**2), ndtr(-r_1 * math.sqrt(k.size))
    if min(large, alike) < INADEQUATE:  # its ends are no levels
        change, reach, curve = _up_and_down(g[k])
        part_s = block_s * JOINED_BLOCKS * k.size / curve.size
    elif not fdtrc(best, left, ratio * scale**2 / spread) * len(DEGREES) < chance:
        return None  # a level that goes up and down by chance may do that
    low, high, least, greatest = (
        math.expm1(v / 2) for v in (change - reach, change + reach, curve.min(), curve.max())
    )
    return Trend(name, math.expm1(change / 2), low, high, least, greatest, part_s)


def _up_and_down(g: np.ndarray) -> tuple[float, float, np.ndarray]:
    """Change of points that no polynomial describes: the last of the means of parts (of a minute,
    or tenths) less the first, its uncertainty by the scatter of the parts, and all of them less
    the first."""
    from scipy.special import stdtrit

    count = max(FEWEST_PARTS, g.size // LEAST_POINTS)
    parts = np.array([part.mean() for part in np.array_split(g, count)])
    error = math.sqrt(2) * float(np.std(parts, ddof=1))
    reach = float(stdtrit(count - 1, 0.975)) * error
    return float(parts[-1] - parts[0]), reach, parts - parts[0]


def log_levels(variance: np.ndarray, out_of: np.ndarray) -> np.ndarray:
    """Points: mean logarithms of the variances of `JOINED_BLOCKS`, NaN with less than half."""
    with np.errstate(divide="ignore", invalid="ignore"):
        g = np.log(np.where(out_of[: variance.size], np.nan, variance))
    g[~np.isfinite(g)] = np.nan
    rows = g[: g.size // JOINED_BLOCKS * JOINED_BLOCKS].reshape(-1, JOINED_BLOCKS)
    enough = np.isfinite(rows).sum(axis=1) * 2 >= JOINED_BLOCKS
    points = np.full(len(rows), np.nan)
    points[enough] = np.nanmean(rows[enough], axis=1)
    return points


def _split(g: np.ndarray, at: int, reach: int) -> int:
    """The index at which two levels fit the points within `reach` of `at` best, by least
    squares."""
    first, last = max(at - reach, 0), min(at + reach, g.size)
    points = g[first:last]
    known = np.isfinite(points)
    total = np.cumsum(np.where(known, points, 0.0))[:-1]
    count = np.cumsum(known)[:-1]
    rest, left = total[-1] + np.nan_to_num(points[-1]) - total, known.sum() - count
    gain = total**2 / np.maximum(count, 1) + rest**2 / np.maximum(left, 1)
    return first + 1 + int(np.argmax(gain))


def _scatter(g: np.ndarray) -> tuple[float, float]:
    """Standard deviation of a point about its level, of differences from one to the next, and its
    degrees of freedom."""
    steps = np.diff(g)
    steps = steps[np.isfinite(steps)]
    if steps.size < 2 * LEAST_POINTS - 1:
        return 0.0, 0.0
    scale = MAD_TO_SIGMA * float(np.median(np.abs(steps))) / math.sqrt(2)
    return scale, max(0.37 * steps.size, 3.0)  # efficiency of the median absolute deviation


def _contrasts(g: np.ndarray, reach: int) -> list[tuple[int, float]]:
    """(place, p) of every comparison of medians, two-sided p."""
    import pandas as pd
    from scipy.special import stdtr

    scale, dof = _scatter(g)
    if not scale > 0:
        return []
    before = pd.Series(g).shift().rolling(reach, LEAST_POINTS)
    after = pd.Series(g)[::-1].rolling(reach, LEAST_POINTS)
    error = 1.2533 * scale * np.sqrt(1 / before.count() + 1 / after.count())
    t = ((after.median() - before.median()).abs() / error).dropna()
    return list(zip(t.index.tolist(), (2 * stdtr(dof, -t)).tolist(), strict=True))
