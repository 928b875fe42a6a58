"""Every bad input in one line that says file, place, what was found and what was expected."""

import re

import pytest
from text_files import FIRST_ROW, MOTIVE, NEXUS, PLAIN, TRC, make, read, refusal, row, spoilt

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.header import READ
from mocap_metrology.io.read import WHAT, labels_of
from mocap_metrology.io.text.table import HOW

NO_RATE = "has no frame rate; give it in column frame_rate_hz"
NO_UNIT = ", expected one of mm, cm, m, um, in, ft, or their names"
BY_TIME = ", by its time column 100 Hz; they may differ by 0.1 %"
NO_LENGTH = (
    "line 1 has no Length Units, without which m and mm cannot be distinguished: export again "
    "with the header, or add Length Units,Meters (or what Units was set to)"
)
SHIFTED = ", expected labels over X: a label with a comma must be in quotes"
NEITHER = f" lines before its numbers, which are not understood; {READ}"
HEADERS = [
    ("a.trc", "PathFileType\t4\t(X/Y/Z)\ttake.trc", "FileType",
     "is not a TRC file: line 1 is 'FileType', not PathFileType ..."),
    ("a.trc", "\t20\t2\tmm", "\t20\t3\tmm", "line 4 has 2 labels, NumMarkers states 3"),
    ("a.trc", "\t20\t2\tmm", "\t20\tmm",
     "line 3 does not match line 2: 7 values for 8 names, NumMarkers among them"),
    ("a.trc", "\t20\t2\tmm", "\t21\t2\tmm", "cut off: 20 of the 21 frames that NumFrames states"),
    ("a.trc", "\t20\t2\tmm", "\t19\t2\tmm", "has 20 frames, NumFrames states 19"),
    ("a.trc", "\t20\t2\tmm", "\tmany\t2\tmm", "NumFrames is 'many', expected a whole number"),
    ("a.trc", "\tmm\t", "\tmil\t", "Units is 'mil'" + NO_UNIT),
    ("a.trc", "100.00\t100.00\t20", "0\t100.00\t20", NO_RATE),
    ("a.trc", "100.00\t100.00\t20", "120\t100.00\t20", "its frame rate is 120 Hz" + BY_TIME),
    ("a.trc", "Frame#\tTime", "Nr\tTime",
     "line 4 is 'Nr\\tTime\\tA\\t\\t\\tB\\t\\t\\t', expected Frame#, Time and labels,"
     " separated by tabs"),
    ("m.csv", "Format Version", "Version", "6" + NEITHER),
    ("m.csv", "Frame,Time", "Bild,Zeit", "no row Frame, Time ... within 10 rows of its header"),
    ("m.csv", "Frames,20,Rotation", "Frames,30,Rotation",
     "cut off: 20 of the 30 frames that Total Exported Frames states"),
    ("m.csv", "Millimeters", "Parsecs", "Length Units is 'Parsecs'" + NO_UNIT),
    ("m.csv", "Length Units,Millimeters,", "", NO_LENGTH),
    ("m.csv", "Length Units,Millimeters,", "Length Units,,", NO_LENGTH),
    ("a.tsv", "NO_OF_FRAMES", "FRAMES",
     "is not a Qualisys export (TSV with its header): it has no line NO_OF_FRAMES"
     " before its numbers"),
    ("a.tsv", "\t3D", "\tVelocity", "DATA_INCLUDED is 'Velocity', expected 3D or 6D"),
    ("a.tsv", "NAMES\tA\tB", "NAMES\tA", "MARKER_NAMES are 1, NO_OF_MARKERS states 2"),
    ("a.tsv", "MARKER_NAMES", "MARKERNAMES",
     "MARKER_NAMES is missing or empty, so no marker has a label"),
    ("a.tsv", "FREQUENCY\t100", "FREQUENCY\tEXT", NO_RATE),
    ("a.tsv", "FRAMES\t20", "FRAMES\t25", "cut off: 20 of the 25 frames that NO_OF_FRAMES states"),
    ("n.csv", "Trajectories", "Devices",
     "is not a Vicon Nexus export (CSV) of markers: it has no section Trajectories"),
    ("n.csv", "\r\n100\r\n", "\r\n\r\n", NO_RATE),
    ("n.csv", ",,A,,,B", ",,A, left,,,B", "line 3: 'left' in cell 4 stands over Y" + SHIFTED),
    ("n.csv", ",,A,,,B", ",,A,,, left,,,B",
     "line 3: 'B' in cell 9 stands over no column" + SHIFTED),
    ("n.csv", ",,A,,,B", ',,"A,,, left,,,B',
     "line 3: 'B' in cell 9 stands over no column" + SHIFTED),
    ("n.csv", ",,mm,", ",,km,", "unit of Trajectories is 'km'" + NO_UNIT),
    ("n.csv", ",,mm,", ",,m,", "unit of Trajectories differ (m, mm), expected one unit"),
    ("n.csv", "Frame,Sub Frame", "Bild,Unterbild",
     "line 4 is 'Bild,Unterbild,X,Y,Z,X,Y,Z', expected Frame, Sub Frame, X, Y, Z ..."),
]  # fmt: skip


