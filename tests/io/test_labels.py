"""Labels that are not there: what was probably meant."""

from __future__ import annotations

import re

import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.labels import find_points, suggestion

GAIT = ("LTOE", "RTOE", "LHEE", "RHEE", "Right hand")


@pytest.mark.parametrize(
    ("wrong", "labels", "said"),
    [
        ("RTEO", GAIT, "did you mean RTOE?"),
        ("rtoe", GAIT, "the letter case differs: did you mean RTOE?"),
        ("right hand", GAIT, "the letter case differs: did you mean Right hand?"),
        ("LTOE,RTOE", GAIT, 'separate the labels with ";": "LTOE;RTOE"'),
        ("LTOE RTOE", GAIT, 'separate the labels with ";": "LTOE;RTOE"'),
        ("ltoe", ("Matt:LTOE", "Matt:RHEE"), "the letter case differs: did you mean Matt:LTOE?"),
        ("Nose", GAIT, ""),
        ("LTOE, Right hand", GAIT, 'separate the labels with ";": "LTOE;Right hand"'),
        ("LTOE,Nose", GAIT, 'separate labels with ";"'),
    ],
)
def test_what_was_probably_meant(wrong: str, labels: tuple[str, ...], said: str) -> None:
    assert suggestion(wrong, labels) == said


def test_a_refusal_names_the_label_that_was_meant_or_else_all() -> None:
    with pytest.raises(Refusal, match=re.escape("a.c3d: no marker 'RTEO'; did you mean RTOE?")):
        find_points(GAIT, ["RTEO"], "a.c3d")
    with pytest.raises(Refusal, match="no marker 'Nose'; there are: LTOE, RTOE, LHEE, "):
        find_points(GAIT, ["Nose"], "a.c3d")
