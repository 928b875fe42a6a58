"""What the summary begins with: counts, the worst, changes, and a picture of all recordings."""

from __future__ import annotations

import base64

import numpy as np

from mocap_metrology.present.pages import front, summary
from mocap_metrology.present.verdict.overview import overview_figure

LIMITS = {"good": 0.1, "usable": 0.25}


def recording(name: str, word: str, frame_mm: float | None, group: str = "hall") -> dict:
    frames_mm = {"x1": frame_mm, "y1": frame_mm and 0.001, "L": 9.0}
    series = {name: {"frame_mm": value} for name, value in frames_mm.items()}
    return {
        "recording": name,
        "group": group,
        "word": word,
        "reason": f"One frame of x1 is uncertain by {frame_mm} mm (0.1…0.2) about the mean.",
        "series": series,
        "source": "measured",
        "limits_mm": LIMITS,
        "caps": [],
        "sentences": [],
    }


ROWS = [
    recording("a", "good", 0.02),
    recording("b", "bad", 0.4),
    recording("c", "bad", 0.9),
    recording("d", "usable", None),
    recording("T40-10", "bad", 5.0, group="skurowski2019"),
]


def test_the_answer_counts_ones_own_and_names_the_worst() -> None:
    own = front.own({"recording": ROWS, "calibration": []})
    assert [row["recording"] for row in own["recording"]] == ["c", "b", "d", "a"]
    answer = front.answer("recording", own["recording"])
    assert answer.startswith("1 of 4 recordings are good, 1 usable, 2 bad. The worst is c (bad): ")
    assert "0.9 mm" in answer and "…" not in answer
    assert front.title(own["recording"]) == "Verdict on hall"
    assert front.answer("recording", own["recording"][:1]).startswith("c is bad: ")


def test_those_of_a_paper_are_shown_where_there_are_no_others() -> None:
    own = front.own({"recording": ROWS[-1:], "calibration": []})
    assert [row["recording"] for row in own["recording"]] == ["T40-10"]


def test_changes_are_those_of_the_groups_that_are_shown() -> None:
    words = {
        "hall": ["a compared with b: worse in x1.", "c compared with b: better in x1."],
        "room": ["d compared with e: no significant change beyond the margin."],
        "skurowski2019": ["of the paper"],
    }
    assert front.changes(words, ["room"]) == words["room"]
    (line,) = front.changes(words, ["hall", "room"])
    assert "3 recordings" in line and "1 worse, 1 better, 1 without" in line
    assert front.changes(words, ["attic"]) == []


def test_what_was_refused_and_what_is_good_alone_is_counted() -> None:
    assert front.answer("recording", ROWS[:1], refused=2).startswith(
        "1 of 3 recordings are good, 2 refused. The least precise is a: "
    )


def test_the_picture_has_a_row_a_recording_at_its_worst_coordinate() -> None:
    """The distance L is no coordinate; a recording without an uncertainty has no row."""
    figure = overview_figure(ROWS[:4], "T", "Source: measured.").figure
    axes = next(panel for panel in figure.get_axes() if panel.lines)
    drawn = {float(line.get_xdata()[0]) for line in axes.lines if line.get_marker() == "o"}
    assert drawn == {0.02, 0.4, 0.9}
    assert [label.get_text() for label in axes.get_yticklabels()] == ["a", "b", "c"]
    bands = sorted(patch.get_x() for patch in axes.patches)
    assert np.allclose(bands[1:], [LIMITS["good"], LIMITS["usable"]])


def test_the_front_of_the_report_has_links_in_place_of_tables() -> None:
    found = summary.Found(ROWS, changes={"hall": ["c compared with b: worse."]}, picture=b"png")
    where = lambda kind, name: f"{kind}/{name}.html"  # noqa: E731
    page = summary.page(found, where)
    part = summary.page(found, where, part=True)
    for text in (page, part):
        assert "The worst is c (bad)" in text and "c compared with b: worse." in text
        assert base64.b64encode(b"png").decode() in text
        assert '<a href="recording/c.html">c</a>' in text
    assert page.count("<table") == 2 and "<table" not in part