@pytest.mark.parametrize(("name", "old", "new", "why"), HEADERS)
def test_headers(tmp_path, name, old, new, why):
    assert refusal(spoilt(tmp_path, name, old, new)) == f"{name}: {why}"


@pytest.mark.parametrize("name", PLAIN)
class TestRows:
    def test_a_row(self, tmp_path, name):
        """No number; cells too many, or too few of a marker; line ends inside."""
        mark, line = "\t" if name[-3] == "t" else ",", FIRST_ROW[name] + 4
        cells = row(name, 5).rstrip(mark).split(mark)
        hint = "; are these decimal commas?" if mark == "," else ""
        half, ended = [[*cells[:3], text, *cells[4:]] for text in (f'"{cells[3]}', f"{cells[3]}\r")]
        for new, said in (
            ([*cells[:4], "n/a", *cells[5:]], f"line {line}, column 5: 'n/a' is not a number"),
            (half, f"line {line}, column 4: '{half[3]}' is not a number"),
            (ended, f"line {line} has a carriage return inside"),
            ([*cells, "7", "8"], f"line {line} has 10 cells, expected 8{hint}"),
            ([*cells, *["7"] * 100], f"line {line} has 108 cells, expected 8{hint}"),
            ([*cells, *["7"] * 101], f"line {line} has 109 cells, expected 8"),
            ([*cells[:6], "", *cells[7:]], f"line {line}: 'B' has 2 of 3 coordinates"),
            ([*cells[:3], "", "", *cells[5:]], f"line {line}: 'A' has 1 of 3 coordinates"),
        ):
            path = spoilt(tmp_path, name, row(name, 5), mark.join(new))
            assert refusal(path) == f"{name}: {said}"
        first = row(name, 1).rstrip(mark).split(mark)
        spoilt_row = mark.join([*first[:4], "n/a", *first[5:]])
        said = f"line {FIRST_ROW[name]}, column 5: 'n/a' is not a number"
        assert refusal(spoilt(tmp_path, name, row(name, 1), spoilt_row)) == f"{name}: {said}"

    def test_frame_numbers(self, tmp_path, name):
        start = re.match("[0-9]+", row(name, 5))[0]
        before, where = int(start) - 1, f"{name}: line {FIRST_ROW[name] + 4}"
        for new, said in (
            ("", "expected a whole frame number, there is none"),
            ("7.5", "expected a whole frame number, 7.5"),
            (f"{before}", f"frame {before} follows frame {before}, expected a larger number"),
        ):
            spoilt_row = new + row(name, 5).removeprefix(start)
            assert refusal(spoilt(tmp_path, name, row(name, 5), spoilt_row)) == f"{where}: {said}"

    def test_nothing_after_the_header(self, tmp_path, name):
        head = "".join(PLAIN[name].splitlines(keepends=True)[: FIRST_ROW[name] - 1])
        assert refusal(make(tmp_path, name, head)).startswith(f"{name}: has no frames: nothing")
        assert refusal(make(tmp_path, name, head[:40])).startswith(f"{name}: ")

    def test_markers(self, tmp_path, name):
        path = make(tmp_path, name, PLAIN[name])
        assert refusal(path, ["A", "C"]) == f"{name}: no marker 'C'; there are: A, B"
        said = refusal(path, frame_rate_hz=90)
        assert said.startswith(f"{name}: ") and "100 Hz" in said and "90 Hz" in said

    def test_other_files(self, tmp_path, name):
        what = "a TRC file" if name == "a.trc" else WHAT
        for content, why in (
            (b"", f"is empty, expected {what}"),
            (b"\r\n \r\n", f"contains only white space, expected {what}"),
            (b"abc\0def", f"is not {what}: it looks like a binary format; {READ}"),
            (PLAIN[name].encode("utf-16"), "is UTF-16 text, expected UTF-8: save it as UTF-8"),
            (PLAIN[name].encode("utf-32"), "is UTF-32 text, expected UTF-8: save it as UTF-8"),
            (
                PLAIN[name].replace("\r\n", "\n").replace("\n", "\r").encode(),
                "its lines end with CR alone, expected LF or CR LF",
            ),
        ):
            (tmp_path / name).write_bytes(content)
            assert refusal(tmp_path / name) == f"{name}: {why}"
        (tmp_path / name).unlink()
        assert refusal(tmp_path / name) == f"{name}: no such file: {tmp_path / name}"
        (tmp_path / name).mkdir()
        assert refusal(tmp_path / name) == f"{name}: is a folder, expected {what}"
        with pytest.raises(Refusal) as caught:
            labels_of(tmp_path / name)
        assert str(caught.value) == refusal(tmp_path / name)


