"""Checks of a recording: the number held against a limit, and the best word a verdict can then
have. The wording for readers is made elsewhere, from code and numbers."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from statistics import median

from mocap_metrology.noise.assess.uncertainty import Reason, SeriesNumbers, Unmodelled
from mocap_metrology.noise.diagnosis.findings import WANDERS, Finding
from mocap_metrology.noise.diagnosis.records import MANY_REPEATS
from mocap_metrology.settings import Verdict as Limits
from mocap_metrology.settings import Word

COORDINATE = re.compile(r"[xyz][1-9]\d*")
SHORT = 0.9  # a recording of less than this of the horizon does not reach it
LEAST_FRAMES, LEAST_S = 100, 1.0  # to judge by: their standard deviation is known to 7 %

PROCESSED = ("smoothed", "resampled", "running_median", "repeated")  # findings
WORDS: tuple[Word, ...] = ("good", "usable", "bad")
Series = Mapping[str, SeriesNumbers]


@dataclass(frozen=True)
class Facts:
    """What the checks need to know of a recording: duration and horizon actually reached, s; number
    of markers; by coordinate the share of missing frames, and of outliers beyond what clean noise
    would have. labels: of the markers, in order, where they are known. asked_s: requested horizon,
    if longer. n_frames: of the recording, where that is known. findings: of the diagnosis."""

    duration_s: float
    horizon_s: float
    n_markers: int
    missing: Mapping[str, float]
    outliers: Mapping[str, float]
    labels: Sequence[str] = ()
    asked_s: float = 0.0
    n_frames: float = math.inf
    findings: Sequence[Finding] = ()

    def values_of(self, code: str) -> dict[str, float]:
        """Values of the findings of a code by series."""
        return {one.series: one.value for one in self.findings if one.code == code}

    @property
    def wandering(self) -> set[str]:
        """Series with slow wander that is no noise: of another kind, or undecided."""
        return {one.series for one in self.findings if one.code in WANDERS}

    @property
    def short(self) -> bool:
        """Whether the requested horizon is out of reach."""
        return self.horizon_s < SHORT * self.asked_s

    def label(self, coordinate: str) -> str:
        """Label of the marker to which a coordinate belongs; its number where the label is not
        known."""
        number = int(coordinate[1:])
        return self.labels[number - 1] if number <= len(self.labels) else f"marker {number}"


class Code(StrEnum):
    """What a check is of."""

    TOO_SHORT = "too_short"  # to judge by at all
    FRAME = "frame"  # uncertainty of one frame; the next three: where it is none
    CONSTANT = "constant"
    NO_SAMPLES = "no_samples"
    FEW_SAMPLES = "few_samples"
    UPPER_END = "upper_end"  # of the interval of one frame, in a short recording
    MOVES = "moves"
    MISSING = "missing"
    MISSING_OR_FILLED = "missing_or_filled"
    STEP = "step"  # of the file
    LOW_PASS = "low_pass"
    PROCESSED = "processed"  # by the software in another way
    EXCHANGED = "exchanged"
    OUTLIERS = "outliers"
    DRIFT = "drift"
    RANDOM_WALK = "random_walk"
    WANDER = "wander"  # slow movement of another kind, or of none that is known
    MISFIT = "misfit"
    DURATION = "duration"
    MARKERS = "markers"


@dataclass(frozen=True)
class Check:
    """One check. word: the best a verdict can have with it; value, limit in `unit`, value of
    `series`; lower, upper: interval of value, where it has one; threshold: key of the configuration
    that holds `limit`; names: coordinates it is of, none where it is of all; over_s: time it is of;
    asked_s: requested horizon if it is out of reach, else NaN."""

    code: Code
    word: Word
    value: float | str
    limit: float | str
    unit: str = ""
    threshold: str = ""
    series: str = ""
    lower: float = math.nan
    upper: float = math.nan
    names: tuple[str, ...] = ()
    over_s: float = math.nan
    asked_s: float = math.nan


@dataclass(frozen=True)
class LengthCheck(Check):
    """The check that a recording is long enough to be judged."""

    n_frames: float = math.nan
    duration_s: float = math.nan


@dataclass(frozen=True)
class MovementCheck(Check):
    """names: labels of the markers that move. What still tells of noise: the distance of that name
    and its uncertainty of one frame, mm, or else markers at rest."""

    distance: str = ""
    distance_mm: float = math.nan
    still: tuple[str, ...] = ()


@dataclass(frozen=True)
class ModelCheck(Check):
    """unmodelled: why there is no model to believe, by coordinate, out of n_coordinates."""

    n_coordinates: int = 0
    unmodelled: Mapping[str, Unmodelled | None] = field(default_factory=dict)


def length(facts: Facts) -> Check:
    """Whether there is enough to judge by at all."""
    few = facts.n_frames < LEAST_FRAMES
    word: Word = "bad" if few or facts.duration_s < LEAST_S else "good"
    by_frames = few and facts.duration_s >= LEAST_S
    value, limit = (facts.n_frames, LEAST_FRAMES) if by_frames else (facts.duration_s, LEAST_S)
    unit = "" if by_frames else "s"
    return LengthCheck(
        *(Code.TOO_SHORT, word, value, limit, unit),
        n_frames=facts.n_frames,
        duration_s=facts.duration_s,
    )


def measured_coordinates(coordinates: Series, facts: Facts) -> Series:
    """Coordinates whose numbers are of a measurement: without those that lie within one step of
    the file all the time, where others pass from step to step."""
    coarse = facts.values_of("resolution_limited")
    constant = [k for k, v in coordinates.items() if v.status == "constant" and k in coarse]
    if all(k in constant for k in coarse):
        return coordinates
    return {k: v for k, v in coordinates.items() if k not in constant}


def uncertainty(series: Series, facts: Facts, limits: Limits) -> Check:
    """Check of the uncertainty of one frame in the worst coordinate."""
    key, limit = "verdict.usable_mm", limits.usable_mm
    constant = tuple(k for k, v in series.items() if v.status == "constant")
    if constant:
        named = ", ".join(constant)
        return Check(Code.CONSTANT, "bad", math.nan, limit, "mm", key, named, names=constant)
    name, value = worst({k: v.frame_mm for k, v in series.items()})
    if not name:
        none = all(v.status == "no valid samples" for v in series.values())
        return Check(Code.NO_SAMPLES if none else Code.FEW_SAMPLES, "bad", value, limit, "mm", key)
    word, key, limit = _graded(value, limits.good_mm, limits.usable_mm, "mm")
    low, high = series[name].frame_lower_mm, series[name].frame_upper_mm
    return Check(
        *(Code.FRAME, word, value, limit, "mm", key, name, low, high),
        over_s=facts.horizon_s,
        asked_s=facts.asked_s if facts.short else math.nan,
    )


def upper_end(series: Series, facts: Facts, limits: Limits, main: Check) -> Check:
    """Check of the upper end of the interval of one frame. In a recording shorter than the horizon
    a good value may be luck: slow wander has one or two degrees of freedom there. Then the upper
    end of the interval counts (a longer one has seen the whole horizon, and the value decides)."""
    judged = facts.short and main.word == "good"
    name, value = worst({k: v.frame_upper_end_mm for k, v in series.items()} if judged else {})
    limit = limits.good_mm
    word: Word = "usable" if value > limit else "good"
    key, over = "verdict.good_mm", facts.horizon_s
    return Check(Code.UPPER_END, word, value, limit, "mm", key, name, over_s=over)


def movement(series: Series, coordinates: Series, facts: Facts, limits: Limits) -> Check:
    """Check of movement that noise does not explain, as the findings state it. A distance still
    tells of noise unless a frame of it is less certain than the largest usable drift: then it
    moves, too."""
    moving = facts.values_of("moves")
    moved = {k: v for k, v in moving.items() if k in coordinates}
    name, value = worst(moved)
    labels = tuple(dict.fromkeys(facts.label(k) for k in moved))
    still = {
        k: v
        for k, v in series.items()
        if k not in moving and math.isfinite(v.frame_mm) and v.status != "constant"
    }
    distances = [k for k in still if not COORDINATE.fullmatch(k)]
    distances = [k for k in distances if still[k].frame_mm <= limits.drift_mm[1]]
    distance = min(distances, key=lambda k: still[k].frame_mm, default="")
    others = dict.fromkeys(facts.label(k) for k in still if COORDINATE.fullmatch(k))
    word: Word = "bad" if moved else "good"
    return MovementCheck(
        *(Code.MOVES, word, value, 0.0, "mm", "still.range_mm", name),
        names=labels,
        over_s=facts.horizon_s,
        distance=distance,
        distance_mm=still[distance].frame_mm if distance else math.nan,
        still=tuple(label for label in others if label not in labels),
    )


def resolution(coordinates: Series, facts: Facts, limits: Limits) -> Check:
    """Never better than usable: where in a step a marker is decides on all numbers below a step,
    and the step is all that is known of them."""
    coarse = {k: v for k, v in facts.values_of("resolution_limited").items() if k in coordinates}
    step = max(coarse.values(), default=math.nan)
    word: Word = "good" if not coarse else "usable" if step <= limits.usable_mm else "bad"
    key, limit, name = "verdict.usable_mm", limits.usable_mm, next(iter(coarse), "")
    names = _unless_all(coarse, coordinates)
    return Check(Code.STEP, word, step, limit, "mm", key, name, names=names)


def low_pass(coordinates: Series, facts: Facts) -> Check:
    """Check for low-pass filters: filtered data are at best usable, as the scatter of single frames
    is lost."""
    cutoffs = {k: v for k, v in facts.values_of("low_pass").items() if k in coordinates}
    known = [v for v in facts.values_of("low_pass").values() if math.isfinite(v)] or [math.nan]
    word: Word = "usable" if cutoffs else "good"
    name, names = next(iter(cutoffs), ""), _unless_all(cutoffs, coordinates)
    ends = min(known), max(known)  # as the diagnosis states them
    return Check(Code.LOW_PASS, word, median(known), math.nan, "Hz", "", name, *ends, names=names)


def processed(coordinates: Series, facts: Facts) -> Check:
    """Check for frames that software computed from other frames: these are at best usable."""
    for code in PROCESSED:
        names = {k: v for k, v in _processed_by(code, facts).items() if k in coordinates}
        if names:
            of_all, name = _unless_all(names, coordinates), next(iter(names))
            return Check(Code.PROCESSED, "usable", code, "", series=name, names=of_all)
    return Check(Code.PROCESSED, "good", "", "")


def _processed_by(code: str, facts: Facts) -> dict[str, float]:
    """Values of the findings of a code of `PROCESSED`; a few repeated frames are no processing."""
    least = MANY_REPEATS if code == "repeated" else -math.inf
    return {k: v for k, v in facts.values_of(code).items() if not v <= least}


def exchanged(facts: Facts) -> Check:
    """The numbers are those of the labels put right, the file has the wrong ones."""
    shares = facts.values_of("exchanged")
    name, value = worst(shares)
    labels = tuple(dict.fromkeys(facts.label(k) for k in shares))
    return Check(Code.EXCHANGED, "bad" if shares else "good", value, 0.0, series=name, names=labels)


def missing(coordinates: Series, facts: Facts, limits: Limits) -> Check:
    """Frames without a sample; those that look filled are among them, also where a filter made
    them as smooth."""
    smooth = any(map(facts.values_of, ("gap_filled", "low_pass", "running_median")))
    code = Code.MISSING_OR_FILLED if smooth else Code.MISSING
    bounds = limits.good_missing, limits.usable_missing
    return _share(code, coordinates, facts.missing, bounds, "missing")


def outliers(coordinates: Series, facts: Facts, limits: Limits) -> Check:
    """Outliers beyond what clean noise and chance make. Filtered series are left out: their
    neighbouring frames are alike, so that sound ones lie far from the median."""
    smooth = set(facts.values_of("low_pass")).union(*(_processed_by(c, facts) for c in PROCESSED))
    coordinates = {k: v for k, v in coordinates.items() if k not in smooth}
    bounds = limits.good_outliers, limits.usable_outliers
    return _share(Code.OUTLIERS, coordinates, facts.outliers, bounds, "outliers")


def _share(
    code: Code,
    coordinates: Series,
    shares: Mapping[str, float],
    bounds: tuple[float, float],
    key: str,
) -> Check:
    """The worst share of frames of a coordinate against the limits of `key`."""
    name, value = worst({k: v for k, v in shares.items() if k in coordinates})
    word, threshold, limit = _graded(value, *bounds, key) if name else ("good", "", math.nan)
    return Check(code, word, value, limit, "", threshold, name)


def drift(coordinates: Series, facts: Facts, limits: Limits) -> Check:
    """Over the horizon, and never beyond the recording: slopes over seconds are no evidence on
    hours."""
    hours = facts.horizon_s / 3600
    name, value = worst({k: abs(v.drift_mm_per_h) * hours for k, v in coordinates.items()})
    word: Word = "good"
    key, limit = "", math.nan
    if name:
        word, key, limit = _graded(value, *limits.drift_mm, "drift_mm")
    code = Code.DRIFT
    if name in facts.wandering:  # the slope through another kind of movement is no drift
        code = Code.WANDER
    elif name not in facts.values_of("drift") and name in facts.values_of("random_walk"):
        code = Code.RANDOM_WALK
    return Check(code, word, value, limit, "mm", key, name, over_s=facts.horizon_s)


def model(coordinates: Series, limits: Limits) -> Check:
    """Whether the noise has a model that describes it."""
    misfits = {k: v for k, v in coordinates.items() if v.status not in ("ok", "constant")}
    return ModelCheck(
        Code.MISFIT,
        limits.misfit if misfits else "good",
        ", ".join(dict.fromkeys(v.status for v in misfits.values())) or "ok",
        "ok",
        threshold="verdict.misfit",
        series=",".join(misfits),
        n_coordinates=len(coordinates),
        unmodelled={
            k: Unmodelled(Reason.MISFIT) if v.status == "misfit" else v.unmodelled
            for k, v in misfits.items()
        },
    )


def duration(facts: Facts, limits: Limits) -> Check:
    """Whether it is long enough to show how the system wanders."""
    least, value = limits.good_duration_s, facts.duration_s
    word: Word = "good" if value >= least else "usable"
    return Check(Code.DURATION, word, value, least, "s", "verdict.good_duration_s")


def markers(facts: Facts, limits: Limits) -> Check:
    """Without two there is no distance, which does not depend on where the cameras are."""
    least, value = limits.good_markers, facts.n_markers
    word: Word = "good" if value >= least else "usable"
    return Check(Code.MARKERS, word, value, least, "", "verdict.good_markers")


def worst(values: Mapping[str, float]) -> tuple[str, float]:
    """The largest finite value and its name; NaN without one."""
    known = {k: v for k, v in values.items() if math.isfinite(v)}
    return max(known.items(), key=lambda item: item[1], default=("", math.nan))


def _unless_all(some: Mapping[str, object], coordinates: Series) -> tuple[str, ...]:
    return tuple(some) if len(some) < len(coordinates) else ()


def _graded(value: float, good: float, usable: float, name: str) -> tuple[Word, str, float]:
    """Word of a value that had better be small; key and value of the limit it kept to, or went
    beyond."""
    if value <= good:
        return "good", f"verdict.good_{name}", good
    if value <= usable:
        return "usable", f"verdict.good_{name}", good
    return "bad", f"verdict.usable_{name}", usable
