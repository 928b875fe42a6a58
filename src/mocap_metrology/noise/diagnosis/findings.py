"""Findings: what was found in a recording, by codes that other programs can rely on.

`diagnosis.json` and `verdict.json` list them under `findings`. Those of slow movement (drift,
warm-up, walk) are of the noise model: made from rows of noise.csv by `likelihood`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from mocap_metrology.common.types import Record, Row
from mocap_metrology.noise.diagnosis.export import DOMINATES
from mocap_metrology.noise.diagnosis.records import Diagnosis, Recording
from mocap_metrology.noise.diagnosis.shape import AT_ONCE
from mocap_metrology.noise.diagnosis.signatures import NEAR_S, Wander
from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR, Z_95, NoiseRow, deterministic_of
from mocap_metrology.noise.model.deterministic import Deterministic
from mocap_metrology.noise.series import AXES

# Unit and meaning of `value`, by code; "" is a pure number
CODES = {
    "drift": ("mm/h", "slope of a straight line under the noise"),
    "warm_up": ("mm", "amplitude of an exponential approach, A_w; positive where it falls"),
    "random_walk": ("mm^2 Hz", "h_-2, over times up to a tenth of the recording"),
    "accelerating": ("mm", "movement that becomes faster, from start to end"),
    "creep": ("mm", "movement that becomes slower as the logarithm of time, from start to end"),
    "slowing": ("mm", "movement that becomes slower, of no known law, from start to end"),
    "cycle": ("s", "period of a slow cycle"),
    "step": ("mm", "lasting change of position at once"),
    "shift": ("mm", "change of position that ends or fades"),
    "two_levels": ("mm", "distance of two positions between which a series switches"),
    "levels": ("mm", "range of several positions between which a series switches"),
    "wander": ("mm", "range of slow wander whose kind cannot be decided"),
    "moves": ("mm", "movement that the noise does not explain, within the horizon"),
    "low_pass": ("Hz", "where a low-pass filter before the export halves the amplitude"),
    "gap_filled": ("", "share of the frames that an interpolation filled"),
    "repeated": ("", "share of the frames, or values of a coordinate, that repeat the one before"),
    "exchanged": ("", "share of the frames with the label of another marker; put right"),
    "smoothed": ("", "white share of the density at the end of the spectrum, where there is none"),
    "resampled": ("Hz", "frequency at which the variance of interpolated frames varies"),
    "running_median": ("", "share of the values that repeat the one before, behind a median"),
    "solved": ("", "variance of the steps of a distance over that of its ends; of measured ones 1"),
    "resolution_limited": ("mm", "step of the file, which exceeds the noise"),
    "heavy_tails": ("", "excess kurtosis of the differences of frames"),
    "level_changes": ("", "relative change of the level of the noise over the recording"),
    "line": ("Hz", "frequency of a periodic disturbance"),
    "resonance": ("Hz", "natural frequency of a broad resonance"),
    "recurring": ("s", "period at which bursts recur"),
    "event": ("s", "time of a disturbance, from the first frame"),
}
CODE_OF = {"drift": "drift", "A_w": "warm_up", "h_-2": "random_walk"}
WANDERS = (
    *("accelerating", "creep", "slowing", "cycle", "step", "shift", "two_levels", "levels"),
    "wander",
)
USABLE = ("ok", "at_bound", "not_converged")
SETTLED = 3.0  # T_w after which 95 % of a warm-up are over


@dataclass(frozen=True)
class Finding:
    """One finding in one series (`x1`, ..., `L`; "" where it is of the whole recording).

    value: in the unit of its code (`CODES`); lower_95, upper_95: its 95 % interval, NaN where there
    is none.
    """

    code: str
    series: str
    value: float
    lower_95: float = math.nan
    upper_95: float = math.nan

    def __post_init__(self) -> None:
        if self.code not in CODES:
            raise ValueError(f"finding {self.code!r}, expected one of {', '.join(CODES)}")

    @property
    def unit(self) -> str:
        """Unit of the value and of its interval."""
        return CODES[self.code][0]

    def as_dict(self) -> Row:
        """For JSON."""
        return vars(self) | {"unit": self.unit}

    @classmethod
    def of(cls, row: Record) -> Finding:
        """Out of JSON, where no number is null."""
        numbers = (row["value"], row["lower_95"], row["upper_95"])
        return cls(row["code"], row["series"], *(math.nan if v is None else v for v in numbers))


def findings_of(
    recording: Recording, diagnosis: Diagnosis, noise: Sequence[NoiseRow]
) -> list[Finding]:
    """All findings in the order of `CODES`, by series within a code.

    noise: rows of noise.csv. Every part is a function of these that returns `Finding`s.
    """
    parts = [
        model_findings(noise, diagnosis.wanders),
        _wanders(diagnosis),
        [
            Finding("moves", name, one.size_mm, one.lower_95, one.upper_95)
            for name, one in diagnosis.movements.items()
            if one.moves
        ],
        [Finding("low_pass", one.series, one.cutoff_hz) for one in diagnosis.low_pass],
        _frames(recording, diagnosis),
        [Finding(one.code, one.series, one.value) for one in diagnosis.processed],
        [Finding("solved", name, ratio) for name, ratio in diagnosis.solved.items()],
        [  # series whose noise the file's steps decide
            Finding("resolution_limited", one.series, one.step_mm)
            for one in diagnosis.resolutions
            if one.word == DOMINATES and one.series not in diagnosis.solved
        ],
        [Finding("heavy_tails", x.series, x.excess, x.lower, x.upper) for x in diagnosis.tails],
        _level_changes(diagnosis),
        _lines(diagnosis),
        [Finding("resonance", one.series, one.f_hz) for one in diagnosis.resonances],
        _events(diagnosis),
    ]
    order = list(CODES)
    return sorted((one for part in parts for one in part), key=lambda one: order.index(one.code))


def _frames(recording: Recording, diagnosis: Diagnosis) -> list[Finding]:
    """Shares of filled (none where frames are smooth), repeated and exchanged frames, for all
    coordinates of a marker, which share them."""
    n = recording.n_frames
    shares = [
        ("gap_filled", label, recording.n_filled[label] / n)
        for label in recording.labels
        if recording.n_filled.get(label) and not diagnosis.smooth
    ]
    shares += [("repeated", one.label, one.share) for one in diagnosis.repeats]
    every = recording.exchanged
    shares += [("exchanged", k, one["n_frames"] / n) for one in every for k in one["labels"]]
    return [
        Finding(code, f"{axis}{recording.labels.index(label) + 1}", share)
        for code, label, share in shares
        for axis in AXES
    ]


def _level_changes(diagnosis: Diagnosis) -> list[Finding]:
    """Slow ones from the start to the end, and those at once from before to after, whose interval
    holds for all series together."""
    slow = [
        Finding("level_changes", one.series, one.change, one.lower, one.upper)
        for one in diagnosis.trends
    ]
    at_once = [
        Finding("level_changes", side.series, side.ratio - 1, side.lower - 1, side.upper - 1)
        for event in diagnosis.events
        if event.kind == "level"
        for side in event.sides
        if side.changed
    ]
    return [*slow, *at_once]


def _lines(diagnosis: Diagnosis) -> list[Finding]:
    """Frequency of every line of every series."""
    return [
        Finding(
            "line", one.series, one.line.f_0,
            one.line.f_0 - Z_95 * one.f_error, one.line.f_0 + Z_95 * one.f_error,
        )
        for one in diagnosis.lines
    ]  # fmt: skip


def _events(diagnosis: Diagnosis) -> list[Finding]:
    """One an event, in the series that moved most, and the period of those that recur."""
    regular = [Finding("recurring", name, period) for name, period in diagnosis.recurring.items()]
    return regular + [
        Finding("event", one.largest, one.time_s, math.nan, math.nan) for one in diagnosis.events
    ]


def _wanders(diagnosis: Diagnosis) -> list[Finding]:
    """Kinds of slow wander that the noise model has no coefficient of, or not beside others, and
    what is undecided. Beside several steps no rival of a straight line is in the library."""

    def value(kind: str, one: Wander) -> float:
        other = {"warm_up": -one.moved_mm, "cycle": one.at_s[-1] if one.at_s else math.nan}
        return other.get(kind, one.size_of(kind))

    def numbers(kind: str, one: Wander) -> tuple[float, float, float]:
        size, error = value(kind, one), one.error_mm if kind in ("step", "shift") else math.nan
        if kind == "drift":
            size, error = 3600 * one.slope[0], 3600 * one.slope[1]
        return size, size - Z_95 * error, size + Z_95 * error

    return [
        Finding(kind, name, *numbers(kind, one))
        for name, one in diagnosis.wanders.items()
        for kind in one.kinds
        if kind not in CODE_OF.values() or one.own(kind)
    ] + [
        Finding("wander", k, one.range_mm) for k, one in diagnosis.wanders.items() if one.undecided
    ]


def _named(row: NoiseRow, wanders: Mapping[str, Wander]) -> bool:
    """Whether no other kind of wander explains what a coefficient stands for, as far as known. Of
    what changes at once the noise model knows nothing, so its curve is not that beside it."""
    one = wanders.get(row["series"])
    kind = CODE_OF.get(row["parameter"], "")
    beside = one is not None and kind in one.kinds and (one.jumps or one.own(kind))
    return one is not None and one.allows(kind) and not beside


def model_findings(noise_rows: Iterable[NoiseRow], wanders: Mapping[str, Wander]) -> list[Finding]:
    """`drift`, `warm_up` and `random_walk` of every series, with 95 % intervals. noise_rows: of
    noise.csv, of any series; what was not detected, or is a misfit, is none, and nor is what may be
    nothing (see `_may_be_nothing`), or of another kind by its signature (`wanders`)."""
    return [
        Finding(CODE_OF[row["parameter"]], row["series"], *_numbers(row))
        for row in noise_rows
        if row["estimator"] == DEFAULT_ESTIMATOR
        and row["parameter"] in CODE_OF
        and row["status"] in USABLE
        and not _may_be_nothing(row)
        and _named(row, wanders)
    ]


def _numbers(row: NoiseRow) -> tuple[float, float, float]:
    return float(row["value"]), float(row["lower_95"]), float(row["upper_95"])


def _may_be_nothing(row: NoiseRow) -> bool:
    """Whether a drift or a warm-up has a 95 % interval that holds zero, or a walk is within 1.96
    standard errors of it. (The interval of a walk also reaches zero where a slow Gauss-Markov term
    could stand for it: a wander all the same.)"""
    if row["parameter"] == "h_-2":
        return float(row["value"]) < Z_95 * float(row["std_error"])
    if row["parameter"] not in ("drift", "A_w"):
        return False
    _, low, high = _numbers(row)
    return low <= 0 <= high


def deterministic_parts(
    noise_rows: Sequence[NoiseRow], wanders: Mapping[str, Wander]
) -> dict[str, Deterministic]:
    """The deterministic part of every series that has one, less what may be nothing, or of another
    kind by its signature."""
    rows = [
        r
        for r in noise_rows
        if r["estimator"] == DEFAULT_ESTIMATOR
        and r["status"] in USABLE
        and not _may_be_nothing(r)
        and (r["parameter"] not in ("drift", "A_w") or _named(r, wanders))
    ]
    names = dict.fromkeys(r["series"] for r in rows)
    parts = {name: deterministic_of([r for r in rows if r["series"] == name]) for name in names}
    return {name: part for name, part in parts.items() if not part.empty}


def other_wanders(
    recording: Recording, diagnosis: Diagnosis, parts: Mapping[str, Deterministic]
) -> list[tuple[str, str, dict[str, float]]]:
    """Kind of slow wander (`undecided` too), the coordinate that has most of it, and its size in
    each series, mm; one a kind, of single steps and shifts one a time. Not those that `parts`
    (`deterministic_parts`) state, nor steps that are an event, nor of distances what coordinates
    have."""
    stated = {"warm_up"} if any(part.A_w for part in parts.values()) else set()
    sizes: dict[tuple[str, float], dict[str, float]] = {}
    for name, one in diagnosis.wanders.items():
        for kind in ("undecided",) if one.undecided else one.kinds:
            if kind in stated or (kind == "drift" and not one.own(kind)):
                continue  # of the noise model, or not sure
            size = one.range_mm if kind == "undecided" else abs(one.size_of(kind))
            sizes.setdefault((kind, _time_of(kind, one, sizes)), {})[name] = size
    coordinates = recording.coordinates
    largest = {key: max(of, key=lambda k: (k in coordinates, of[k])) for key, of in sizes.items()}
    known = {kind for (kind, _), name in largest.items() if name in coordinates}
    return [
        (key[0], largest[key], of)
        for key, of in sizes.items()
        if (largest[key] in coordinates or key[0] not in known)
        and not _is_event(key[0], diagnosis.wanders[largest[key]], diagnosis)
    ]


def _time_of(kind: str, wander: Wander, known: Iterable[tuple[str, float]]) -> float:
    """When a single step or shift was, by the first of these kinds and times that it is near; else
    0."""
    if kind != "shift" and not (kind == "step" and len(wander.jumps) == 1):
        return 0.0
    time_s = wander.jumps[0][0]
    return next((t for one, t in known if one == kind and abs(t - time_s) <= NEAR_S), time_s)


def _is_event(kind: str, wander: Wander, diagnosis: Diagnosis) -> bool:
    """Whether a single step or shift is one of the bursts."""
    return kind in ("step", "shift") and any(
        one.time_s - NEAR_S <= wander.jumps[0][0] <= one.stop_s + NEAR_S
        for one in diagnosis.events
        if one.kind == "burst" and (len(wander.jumps) == 1 or kind == "shift")
    )


def times_of(wander: Wander, diagnosis: Diagnosis) -> list[float]:
    """When changes at once were: as the event says that it is, else to the next block."""
    bursts = [event for event in diagnosis.events if event.kind == "burst"]

    def time_of(jump_s: float) -> float:
        near = [e.time_s for e in bursts if e.time_s - NEAR_S <= jump_s <= e.stop_s + NEAR_S]
        return min(near, key=lambda time_s: abs(time_s - jump_s), default=jump_s)

    return [*dict.fromkeys(time_of(jump_s) for jump_s, _ in wander.jumps)]


def shift_near(
    begin_s: float, end_s: float, wanders: Mapping[str, Wander]
) -> tuple[str, float, bool] | None:
    """Series (coordinates before distances, then the largest), size in mm of the step, lasting
    shift or switch that an event is, and whether a shift ends with it; None of other events."""
    near = {
        name: jump
        for name, one in wanders.items()
        if set(one.kinds) & AT_ONCE
        if (jump := one.jump_near(begin_s, end_s))
    }
    name = max(near, key=lambda k: (not k.startswith("L"), abs(near[k][1])), default=None)
    if name is None:
        return None
    one, (time_s, size_mm) = wanders[name], near[name]
    return name, size_mm, "shift" in one.kinds and time_s > (one.at_s[0] + one.at_s[1]) / 2


def approach(part: Deterministic, duration_s: float) -> tuple[float, float]:
    """What the warm-up does, mm, and in what time, s: three T_w, or the recording."""
    within = min(SETTLED * part.T_w, duration_s)
    return -part.A_w * math.expm1(-within / part.T_w), within