def test_types_of_motive_below_the_other_rows_of_its_header(tmp_path):
    lines = PLAIN["m.csv"].split("\r\n")
    lines[2], lines[5] = lines[5], lines[2]
    said = refusal(make(tmp_path, "m.csv", "\r\n".join(lines)))
    assert said == "m.csv: no row of types (Marker, Rigid Body, ...) in the header"


def test_coordinates_of_two_markers_of_motive(tmp_path):
    lines = PLAIN["m.csv"].split("\r\n")
    at = next(k for k, line in enumerate(lines) if line.startswith(",Name"))
    names = lines[at].split(",")
    names[3] = "B2"
    lines[at] = ",".join(names)
    said = refusal(make(tmp_path, "m.csv", "\r\n".join(lines)))
    assert said.startswith("m.csv: X, Y, Z in columns 3 to 5 are of ")
    assert said.endswith(" and 'B2'; expected one")


def test_poses(tmp_path):
    rows = "1 0 0 1.5 0 1 0 2.5 0 0 1 3.5\n" * 5
    for text, why in (
        ("# Freq: 250\n", "has no frames: nothing follows the comment"),
        ("1 2 3\n", f"line 1 has numbers without names: {HOW}; {READ}"),
        (rows, "has no frame rate; give it in column frame_rate_hz"),
    ):  # fmt: skip
        assert refusal(make(tmp_path, "p.txt", text), ["tracker"]) == f"p.txt: {why}"


def test_a_rate_with_a_decimal_comma_is_not_cut(tmp_path):
    """In a file with commas between cells, where 119,88 Hz would be 119 Hz."""
    lines = NEXUS.splitlines()
    lines[1] = "119,88"
    path = make(tmp_path, "n.csv", "\n".join([*lines, ""]))
    assert "n.csv: line 2 is '119,88'; expected the frame rate in Hz alone" in refusal(path)


