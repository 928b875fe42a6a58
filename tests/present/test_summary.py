"""The summary and the provenance: what they say of given verdicts, benchmarks and poses."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mocap_metrology.present.pages import provenance, summary
from mocap_metrology.present.pages.summary import spread


def recording(name: str, word: str, **more) -> dict:
    series = {
        "x1": {"sigma_frame_mm": 0.01, "frame_mm": 0.02, "shares": {"white": 0.9, "flicker": 0.1}},
        "z2": {"sigma_frame_mm": 0.03, "frame_mm": 0.05, "shares": {"white": 0.2, "flicker": 0.8}},
        "L": {"sigma_frame_mm": 9.0, "frame_mm": 9.0, "shares": {"white": 1.0}},
        "y1": {"sigma_frame_mm": None, "frame_mm": None, "shares": {}},
    }
    for one in series.values():
        one["means"] = [{"duration_s": 1.0, "uncertainty_mm": one["frame_mm"] and 0.004}]
    row = {"recording": name, "group": "g", "source": "twin", "word": word, "series": series}
    return row | {"reason": f"because of {name}"} | more


def pose(word: str, x: float, checks=()) -> dict:
    entry = {"translation_mm": [x, 0.0, 1.0], "rotation_deg": dict.fromkeys(ANGLES, 10.0)}
    return {
        "stations": {"master": {"id": 1}, "slave": {"id": 2}},
        "chosen": 0,
        "poses": [entry],
        "verdict": {"word": word, "reason": f"it is {word}"},
        "checks": [{"name": name, "ok": False} for name in checks],
    }


JUMPS = [{"words": "a <jump>", "severity": "warning"}] * 5
JUMPS += [{"words": "no gaps", "severity": "info"}]
ANGLES = ("alpha", "beta", "gamma")


def test_numbers_are_of_the_worst_coordinate_and_never_of_a_distance() -> None:
    cells = summary.recording_row(recording("a", "good"), lambda kind, name: "")
    assert cells[2:8] == ["0.0300", "0.0500", "0.00400", "–", "–", "flicker 80 %"]


def test_refusals_come_first_and_nothing_is_taken_for_markup() -> None:
    refused = [{"kind": "recording", "name": "r", "why": "no <marker>"}]
    rows = [recording("a", "good"), recording("b", "bad", sentences=JUMPS)]
    text = summary.page(summary.Found(rows, (), refused, {"g": {"short": ["Camera 6 is noisy."]}}))
    assert text.index("no &lt;marker&gt;") < text.index("2 recordings, all simulated (twins)")
    assert "1 good, 1 bad" in text
    assert text.index("</table>") < text.index("Camera 6 is noisy.")
    assert text.count("a &lt;jump&gt;") == summary.MOST
    assert "And 2 more" in text
    assert "no gaps" not in text


def test_why_names_all_that_lowers_the_word_in_few_words() -> None:
    reason = (
        "One frame of x2 is uncertain by 0.728 (0.680…0.779) mm about the mean of 10 min; the "
        "limit for usable is 0.25 mm."
    )
    drift = {"reason": "x1 drifts by 0.521 mm in 10 min; the limit for good is 0.35 mm."}
    event = {"words": "At 3 s it moved; so it did.", "severity": "warning"}
    row = recording("a", "bad", caps=[drift], sentences=[event]) | {"reason": reason}
    assert summary.why(row) == [
        "One frame of x2: 0.728 mm; the limit for usable is 0.25 mm.",
        drift["reason"],
        "At 3 s it moved.",
    ]


@pytest.mark.parametrize(
    ("group", "source", "said"),
    [
        ("skurowski2019", "twin", "a rise is one of the published table"),
        ("mine", "twin", "a rise is one of those numbers"),
        ("mine", "measured", "only a rise is evidence on a camera"),
    ],
)
def test_subsets_that_share_no_frames_say_so_once(group: str, source: str, said: str) -> None:
    rows = [recording(name, "good", group=group, source=source) for name in "ab"]
    told = {"short": ["T: raised.", "B: raised."], "apart": True}
    text = summary.page(summary.Found(rows, cameras={group: told}))
    assert text.count("do not share their frames") == text.count(said) == 1


def test_short_twins_are_called_a_quick_look_and_their_length_is_said() -> None:
    rows = [recording("a", "good", duration_s=600.0), recording("b", "bad", source="measured")]
    text = summary.page(summary.Found(rows))
    assert "A quick look: the simulated stand-ins (twins) are 10 min long" in text
    assert "2 recordings, 1 simulated (twins of 10 min), 1 measured: " in text
    whole = [recording("a", "good", duration_s=32400.0)]
    text = summary.page(summary.Found(whole))
    assert "quick look" not in text and "simulated (a twin of nine hours): 1 good" in text
    measured = [recording("a", "good", duration_s=600.0, source="measured")]
    assert "quick look" not in summary.page(summary.Found(measured))


def test_own_groups_come_before_the_papers_and_measured_before_twins() -> None:
    rows = [
        recording("T40-10", "good", group="skurowski2019"),
        recording("stand-in", "good", group="lab"),
        recording("noise-10", "good", group="lab", source="measured"),
        recording("noise-2", "bad", group="lab", source="measured"),
    ]
    papers = [summary.Paper("The paper", "p.html", "3 hold, 1 undecided")]
    text = summary.page(summary.Found(rows), papers=papers, tables=["t_10", "t_2"])
    order = ("noise-2<", "noise-10<", "stand-in<", "The paper", "T40-10<", "t_2.csv", "t_10.csv")
    places = [text.index(name) for name in order]
    assert places == sorted(places)
    assert "of its claims 3 hold, 1 undecided" in text


def test_only_calibrations_or_nothing_at_all() -> None:
    row = {"calibration": "c", "setup": "s", "group": "h", "source": "measured"}
    text = summary.page(summary.Found(calibrations=[row | {"pose": pose("good", 1.0)}]))
    assert "1 calibration, measured: 1 good." in text
    assert "it is good" in text
    assert "empty" in summary.page(summary.Found())


def test_many_calibrations_are_a_row_a_setup() -> None:
    rows = [
        {"calibration": f"c{k}", "setup": f"s{k % 2}", "group": "h", "source": "twin"}
        | {"pose": pose("usable" if k % 2 else "good", float(k), ["residual"] * (k % 2))}
        for k in range(22)
    ]
    table, _ = summary.calibrations(rows, lambda name: "")
    assert len(table.rows) == 2  # setups
    assert "11 good" in table.rows[0][2]
    assert "11 usable" in table.rows[1][2]
    assert table.rows[1][-1] == "residual (11)"


def test_spread_of_poses_against_scipy() -> None:
    """Poses scattered round a known one by known deviations."""
    rng = np.random.default_rng(5)
    centre = Rotation.from_euler("xyz", [5, -20, 60], degrees=True)
    turned = Rotation.from_rotvec(rng.normal(0, np.radians([0.1, 0.3, 0.2]), (4000, 3))) * centre
    moved = rng.normal([2000, -50, 3], [1.0, 2.0, 4.0], (4000, 3))
    pose, mm, deg = spread(np.hstack([moved, turned.as_euler("xyz", degrees=True)]))
    assert pose == pytest.approx([2000, -50, 3, 5, -20, 60], abs=0.3)
    assert mm == pytest.approx(4.0, rel=0.05)
    assert deg == pytest.approx(0.3, rel=0.05)


def test_two_poses_and_one() -> None:
    two = np.array([[0.0, 0, 0, 0, 0, 0], [1.0, 0, 0, 0, 0, 2]])
    pose, mm, deg = spread(two)
    assert pose == pytest.approx([0.5, 0, 0, 0, 0, 1])
    assert (mm, deg) == pytest.approx((math.sqrt(0.5), math.sqrt(2.0)))
    assert np.isnan(spread(two[:1])[1:]).all()


def test_run_times_of_benchmarks(tmp_path) -> None:
    head = "s\th:m:s\tmax_rss\tmax_vms\n"
    for name, line in {"a": "1.5\t0:00:01\t200\t1\n", "b": "2.25\t0:00:02\tNA\t1\n"}.items():
        (tmp_path / name).write_text(head + line)
    found = provenance.run_times({"noise": [tmp_path / "a", tmp_path / "b"], "empty": []})
    assert found == [
        {"rule": "noise", "jobs": 2, "total_s": 3.75, "longest_s": 2.25, "max_rss_mb": 200.0}
    ]


def test_a_marker_that_moves_is_told_once() -> None:
    warned = {
        "kind": "moves",
        "severity": "warning",
        "words": "Marker A seems to move: medians over 1 s span 3 mm.",
    }
    row = {"reason": "A moves: means over 1 s of x1 span 3 mm (limit 2 mm).", "sentences": [warned]}
    assert len(summary.why(row)) == 1
    assert len(summary.why(row | {"reason": "One frame is uncertain."})) == 2
