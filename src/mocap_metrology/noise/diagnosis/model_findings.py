"""What the noise model says of slow movement, as findings and in words: drift, warm-up, walk.

Made from rows of noise.csv by `likelihood`, so that verdict and diagnosis say the same.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from mocap_metrology.common.words import three
from mocap_metrology.noise.diagnosis.findings import Finding
from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR, Z_95
from mocap_metrology.noise.model.deterministic import Deterministic, deterministic_of

CODE_OF = {"drift": "drift", "A_w": "warm_up", "h_-2": "random_walk"}
USABLE = ("ok", "at_bound", "not_converged")
SETTLED = 3.0  # T_w after which 95 % of a warm-up are over
MINUTES_S = 120.0  # times from which minutes are said

Row = Mapping[str, Any]


def model_findings(noise_rows: Iterable[Row]) -> list[Finding]:
    """`drift`, `warm_up` and `random_walk` of every series, with 95 % intervals. noise_rows: of
    noise.csv, of any series; what was not detected, or is a misfit, is none, and nor is what may be
    nothing (see `_may_be_nothing`)."""
    return [
        Finding(CODE_OF[row["parameter"]], row["series"], *_numbers(row))
        for row in noise_rows
        if row["estimator"] == DEFAULT_ESTIMATOR
        and row["parameter"] in CODE_OF
        and row["status"] in USABLE
        and not _may_be_nothing(row)
    ]


def _numbers(row: Row) -> tuple[float, float, float]:
    value, low, high = (float(row[k]) for k in ("value", "lower_95", "upper_95"))
    return value, low, high


def _may_be_nothing(row: Row) -> bool:
    """Whether a drift or a warm-up has a 95 % interval that holds zero, or a walk is within 1.96
    standard errors of it. (The interval of a walk also reaches zero where a slow Gauss-Markov term
    could stand for it: a wander all the same.)"""
    if row["parameter"] == "h_-2":
        return float(row["value"]) < Z_95 * float(row["std_error"])
    if row["parameter"] not in ("drift", "A_w"):
        return False
    _, low, high = _numbers(row)
    return low <= 0 <= high


def deterministic_parts(noise_rows: Sequence[Row]) -> dict[str, Deterministic]:
    """The deterministic part of every series that has one, less what may be nothing."""
    own = [
        r
        for r in noise_rows
        if r["estimator"] == DEFAULT_ESTIMATOR and r["status"] in USABLE and not _may_be_nothing(r)
    ]
    names = dict.fromkeys(r["series"] for r in own)
    parts = {name: deterministic_of([r for r in own if r["series"] == name]) for name in names}
    return {name: part for name, part in parts.items() if not part.empty}


def warm_up_words(parts: Mapping[str, Deterministic], duration_s: float) -> str:
    """`still warming up: 0.21 mm in the first 18 minutes (x1), time constant 6 minutes: start
    recording later`; of the series that moves most; empty where none does."""
    sizes = {name: _approach(p, duration_s) for name, p in parts.items() if p.A_w}
    if not sizes:
        return ""
    name = max(sizes, key=lambda k: abs(sizes[k][0]))
    size, within = sizes[name]
    return (
        f"still warming up: {three(abs(size))} mm in the first {_time(within)} ({name}), time "
        f"constant {_time(parts[name].T_w)}: start recording later"
    )


def _approach(part: Deterministic, duration_s: float) -> tuple[float, float]:
    """What the warm-up does, mm, and in what time, s: three T_w, or the recording."""
    within = min(SETTLED * part.T_w, duration_s)
    return -part.A_w * math.expm1(-within / part.T_w), within


def drift_words(parts: Mapping[str, Deterministic], duration_s: float) -> str:
    """`a steady drift of 1.2 mm/h (x1), 0.2 mm in this recording`; of the series with the fastest;
    empty where none drifts."""
    speeds = {name: p.drift for name, p in parts.items() if p.drift}
    if not speeds:
        return ""
    name = max(speeds, key=lambda k: abs(speeds[k]))
    gone = abs(speeds[name]) * duration_s / 3600
    return f"a steady drift of {three(speeds[name])} mm/h ({name}), {three(gone)} mm in all"


def _time(seconds: float) -> str:
    if seconds < MINUTES_S:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} minutes" if seconds < 2 * 3600 else f"{three(seconds / 3600)} h"
