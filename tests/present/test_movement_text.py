"""The line that warns of markers that move."""

from __future__ import annotations

from mocap_metrology.noise.motion.movement import Movement
from mocap_metrology.present.text.movement import movement_words
from mocap_metrology.present.text.numbers import mm

TAIL = ", which noise does not explain; the Allan variance assumes stationary markers"


def test_no_line_without_movement() -> None:
    assert movement_words({}, 100.0) == []


def test_one_marker_that_goes_on_and_one_that_jumped() -> None:
    assert movement_words({"B": ("y", Movement(9.98))}, 100.0) == [
        f"marker B seems to move: moves by 9.98 mm along y within 100 s{TAIL}"
    ]
    assert movement_words({"A": ("y", Movement(2.99, 2.9, 3.1, 30.24))}, 100.0) == [
        f"marker A seems to move: shifts by 2.99 mm along y at 30.2 s{TAIL}"
    ]


def test_all_markers_that_move_are_one_line() -> None:
    walking = {
        name: ("x", Movement(mm)) for name, mm in zip("ABC", (2360, 2380, 2340), strict=True)
    }
    assert movement_words(walking, 1.7) == [
        (f"marker A seems to move, and so do B and C: B moves by 2.38 m along x within 1.7 s{TAIL}")
    ]
    two = {name: walking[name] for name in "AB"}
    assert movement_words(two, 1.7)[0].startswith("marker A seems to move, and so does B: B ")
    many = {f"M{k}": ("x", Movement(3.0)) for k in range(9)}
    assert ", and so do 8 others: M0 moves by" in movement_words(many, 1.7)[0]


def test_lengths_of_sentences_have_no_power_of_ten() -> None:
    said = {
        2020.4: "2.02 m",
        928_000: "928 m",
        0.24589: "0.246 mm",
        0.0426: "42.6 µm",
        -0.503: "−0.503 mm",
    }
    assert {value: mm(value) for value in said} == said
