"""One recording: numbers of every series, and the verdict, as they stand in verdict.json."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mocap_metrology.noise.assess.series import Span, assess_series
from mocap_metrology.noise.assess.verdict import (
    Facts,
    Thresholds,
    Verdict,
    excess_outliers,
    missing_frames,
    verdict,
)
from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR
from mocap_metrology.noise.gaussian.describe import LONG_S


@dataclass(frozen=True)
class Inputs:
    """series: name and cleaned values in mm; origin: metadata of clean.parquet; noise: rows of
    noise.csv; allan: columns of allan_masked.parquet; outliers: rows of outliers.csv;
    findings: those of diagnosis.json."""

    series: Iterable[tuple[str, np.ndarray]]
    origin: Mapping[str, Any]
    noise: Sequence[Mapping[str, Any]]
    allan: Mapping[str, np.ndarray]
    outliers: Sequence[Mapping[str, Any]]
    findings: Sequence[Mapping[str, Any]] = ()


def assess_recording(
    inputs: Inputs, span: Span, limits: Thresholds | None = None
) -> dict[str, Any]:
    """What verdict.json holds, but for what the sheet, the check and the diagnosis say."""
    limits = limits or Thresholds()
    numbers, n_frames = {}, 0
    for name, values in inputs.series:
        rows = [
            r for r in inputs.noise if r["series"] == name and r["estimator"] == DEFAULT_ESTIMATOR
        ]
        numbers[name] = assess_series(values, rows, _curve(inputs.allan, name), span)
        n_frames = values.size
    duration = n_frames / span.frame_rate_hz
    facts = Facts(
        duration,
        min(span.horizon_s, duration),
        len(inputs.origin["labels"]),
        missing_frames(inputs.outliers),
        excess_outliers(inputs.outliers),
        tuple(inputs.origin["labels"]),
        span.horizon_s,
        n_frames,
        inputs.findings,
    )
    found = verdict(numbers, facts, limits)
    for name, values in numbers.items():
        values["missing"] = facts.missing.get(name)
        values["excess_outliers"] = facts.outliers.get(name)
        if duration < LONG_S:
            values["drift_mm_per_h"] = math.nan  # seconds tell of no hour
    return {
        "source": inputs.origin["source"],
        "labels": list(facts.labels),
        "duration_s": duration,
        "frame_rate_hz": span.frame_rate_hz,
        "horizon_s": facts.horizon_s,
        "window_s": span.window_s,
        "confidence": span.confidence,
        **_told(found),
        "limits_mm": {"good": limits.good_mm, "usable": limits.usable_mm},
        "series": numbers,
    }


def _told(found: Verdict) -> dict[str, Any]:
    return {
        "word": found.word,
        "reason": found.decided_by.sentence,
        "decided_by": found.decided_by.as_row(),
        "caps": [c.as_row() | {"word": c.word, "reason": c.sentence} for c in found.caps],
        "uncertainty": found.uncertainty,
        "reference_for_mm": found.reference_for_mm,
    }


def _curve(allan: Mapping[str, np.ndarray], name: str) -> dict[str, np.ndarray]:
    own = (np.asarray(allan["series"]) == name) & (np.asarray(allan["estimator"]) == "oadev")
    columns = ("tau_s", "adev_mm", "adev_lower_mm", "adev_upper_mm", "edf")
    return {k: np.asarray(allan[k])[own] for k in columns}
