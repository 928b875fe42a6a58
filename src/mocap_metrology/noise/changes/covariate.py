"""Coherence of the noise with a covariate, such as a temperature recorded at the same time."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.types import Floats, Row
from mocap_metrology.noise.changes.compare import WINDOWS, coherence
from mocap_metrology.noise.series import block_means

BLOCKS = 360  # samples of a comparison, at most: what slow causes need, and few enough tests
LEAST_BLOCKS = 4 * (WINDOWS + 1)  # windows of eight samples
HOLE = 3  # steps without a sample
# Of the blocks. Straight lines through holes of one of both raise no false alarms; where they
# bridge both at once, alarms of 5 % become 6 to 8 % at a tenth, 13 to 21 % at a quarter, by Monte
# Carlo
MOST_MISSING = 0.25
MOST_MISSING_IN_BOTH = 0.1


@dataclass(frozen=True)
class Covariate:
    """`name` with its unit as the file has it; `time_s` (n,) rising from the recording's first
    frame, `values` (n,)."""

    name: str
    time_s: Floats
    values: Floats

    @property
    def step_s(self) -> float:
        return float(np.median(np.diff(self.time_s)))


def coherence_row(
    series: np.ndarray, frame_rate_hz: float, covariate: Covariate, alpha: float
) -> Row:
    """The period at which a series (n,) in mm and the covariate are most coherent, as a row of a
    table.

    Both are means over blocks as long as a step of the covariate, or longer: `BLOCKS` blocks of
    the time both were recorded at most. `word`: `goes with it` where the coherence exceeds what an
    unrelated random pair reaches anywhere with probability alpha (periodic ones: see `coherence`).
    `gain_mm_per_unit` is the size of the response at that period, `lag_s` how much the series is
    behind (modulo the period). `note`, if there is one, reports holes in the covariate. Refuses
    fewer than `LEAST_BLOCKS` blocks, too many that are missing, and whatever never changes.
    """
    first, last = _common_time(series.size / frame_rate_hz, covariate)
    length_s = max(covariate.step_s, (last - first) / BLOCKS)
    length = max(round(length_s * frame_rate_hz), 1)
    start = max(math.ceil(first * frame_rate_hz), 0)
    common = series[start : math.floor(last * frame_rate_hz)]
    means = block_means(common, length)
    if means.size < LEAST_BLOCKS:
        raise Refusal(
            f"covariate: {means.size} steps of {length / frame_rate_hz:g} s in the"
            f" {last - first:g} s that {covariate.name} shares with the recording; expected"
            f" {LEAST_BLOCKS} or more"
        )
    edges = (start + np.arange(means.size + 1) * length) / frame_rate_hz
    holes = _in_holes(covariate, edges)
    _check_missing(~np.isfinite(means), holes, covariate.name)
    seen = common[np.isfinite(common)]
    if np.ptp(seen) == 0:
        raise Refusal(
            f"covariate: the series never changes ({seen[0]:g} mm): it cannot correlate with "
            "anything"
        )
    beside = _interval_means(covariate, edges)
    swing = float(np.ptp(beside))
    if swing == 0:
        raise Refusal(
            f"covariate: {covariate.name} stays at {beside[0]:g}: nothing can correlate with it"
        )
    unit = (beside - beside[0]) / swing  # or the squares of very large values overflow
    estimate = coherence(_filled(means), unit, length / frame_rate_hz, alpha)
    above = estimate.squared - estimate.threshold
    best = int(np.where(estimate.same_phase, above, above - 1).argmax())
    clear = bool(above[best] > 0 and estimate.same_phase[best])
    row: Row = {
        "covariate": covariate.name,
        "word": "goes with it" if clear else "unrelated",
        "coherence": float(estimate.squared[best]),
        "threshold": float(estimate.threshold[best]),
        "period_s": 1 / float(estimate.f_hz[best]),
        "gain_mm_per_unit": float(estimate.gain[best]) / swing if clear else math.nan,
        "lag_s": float(estimate.phase_rad[best] / (2 * np.pi * estimate.f_hz[best]))
        if clear
        else math.nan,
        "from_s": first,
        "to_s": last,
    }
    if holes.any():
        row["note"] = (
            f"{covariate.name} has no samples in {100 * holes.mean():.2g} % of the common time "
            f"(gaps of more than {HOLE} steps): interpolated linearly"
        )
    return row


def _common_time(duration_s: float, covariate: Covariate) -> tuple[float, float]:
    """From and to when both were recorded, in s."""
    first = max(float(covariate.time_s[0]), 0.0)
    last = min(float(covariate.time_s[-1]), duration_s)
    if first >= last:
        raise Refusal(
            f"covariate: {covariate.name} is of {covariate.time_s[0]:g} to "
            f"{covariate.time_s[-1]:g} s, the recording of 0 to "
            f"{duration_s:g} s; expected times from its first frame"
        )
    return first, last


def _in_holes(covariate: Covariate, edges_s: np.ndarray) -> np.ndarray:
    """(n,) whether more than half of a block lies in holes of the covariate."""
    apart = np.diff(covariate.time_s)
    missing = np.append(0.0, np.cumsum(np.where(apart > HOLE * covariate.step_s, apart, 0.0)))
    until = np.interp(edges_s, covariate.time_s, missing)
    return np.diff(until) > 0.5 * np.diff(edges_s)


def _check_missing(gaps: np.ndarray, holes: np.ndarray, name: str) -> None:
    """Refuse more gaps of the markers and holes of the covariate than may be bridged."""
    limits = (
        (gaps, MOST_MISSING, "a gap of the markers"),
        (holes, MOST_MISSING, f"a gap of {name}"),
        (gaps & holes, MOST_MISSING_IN_BOTH, f"a gap of the markers and of {name} at once"),
    )
    for missing, most, what in limits:
        if missing.mean() > most:
            share = "a quarter" if most == MOST_MISSING else "a tenth"
            raise Refusal(f"covariate: more than {share} of the common time is {what}")


def _interval_means(covariate: Covariate, edges_s: np.ndarray) -> np.ndarray:
    """(n,) means between (n + 1,) edges of straight lines through the samples: what is faster than
    a block, noise of the sensor above all, averages out as it does in the series."""
    at = np.union1d(covariate.time_s, edges_s)
    base = covariate.values[0]  # without it, rounding would move a constant
    values = np.interp(at, covariate.time_s, covariate.values - base)
    area = np.append(0.0, np.cumsum((values[1:] + values[:-1]) / 2 * np.diff(at)))
    return base + np.diff(area[np.searchsorted(at, edges_s)]) / np.diff(edges_s)


def _filled(means: Floats) -> Floats:
    """Blocks without data from their neighbours."""
    there = np.isfinite(means)
    at = np.arange(means.size)
    return np.interp(at, at[there], means[there])
