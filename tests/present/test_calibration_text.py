"""The verdict on a calibration in words: one sentence a case, and the reason made of them."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from said import numbers_in

from mocap_metrology.lighthouse.assess.comparison import Comparison
from mocap_metrology.lighthouse.assess.fit_checks import WORDS, Case, Check
from mocap_metrology.lighthouse.assess.pose_file import pose_json
from mocap_metrology.lighthouse.assess.summary import Summary
from mocap_metrology.lighthouse.assess.validation import Verdict
from mocap_metrology.lighthouse.records import Station
from mocap_metrology.present.text.calibration import (
    SENTENCES,
    comparison_words,
    pose_document,
    reason,
    sentence,
)

SAID = {  # numbers, and the cases whose sentences have these
    "":
        "RESIDUAL_UNKNOWN WEIGHT_UNKNOWN PRIORS PRIORS_UNKNOWN MISFIT_NONE MISFIT_UNKNOWN "
        "PATH_ERRORS_UNKNOWN HALVES_UNKNOWN MIRRORED_UNKNOWN MOVED STILL COMMON_UNNEEDED "
        "BOARD_POSES_NONE PATH_UNNEEDED PATH_NONE UNCERTAINTY_NONE UNCERTAINTY_UNKNOWN "
        "DURATION_UNKNOWN FACTORY FACTORY_FILE FACTORY_DOUBTED FACTORY_UNSEEN FACTORY_EXCHANGED "
        "ESTIMATED ROTOR_CLEAR ROTOR_UNASKED GRAVITY_UNKNOWN REFERENCE_NONE",
    "12": "MISFIT MISFIT_OPEN",
    "42 %, 2": "SCALE_OPEN",
    "42 %, +0.90 %, +2.1": "LENGTH",
    "2.1": "PRIORS_LEFT",
    "2.1°": "GRAVITY GRAVITY_OFF",
    "42 %": "SCALE WEIGHT WEIGHT_LOST MIRRORED MIRRORED_FLAT MIRRORED_BOTH",
    "2.1 m": "PATH PATH_SHORT",
    "2.149": "COMMON COMMON_FEW",
    "2 µrad": "PATH_ERRORS BOARD_POSES BOARD_POSES_HIGH",
    "2.15 m": "DISTANCE",
    "2.15 s": "DURATION",
    "2.1°, 4°": "GRAVITY_OFF_IDEAL",
    "2 µrad, 12": "RESIDUAL_HIGH",
    "2 µrad, 75": "BEYOND_PATH",
    "2.15 s, 8 s": "DURATION_UNUSUAL DURATION_SHORT",
    "4 mm, 0.05°": "HALVES RECORDINGS OBJECTS",
    "2, 20, 1, 6°": "IDEAL",
    "2.15 m, 20 m": "TOO_DISTANT",
    "2.1 mm, 0.05°": "UNCERTAINTY ROTOR_OPEN",
    "2.1 mm, 0.05°, 0.7 %": "UNCERTAINTY_ALL",
    "2 µrad, 75, 20": "RESIDUAL",
    "2.15 mm, 0.05°": "STAGES STAGES_LOOSE STAGES_UNKNOWN OPTICS OPTICS_FAR REFERENCE",
    "4 mm, 0.05°, 12": "HALVES_APART HALVES_MISFIT HALVES_OPEN RECORDINGS_APART",
    "4 mm, 0.05°, 2.1": "OBJECTS_APART",
    "2.1 mm, 0.05°, 42 %, 0.7 %": "UNCERTAINTY_SCALE",
}  # fmt: skip
NUMBERS = {"noise": 75.0, "times": 12.0, "mm": 4.0, "deg": 0.05, "percent": 42.0, "larger": 0.9}
NUMBERS |= {"size": 0.7}
WHY = {"master": "", "slave": "checksum wrong"}


def check(case: Case, level: str = "good", ok: bool | None = True, name: str = "") -> Check:
    return Check(name, case, 2.149, "", 20.0, ok, level, NUMBERS, ("a", "b", "c"), WHY)


def test_one_of_many_stations_is_named() -> None:
    """Nothing says "both" or "the slave" where there is neither, nor a noise that V1 has."""
    said = [sentence(replace(check(case), why={}), "3") for case in Case]
    assert not any(word in line for line in said for word in ("oth stations", "slave"))


def test_numbers_of_every_case() -> None:
    expected = {Case[name]: numbers for numbers, names in SAID.items() for name in names.split()}
    assert {case: numbers_in(sentence(check(case))) for case in Case} == expected


ROUNDING = {"mm": 8.4e-12, "deg": 1.2e-13, "times": 0.1, "percent": 42.0, "size": 0.7}
COMPARED = [case for case, text in SENTENCES.items() if re.search("{(apart|about)}", text)]


@pytest.mark.parametrize("case", COMPARED)
def test_rounding_errors_are_no_difference(case: Case) -> None:
    """Poses of a perfect twin differ in their last bits."""
    names = ("a", "b", "c")
    said = sentence(Check("", case, 1.79e-7, "mm", 20.0, True, "good", ROUNDING, names))
    assert "0.001 mm and 0.00001°" in said
    assert not re.search(r"\de-\d|×10", said)


def test_a_good_reason_counts_what_passed() -> None:
    checks = (
        check(Case.RESIDUAL, name="residual"),
        check(Case.DISTANCE, name="distance"),
        check(Case.ROTOR_OPEN, ok=False, name="rotor model"),
        check(Case.REFERENCE_NONE, ok=None, name="reference"),
        check(Case.UNCERTAINTY, name="uncertainty"),
    )
    told = (Case.RESIDUAL, Case.UNCERTAINTY, Case.ROTOR_OPEN)
    expected = " ".join(["All 3 checks passed.", *(sentence(check(case)) for case in told)])
    assert reason(Verdict("good", checks)) == expected


def test_reasons_are_what_made_the_word_and_the_rest_in_short() -> None:
    assert WORDS.index("usable") < WORDS.index("doubtful")
    checks = (
        check(Case.RESIDUAL_HIGH, "doubtful", False),
        check(Case.DISTANCE),
        check(Case.IDEAL, "doubtful", False),
        check(Case.BEYOND_PATH, "usable", False),
        check(Case.HALVES_APART, "doubtful", False),
    )
    assert reason(Verdict("doubtful", checks)) == " ".join([
        sentence(check(Case.RESIDUAL_HIGH)),
        sentence(check(Case.IDEAL)),
        sentence(check(Case.HALVES_APART)),
        "Errors of the board's path leave 2 µrad of the residual unexplained (noise of an angle: "
        "75).",
    ])  # fmt: skip


def test_without_a_pose() -> None:
    assert reason(Verdict("failed")) == "No pose of the slave was found."
    assert reason(Verdict("failed", why_none="The slave is not seen.")) == "The slave is not seen."


def test_the_document_has_the_sentences_at_its_places() -> None:
    verdict = Verdict("failed", (check(Case.TOO_DISTANT, "failed", False, "distance"),))
    bare = pose_json([], [Station("master"), Station("slave")], {}, verdict)
    told = pose_document(Summary(bare | {"check_against": {"moved": None, "valid": None}}, verdict))
    assert list(told) == [*bare, "check_against"]
    assert told["verdict"] == {"word": "failed", "reason": sentence(check(Case.TOO_DISTANT))}
    assert list(told["checks"][0]) == [
        *("name", "value", "unit", "limit", "ok", "level", "sentence")
    ]
    assert told["checks"][0]["sentence"] == sentence(check(Case.TOO_DISTANT))
    assert told["check_against"] == {
        "moved": None,
        "valid": None,
        "sentence": "No pose to compare with the earlier one.",
    }


def test_a_comparison_with_an_earlier_pose() -> None:
    mm, deg = np.array([20.0, 0, 0]), np.array([0, 0.02, 0])
    moved = comparison_words(Comparison(mm, deg, 50.0, 0.0004, True))
    assert numbers_in(moved) == "20 mm, 0.02°, 0.0004" and "no longer valid" in moved
    tiny = Comparison(1e-13 * mm, 1e-13 * deg, 0.0, 1.0, False)
    assert ": less than 0.001 mm and 0.00001° from the earlier pose" in comparison_words(tiny)
    other = ("paper-lm", "kabsch", "ideal")
    ends = (0.0, 0.01), (3.25, 0.041)
    held = Comparison(mm / 10, deg, 3.0, 0.8, False, "difference", *ends)
    said = comparison_words(held)
    assert numbers_in(said) == "2 mm, 0.02°, 0.8, 95 %, 0, 3.2 mm, 0.01, 0.041°"
    assert "still valid" in said
    note = "Station ids not compared."
    found = Comparison(mm, deg, math.nan, math.nan, False, other=other, note=note)
    said = comparison_words(found)
    assert numbers_in(said) == "20 mm, 0.02°, 20 mm, 0.5°, 5 mm, 0.2°"
    assert "not confirmed" in said and note in said and "(paper-lm, kabsch, ideal)" in said
