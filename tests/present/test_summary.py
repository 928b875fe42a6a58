"""The summary and the provenance: what they say of given verdicts, benchmarks and poses."""

import base64
import math
import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mocap_metrology.lighthouse.assess.rows import spread
from mocap_metrology.present.pages import details, summary
from mocap_metrology.present.plot.figure import Texts
from mocap_metrology.present.verdict.figure import overview_figure

LIMITS = {"good": 0.1, "usable": 0.25}
ANGLES = ("alpha", "beta", "gamma")
WARNINGS = [{"kind": "event", "words": "a <jump>; so it did.", "severity": "warning"}] * 5
WARNINGS += [{"kind": "gaps", "words": "no gaps", "severity": "info"}]


def recording(name: str, word: str, frame_mm: float | None = 0.05, **more) -> dict:
    """Noise of x1 less than that of z2; L is no coordinate; y1 has no number."""
    shares = {"white": 0.2, "flicker": 0.8}
    series = {
        "x1": {"sigma_frame_mm": 0.01, "frame_mm": frame_mm and 0.001, "shares": {"white": 0.9}},
        "z2": {"sigma_frame_mm": 0.03, "frame_mm": frame_mm, "shares": shares},
        "L": {"sigma_frame_mm": 9.0, "frame_mm": 9.0, "shares": {"white": 1.0}},
        "y1": {"sigma_frame_mm": None, "frame_mm": None, "shares": {}},
    }
    for one in series.values():
        one["means"] = [{"duration_s": 1.0, "uncertainty_mm": one["frame_mm"] and 0.004}]
    reason = f"One frame of z2 is uncertain by {frame_mm} mm (0.1…0.2) about the mean of 1 h; so."
    row = {"recording": name, "group": "hall", "source": "measured", "word": word}
    row |= {"series": series, "reason": reason, "limits_mm": LIMITS, "caps": [], "sentences": []}
    row["decided_by"] = {"code": "frame"}
    return row | more


ROWS = [recording("a", "good", 0.02), recording("b", "bad", 0.4), recording("c", "bad", 0.9)]
ROWS += [recording("d", "usable", None), recording("T40-10", "bad", 5.0, group="skurowski2019")]


def calibration(name: str, word: str, x: float = 1.0, wrong=(), setup: str = "s") -> dict:
    entry = {"translation_mm": [x, 0.0, 1.0], "rotation_deg": dict.fromkeys(ANGLES, 10.0)}
    pose = {
        "stations": {"master": {"id": 1}, "slave": {"id": 2}},
        "chosen": 0,
        "poses": [entry],
        "verdict": {"word": word, "reason": f"it is {word}"},
        "checks": [{"name": name, "ok": False} for name in wrong] + [{"name": "n", "ok": None}],
    }
    row = {"calibration": name, "setup": setup, "group": "hall", "source": "measured"}
    return row | {"pose": pose}


def rows(*recordings: dict) -> list[dict]:
    return summary.own_rows(summary.Verdicts(recordings).rows())


def test_changes_are_a_sentence_or_counts() -> None:
    """Each recording counts once, also one in which some series became worse and others better;
    those that changed are named, three of many."""
    words = [f"{name} compared with z: so." for name in "abcdefgh"]
    outcomes = {"a": "worse and better", "b": "the same data", "c": "limited by the resolution"}
    outcomes |= dict.fromkeys("defg", "worse") | {"h": "without a significant change"}
    of = {"words": words[:1], "outcomes": {"a": "worse"}}
    assert summary.changes([of]) == words[:1] and summary.changes([]) == []
    (line,) = summary.changes([{"words": words, "outcomes": outcomes}])
    counts = [int(n) for n in re.findall(r"(\d+) (?:worse|better|without|limited|the)", line)]
    assert sum(counts) == 8 and counts[0] == 4
    assert "(d, e, f, 1 more)" in line and "(a)" in line and "(b)" not in line


