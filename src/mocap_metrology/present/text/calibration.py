"""The verdict on a calibration, its checks and its comparison with an earlier one, in words."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

from mocap_metrology.common.types import Row
from mocap_metrology.lighthouse.assess import comparison
from mocap_metrology.lighthouse.assess.fit_checks import USUAL_S, Case, Check
from mocap_metrology.lighthouse.assess.summary import Summary
from mocap_metrology.lighthouse.assess.validation import Verdict
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import apart, is_same

SENTENCES = captions.texts("CALIBRATION_SENTENCES")
OF_PARTS = (  # cases of poses by parts of a recording, or by several
    *(Case.HALVES, Case.HALVES_APART, Case.HALVES_MISFIT, Case.HALVES_OPEN),
    *(Case.RECORDINGS, Case.RECORDINGS_APART, Case.OBJECTS, Case.OBJECTS_APART),
)
SAME = captions.texts("CALIBRATION_SAME")  # where poses differ by less than their resolution


def pose_document(summary: Summary) -> Row:
    """Contents of pose.json, with its sentences."""
    document, checks = summary.document, summary.verdict.checks
    told: Row = {
        "verdict": document["verdict"] | {"reason": reason(summary.verdict)},
        "checks": [
            row | {"sentence": sentence(check, summary.verdict.station)}
            for row, check in zip(document["checks"], checks, strict=True)
        ],
    }
    if "check_against" in document:
        words = comparison_words(summary.comparison)
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
        return " ".join(map(_ended, [said, *map(_capital, verdict.apart)]))
    return _reason_of(verdict.word, checks, "", verdict.why_none)


def _reason_of(word: str, checks: Sequence[Check], station: str, why_none: str) -> str:
    if not checks:
        return why_none or "No pose of the slave was found."
    say = partial(sentence, station=station)
    told = [c for c in checks if c.case is Case.LENGTH or (c.ok is False and c.level == "good")]
    always = [
        say(c) for c in told if c.case is not Case.ROTOR_OPEN or not is_same(*_pose_distance(c))
    ]
    if word == "good":
        passed = sum(c.ok is True for c in checks)
        said = [say(c) for c in checks if c.ok and c.name in ("residual", "uncertainty")]
        return " ".join([f"All {passed} checks passed.", *said, *always])
    bad = [c for c in checks if c.level == word]
    others = [*bad[2:], *(c for c in checks if c.level not in (word, "good"))]
    short = [say(c).split(". Possible causes: ")[0] for c in others]
    return " ".join([*map(say, bad[:2]), *map(_ended, short), *always])


def _ended(said: str) -> str:
    return said if said.endswith((".", "?")) else f"{said}."


def _capital(line: str) -> str:
    return line[:1].upper() + line[1:]


def sentence(check: Check, station: str = "") -> str:
    """A check in words, with its numbers; station: of several the one that it is of."""
    by_poses = check.numbers.get("made_by_poses")
    small = (
        f" (errors of the board's poses alone make {by_poses:.0f} µrad of it)" if by_poses else ""
    )
    why = "; ".join(f"{role}: {reason or 'none found'}" for role, reason in check.why.items())
    distance = _pose_distance(check)
    both = f"station {station} and the reference" if station else "both stations"
    errors = "noise and places of the diodes"
    sentences = SENTENCES | SAME if is_same(*distance) else SENTENCES
    return sentences[check.case].format(
        **check.numbers,
        value=check.value,
        chance=_chance(check.value),
        apart=apart(*distance),
        about=apart(*distance, digits=2),
        limit=check.limit,
        usual_s=USUAL_S,
        made=small,
        both=both,
        Both=_capital(both),
        usual=f"{errors} make up to" if station else "the noise of an angle is",
        that=f"what {errors} make" if station else "the noise of an angle",
        its=f"the rotation of station {station}" if station else "the slave's rotation",
        of_it=f" of station {station}" if station else "",
        why=why or "not used",
        first=next(iter(check.names), ""),
        in_one=f" in recording {check.names[0]}" if check.names else "",
        the_recording=f"recording {check.names[0]}" if check.names else "the recording",
        others=" or ".join(check.names[1:]),
        all_names=_all_names(check.names, station),
    )


def _all_names(names: Sequence[str], station: str) -> str:
    """Master, slave or both, or stations by their channels, in words."""
    kind = "the" if not station else "station" if len(names) == 1 else "stations"
    return f"{kind} " + " and ".join(filter(None, (", ".join(names[:-1]), *names[-1:])))


def _chance(p: object) -> str:
    if not isinstance(p, float):
        return str(p)
    return "below 0.0001" if p < 0.0001 else f"{p:.2g}"


def _pose_distance(check: Check) -> tuple[float, float]:
    """mm and deg between the poses that a check compares; NaN of another check."""
    mm = check.numbers.get("mm") if check.case in OF_PARTS else check.value
    deg = check.numbers.get("deg", math.nan)
    return mm if isinstance(mm, float) else math.nan, deg


def comparison_words(compared: comparison.Comparison | None) -> str:
    """Whether a station has moved since an earlier calibration, by how much, and whether that one
    is still valid; None: there is no pose."""
    if compared is None:
        return "No pose to compare with the earlier one."
    said = "A station has moved" if compared.moved else "No sign that a station moved"
    how = f"probability by chance: {_chance(compared.p_value)}"
    if math.isnan(compared.p_value):
        far = f"{comparison.LARGE_MM:g} mm or {comparison.LARGE_DEG:g}°"
        how = f"no covariance; a station counts as moved beyond {far}"
    other = (
        f"Compared with another estimate ({', '.join(compared.other)})." if compared.other else ""
    )
    first = f"{said}: {apart(*compared.shift)} from the earlier pose ({how})."
    (mm, deg), (to_mm, to_deg) = compared.lower_95, compared.upper_95
    spans = f"95 % intervals: {mm:.2g} to {to_mm:.2g} mm, {deg:.2g} to {to_deg:.2g}°."
    limit = f"{comparison.TOLERANCE_MM:g} mm or {comparison.TOLERANCE_DEG:g}°"
    valid = f"The difference exceeds {limit}, so the earlier calibration is not confirmed."
    if compared.valid or compared.moved:
        valid = f"The earlier calibration is {'still' if compared.valid else 'no longer'} valid."
    parts = (first, "" if math.isnan(to_mm) else spans, valid, compared.note, other)
    return " ".join(part for part in parts if part)
