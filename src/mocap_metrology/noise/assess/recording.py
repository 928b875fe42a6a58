"""One recording: numbers of every series, and the verdict on it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypedDict

import numpy as np

from mocap_metrology.noise.assess.checks import Facts, Thresholds
from mocap_metrology.noise.assess.conformity import Verdict, verdict
from mocap_metrology.noise.assess.uncertainty import SeriesNumbers, Span, assess_series
from mocap_metrology.noise.diagnosis.findings import Finding
from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR, NoiseRow
from mocap_metrology.noise.gaussian.two_markers import LONG_S

CHANCE = 3.0  # standard deviations that a count of outliers may be above its mean


class OutlierRow(TypedDict):
    """A row of outliers.csv."""

    series: str
    n_frames: float
    n_valid: float
    share: float
    share_of_clean_gaussian_noise: float


@dataclass(frozen=True)
class Inputs:
    """series: name and cleaned values in mm; labels: of the markers; noise: rows of noise.csv;
    allan: columns of allan_masked.parquet; outliers: rows of outliers.csv; findings: those of the
    diagnosis."""

    series: Iterable[tuple[str, np.ndarray]]
    labels: Sequence[str]
    noise: Sequence[NoiseRow]
    allan: Mapping[str, np.ndarray]
    outliers: Sequence[OutlierRow]
    findings: Sequence[Finding] = ()


@dataclass(frozen=True)
class Assessment:
    """What one recording tells of its system."""

    facts: Facts
    span: Span
    limits: Thresholds
    verdict: Verdict
    series: Mapping[str, SeriesNumbers]


def assess_recording(inputs: Inputs, span: Span, limits: Thresholds | None = None) -> Assessment:
    """Numbers of every series and the verdict. Of a recording of less than a minute no drift per
    hour is told, though the verdict goes by what it was."""
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
        len(inputs.labels),
        missing_frames(inputs.outliers),
        excess_outliers(inputs.outliers),
        tuple(inputs.labels),
        span.horizon_s,
        n_frames,
        inputs.findings,
    )
    found = verdict(numbers, facts, limits)
    if duration < LONG_S:
        numbers = {k: replace(v, drift_mm_per_h=math.nan) for k, v in numbers.items()}
    return Assessment(facts, span, limits, found, numbers)


def _curve(allan: Mapping[str, np.ndarray], name: str) -> dict[str, np.ndarray]:
    own = (np.asarray(allan["series"]) == name) & (np.asarray(allan["estimator"]) == "oadev")
    columns = ("tau_s", "adev_mm", "adev_lower_mm", "adev_upper_mm", "edf")
    return {k: np.asarray(allan[k])[own] for k in columns}


def excess_outliers(rows: Sequence[OutlierRow]) -> dict[str, float]:
    """By series of outliers.csv: share of outliers less that of clean Gaussian noise, >= 0.

    The share is the least that goes with the count (Wilson's interval, CHANCE standard deviations):
    of 30 frames of clean noise three may well be beyond a threshold that they make themselves.
    """
    return {
        row["series"]: max(
            _least_share(float(row["share"]), float(row["n_valid"]))
            - float(row["share_of_clean_gaussian_noise"]),
            0.0,
        )
        for row in rows
    }


def _least_share(share: float, n: float) -> float:
    if not n > 0:
        return math.nan
    scatter = math.sqrt(share * (1 - share) / n + CHANCE**2 / (4 * n**2))
    return (share + CHANCE**2 / (2 * n) - CHANCE * scatter) / (1 + CHANCE**2 / n)


def missing_frames(rows: Sequence[OutlierRow]) -> dict[str, float]:
    """By series of outliers.csv: share of frames without a sample."""
    return {row["series"]: 1 - float(row["n_valid"]) / float(row["n_frames"]) for row in rows}
