"""Temperature or whatever else was recorded beside a recording, and what noise goes with it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.compare import block_means, coherence

BLOCKS = 360  # samples of a comparison, at most: what slow causes need, and few enough tests


@dataclass(frozen=True)
class Covariate:
    """`name` with its unit as the file has it; `time_s` (n,) rising from the recording's first
    frame, `values` (n,)."""

    name: str
    time_s: np.ndarray
    values: np.ndarray

    @property
    def step_s(self) -> float:
        return float(np.median(np.diff(self.time_s)))


def read_covariate(path: str | Path) -> Covariate:
    """A CSV file with two columns, `time_s` and another; refused in one line if it is not that."""
    import pandas as pd

    name = Path(path).name
    try:
        table = pd.read_csv(path, encoding="utf-8-sig")
    except (ValueError, OSError) as error:
        raise Refusal(f"{name}: {' '.join(str(error).split())}; expected a CSV file") from error
    columns = [str(column).strip() for column in table.columns]
    if len(columns) != 2 or columns[0] != "time_s":
        raise Refusal(f"{name}: columns {', '.join(columns)}; expected time_s and one other")
    values = table.apply(pd.to_numeric, errors="coerce").to_numpy(dtype=float)
    bad = np.flatnonzero(~np.isfinite(values).all(axis=1))
    if bad.size:
        raise Refusal(f"{name}, line {bad[0] + 2}: expected two numbers")
    if len(values) < 2 or (np.diff(values[:, 0]) <= 0).any():
        raise Refusal(f"{name}: time_s must rise from line to line, over two lines or more")
    return Covariate(columns[1], values[:, 0], values[:, 1])


def together(
    series: np.ndarray, frame_rate_hz: float, covariate: Covariate, alpha: float
) -> dict[str, Any]:
    """Where a series (n,) in mm and the covariate have most in common, as a row of a table.

    Both are means over blocks as long as a step of the covariate, or longer: `BLOCKS` blocks of
    the time both were recorded at most. `word`: `goes with it` where the coherence exceeds what an
    unrelated pair reaches anywhere with probability alpha. `gain_mm_per_unit` is the size of the
    response at that period, `lag_s` how much the series is behind (modulo the period).
    """
    first = max(float(covariate.time_s[0]), 0.0)
    last = min(float(covariate.time_s[-1]), series.size / frame_rate_hz)
    if first >= last:
        raise Refusal(
            f"covariate: {covariate.name} is of {covariate.time_s[0]:g} to "
            f"{covariate.time_s[-1]:g} s, the recording of 0 to "
            f"{series.size / frame_rate_hz:g} s; expected times from its first frame"
        )
    length_s = max(covariate.step_s, (last - first) / BLOCKS)
    length = max(round(length_s * frame_rate_hz), 1)
    start = max(math.ceil(first * frame_rate_hz), 0)
    means = block_means(series[start : math.floor(last * frame_rate_hz)], length)
    edges = (start + np.arange(means.size + 1) * length) / frame_rate_hz
    beside = _between(covariate, edges)
    if beside.size and np.ptp(beside) == 0:
        raise Refusal(f"covariate: {covariate.name} stays at {beside[0]:g}: nothing goes with it")
    found = coherence(_filled(means), beside, length / frame_rate_hz, alpha)
    best = int((found.squared - found.threshold).argmax())
    clear = bool(found.squared[best] > found.threshold[best])
    return {
        "covariate": covariate.name,
        "word": "goes with it" if clear else "unrelated",
        "coherence": float(found.squared[best]),
        "threshold": float(found.threshold[best]),
        "period_s": 1 / float(found.f_hz[best]),
        "gain_mm_per_unit": float(found.gain[best]) if clear else math.nan,
        "lag_s": float(found.phase_rad[best] / (2 * np.pi * found.f_hz[best]))
        if clear
        else math.nan,
        "from_s": first,
        "to_s": last,
    }


def _between(covariate: Covariate, edges_s: np.ndarray) -> np.ndarray:
    """(n,) means between (n + 1,) edges of straight lines through the samples: what is faster than
    a block, noise of the sensor above all, averages out as it does in the series."""
    at = np.union1d(covariate.time_s, edges_s)
    values = np.interp(at, covariate.time_s, covariate.values)
    area = np.append(0.0, np.cumsum((values[1:] + values[:-1]) / 2 * np.diff(at)))
    return np.diff(area[np.searchsorted(at, edges_s)]) / np.diff(edges_s)


def _filled(means: np.ndarray) -> np.ndarray:
    """Blocks without data from their neighbours; refused where a quarter is missing."""
    there = np.isfinite(means)
    if there.sum() < 0.75 * means.size:
        raise Refusal("covariate: more than a quarter of the common time is a gap of the markers")
    at = np.arange(means.size)
    return np.interp(at, at[there], means[there])
