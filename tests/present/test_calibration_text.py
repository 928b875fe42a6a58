"""The verdict on a calibration in words: one sentence a case, and the reason made of them."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

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

SAID = {
    Case.DISTANCE: "The stations are 2.15 m apart.",
    Case.TOO_DISTANT: (
        "The stations are 2.15 m apart, too far apart for a board to be in view of both (at most "
        "20 m)."
    ),
    Case.RESIDUAL: "Angles are 2 µrad rms from the fit; the noise of an angle is 75, good is below "
    "20.",
    Case.RESIDUAL_HIGH: (
        "Angles are 2 µrad rms from the fit, 12 times the noise of an angle. Possible causes: "
        "wrong optics (factory values, lasers off the housing's origin), a wrong board file, "
        "reflections or board poses in the wrong minimum."
    ),
    Case.RESIDUAL_UNKNOWN: "The residual of the fit is unknown.",
    Case.WEIGHT: "42 % of the hits' weight is lost.",
    Case.WEIGHT_LOST: (
        "42 % of the hits' weight is lost, as these hits fit no path of the board. Possible "
        "causes: reflections, stray light, a board beyond the view of a station."
    ),
    Case.WEIGHT_UNKNOWN: "Hits of this estimate are not weighed.",
    Case.PRIORS: "Board and optics as estimated agree with what is known of them.",
    Case.PRIORS_LEFT: (
        "Board and optics as estimated deviate from what is known of them (probability by chance: "
        "2.1). Possible causes: a board file that does not fit the board (stretched, or wrong "
        "diodes), wrong factory values, lasers far from their places."
    ),
    Case.PRIORS_UNKNOWN: "Board and optics are not estimated.",
    Case.MISFIT_NONE: "Pieces of the recording agree within noise.",
    Case.MISFIT: (
        "Pieces of the recording deviate from each other 12 times as much as noise explains, "
        "which the uncertainty includes. Possible causes: wrong optics or board file, reflections."
    ),
    Case.MISFIT_UNKNOWN: "Pieces of the recording were not compared.",
    Case.PATH_ERRORS: "Errors of the board's path leave 2 µrad of the residual unexplained.",
    Case.BEYOND_PATH: (
        "Errors of the board's path leave 2 µrad of the residual unexplained (noise of an angle: "
        "75). Possible causes: a station that was touched, a wrong board file or wrong optics."
    ),
    Case.PATH_ERRORS_UNKNOWN: "Errors of the board's path could not be separated.",
    Case.HALVES: "Parts of the recording differ by 4 mm and 0.05°, which is within chance.",
    Case.HALVES_APART: (
        "Parts of the recording differ by 4 mm and 0.05°, 12 times as much as noise explains: was "
        "a station touched during the recording?"
    ),
    Case.HALVES_MISFIT: (
        "Parts of the recording differ by 4 mm and 0.05°, 12 times as much as noise explains, and "
        "no step at one moment explains it. Possible causes: wrong optics or board file, "
        "reflections."
    ),
    Case.RECORDINGS: (
        "The recording that agrees least with the others differs from them by 4 mm and 0.05°, "
        "which is within chance."
    ),
    Case.RECORDINGS_APART: (
        "One recording differs from the others by 4 mm and 0.05°, 12 times as much as noise "
        "explains: was a station touched between the recordings?"
    ),
    Case.OBJECTS: (
        "The pose from a, another object of the same recording, differs by 4 mm and 0.05°, which "
        "is within chance."
    ),
    Case.OBJECTS_APART: (
        "The pose from a, another object of the same recording, differs by 4 mm and 0.05° "
        "(probability by chance: 2.1): one of both is farther off than stated. Possible causes: a "
        "board file that does not fit its object, reflections."
    ),
    Case.HALVES_UNKNOWN: "Parts of the recording were not compared.",
    Case.MIRRORED: "42 % of the board poses are mirrored.",
    Case.MIRRORED_FLAT: (
        "42 % of the board poses are mirrored, which is possible with a flat board: use "
        "`paper-lm`, which decides by both stations."
    ),
    Case.MIRRORED_BOTH: (
        "42 % of the board poses are mirrored or wrong in another way, although both stations "
        "were used to decide: is the board file right (and no mirror image)? Use a larger board, "
        "or one with depth."
    ),
    Case.MIRRORED_UNKNOWN: "The share of mirrored board poses was not determined.",
    Case.MOVED: "The board moved.",
    Case.STILL: (
        "The board did not move: the pose is based on one position of the board, and the size of "
        "the board limits its accuracy. Record again with the board moved through the room."
    ),
    Case.COMMON: "Both stations saw the board at 2.149 moments.",
    Case.COMMON_FEW: "Both stations saw the board at 2.149 moments, few for a pose: keep the board "
    "in the view of both.",
    Case.COMMON_UNNEEDED: "A board at rest needs no common measurements.",
    Case.BOARD_POSES: "Angles of single board poses are 2 µrad rms from their fit.",
    Case.BOARD_POSES_HIGH: "Angles of single board poses are 2 µrad rms from their fit: is the "
    "board file right, are there reflections?",
    Case.BOARD_POSES_NONE: "There are no board poses.",
    Case.PATH: "The path of the board is 2.1 m long.",
    Case.PATH_SHORT: (
        "The path of the board is only 2.1 m long: a short path leaves the slave's rotation "
        "uncertain."
    ),
    Case.PATH_UNNEEDED: "The last stage does not depend on the length of the path.",
    Case.PATH_NONE: "A board at rest has no path.",
    Case.UNCERTAINTY: (
        "One standard deviation is 2.1 mm and 0.05° in the worst axes. They do not include an "
        "error of scale in the board file, which scales the distance."
    ),
    Case.UNCERTAINTY_ALL: (
        "One standard deviation is 2.1 mm and 0.05° in the worst axes, errors of board and optics "
        "included."
    ),
    Case.UNCERTAINTY_SCALE: (
        "One standard deviation is 2.1 mm and 0.05° in the worst axes, errors of board and optics "
        "included; 42 % of the variance of the position is the scale of the board, which a known "
        "length reduces (column known_length)."
    ),
    Case.UNCERTAINTY_NONE: "This estimate has no covariance.",
    Case.UNCERTAINTY_UNKNOWN: "The covariance of this estimate contains values that are not finite "
    "numbers: its uncertainty is unknown.",
    Case.DURATION: "The recording lasts 2.15 s.",
    Case.DURATION_UNUSUAL: "The recording lasts 2.15 s, not the usual 8 s.",
    Case.DURATION_SHORT: "The recording lasts 2.15 s, not the usual 8 s: few measurements.",
    Case.DURATION_UNKNOWN: "The duration is unknown.",
    Case.FACTORY: "Factory values from the recording.",
    Case.FACTORY_FILE: (
        "Factory values of the a and b and c come from a calibration file, not from the "
        "recording: they are correct only if the file belongs to this station."
    ),
    Case.IDEAL: (
        "Ideal optics, without the stations' factory values (master: none found; slave: checksum "
        "wrong): for real stations the pose is wrong by 2 to 20 cm and 1 to 6°, and no residual "
        "shows this."
    ),
    Case.ESTIMATED: (
        "The stations' factory values are not known (master: none found; slave: checksum wrong) "
        "and were estimated with the pose, which the uncertainty includes: several recordings at "
        "different places make it smaller."
    ),
    Case.ROTOR_CLEAR: (
        "The rotor model of a fits the recording significantly better than the others."
    ),
    Case.ROTOR_OPEN: (
        "The recording cannot distinguish the rotor models of a and b or c; their poses differ "
        "by up to 2.1 mm and 0.05°, which the uncertainty includes."
    ),
    Case.ROTOR_UNASKED: "Models of the rotors were not compared.",
    Case.STAGES: "Kabsch and final stage are 2.15 mm and 0.05° apart.",
    Case.STAGES_LOOSE: (
        "Kabsch and final stage are 2.15 mm and 0.05° apart. The Kabsch stage is no more accurate "
        "than that on such a path."
    ),
    Case.STAGES_UNKNOWN: "Kabsch and final stage are 2.15 mm and 0.05° apart. Whether noise "
    "explains that is unknown: a covariance contains values that are not finite numbers.",
    Case.OPTICS: "Factory values change the pose by 2.15 mm and 0.05°.",
    Case.OPTICS_FAR: (
        "Factory values change the pose by 2.15 mm and 0.05°, more than is possible for a "
        "first-generation station."
    ),
    Case.GRAVITY: "The vertical directions measured by both stations agree within 2.1°.",
    Case.GRAVITY_OFF: (
        "The vertical directions measured by both stations differ by 2.1° in this pose."
    ),
    Case.GRAVITY_OFF_IDEAL: (
        "The vertical directions measured by both stations differ by 2.1° in this pose. "
        "Neglected factory values alone can make 4°."
    ),
    Case.GRAVITY_UNKNOWN: "No gravity from both stations to compare with.",
    Case.REFERENCE: "The pose is 2.15 mm and 0.05° from the reference.",
    Case.REFERENCE_NONE: "There is no reference.",
}
NUMBERS = {"noise": 75.0, "times": 12.0, "mm": 4.0, "deg": 0.05, "percent": 42.0}
WHY = {"master": "", "slave": "checksum wrong"}


def check(case: Case, level: str = "good", ok: bool | None = True, name: str = "") -> Check:
    return Check(name, case, 2.149, "", 20.0, ok, level, NUMBERS, ("a", "b", "c"), WHY)


def test_one_of_many_stations_is_named() -> None:
    """Nothing says "both" or "the slave" where there is neither, nor a noise that V1 has."""
    said = [sentence(replace(check(case), why={}), "3") for case in Case]
    assert not any(word in line for line in said for word in ("oth stations", "slave"))
    assert said[list(Case).index(Case.COMMON)].startswith(
        "Station 3 and the reference saw the board"
    )
    assert "noise and places of the diodes make 75" in said[list(Case).index(Case.RESIDUAL)]


@pytest.mark.parametrize("case", Case)
def test_a_case_in_words(case: Case) -> None:
    assert sentence(check(case)) == SAID[case]


ROUNDING = {"mm": 8.4e-12, "deg": 1.2e-13, "times": 0.1, "percent": 42.0}
COMPARED = [case for case, text in SENTENCES.items() if re.search("{(apart|about)}", text)]


@pytest.mark.parametrize("case", COMPARED)
def test_rounding_errors_are_no_difference(case: Case) -> None:
    """Poses of a perfect twin differ in their last bits."""
    names = ("a", "b", "c")
    said = sentence(Check("", case, 1.79e-7, "mm", 20.0, True, "good", ROUNDING, names))
    assert "0.001 mm and 0.00001°" in said
    assert not re.search(r"\de-\d|×10", said)


def test_models_with_the_same_pose_are_not_in_the_reason() -> None:
    same = Check("", Case.ROTOR_OPEN, 8.4e-12, "mm", None, False, "good", ROUNDING, ("a", "b"))
    assert reason(Verdict("good", (same,))) == "All 0 checks passed."
    assert sentence(same).endswith("do not differ (less than 0.001 mm and 0.00001°).")


def test_a_good_reason_counts_what_passed() -> None:
    checks = (
        check(Case.RESIDUAL, name="residual"),
        check(Case.DISTANCE, name="distance"),
        check(Case.ROTOR_OPEN, ok=False, name="rotor model"),
        check(Case.REFERENCE_NONE, ok=None, name="reference"),
        check(Case.UNCERTAINTY, name="uncertainty"),
    )
    told = (Case.RESIDUAL, Case.UNCERTAINTY, Case.ROTOR_OPEN)
    expected = " ".join(["All 3 checks passed.", *(SAID[case] for case in told)])
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
        SAID[Case.RESIDUAL_HIGH],
        SAID[Case.IDEAL],
        SAID[Case.HALVES_APART] + ".",
        "Errors of the board's path leave 2 µrad of the residual unexplained (noise of an angle: "
        "75).",
    ])  # fmt: skip


def test_without_a_pose() -> None:
    assert reason(Verdict("failed")) == "No pose of the slave was found."
    assert reason(Verdict("failed", why_none="The slave is not seen.")) == "The slave is not seen."


def test_the_document_has_the_sentences_at_its_places() -> None:
    verdict = Verdict("failed", (check(Case.TOO_DISTANT, "failed", False, "distance"),))
    bare = pose_json([], [Station("master"), Station("slave")], None, verdict)
    told = pose_document(Summary(bare | {"check_against": {"moved": None, "valid": None}}, verdict))
    assert list(told) == [*bare, "check_against"]
    assert told["verdict"] == {"word": "failed", "reason": SAID[Case.TOO_DISTANT]}
    assert list(told["checks"][0]) == [
        *("name", "value", "unit", "limit", "ok", "level", "sentence")
    ]
    assert told["checks"][0]["sentence"] == SAID[Case.TOO_DISTANT]
    assert told["check_against"] == {
        "moved": None,
        "valid": None,
        "sentence": "No pose to compare with the earlier one.",
    }


def test_a_comparison_with_an_earlier_pose() -> None:
    mm, deg = np.array([20.0, 0, 0]), np.array([0, 0.02, 0])
    assert comparison_words(Comparison(mm, deg, 50.0, 0.0004, True)) == (
        "A station has moved: 20 mm and 0.02° from the earlier pose (probability by chance: "
        "0.0004). The earlier calibration is no longer valid."
    )
    tiny = Comparison(1e-13 * mm, 1e-13 * deg, 0.0, 1.0, False)
    assert ": less than 0.001 mm and 0.00001° from the earlier pose" in comparison_words(tiny)
    other = ("paper-lm", "kabsch", "ideal")
    ends = (0.0, 0.01), (3.25, 0.041)
    held = Comparison(mm / 10, deg, 3.0, 0.8, False, "difference", *ends)
    assert comparison_words(held) == (
        "No sign that a station moved: 2 mm and 0.02° from the earlier pose (probability by chance:"
        " 0.8). 95 % intervals: 0 to 3.2 mm, 0.01 to 0.041°. The earlier calibration is still "
        "valid."
    )
    note = "Station ids not compared."
    found = Comparison(mm, deg, math.nan, math.nan, False, other=other, note=note)
    assert comparison_words(found) == (
        "No sign that a station moved: 20 mm and 0.02° from the earlier pose (no covariance; a "
        "station counts as moved beyond 20 mm or 0.5°). The difference exceeds 5 mm or 0.2°, so "
        "the earlier calibration is not confirmed. Station ids not compared. Compared with another "
        "estimate (paper-lm, kabsch, ideal)."
    )