@pytest.mark.parametrize(
    ("sources", "lengths", "words"),
    [
        ("mm", (None, 5.0), "measured"),
        ("t", (600.0,), "simulated (a twin of 10 min)"),
        ("tt", (None, None), "all simulated (twins)"),
        ("tm", (600.0, 5.0), "1 simulated (twins of 10 min), 1 measured"),
        ("ttt", (32400.0, 20.0, 600.0), "all simulated (twins of 20 s to nine hours)"),
    ],
)
def test_origin_of_recordings(sources: str, lengths: tuple, words: str) -> None:
    kinds = {"m": "measured", "t": "twin"}
    of = [{"source": kinds[s], "duration_s": t} for s, t in zip(sources, lengths, strict=True)]
    assert summary.origin(of) == words
    known = [t for s, t in zip(sources, lengths, strict=True) if s == "t" and t]
    for group in ("hall", "skurowski2019"):  # of the paper's recordings alone the length matters
        twins = [recording("a", "good", group=group, **row) for row in of]
        text = summary.page(summary.Verdicts(twins))
        assert f"recording{'s' * (len(of) > 1)}, {words}: {len(of)} good." in text
        short = group == "skurowski2019" and known and max(known) < 32400
        assert ("A quick look" in text) == bool(short)


def test_the_picture_has_a_row_a_recording_at_its_worst_coordinate() -> None:
    """The distance L is no coordinate; a recording without an uncertainty has no row."""
    figure = overview_figure(ROWS[:4], Texts("T", "Source: measured.")).figure
    axes = next(panel for panel in figure.get_axes() if panel.lines)
    drawn = {float(line.get_xdata()[0]) for line in axes.lines if line.get_marker() == "o"}
    assert drawn == {0.02, 0.4, 0.9}
    assert [label.get_text() for label in axes.get_yticklabels()] == ["a", "b", "c"]
    bands = sorted(patch.get_x() for patch in axes.patches)
    assert np.allclose(bands[1:], [LIMITS["good"], LIMITS["usable"]])


def test_certified_bars_have_a_panel_of_their_own() -> None:
    """With the limits of a length; a bar without a certificate has no row."""
    limits = {"good": 0.5, "usable": 2.0}
    bars = [
        recording("z", "usable", None, bar={"size_mm": 1.88, "certificate": {"u_mm": 0.05}}),
        recording("p", "precise", None, bar={"size_mm": 1.2, "certificate": None}),
    ]
    rows = [*ROWS[:2], *(row | {"limits_mm": limits} for row in bars)]
    shown = overview_figure(rows, Texts("T", "Source: measured."))
    still, moved = (panel for panel in shown.figure.get_axes() if panel.lines)
    assert len(still.lines) == 2 and [float(one.get_xdata()[0]) for one in moved.lines] == [1.88]
    assert sorted(patch.get_x() for patch in moved.patches)[1:] == pytest.approx([0.5, 2.0])
    assert "as without that number: 1." in shown.caption


