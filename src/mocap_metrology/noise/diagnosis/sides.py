"""Fast noise in blocks of a second, and its level five minutes before and after an event (S
3.5)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from mocap_metrology.noise.allan.confidence import mean_variance

BLOCK_S = 1.0  # fast noise is what is left about means so long
FEWEST = 5  # blocks a side can be judged by
DECISIVE_FACTOR = 1.5  # an interval that reaches beyond this factor is inconclusive


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
