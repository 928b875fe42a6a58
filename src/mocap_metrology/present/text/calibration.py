"""The verdict on a calibration, its checks and its comparison with an earlier one, in words."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

from mocap_metrology.common.types import Row
from mocap_metrology.lighthouse.assess.comparison import (
    LARGE_DEG,
    LARGE_MM,
    TOLERANCE_DEG,
    TOLERANCE_MM,
    Comparison,
)
from mocap_metrology.lighthouse.assess.fit_checks import USUAL_S, Case, Check
from mocap_metrology.lighthouse.assess.summary import Summary
from mocap_metrology.lighthouse.assess.validation import Verdict
from mocap_metrology.present.text.numbers import apart, is_same

SENTENCES = {
    Case.DISTANCE: "The stations are {value:.3g} m apart.",
    Case.TOO_DISTANT: (
        "The stations are {value:.3g} m apart, too far apart for a board to be in view of both "
        "(at most {limit:g} m)."
    ),
    Case.RESIDUAL: "Angles are {value:.0f} µrad rms from the fit; {usual} {noise:.0f}{made}, good"
    " is below {limit:.0f}.",
    Case.RESIDUAL_HIGH: (
        "Angles are {value:.0f} µrad rms from the fit, {times:.0f} times {that}"
        "{made}. Possible causes: wrong optics (factory values, lasers off the housing's "
        "origin), a wrong board file, reflections, a station that moved or has a noisy rotor, or "
        "board poses in the wrong minimum."
    ),
    Case.RESIDUAL_UNKNOWN: "The residual of the fit is unknown.",
    Case.WEIGHT: "{percent:.2g} % of the hits' weight is lost.",
    Case.WEIGHT_LOST: (
        "{percent:.2g} % of the hits' weight is lost, as these hits fit no path of the board. "
        "Possible causes: reflections, stray light, a board beyond the view of a station."
    ),
    Case.WEIGHT_UNKNOWN: "Hits of this estimate are not weighed.",
    Case.PRIORS: "Board and optics as estimated agree with what is known of them.",
    Case.PRIORS_LEFT: (
        "Board and optics as estimated deviate from what is known of them (probability by chance: "
        "{chance}). Possible causes: a board file that does not fit the board (stretched, or "
        "wrong diodes), wrong factory values, lasers far from their places, a known length that is "
        "wrong."
    ),
    Case.PRIORS_UNKNOWN: "Board and optics are not estimated.",
    Case.MISFIT_NONE: "Pieces of the recording agree within noise.",
    Case.MISFIT: (
        "Pieces of the recording deviate from each other {times:.2g} times as much as noise "
        "explains, which the uncertainty includes. Possible causes: wrong optics or board file, "
        "reflections, a station that moved."
    ),
    Case.MISFIT_UNKNOWN: "Pieces of the recording were not compared.",
    Case.PATH_ERRORS: "Errors of the board's path leave {value:.0f} µrad of the residual"
    " unexplained.",
    Case.BEYOND_PATH: (
        "Errors of the board's path leave {value:.0f} µrad of the residual unexplained (noise of "
        "an angle: {noise:.0f}). Possible causes: a station that was touched, a wrong board file "
        "or wrong optics."
    ),
    Case.PATH_ERRORS_UNKNOWN: "Errors of the board's path could not be separated.",
    Case.HALVES: ("Parts of the recording differ by {about}, which is within chance."),
    Case.HALVES_APART: (
        "Parts of the recording differ by {about}, {times:.0f} times as much "
        "as noise explains: was a station touched during the recording?"
    ),
    Case.HALVES_MISFIT: (
        "Parts of the recording differ by {about}, {times:.0f} times as much as noise explains, "
        "and no step at one moment explains it. Possible causes: wrong optics or board file, "
        "reflections."
    ),
    Case.HALVES_OPEN: (
        "Parts of the recording differ by {about}, {times:.0f} times as much as noise explains. "
        "Possible causes: wrong optics or board file, reflections, a station that moved."
    ),
    Case.RECORDINGS: (
        "The recording that agrees least with the others differs from them by {about}, which is "
        "within chance."
    ),
    Case.RECORDINGS_APART: (
        "One recording differs from the others by {about}, {times:.0f} times as much as noise "
        "explains: was a station touched between the recordings?"
    ),
    Case.HALVES_UNKNOWN: "Parts of the recording were not compared.",
    Case.MIRRORED: "{percent:.2g} % of the board poses are mirrored.",
    Case.MIRRORED_FLAT: (
        "{percent:.2g} % of the board poses are mirrored, which is possible with a flat board: "
        "use `paper-lm`, which decides by {both}."
    ),
    Case.MIRRORED_BOTH: (
        "{percent:.2g} % of the board poses are mirrored or wrong in another way, although "
        "{both} were used to decide: is the board file right (and no mirror image)? Use a "
        "larger board, or one with depth."
    ),
    Case.MIRRORED_UNKNOWN: "The share of mirrored board poses was not determined.",
    Case.MOVED: "The board moved.",
    Case.STILL: (
        "The board did not move: the pose is based on one position of the board, and the size of "
        "the board limits its accuracy. Record again with the board moved through the room."
    ),
    Case.COMMON: "{Both} saw the board at {value} moments.",
    Case.COMMON_FEW: "{Both} saw the board at {value} moments, few for a pose: record for longer,"
    " with the board in the view of both.",
    Case.COMMON_UNNEEDED: "A board at rest needs no common measurements.",
    Case.BOARD_POSES: "Angles of single board poses are {value:.0f} µrad rms from their fit.",
    Case.BOARD_POSES_HIGH: "Angles of single board poses are {value:.0f} µrad rms from their fit:"
    " is the board file right, are there reflections?",
    Case.BOARD_POSES_NONE: "There are no board poses.",
    Case.PATH: "The path of the board is {value:.2g} m long.",
    Case.PATH_SHORT: (
        "The path of the board is only {value:.2g} m long: a short path leaves {its} uncertain."
    ),
    Case.PATH_UNNEEDED: "The last stage does not depend on the length of the path.",
    Case.PATH_NONE: "A board at rest has no path.",
    Case.UNCERTAINTY: (
        "One standard deviation is {about} in the worst axes. They do not "
        "include an error of scale in the board file, which scales the distance."
    ),
    Case.UNCERTAINTY_ALL: (
        "One standard deviation is {about} in the worst axes, errors of board and optics included."
    ),
    Case.UNCERTAINTY_SCALE: (
        "One standard deviation is {about} in the worst axes, errors of board and optics included; "
        "{percent:.0f} % of the variance of the position is the scale of the board, which a known "
        "length reduces (column known_length)."
    ),
    Case.UNCERTAINTY_NONE: "This estimate has no covariance.",
    Case.UNCERTAINTY_UNKNOWN: "The covariance of this estimate contains values that are not finite"
    " numbers: its uncertainty is unknown.",
    Case.DURATION: "The recording lasts {value:.3g} s.",
    Case.DURATION_UNUSUAL: f"The recording lasts {{value:.3g}} s, not the usual {USUAL_S:g} s.",
    Case.DURATION_SHORT: f"The recording lasts {{value:.3g}} s, not the usual {USUAL_S:g} s: few"
    " measurements.",
    Case.DURATION_UNKNOWN: "The duration is unknown.",
    Case.FACTORY: "Factory values from the recording.",
    Case.FACTORY_FILE: (
        "Factory values of the {all_names} come from a calibration file, not from the recording: "
        "they are correct only if the file belongs to this station."
    ),
    Case.IDEAL: (
        "Ideal optics, without the stations' factory values ({why}): for real stations the pose "
        "is wrong by 2 to 20 cm and 1 to 6°, and no residual shows this."
    ),
    Case.ESTIMATED: (
        "The stations' factory values are not known ({why}) and were estimated with the pose, "
        "which the uncertainty includes: several recordings at different places make it smaller."
    ),
    Case.ROTOR_CLEAR: (
        "The rotor model of {first} fits the recording significantly better than the others."
    ),
    Case.ROTOR_OPEN: (
        "The recording cannot distinguish the rotor models of {first} and {others}; their poses "
        "differ by up to {about}, which the uncertainty includes."
    ),
    Case.ROTOR_UNASKED: "Models of the rotors were not compared.",
    Case.STAGES: "Kabsch and final stage are {apart} apart.",
    Case.STAGES_LOOSE: (
        "Kabsch and final stage are {apart} apart. The Kabsch stage is no "
        "more accurate than that on such a path."
    ),
    Case.STAGES_UNKNOWN: "Kabsch and final stage are {apart} apart. Whether"
    " noise explains that is unknown: a covariance contains values that are not finite numbers.",
    Case.OPTICS: "Factory values change the pose by {apart}.",
    Case.OPTICS_FAR: (
        "Factory values change the pose by {apart}, more than is possible "
        "for a first-generation station."
    ),
    Case.GRAVITY: "The vertical directions measured by {both} agree within {value:.1f}°.",
    Case.GRAVITY_OFF: (
        "The vertical directions measured by {both} differ by {value:.1f}° in this pose."
    ),
    Case.GRAVITY_OFF_IDEAL: (
        "The vertical directions measured by {both} differ by {value:.1f}° in this pose. "
        "Neglected factory values alone can make 4°."
    ),
    Case.GRAVITY_UNKNOWN: "No gravity from {both} to compare with.",
    Case.REFERENCE: "The pose is {apart} from the reference.",
    Case.REFERENCE_NONE: "There is no reference.",
    Case.OBJECTS: (
        "The pose from {first}, another object of the same recording, differs by {about}, which is "
        "within chance."
    ),
    Case.OBJECTS_APART: (
        "The pose from {first}, another object of the same recording, differs by {about} "
        "(probability by chance: {chance}): one of both is farther off than stated. Possible "
        "causes: a board file that does not fit its object, reflections."
    ),
}


SAME = {  # where poses differ by less than their resolution
    Case.ROTOR_OPEN: (
        "The recording cannot distinguish the rotor models of {first} and {others}, and need not: "
        "their poses do not differ ({apart})."
    ),
    Case.OPTICS: "Factory values do not change the pose ({apart}).",
}


def pose_document(found: Summary) -> Row:
    """Contents of pose.json, with its sentences."""
    document, checks = found.document, found.verdict.checks
    told: Row = {
        "verdict": document["verdict"] | {"reason": reason(found.verdict)},
        "checks": [
            row | {"sentence": sentence(check, found.verdict.station)}
            for row, check in zip(document["checks"], checks, strict=True)
        ],
    }
    if "check_against" in document:
        words = comparison_words(found.comparison)
        told["check_against"] = document["check_against"] | {"sentence": words}
    return {**document, **told}


def reason(verdict: Verdict) -> str:
    """The sentences of the checks that made the word, then what else was found, in short; of any
    number of stations those of the worst, and why others have no pose."""
    station, checks = verdict.station, verdict.checks
    if station:
        word = verdict.words[station]
        first = "" if word == "good" else f"Station {station}: "
        said = first + _reason_of(word, checks, station, verdict.why_none)
        return ". ".join([said.rstrip("."), *map(_capital, verdict.apart)]) + "."
    return _reason_of(verdict.word, checks, "", verdict.why_none)


def _reason_of(word: str, checks: Sequence[Check], station: str, why_none: str) -> str:
    if not checks:
        return why_none or "No pose of the slave was found."
    say = partial(sentence, station=station)
    models = [say(c) for c in checks if c.case is Case.ROTOR_OPEN and not is_same(*_apart(c))]
    if word == "good":
        passed = sum(c.ok is True for c in checks)
        said = [say(c) for c in checks if c.ok and c.name in ("residual", "uncertainty")]
        return " ".join([f"All {passed} checks passed.", *said, *models])
    bad = [c for c in checks if c.level == word]
    rest = [*bad[2:], *(c for c in checks if c.level not in (word, "good"))]
    return " ".join([*map(say, bad[:2]), *(_in_short(say(c)) for c in rest), *models])


def _capital(line: str) -> str:
    return line[:1].upper() + line[1:]


def _in_short(said: str) -> str:
    """Without the causes it may have."""
    first = said.split(". Possible causes: ")[0]
    return first if first.endswith((".", "?")) else first + "."


def sentence(check: Check, station: str = "") -> str:
    """A check in words, with its numbers; station: of several the one that it is of."""
    made = check.numbers.get("made_by_poses")
    small = f" (errors of the board's poses alone make {made:.0f} µrad of it)" if made else ""
    why = "; ".join(f"{role}: {reason or 'none found'}" for role, reason in check.why.items())
    distance = _apart(check)
    both = f"station {station} and the reference" if station else "both stations"
    sentences = SENTENCES | SAME if is_same(*distance) else SENTENCES
    return sentences[check.case].format(
        **check.numbers,
        value=check.value,
        chance=_chance(check.value),
        apart=apart(*distance),
        about=apart(*distance, digits=2),
        limit=check.limit,
        made=small,
        both=both,
        Both=_capital(both),
        usual="noise and places of the diodes make" if station else "the noise of an angle is",
        that="what noise and places of the diodes make" if station else "the noise of an angle",
        its=f"the rotation of station {station}" if station else "the slave's rotation",
        why=why or "not used",
        first=next(iter(check.names), ""),
        others=" or ".join(check.names[1:]),
        all_names=" and ".join(check.names),
    )


def _chance(p: object) -> str:
    if not isinstance(p, float):
        return str(p)
    return "below 0.0001" if p < 0.0001 else f"{p:.2g}"


def _apart(check: Check) -> tuple[float, float]:
    """mm and deg between the poses that a check compares; NaN of another check."""
    parts = (
        Case.HALVES,
        Case.HALVES_APART,
        Case.HALVES_MISFIT,
        Case.HALVES_OPEN,
        Case.RECORDINGS,
        Case.RECORDINGS_APART,
        Case.OBJECTS,
        Case.OBJECTS_APART,
    )
    by_numbers = check.case in parts
    mm = check.numbers.get("mm") if by_numbers else check.value
    deg = check.numbers.get("deg", math.nan)
    return mm if isinstance(mm, float) else math.nan, deg


def comparison_words(found: Comparison | None) -> str:
    """Whether a station has moved since an earlier calibration, by how much, and whether that one
    is still valid; None: there is no pose."""
    if found is None:
        return "No pose to compare with the earlier one."
    said = "A station has moved" if found.moved else "No sign that a station moved"
    how = f"probability by chance: {_chance(found.p_value)}"
    if math.isnan(found.p_value):
        how = f"no covariance; a station counts as moved beyond {LARGE_MM:g} mm or {LARGE_DEG:g}°"
    other = f"Compared with another estimate ({', '.join(found.other)})." if found.other else ""
    first = f"{said}: {apart(*found.shift)} from the earlier pose ({how})."
    parts = (first, _interval_words(found), _validity_words(found), found.note, other)
    return " ".join(part for part in parts if part)


def _interval_words(found: Comparison) -> str:
    if math.isnan(found.upper_95[0]):
        return ""
    (mm, deg), (to_mm, to_deg) = found.lower_95, found.upper_95
    return f"95 % intervals: {mm:.2g} to {to_mm:.2g} mm, {deg:.2g} to {to_deg:.2g}°."


def _validity_words(found: Comparison) -> str:
    if found.valid:
        return "The earlier calibration is still valid."
    if found.moved:
        return "The earlier calibration is no longer valid."
    limit = f"{TOLERANCE_MM:g} mm or {TOLERANCE_DEG:g}°"
    return f"The difference exceeds {limit}, so the earlier calibration is not confirmed."
