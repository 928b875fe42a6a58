"""Reasons of a verdict on a recording: each check, and why numbers are measured, in words."""

from __future__ import annotations

import math

from mocap_metrology.noise.assess.checks import (
    LEAST_FRAMES,
    LEAST_S,
    Check,
    Code,
    LengthCheck,
    ModelCheck,
    MovementCheck,
)
from mocap_metrology.noise.assess.uncertainty import Unmodelled, Why
from mocap_metrology.present.text.numbers import duration_words, mm, with_interval, with_unit

# What the value of a check is, as verdict.json names it
QUANTITIES = {
    Code.FRAME: "uncertainty of one frame",
    Code.CONSTANT: "uncertainty of one frame",
    Code.NO_SAMPLES: "uncertainty of one frame",
    Code.FEW_SAMPLES: "uncertainty of one frame",
    Code.UPPER_END: "upper end of the interval of one frame",
    Code.MOVES: "movement beyond noise",
    Code.MISSING: "share of missing frames",
    Code.MISSING_OR_FILLED: "share of missing frames",
    Code.STEP: "step of the file",
    Code.LOW_PASS: "low-pass filter of the export",
    Code.PROCESSED: "frames as they were measured",
    Code.EXCHANGED: "share of frames with exchanged labels",
    Code.OUTLIERS: "share of outliers",
    Code.DRIFT: "drift over the horizon",
    Code.RANDOM_WALK: "drift over the horizon",
    Code.WANDER: "drift over the horizon",
    Code.MISFIT: "noise model",
    Code.DURATION: "duration",
    Code.MARKERS: "markers",
}
SHARES = {
    Code.MISSING: "missing",
    Code.MISSING_OR_FILLED: "missing or filled by interpolation",
    Code.OUTLIERS: "outliers, more than clean noise and chance explain",
}
DONE = {
    "smoothed": "no white noise, so the software smoothed it, as far as can be told; the noise of "
    "a measured frame is not known",
    "resampled": "interpolated to another frame rate",
    "running_median": "running medians of the measured frames",
}
KEPT = {
    "good": "within the limit for good,",
    "usable": "the limit for good is",
    "bad": "the limit for usable is",
}
NO_MODEL = "there is no noise model"
MISFIT = "the noise model does not describe the spectrum"


def quantity(check: Check) -> str:
    """Name of the quantity that is compared with the limit."""
    if check.code is Code.TOO_SHORT:
        return "duration" if check.unit else "frames"
    return QUANTITIES[check.code]


def reason(check: Check) -> str:
    """The sentence of a check, with its numbers."""
    match check:
        case LengthCheck():
            return _length(check)
        case MovementCheck():
            return _movement(check)
        case ModelCheck():
            return _model(check)
    if check.code is Code.PROCESSED:
        named = ", ".join(check.names) or "The recording"
        return f"{named}: {DONE[str(check.value)]}. Export unprocessed frames."
    value = float(check.value)
    match check.code:
        case Code.EXCHANGED:
            named = " and ".join(check.names)
            return (
                f"The labels of {named} are exchanged in {100 * value:.3g} % of the frames; the "
                "numbers are of the labels put right. Correct them in the file."
            )
        case Code.FRAME:
            return _frame(check, value)
        case Code.CONSTANT:
            verb = "changes" if len(check.names) == 1 else "change"
            named = ", ".join(check.names)
            return (
                f"{named} never {verb}: nothing is measured there, or the steps of the file are "
                "too coarse."
            )
        case Code.NO_SAMPLES | Code.FEW_SAMPLES:
            few = "no" if check.code is Code.NO_SAMPLES else "too few"
            return f"There are {few} valid samples for a verdict."
        case Code.UPPER_END:
            return (
                f"Over only {duration_words(check.over_s)}, the uncertainty of one frame of "
                f"{check.series} may be {mm(value)} (upper end of its interval); the limit for "
                f"good is {float(check.limit):g} mm."
            )
        case Code.STEP:
            return (
                f"The resolution of the export limits the result: its steps of {mm(value)} hide "
                f"the noise of {', '.join(check.names) or 'all coordinates'}, so a frame is known "
                "no better than one step; export with finer steps."
            )
        case Code.LOW_PASS:
            about = f" at about {value:.2g} Hz" if math.isfinite(value) else ""
            named = ", ".join(check.names) or "The recording"
            verb = "look" if len(check.names) > 1 else "looks"
            return (
                f"{named} {verb} to be low-pass filtered{about}; the noise of a frame before the "
                "filter cannot be estimated. Export unfiltered data."
            )
        case Code.MISSING | Code.MISSING_OR_FILLED | Code.OUTLIERS:
            return (
                f"{100 * value:.3g} % of the frames of {check.series} are {SHARES[check.code]}; "
                f"{_against(check, 100, '%')}."
            )
        case Code.WANDER:
            return (
                f"{check.series} wanders: a straight line fitted to it changes by {mm(value)} in "
                f"{duration_words(check.over_s)}; {_against(check)}."
            )
        case Code.DRIFT | Code.RANDOM_WALK:
            walk = "wanders as a random walk: a straight line fitted to it rises"
            does = "drifts" if check.code is Code.DRIFT else walk
            return (
                f"{check.series} {does} by {mm(value)} in {duration_words(check.over_s)}; "
                f"{_against(check)}."
            )
        case Code.DURATION:
            least = float(check.limit)
            return (
                f"The recording lasts {duration_words(value)}; at least {least:g} s are needed to "
                "estimate slow wander."
            )
        case _:
            return (
                f"{check.value} marker{'' if value == 1 else 's'}; at least {check.limit} are "
                "needed: without a distance, every quantity depends on the positions of the "
                "cameras."
            )


