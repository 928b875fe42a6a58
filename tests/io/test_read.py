"""How the format of a file is told, and how one is added; which point a label means."""

from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.c3d.write import write_c3d
from mocap_metrology.io.labels import find_points, suggestion
from mocap_metrology.io.read import FORMATS, bodies_of, labels_of, read_recording, text_format
from mocap_metrology.io.text.layout import Layout, check_text, lines, rate, triples
from mocap_metrology.io.units import MILLIMETRE

POSITIONS = np.round(np.random.default_rng(1).normal(100, 1, (50, 2, 3)), 3)


def layout(path: Path) -> Layout:
    """Line 1: rate in Hz and labels; then a frame number and x y z of each label, in mm."""
    check_text(path, "a recording of this test")
    first, second = islice(lines(path), 2)
    told, *labels = first.cells(" ")
    return Layout(
        path=path,
        encoding="text of this test",
        labels=tuple(labels),
        columns=triples(range(1, 1 + 3 * len(labels), 3)),
        frame_rate_hz=rate(told),
        unit=MILLIMETRE,
        delimiter=" ",
        first=second,
        n_columns=1 + 3 * len(labels),
        frame_column=0,
    )


def write(path: Path, first: int, stop: int) -> Path:
    rows = [f"{i} " + " ".join(map(str, POSITIONS[i].ravel())) for i in range(first, stop)]
    path.write_text("\n".join(["100 A B", *rows, ""]))
    return path


def test_a_format_is_added_by_the_reader_of_its_header(tmp_path, monkeypatch):
    """Segments, gaps, units and resolution are then those of every format."""
    monkeypatch.setitem(FORMATS, ".xyz", text_format(layout))
    later, sooner = write(tmp_path / "2.XYZ", 30, 50), write(tmp_path / "1.xyz", 0, 20)
    assert labels_of(later) == ("A", "B") and bodies_of(later) == ()
    recording = read_recording([later, sooner], ["B"])
    expected = POSITIONS[:, 1].T.copy()
    expected[:, 20:30] = np.nan
    assert np.array_equal(recording.position_mm[0], expected, equal_nan=True)
    assert recording.n_gap_frames == 10 and recording.segments[1].gap_before == 10
    assert (recording.resolution_mm, recording.resolution_kind) == (1e-3, "text")
    assert recording.encoding == "text of this test"


def test_what_has_no_other_suffix_is_read_as_c3d(tmp_path):
    path = tmp_path / "take.xyz"
    write_c3d(path, ["A", "B"], 100, [POSITIONS], 50)
    assert labels_of(path) == ("A", "B") and bodies_of(path) == ()
    assert read_recording([path], ["A"]).encoding == "Intel float"
    with pytest.raises(
        Refusal,
        match=r"^take\.xyz: is not a C3D file: it looks like text; what is read: C3D, TRC, ",
    ):
        labels_of(write(path, 0, 50))


@pytest.mark.parametrize("suffix", ["c3d", "xyz"])
def test_of_all_markers_those_that_are_never_seen_are_left_out(suffix, tmp_path, monkeypatch):
    """A marker that is named must be seen."""
    path, never = tmp_path / f"take.{suffix}", np.full((50, 1, 3), np.nan)
    labels = ["A", "B", "C"]
    if suffix == "c3d":
        write_c3d(path, labels, 100, [np.hstack([POSITIONS, never])], 50)
    else:
        monkeypatch.setitem(FORMATS, ".xyz", text_format(layout))
        text = write(path, 0, 50).read_text().replace("100 A B", "100 A B C")
        path.write_text(text.replace("\n", " nan nan nan\n").replace("C nan nan nan", "C"))
    recording = read_recording([path], [])
    assert recording.labels == tuple(labels[:2])
    assert recording.position_mm == pytest.approx(POSITIONS.transpose(1, 2, 0), abs=1e-4)
    note = f"take.{suffix}: seen in no frame, and left out: {labels[2]}"
    assert note in recording.notes
    with pytest.raises(Refusal, match="is valid in no frame of 50"):
        read_recording([path], labels)
    assert note in read_recording([path], labels, only_seen=True).notes
    with pytest.raises(Refusal, match="is valid in no frame of 50"):
        read_recording([path], labels[2:], only_seen=True)


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
