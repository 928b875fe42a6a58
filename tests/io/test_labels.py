"""Labels: which point is meant; of one that is not there, what was probably meant."""

import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.labels import find_points, suggestion

GAIT = ("LTOE", "RTOE", "LHEE", "RHEE", "Right hand")
TWO = ("Wand:A", "Wand:B", "Cal:B", "C D", "E", "E")


@pytest.mark.parametrize(
    ("markers", "places"),
    [
        (["A", " C D ", "Cal:B"], [0, 3, 2]),
        (["E#2", "E#1", "Wand:A"], [5, 4, 0]),
        (["B"], "marker 'B' occurs several times: choose from Wand:B, Cal:B"),
        (["A", "Wand:A"], "marker 'Wand:A' is chosen twice"),
        (["E"], "2 points are labelled 'E': choose one of them as E#1, E#2"),
        (["E#3"], "no 'E#3': points labelled 'E': 2"),
        (["E#0"], "no 'E#0': points labelled 'E': 2"),
        ([], "no marker is chosen; the file has: Wand:A, Wand:B, Cal:B, C D, E, E"),
        (["Nose"], "no marker 'Nose'; there are: Wand:A, Wand:B, Cal:B, C D, E, E"),
        (["wand:a"], "no marker 'wand:a'; the letter case differs: did you mean Wand:A?"),
    ],
)
def test_which_points_are_meant(markers: list[str], places: list[int] | str) -> None:
    if isinstance(places, list):
        assert find_points(TWO, markers, "a.c3d") == places
    else:
        with pytest.raises(Refusal) as refused:
            find_points(TWO, markers, "a.c3d")
        assert str(refused.value) == f"a.c3d: {places}"


@pytest.mark.parametrize(
    ("wrong", "labels", "said"),
    [
        ("RTEO", GAIT, "did you mean RTOE?"),
        ("LTOEE", ("LTOES", "LTOER"), "did you mean LTOES or LTOER?"),
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
