"""One recording: numbers of every series, and the verdict on it: one word, and why.

S 2.2 requires of a reference that its uncertainty be 4 to 10 times smaller than that of the device
under test. The number held against this rule is the uncertainty of one frame about the mean of the
horizon (`assess.uncertainty`, frame_mm) in the worst coordinate, as devices are compared frame by
frame. For a device of 1 mm the rule requires 0.25 mm at least (`usable`) and better 0.1 mm
(`good`): the thresholds of the configuration. What else was found can only make the word worse:
`checks`.

It is of noise alone, the part that repeating a measurement shows (GUM 4.2, type A). What a
reference adds by scale and distortion of its volume is the same in every frame of a still
marker, and must be known otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypedDict, cast

import numpy as np

from mocap_metrology.common.files import read_csv
from mocap_metrology.common.parallel import MapFunction
from mocap_metrology.noise.assess import checks
from mocap_metrology.noise.assess.checks import (
    COORDINATE,
    WORDS,
    Check,
    Code,
    Facts,
    MovementCheck,
    Series,
)
from mocap_metrology.noise.assess.mean import MeanOfAll
from mocap_metrology.noise.assess.spread import Share, joined
from mocap_metrology.noise.assess.uncertainty import SeriesNumbers, Span, assess_series
from mocap_metrology.noise.diagnosis.findings import Finding
from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR, NoiseRow
from mocap_metrology.noise.gaussian.two_markers import LONG_S
from mocap_metrology.settings import Verdict as Limits
from mocap_metrology.settings import Word

OF_WANDER = ("random walk", "drift", "warm-up")  # shares that are named where the kind is sure
SLOW_WANDER = "slow wander"
NO_MEAN = ("moves", "drift", "warm_up")  # besides slow wander: a mean depends on when it is taken
OF_MOVING = (
    Code.MISSING,
    Code.MISSING_OR_FILLED,
    Code.EXCHANGED,
)  # what else counts where every marker moves
RULE = (4, 10)  # times better than the device under test [S 2.2]
CHANCE = 3.0  # standard deviations that a count of outliers may be above its mean


class OutlierRow(TypedDict):
    """A row of outliers.csv."""

    series: str
    n_frames: float
    n_valid: float
    share: float
    share_of_clean_gaussian_noise: float


def read_outliers(path: str | Path) -> list[OutlierRow]:
    """Rows of an outliers.csv."""
    numbers = set(OutlierRow.__annotations__) - {"series"}
    return cast(list[OutlierRow], read_csv(path, numbers))


@dataclass(frozen=True)
class Inputs:
    """series: name and values in mm, gross outliers masked; labels: of the markers; noise: rows of
    noise.csv; allan: columns of allan_masked.parquet; outliers: rows of outliers.csv; findings:
    those of the diagnosis."""

    series: Iterable[tuple[str, np.ndarray]]
    labels: Sequence[str]
    noise: Sequence[NoiseRow]
    allan: Mapping[str, np.ndarray]
    outliers: Sequence[OutlierRow]
    findings: Sequence[Finding] = ()


@dataclass(frozen=True)
class Verdict:
    """word: one of `WORDS`; decided_by: the check that made it; caps: all other checks that allow
    no better word than theirs (where every marker moves, only those that are not of noise);
    uncertainty: that of one frame, where it is known and did not decide; reference_for_mm: by
    factor of `RULE`, the least uncertainty of a device it may serve as a reference for by its noise
    alone: that many times the upper end of the interval of one frame in the worst coordinate; NaN
    where the word is bad."""

    word: Word
    decided_by: Check
    caps: tuple[Check, ...]
    uncertainty: Check | None
    reference_for_mm: dict[str, float]


@dataclass(frozen=True)
class Assessment:
    """Assessment of a system from one recording."""

    facts: Facts
    span: Span
    limits: Limits
    verdict: Verdict
    series: Mapping[str, SeriesNumbers]


def assess_recording(inputs: Inputs, span: Span, limits: Limits, over: MapFunction) -> Assessment:
    """Numbers of every series and the verdict. Of a recording of less than a minute no drift per
    hour is told, though the verdict goes by what it was."""

    def assessed(one: tuple[str, np.ndarray]) -> tuple[str, SeriesNumbers, int]:
        name, values = one
        rows = [
            r for r in inputs.noise if r["series"] == name and r["estimator"] == DEFAULT_ESTIMATOR
        ]
        return name, assess_series(values, rows, _curve(inputs.allan, name), span), values.size

    every = list(over(assessed, inputs.series))
    numbers = {name: of_series for name, of_series, _ in every}
    n_frames = every[-1][2] if every else 0
    duration = n_frames / span.frame_rate_hz
    facts = Facts(
        duration,
        min(span.horizon_s, duration),
        len(inputs.labels),
        {r["series"]: (r["n_frames"] - r["n_valid"]) / r["n_frames"] for r in inputs.outliers},
        excess_outliers(inputs.outliers),
        tuple(inputs.labels),
        span.horizon_s,
        n_frames,
        inputs.findings,
    )
    numbers = {k: _unnamed(v) if k in facts.wandering else v for k, v in numbers.items()}
    moved = facts.wandering.union(*(facts.values_of(code) for code in NO_MEAN))
    for k in moved & set(numbers):
        without = MeanOfAll(numbers[k].mean_of_all.duration_s)
        numbers[k] = replace(numbers[k], mean_of_all=without)
    word = verdict(numbers, facts, limits)
    if duration < LONG_S:
        numbers = {k: replace(v, drift_mm_per_h=math.nan) for k, v in numbers.items()}
    return Assessment(facts, span, limits, word, numbers)


def _unnamed(numbers: SeriesNumbers) -> SeriesNumbers:
    """Shares with walk, drift and warm-up as slow wander: its kind is another, or open."""

    def renamed(kinds: Sequence[Share]) -> tuple[Share, ...]:
        return joined(
            Share(SLOW_WANDER, one.share) if one.kind in OF_WANDER else one for one in kinds
        )

    means = tuple(replace(mean, kinds=renamed(mean.kinds)) for mean in numbers.means)
    return replace(numbers, kinds=renamed(numbers.kinds), means=means)


def verdict(series: Series, facts: Facts, limits: Limits) -> Verdict:
    """Verdict on numbers of every series (`assess.uncertainty`), keyed by name.

    Coordinates decide, distances do not: their noise is that of two coordinates. Movement is told
    first: an uncertainty of what moves is none, and nothing may be held against it. Before it what
    leaves nothing to judge by: a recording that is too short, or gaps.
    """
    coordinates = {k: v for k, v in series.items() if COORDINATE.fullmatch(k)}
    main = checks.uncertainty(checks.measured_coordinates(coordinates, facts), facts, limits)
    judged = _checks(series, coordinates, facts, limits, main)
    word = max((c.word for c in judged), key=WORDS.index)
    decided = next(c for c in judged if c.word == word)
    caps = tuple(c for c in judged if c.word != "good" and c not in (main, decided))
    if isinstance(decided, MovementCheck) and not decided.still:
        caps = tuple(c for c in caps if c.code in OF_MOVING)
    moves = any(c.code is Code.MOVES and c.word == "bad" for c in judged)
    steps = facts.values_of("resolution_limited")
    told = main in judged and main is not decided and main.code is Code.FRAME and not moves
    told = told and main.series not in steps
    surely = math.nan
    if word != "bad" and not facts.values_of("low_pass"):
        surely = max(coordinates[main.series].frame_upper_end_mm, *steps.values(), 0.0)
    reference = {str(k): k * surely for k in RULE}
    return Verdict(word, decided, caps, main if told else None, reference)


def _checks(
    series: Series, coordinates: Series, facts: Facts, limits: Limits, main: Check
) -> list[Check]:
    """All checks, in the order of reports if equally bad."""
    moving = checks.movement(series, coordinates, facts, limits)
    steps = checks.resolution(coordinates, facts, limits)
    missing = checks.missing(coordinates, facts, limits)
    length = checks.length(facts)
    if length.word == "bad":
        return [length, moving, missing]
    first = [main, moving, checks.upper_end(coordinates, facts, limits, main), missing]
    if steps.word != "good":
        first = [steps, *first]
    if moving.word == "bad" and main.code is Code.FRAME:
        first = [moving, *(check for check in first if check is not moving)]
    if missing.word == "bad" and not main.series:
        first = [missing, moving]
    return [
        *first,
        checks.exchanged(facts),
        checks.low_pass(coordinates, facts),
        checks.processed(coordinates, facts),
        checks.outliers(coordinates, facts, limits),
        checks.drift(coordinates, facts, limits),
        checks.model(coordinates, limits),
        checks.duration(facts, limits),
        checks.markers(facts, limits),
    ]


def _curve(allan: Mapping[str, np.ndarray], name: str) -> dict[str, np.ndarray]:
    rows = (np.asarray(allan["series"]) == name) & (np.asarray(allan["estimator"]) == "oadev")
    columns = ("tau_s", "adev_mm", "adev_lower_mm", "adev_upper_mm", "edf")
    return {k: np.asarray(allan[k])[rows] for k in columns}


def excess_outliers(rows: Sequence[OutlierRow]) -> dict[str, float]:
    """Share of outliers less that of clean Gaussian noise, >= 0, by series of outliers.csv.

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
