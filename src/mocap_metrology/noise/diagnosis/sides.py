"""Noise beside an event: its fast part in blocks of a second, whose level is compared five minutes
before and after (S 3.5); and whether frames are less white than it, as what moves is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from mocap_metrology.noise.allan.confidence import mean_variance
from mocap_metrology.noise.diagnosis.outliers import mad_spread

BLOCK_S = 1.0  # fast noise is what is left about means so long
FEWEST = 5  # blocks a side can be judged by
DECISIVE_FACTOR = 1.5  # an interval that reaches beyond this factor is inconclusive
LIKE_NOISE, WHITE = 0.75, 0.5  # of the whiteness beside it, of louder noise; if its size varies
LIKE, PIECES = 5, 12  # windows as long to each side, at most; pieces at least, of all
SURE, SURER = 3.0, 5.0  # standard errors of a whiteness, or by which it scatters more; a scatter


@dataclass(frozen=True)
class Blocks:
    """Means and variances about them of blocks of about a second, (k,), NaN with less than half."""

    mean: np.ndarray
    variance: np.ndarray
    length_s: float

    def between(self, start_s: float, stop_s: float, out_of: np.ndarray | None = None) -> Blocks:
        """Those that lie within, and not in `out_of` (k,)."""
        first = max(math.ceil((start_s - 1e-9) / self.length_s), 0)
        inside = slice(first, max(math.floor((stop_s + 1e-9) / self.length_s), first))
        mean, variance = self.mean[inside], self.variance[inside]
        keep = np.isfinite(mean) if out_of is None else np.isfinite(mean) & ~out_of[inside]
        return Blocks(mean[keep], variance[keep], self.length_s)

    @property
    def about_line(self) -> np.ndarray:
        """(k,) variance less b^2 / 12 of slow movement; b: mean of like steps to both sides."""
        steps = np.nan_to_num(np.diff(self.mean))
        before, after = np.append(0.0, steps), np.append(steps, 0.0)
        alike = 5 * before * after > before**2 + after**2
        return np.where(alike, self.variance - (before + after) ** 2 / 48, self.variance)

    @property
    def sd(self) -> float:
        """Standard deviation of all samples: within blocks and between them."""
        if self.mean.size < 2:
            return math.nan
        return math.sqrt(self.variance.mean() + self.mean.var())

    @property
    def fast_sd(self) -> float:
        """Standard deviation of the noise about the means of the blocks."""
        return math.sqrt(self.variance.mean()) if self.mean.size else math.nan


@dataclass(frozen=True)
class Sides:
    """One series around an event, mm: sd of everything (S's descriptor; slow noise makes it
    wander), sd of what is faster than a second, and the ratio of the latter, after to before, with
    its interval."""

    series: str
    sd_before: float
    sd_after: float
    fast_before: float
    fast_after: float
    ratio: float
    lower: float
    upper: float

    @property
    def changed(self) -> bool:
        return self.lower > 1 or self.upper < 1

    @property
    def word(self) -> Literal["changed", "alike", "undecided", "unknown"]:
        """`changed`, `alike`, or `undecided` where the interval holds 1 and more than a factor
        of 1.5; `unknown` without one."""
        if not math.isfinite(self.ratio):
            return "unknown"
        if self.changed:
            return "changed"
        alike = self.lower >= 1 / DECISIVE_FACTOR and self.upper <= DECISIVE_FACTOR
        return "alike" if alike else "undecided"


def blocks(series: np.ndarray, rate_hz: float) -> Blocks:
    """Means and variances of blocks of a series (n,), NaN in gaps; the variance is unbiased for
    white noise."""
    size = max(round(BLOCK_S * rate_hz), 2)
    rows = series[: series.size // size * size].reshape(-1, size)
    enough = np.isfinite(rows).sum(axis=1) >= size / 2
    mean, variance = np.full((2, len(rows)), np.nan)
    mean[enough] = np.nanmean(rows[enough], axis=1)
    variance[enough] = np.nanvar(rows[enough], axis=1, ddof=1)
    return Blocks(mean, variance, size / rate_hz)


def compare(series: str, before: Blocks, after: Blocks, tail: float) -> Sides:
    """Both sides; tail: probability that the ratio's interval misses the truth on either side.

    The variances of blocks are averaged, with the error that `mean_variance` states; the logarithm
    of the ratio is taken for t-distributed with as many degrees of freedom as the smaller side has.
    """
    from scipy.special import stdtrit

    fast = before.fast_sd, after.fast_sd
    few = min(before.mean.size, after.mean.size)
    stored = np.abs(np.concatenate([before.mean, after.mean])).max(initial=0.0)
    if few < FEWEST or not min(fast) > np.spacing(np.float32(stored)):  # else of rounding alone
        return Sides(series, before.sd, after.sd, *fast, math.nan, math.nan, math.nan)
    error = math.sqrt(_relative(before.variance) + _relative(after.variance)) / 2
    reach = float(stdtrit(few - 1, 1 - tail / 2)) * error
    ratio = fast[1] / fast[0]
    return Sides(
        series, before.sd, after.sd, *fast,
        ratio, ratio * math.exp(-reach), ratio * math.exp(reach),
    )  # fmt: skip


def _relative(variance: np.ndarray) -> float:
    """Relative variance of the mean of these."""
    return mean_variance(variance) / float(variance.mean()) ** 2


def likeness(
    values: np.ndarray, first: int, last: int, context: int, n_series: int
) -> tuple[float, bool, bool, bool]:
    """Whiteness of the frames first to last of (n,) values, of that beside them; whether it is
    less, and more so than louder noise may be that is correlated; whether they are louder.

    context: frames to each side, at least; n_series: of which one may be less white by chance.
    """
    from scipy.special import ndtr, ndtri

    far = max(context, LIKE * (last - first))
    start = max(first - far, 0)
    near = values[start : last + far].astype(float)
    before, within, after = np.split(near, [first - start, last - start])
    count = [max(side.size // max(within.size, 1), 1) for side in (before, after)]  # as long
    alone = [*np.array_split(before, count[0]), *np.array_split(after, count[1])]
    alone = [one for one in alone if one.size > max(map(len, alone)) / 2]  # short ones tell little
    usual = np.median([_power(one) for one in alone if one.size > 1] or [np.zeros(2)], axis=0)
    of_event, beside = _power(within), max(sum(map(len, alone)), 1)
    scatter = math.sqrt(3 / max(within.size, 1) + 3 / beside)
    white = float(of_event[1] * usual[0] / max(usual[1] * of_event[0], 1e-300))  # of that beside it
    alike = max(_alike(within), _alike(np.diff(within)), 1.0)  # fewer, where a part is louder
    sure = -float(ndtri(ndtr(-SURE) / n_series))
    off = white < min(LIKE_NOISE, max(1 - sure * math.sqrt(1 / alike + 1 / beside), WHITE))
    louder = of_event > (1 + SURE * scatter) * usual
    varies = math.exp(-SURER * _varies([before, after], within.size)) if off and louder[1] else 1.0
    return white, off, off and white < varies, bool(louder.any())


def _alike(values: np.ndarray) -> float:
    """Number of Gaussian values of one size whose mean square is as uncertain as that of (n,)."""
    squares = (values - np.nanmean(values)) ** 2 if np.isfinite(values).any() else np.ones(1)
    n = np.isfinite(squares).sum()
    return float(min(3 * np.nansum(squares) ** 2 / max(np.nansum(squares**2), 1e-300), n))


def _varies(sides: Sequence[np.ndarray], size: int) -> float:
    """Scatter of the logarithm of the whiteness of so many frames, as noise has it that is
    correlated for long: by that of shorter pieces, where there are few so long."""
    length = max(min(size, sum(map(len, sides)) // PIECES), 2)
    rows = [side[: side.size // length * length].reshape(-1, length) for side in sides]
    powers = np.array([_power(row) for row in np.concatenate(rows)])
    known = powers[powers.min(axis=1, initial=1.0) > 0] if powers.size else np.ones((1, 2))
    return mad_spread(np.log(known[:, 1] / known[:, 0])) * math.sqrt(length / max(size, 1))


def _power(values: np.ndarray) -> np.ndarray:
    """Variance of (n,) values, and half that of their steps, which of white noise is as much [von
    Neumann 1941]."""
    known = values[np.isfinite(values)]
    return np.array([np.var(known), np.var(np.diff(known)) / 2]) if known.size > 1 else np.zeros(2)