@pytest.mark.parametrize(
    ("name", "label", "line"),
    [("a.trc", "\tA\t", 4), ("m.csv", '"A"', 4), ("a.tsv", "\tA\t", 12), ("n.csv", ",A,", 3)],
)
def test_a_carriage_return_inside_the_header(tmp_path, name, label, line):
    """A spreadsheet would read two lines, and another program a blank."""
    path = spoilt(tmp_path, name, label, label.replace("A", "A\r"))
    assert refusal(path) == f"{name}: line {line} has a carriage return inside"


def test_an_unreadable_pose_is_no_gap(tmp_path):
    pose = "1 0 0 0.1 0 1 0 0.2 0 0 1 0.3"
    nan = " ".join(["nan"] * 12)
    good = make(tmp_path, "good.txt", "\n".join(["# Freq: 10", pose, nan, pose, ""]))
    assert read(good, ["tracker"]).n_invalid[0]["empty"] == 1
    for line, message in (
        ("lost", "line 3 has 1 cells, expected 12"),
        ("1 0 0", "line 3 has 3 cells, expected 12"),
        (pose.replace("1 0 0 0.1", "x 0 0 0.1"), "line 3, column 1: 'x' is not a number"),
        (f"{pose} 7", "line 3 has 13 cells, expected 12"),
    ):
        path = make(tmp_path, "a.txt", "\n".join(["# Freq: 10", pose, line, pose, ""]))
        assert message in refusal(path, ["tracker"])


@pytest.mark.parametrize("name", PLAIN)
def test_a_row_without_its_time_is_no_gap(tmp_path, name):
    if name == "n.csv":
        pytest.skip("Nexus writes no times")
    own, mark = row(name, 9), "," if name == "m.csv" else "\t"
    path = spoilt(tmp_path, name, f"{own.strip()}", own.split(mark)[0])
    assert "has no time, as other lines have" in refusal(path)


@pytest.mark.parametrize("between", ["\r\n", ",,,\r\n\r\n,,mm,mm,mm,mm,mm,mm\r\n"])
def test_numbers_below_an_empty_line_of_nexus_are_not_left_out(tmp_path, between):
    """An empty line ends a section, so that half of the frames would be lost without a word."""
    rows = NEXUS.splitlines(keepends=True)
    said = refusal(make(tmp_path, "n.csv", "".join([*rows[:15], between, *rows[15:]])))
    assert "line 16 is empty, and numbers go on in line" in said


def test_a_title_of_nexus_that_is_spoilt_leaves_no_marker_out(tmp_path):
    said = refusal(spoilt(tmp_path, "n.csv", "X,Y,Z,X,Y,Z", "X,Y,Z,X,[,Z"))
    assert said.startswith("n.csv: line 4: column 6 is X, not in a row of X, Y, Z; export again")


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [("a.tsv", "FREQUENCY\t100", "FREQUENCY\t1,000"), ("a.trc", "\n100.00\t", '\n"1,000"\t')],
)
def test_a_rate_with_a_separator_of_thousands_is_not_1_hz(tmp_path, name, old, new):
    said = refusal(spoilt(tmp_path, name, old, new))
    assert (
        said == f"{name}: its frame rate, 1,000, may be 1.000 or 1000 Hz; write it without a comma"
    )


def test_a_rate_of_nexus_has_no_comma_beside_points(tmp_path):
    assert "expected the frame rate in Hz alone" in refusal(
        spoilt(tmp_path, "n.csv", "\n100\r", '\n"1,5"\r')
    )


def test_a_label_of_thousands_of_letters_fits_into_its_message(tmp_path):
    said = refusal(make(tmp_path, "a.trc", TRC), ("A" * 3000,))
    assert len(said) < 300 and "AAA[...]" in said


def test_positions_of_a_type_that_motive_has_not_are_told(tmp_path):
    spoilt_type = MOTIVE.replace("Marker,Marker,Marker,Marker", "Marker,Marker,Marker,Trained", 1)
    notes = read(make(tmp_path, "m.csv", spoilt_type), ("A",)).notes
    assert any("not known are not read: B (trained), B (marker)" in note for note in notes)