def test_the_page_and_the_front_in_order_and_nothing_is_taken_for_markup() -> None:
    """Refusals first, one's own groups, measured before twins, papers, theirs, all tables."""
    recordings = [*ROWS[2:], recording("twin-1", "good", source="twin", sentences=WARNINGS)]
    recordings += [recording(f"noise-{k}", "good") for k in (10, 2)]
    refused = [{"kind": "recording", "name": "r", "why": "no <marker>"}]
    verdicts = summary.Verdicts(
        recordings,
        [calibration("pair", "good")],
        refused,
        {
            "hall": {
                "short": ["V: camera 6 is noisy.", "W: even."],
                "noisy": [{"camera_type": "V"}],
            }
        },
        {
            "hall": {"words": ["c compared with b: worse."], "outcomes": {"c": "worse"}},
            "skurowski2019": {"words": ["T40-6 with T40-8."], "outcomes": {}},
        },
        b"png",
    )
    papers = [summary.Paper("The paper", "p.html", "3 hold, 1 undecided")]
    page, part = (
        summary.page(verdicts, lambda kind, name: f"{kind}/{name}", papers, ["t_10", "t_2"], part)
        for part in (False, True)
    )
    for text in (page, part):
        assert "<title>Verdict on hall</title>" in text or text is part
        assert "The worst is c (bad)" in text and "pair is good: it is good." in text
        assert text.index("V: camera 6 is noisy.") < text.index(">c<") and ("W:" in text) != (
            text is part
        )
        assert "c compared with b: worse." in text and base64.b64encode(b"png").decode() in text
        assert '<a href="recording/c">c</a>' in text
        assert "of its claims 3 hold, 1 undecided" in text
    assert page.count("<table") == 5 and part.count("<table") == 1  # the refused
    order = ["no &lt;marker&gt;", ">c<", ">d<", ">noise-2<", ">noise-10<", ">twin-1<"]
    order += ["W: even.", "hall: calibrations", "The paper", "skurowski2019: recordings"]
    order += ["T40-6 with T40-8.", ">T40-10<", ">t_2.csv<", ">t_10.csv<"]
    places = [page.index(words) for words in order]
    assert places == sorted(places)
    assert page.count("a &lt;jump&gt;") == 3 and "<jump>" not in page
    assert "are empty" in summary.page(summary.Verdicts()) and "are empty" not in page


def test_spread_of_poses_about_a_known_one() -> None:
    """Scattered by known deviations; two poses, and one, by hand."""
    rng = np.random.default_rng(5)
    centre = Rotation.from_euler("xyz", [5, -20, 60], degrees=True)
    turned = Rotation.from_rotvec(rng.normal(0, np.radians([0.1, 0.3, 0.2]), (4000, 3))) * centre
    moved = rng.normal([2000, -50, 3], [1.0, 2.0, 4.0], (4000, 3))
    poses = np.hstack([moved, turned.as_euler("xyz", degrees=True)])
    pose, mm, deg = spread(poses)
    assert pose == pytest.approx([2000, -50, 3, 5, -20, 60], abs=0.3)
    assert (mm, deg) == pytest.approx((4.0, 0.3), rel=0.05)
    two = np.array([[0.0, 0, 0, 0, 0, 0], [1.0, 0, 0, 0, 0, 2]])
    pose, mm, deg = spread(two)
    assert pose == pytest.approx([0.5, 0, 0, 0, 0, 1])
    assert (mm, deg) == pytest.approx((math.sqrt(0.5), math.sqrt(2.0)))
    assert np.isnan(spread(two[:1])[1:]).all() and np.isnan(spread(two[:0])[1])


def test_run_times_and_the_page_of_provenance(tmp_path) -> None:
    for name, line in {"a": "1.5\t0:00:01\t200\t1", "b": "2.25\t0:00:02\tNA\t1"}.items():
        (tmp_path / name).write_text(f"s\th:m:s\tmax_rss\tmax_vms\n{line}\n")
    times = details.run_times({"noise": [tmp_path / "a", tmp_path / "b"], "empty": []})
    assert times == [
        {"rule": "noise", "jobs": 2, "total_s": 3.75, "longest_s": 2.25, "max_rss_mb": 200.0}
    ]
    row = dict.fromkeys(details.INPUTS, "<i>") | {"seed": 110}
    code = {"version": "1.2", "commit": None, "python": "3.13"}
    document = {"code": code, "inputs": [row], "run_times": times, "tables": {"t.csv": "5eed"}}
    text = details.provenance_page(document | {"packages": {"numpy": "2"}})
    assert "mocap-metrology 1.2, commit not in a repository, Python 3.13." in text
    assert "<i>" not in text
    assert all(f">{cell}<" in text for cell in ("&lt;i&gt;", 110, "3.75", 2, "200", "5eed"))
