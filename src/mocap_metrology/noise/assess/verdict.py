"""Is a capture system good enough, as one of its recordings tells: one word, and why.

S 2.2 asks of a reference that its uncertainty be 4 to 10 times smaller than that of the device
under test. The number held against this rule is the uncertainty of one frame about the mean of the
horizon (`assess.series`, frame_mm) in the worst coordinate, as devices are compared frame by frame.
For a device of 1 mm the rule asks for 0.25 mm at least (`usable`) and better 0.1 mm (`good`): the
thresholds of the configuration. What else was found can only make the word worse: `Check`s.

It is of noise alone, the part that repeating a measurement shows (GUM 4.2, type A). What a
reference adds by scale and distortion of its volume is the same in every frame of a still
marker, and must be known otherwise.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from mocap_metrology.common.words import three
from mocap_metrology.noise.assess.export import filter_check, measured, resolution_check
from mocap_metrology.noise.assess.facts import NO_MODEL, Check, Facts, Thresholds

COORDINATE = re.compile(r"[xyz][1-9]\d*")
WORDS = ("good", "usable", "bad")
MOVES = "still.range_mm"
RULE = (4, 10)  # times better than the device under test [S 2.2]
LEAST_FRAMES, LEAST_S = 100, 1.0  # to judge by: their standard deviation is known to 7 %
CHANCE = 3.0  # standard deviations that a count of outliers may be above its mean


@dataclass(frozen=True)
class Verdict:
    """word: one of `WORDS`; decided_by: the check that made it; caps: all other checks that allow
    no better word than theirs; uncertainty: what one frame is uncertain by, in words, where it is
    known and did not decide; reference_for_mm: by factor of `RULE`, the least uncertainty of a
    device it may serve as a reference for by its noise alone: that many times the upper end of the
    interval of one frame in the worst coordinate; NaN where the word is bad."""

    word: str
    decided_by: Check
    caps: tuple[Check, ...]
    uncertainty: str
    reference_for_mm: dict[str, float]


def verdict(
    series: Mapping[str, Mapping[str, Any]], facts: Facts, limits: Thresholds | None = None
) -> Verdict:
    """Verdict on numbers of every series (`assess.series`), keyed by name.

    Coordinates decide, distances do not: their noise is that of two coordinates. Movement is told
    first: an uncertainty of what moves is none, and nothing may be held against it. Before it what
    leaves nothing to judge by: a recording that is too short, or gaps.
    """
    limits = limits or Thresholds()
    coordinates = {k: v for k, v in series.items() if COORDINATE.fullmatch(k)}
    main = _uncertainty(measured(coordinates, facts), facts, limits)
    checks = _checks(series, coordinates, facts, limits, main)
    word = max((c.word for c in checks), key=WORDS.index)
    decided = next(c for c in checks if c.word == word)
    caps = tuple(c for c in checks if c.word != "good" and c not in (main, decided))
    moves = any(c.threshold == MOVES and c.word == "bad" for c in checks)
    steps = facts.found("resolution_limited")
    told = main in checks and main is not decided and math.isfinite(main.value) and not moves
    told = told and main.series not in steps
    surely = math.nan
    if word != "bad" and not facts.found("low_pass"):
        surely = max(_upper_end(coordinates[main.series]), *steps.values(), 0.0)
    reference = {str(k): k * surely for k in RULE}
    return Verdict(word, decided, caps, main.sentence if told else "", reference)


def _checks(
    series: Mapping[str, Mapping[str, Any]],
    coordinates: Mapping[str, Mapping[str, Any]],
    facts: Facts,
    limits: Thresholds,
    main: Check,
) -> list[Check]:
    """All, in the order in which they are told if equally bad."""
    moving = _moving(series, coordinates, facts)
    steps = resolution_check(coordinates, facts, limits)
    missing = _missing(coordinates, facts, limits)
    least = _least(facts)
    if least.word == "bad":
        return [least, moving, missing]
    known = math.isfinite(main.value)
    first = [main, moving, _short(coordinates, facts, limits, main), missing]
    if steps.word != "good":
        first = [steps, *first]
    if moving.word == "bad" and known:
        first = [moving, *(check for check in first if check is not moving)]
    if missing.word == "bad" and not main.series:
        first = [missing, moving]
    return [
        *first,
        filter_check(coordinates, facts),
        _outliers(coordinates, facts, limits),
        _drift(coordinates, facts, limits),
        _misfit(coordinates, limits),
        _duration(facts, limits),
        _markers(facts, limits),
    ]


def _least(facts: Facts) -> Check:
    """Whether there is enough to judge by at all."""
    few = facts.n_frames < LEAST_FRAMES
    word = "bad" if few or facts.duration_s < LEAST_S else "good"
    sentence = (
        f"The recording is too short to judge: {facts.n_frames:.0f} frames in "
        f"{duration_words(facts.duration_s)}; a verdict needs {LEAST_FRAMES} frames and "
        f"{LEAST_S:g} s at least."
    )
    if few and facts.duration_s >= LEAST_S:
        return Check("", "", "frames", facts.n_frames, LEAST_FRAMES, "", word, sentence)
    return Check("", "", "duration", facts.duration_s, LEAST_S, "s", word, sentence)


def _upper_end(numbers: Mapping[str, Any]) -> float:
    """Of the interval of one frame; the value where there is no interval."""
    upper = float(numbers["frame_upper_mm"])
    return upper if math.isfinite(upper) else float(numbers["frame_mm"])


def _graded(value: float, limits: Thresholds, name: str) -> tuple[str, str, float]:
    """Word of a value that had better be small; key and value of the limit it kept to, or went
    beyond."""
    good, usable = getattr(limits, f"good_{name}"), getattr(limits, f"usable_{name}")
    if value <= good:
        return "good", f"verdict.good_{name}", good
    if value <= usable:
        return "usable", f"verdict.good_{name}", good
    return "bad", f"verdict.usable_{name}", usable


def _worst(values: Mapping[str, float]) -> tuple[str, float]:
    known = {k: v for k, v in values.items() if math.isfinite(v)}
    return max(known.items(), key=lambda item: item[1], default=("", math.nan))


def duration_words(seconds: float) -> str:
    """`an hour`, `10 min`, `5.2 s`."""
    if abs(seconds / 3600 - 1) < 0.005:
        return "an hour"
    if seconds >= 5400:
        return f"{seconds / 3600:.3g} h"
    return f"{seconds / 60:.3g} min" if seconds >= 120 else f"{seconds:.3g} s"


def _digits(mm: float) -> str:
    """Three digits, zeros too, so that a value and its interval have as many: 0.0260, 693."""
    rounded = float(f"{mm:.3g}")
    if not math.isfinite(rounded) or rounded == 0:
        return f"{mm:g}"
    return f"{rounded:.{max(2 - math.floor(math.log10(abs(rounded))), 0)}f}"


def _uncertainty(
    series: Mapping[str, Mapping[str, Any]], facts: Facts, limits: Thresholds
) -> Check:
    quantity = "uncertainty of one frame"
    still = [k for k, v in series.items() if v["status"] == "constant"]
    if still:
        constant, verb = ", ".join(still), "changes" if len(still) == 1 else "change"
        why = f"{constant} never {verb}: nothing is measured there, or the file is too coarse."
        key, limit = "verdict.usable_mm", limits.usable_mm
        return Check(key, constant, quantity, math.nan, limit, "mm", "bad", why)
    name, value = _worst({k: v["frame_mm"] for k, v in series.items()})
    if not name:
        none = all(v["status"] == "no valid samples" for v in series.values())
        why = f"There are {'no' if none else 'too few'} valid samples to judge by."
        return Check("verdict.usable_mm", "", quantity, value, limits.usable_mm, "mm", "bad", why)
    word, key, limit = _graded(value, limits, "mm")
    low, high = series[name]["frame_lower_mm"], series[name]["frame_upper_mm"]
    close = " (the interval reaches across)" if low <= limit < high else ""
    interval = f" ({_digits(low)} to {_digits(high)})" if math.isfinite(low + high) else ""
    sentence = (
        f"One frame of {name} is uncertain by {_digits(value)} mm{interval} about "
        f"the mean of {duration_words(facts.horizon_s)}; {_against(word, limit, 'mm')}{close}"
        f"{_not_known(facts)}."
    )
    return Check(key, name, quantity, value, limit, "mm", word, sentence)


def _not_known(facts: Facts) -> str:
    if not facts.short:
        return ""
    reached, asked = duration_words(facts.horizon_s), duration_words(facts.asked_s)
    return f"; over {reached} only, nothing is known of {asked}"


def _short(
    series: Mapping[str, Mapping[str, Any]], facts: Facts, limits: Thresholds, main: Check
) -> Check:
    """In a recording shorter than the horizon a good value may be luck: slow wander has one degree
    of freedom or two there. Then the upper end of the interval counts (a longer one has seen
    the whole horizon, and the value decides)."""
    judged = facts.short and main.word == "good"
    name, value = _worst({k: _upper_end(v) for k, v in series.items()} if judged else {})
    word = "usable" if value > limits.good_mm else "good"
    sentence = (
        f"Over {duration_words(facts.horizon_s)} only, one frame of {name} may be uncertain by "
        f"{_digits(value)} mm, the upper end of its interval; good is up to {limits.good_mm:g} mm."
    )
    quantity = "upper end of the interval of one frame"
    return Check("verdict.good_mm", name, quantity, value, limits.good_mm, "mm", word, sentence)


def _against(word: str, limit: float, unit: str) -> str:
    unit = f" {unit}" if unit else ""
    kept = {"good": "good is up to", "usable": "good would be up to", "bad": "usable is up to"}
    return f"{kept[word]} {limit:g}{unit}"


def _moving(
    series: Mapping[str, Mapping[str, Any]],
    coordinates: Mapping[str, Mapping[str, Any]],
    facts: Facts,
) -> Check:
    """Of the findings: what noise does not explain."""
    moved = {k: v for k, v in facts.found("moves").items() if k in coordinates}
    name, value = _worst(moved)
    labels = list(dict.fromkeys(_label(k, facts) for k in moved))
    verb = "moves" if len(labels) == 1 else "move"
    sentence = (
        f"{', '.join(labels)} {verb}: {name} by {three(value)} mm within "
        f"{duration_words(facts.horizon_s)}, which its noise does not explain; "
        f"{_still_counts(series, labels, facts)}."
    )
    quantity, word = "movement beyond noise", "bad" if moved else "good"
    return Check(MOVES, name, quantity, value, 0.0, "mm", word, sentence)


def _label(coordinate: str, facts: Facts) -> str:
    """Of the marker of a coordinate; its number where the label is not known."""
    number = int(coordinate[1:])
    return facts.labels[number - 1] if number <= len(facts.labels) else f"marker {number}"


def _still_counts(
    series: Mapping[str, Mapping[str, Any]], moved: Sequence[str], facts: Facts
) -> str:
    """What of a recording still tells of noise although some of its markers move."""
    moving = facts.found("moves")
    still = {
        k: v
        for k, v in series.items()
        if k not in moving and math.isfinite(v["frame_mm"]) and v["status"] != "constant"
    }
    distances = [k for k in still if not COORDINATE.fullmatch(k)]
    if distances:
        name = min(distances, key=lambda k: still[k]["frame_mm"])
        value = _digits(still[name]["frame_mm"])
        return f"what still counts is the distance {name}, one frame uncertain by {value} mm"
    others = dict.fromkeys(_label(k, facts) for k in still if COORDINATE.fullmatch(k))
    others = [label for label in others if label not in moved]
    if others:
        return f"what still counts are the numbers of {', '.join(others)}"
    return "none of its numbers is of noise alone"


def _missing(series: Mapping[str, Mapping[str, Any]], facts: Facts, limits: Thresholds) -> Check:
    filled = facts.found("gap_filled")
    shares = {k: v + filled.get(k, 0.0) for k, v in facts.missing.items()}
    said = "missing, or filled by an interpolation" if filled else "missing"
    return _share(series, shares, limits, "missing", "missing frames", said)


def _outliers(series: Mapping[str, Mapping[str, Any]], facts: Facts, limits: Thresholds) -> Check:
    said = "outliers, beyond what clean noise and chance make"
    return _share(series, facts.outliers, limits, "outliers", "outliers", said)


def _share(
    series: Mapping[str, Mapping[str, Any]],
    shares: Mapping[str, float],
    limits: Thresholds,
    key: str,
    what: str,
    said: str,
) -> Check:
    """The worst share of frames of a coordinate against the limits of `key`."""
    name, value = _worst({k: v for k, v in shares.items() if k in series})
    word, threshold, limit = _graded(value, limits, key) if name else ("good", "", math.nan)
    sentence = (
        f"{100 * value:.3g} % of the frames of {name} are {said}; "
        f"{_against(word, 100 * limit, '%')}."
    )
    return Check(threshold, name, f"share of {what}", value, limit, "", word, sentence)


def _drift(series: Mapping[str, Mapping[str, Any]], facts: Facts, limits: Thresholds) -> Check:
    """Over the horizon, and never beyond the recording: slopes of seconds say nothing of hours."""
    hours = facts.horizon_s / 3600
    name, value = _worst({k: abs(v["drift_mm_per_h"]) * hours for k, v in series.items()})
    word, key, limit = _graded(value, limits, "drift_mm") if name else ("good", "", math.nan)
    straight = name in facts.found("drift") or name not in facts.found("random_walk")
    does = "drifts" if straight else "wanders as a random walk: a line through it rises"
    sentence = (
        f"{name} {does} by {three(value)} mm in {duration_words(facts.horizon_s)}; "
        f"{_against(word, limit, 'mm')}."
    )
    return Check(key, name, "drift over the horizon", value, limit, "mm", word, sentence)


def _misfit(series: Mapping[str, Mapping[str, Any]], limits: Thresholds) -> Check:
    found = {k: v for k, v in series.items() if v["status"] not in ("ok", "constant")}
    word = limits.misfit if found else "good"
    reasons: dict[str, list[str]] = {}
    for name, values in found.items():
        reasons.setdefault(_why_no_model(values), []).append(name)
    said = "; ".join(
        f"{why} of {', '.join(names)}" if len(names) < len(series) else why
        for why, names in reasons.items()
    )
    sentence = (
        f"{said[:1].upper()}{said[1:]}: its numbers are those of this recording and may not be of "
        "the next."
    )
    value = ", ".join(dict.fromkeys(v["status"] for v in found.values())) or "ok"
    named = ",".join(found)
    return Check("verdict.misfit", named, "noise model", value, "ok", "", word, sentence)


def _why_no_model(values: Mapping[str, Any]) -> str:
    if values["status"] == "misfit":
        return "the noise model does not describe the spectrum"
    why = values.get("why_measured", "")
    known = "" if why in ("", NO_MODEL) else f" ({why})"
    return f"{NO_MODEL}{known}"


def _duration(facts: Facts, limits: Thresholds) -> Check:
    least, value = limits.good_duration_s, facts.duration_s
    word = "good" if value >= least else "usable"
    sentence = (
        f"The recording lasts {duration_words(value)}; less than {least:g} s do not tell how the "
        "system wanders."
    )
    return Check("verdict.good_duration_s", "", "duration", value, least, "s", word, sentence)


def _markers(facts: Facts, limits: Thresholds) -> Check:
    least, value = limits.good_markers, facts.n_markers
    word = "good" if value >= least else "usable"
    sentence = (
        f"{value} marker{'' if value == 1 else 's'} of at least {least}: without a distance, "
        "nothing is measured that does not depend on where the cameras are."
    )
    return Check("verdict.good_markers", "", "markers", value, least, "", word, sentence)


def dominating(series: Mapping[str, Any]) -> str:
    """Kind of noise with the largest share of the uncertainty of one frame; empty if unknown."""
    shares: Mapping[str, float] = series["shares"]
    return max(shares, key=lambda name: shares[name], default="")


def worst_coordinate(series: Mapping[str, Mapping[str, Any]], key: str) -> str:
    """Name of the coordinate with the greatest `key`; empty without one."""
    return _worst({k: v[key] for k, v in series.items() if COORDINATE.fullmatch(k)})[0]


def excess_outliers(rows: Sequence[Mapping[str, Any]]) -> dict[str, float]:
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


def missing_frames(rows: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    """By series of outliers.csv: share of frames without a sample."""
    return {row["series"]: 1 - float(row["n_valid"]) / float(row["n_frames"]) for row in rows}