def _length(check: LengthCheck) -> str:
    return (
        f"The recording is too short to judge: {check.n_frames:.0f} frames in "
        f"{duration_words(check.duration_s)}; a verdict needs at least {LEAST_FRAMES} frames and "
        f"{LEAST_S:g} s."
    )


def _frame(check: Check, value: float) -> str:
    low, high, limit = check.lower, check.upper, float(check.limit)
    close = " (the interval includes the limit)" if low <= limit < high else ""
    unknown = ""
    if math.isfinite(check.asked_s):
        reached, asked = duration_words(check.over_s), duration_words(check.asked_s)
        unknown = f"; a recording of {reached} gives no information about {asked}"
    size = with_interval(value, low, high, "mm")
    return (
        f"One frame of {check.series} is uncertain by {size} about "
        f"the mean of {duration_words(check.over_s)}; {_against(check)}{close}{unknown}."
    )


def _against(check: Check, times: float = 1, unit: str = "mm") -> str:
    """The limit that decides the word of a check."""
    return f"{KEPT[check.word]} {with_unit(times * float(check.limit), unit)}"


def _movement(check: MovementCheck) -> str:
    verb = "moves" if len(check.names) == 1 else "move"
    if check.distance:
        counts = (
            f"the distance {check.distance} is still valid, with an uncertainty of one frame of "
        )
        counts += mm(check.distance_mm)
    elif check.still:
        counts = f"still valid are the numbers of {', '.join(check.still)}"
    else:
        counts = "all its numbers include this movement"
    size = mm(float(check.value))
    return (
        f"{', '.join(check.names)} {verb}: {check.series} by {size} within "
        f"{duration_words(check.over_s)}, which its noise does not explain; {counts}."
    )


def _model(check: ModelCheck) -> str:
    reasons: dict[str, list[str]] = {}
    for name, why in check.unmodelled.items():
        reasons.setdefault(_why_no_model(why), []).append(name)
    said = "; ".join(
        f"{why} of {', '.join(names)}" if len(names) < check.n_coordinates else why
        for why, names in reasons.items()
    )
    return (
        f"{said[:1].upper()}{said[1:]}: its numbers describe this recording and may not hold for "
        "the next one."
    )


def _why_no_model(found: Unmodelled | None) -> str:
    if found is None or found.why is Why.NO_MODEL:
        return NO_MODEL
    return MISFIT if found.why is Why.MISFIT else f"{NO_MODEL} ({why_measured(found)})"


def why_measured(found: Unmodelled | None) -> str:
    """Why the numbers of a series are not those of a model; empty where they are."""
    if found is None:
        return ""
    needed = f"{found.value:.0f} samples, a noise model needs {found.expected:.0f}"
    scatter = f"scatter by {mm(found.value)}, the model predicts {mm(found.expected)}"
    return {
        Why.NO_SAMPLES: "no valid samples",
        Why.TOO_SHORT: f"too short: {needed}",
        Why.TOO_MANY_GAPS: f"too many gaps: {needed}",
        Why.REFUSED: found.note,
        Why.NO_MODEL: NO_MODEL,
        Why.MISFIT: MISFIT,
        Why.FRAMES_DISAGREE: f"single frames {scatter}",
        Why.MEANS_DISAGREE: f"means over {found.over_s:g} s {scatter}",
    }[found.why]
