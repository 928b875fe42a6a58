"""What headers and rows look like in the wild, each variant beside the plain one."""

import numpy as np
import pytest
from text_files import LABELS, make, motive, nexus, qualisys, read, refusal, still, table, trc

from mocap_metrology.io.read import labels_of, points_by_kind

TAKE = still()
EXPECTED = TAKE.transpose(1, 2, 0)


def same(recording, expected=EXPECTED, within=1e-9):
    assert np.allclose(recording.position_mm, expected, rtol=0, atol=within, equal_nan=True)
    return recording


@pytest.mark.parametrize("value", [0, -1, 9999])
@pytest.mark.parametrize("kind", [trc, nexus, table])
def test_one_number_far_from_a_marker_is_missing_and_near_it_is_measured(tmp_path, kind, value):
    """Of a marker at 100, 200, 300 mm, and of the same one near that number."""
    away, near = TAKE.copy(), TAKE - TAKE[0, 0] + value
    away[4, 0] = near[4, 0] = value
    away[7, 0] = -99999
    said = f"A: x = y = z = {value} or -99999 in 2 frames, taken as missing"
    assert said in str(read(make(tmp_path, "a.csv", kind(LABELS, 100, away))).notes)
    away[[4, 7], 0] = np.nan
    same(read(tmp_path / "a.csv"), away.transpose(1, 2, 0))
    same(read(make(tmp_path, "b.csv", kind(LABELS, 100, near))), near.transpose(1, 2, 0), 1e-6)


def test_cells_that_a_spreadsheet_has_put_in_quotes_or_apart(tmp_path):
    quoted = trc(LABELS, 100, TAKE).replace("100.00\t100.00", "100 Hz\t100 Hz")
    for text in (quoted, nexus(LABELS, 100, TAKE)):
        between = "\t" if text is quoted else ","
        rows = [between.join(f'"{c}"' for c in r.split(between)) for r in text.splitlines()]
        assert same(read(make(tmp_path, "a.csv", "\n".join(rows) + "\n"))).frame_rate_hz == 100
    same(read(make(tmp_path, "b.csv", qualisys(LABELS, 100, TAKE, digits=5).replace("\t", ";"))))


def test_a_rate_that_no_system_has_is_refused(tmp_path):
    said = refusal(make(tmp_path, "a.trc", trc(LABELS, 2e6, TAKE)))
    assert "its frame rate, by the file or its times, is 2e+06 Hz; expected at most 1e+06" in said


@pytest.mark.parametrize("suffix", ["csv", "tsv", "txt"])
def test_the_format_is_told_by_the_content(tmp_path, suffix):
    for text in (
        trc(LABELS, 100, TAKE),
        motive(LABELS, 100, TAKE),
        motive(LABELS, 100, TAKE).replace(",", ";").replace(".", ","),
        nexus(LABELS, 100, TAKE),
        "\n\n" + qualisys(LABELS, 100, TAKE, digits=5),
    ):
        assert same(read(make(tmp_path, f"a.{suffix}", text))).frame_rate_hz == 100


class TestTrc:
    def test_headers(self, tmp_path):
        plain = trc(LABELS, 100, TAKE)
        labels = "Frame#\tTime\tA\t\t\tB\t\t\t"
        for old, new in (
            (labels, "Frame\tTime\tA\tB"),  # side by side
            ("\t\tX1\tY1\tZ1\tX2\tY2\tZ2\t\n\n", "\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n"),
            ("\t\tX1\tY1\tZ1\tX2\tY2\tZ2\t\n\n", ""),
            ("100.00\t100.00\t40", "100.00\t100.00\t       40"),
            ("mm\t100.00\t1\t40", "mm   100.00  1 40"),
            ("100.00\t100.00\t40\t2\tmm", "  100.00\t\t  100.00\t\t    40\t\t  2\t\t mm"),
            ("PathFileType\t4\t", "PathFileType  4\t"),
        ):
            assert old in plain
            same(read(make(tmp_path, "a.trc", plain.replace(old, new))))
        unnamed = make(tmp_path, "b.trc", plain.replace(labels, "Frame#\tTime\t\t\t\tB\t\t\t"))
        assert labels_of(unnamed) == ("point_1", "B")


class TestMotive:
    HEAD = "Format Version,{},Take Name,t,Capture Frame Rate,50.000000{},Length Units,Meters\r\n"

    def test_all_kinds_of_columns(self, tmp_path):
        """Rigid body with quality, solved and measured markers, time code, parents (1.25)."""
        types = ["Rigid Body"] * 8 + ["Rigid Body Marker"] * 8 + ["Marker"] * 3
        names = ["RB"] * 8 + ["RB:1"] * 4 + ["RB:2"] * 4 + ["RB:1"] * 3
        held = ["Rotation"] * 4 + ["Position"] * 3 + ["Mean Marker Error"]
        held += (["Position"] * 3 + ["Marker Quality"]) * 2 + ["Position"] * 3
        axes = ["X", "Y", "Z", "W", "X", "Y", "Z", ""] + ["X", "Y", "Z", ""] * 2 + ["X", "Y", "Z"]
        text = self.HEAD.format("1.25", ",Export Frame Rate,25.000000") + "\r\n"
        for key, row in (("Type", types), ("Name", names), ("ID", names), ("Parent", types)):
            text += ",".join(["", key, "", *row]) + "\r\n"
        text += ",".join(["", "", "", *held]) + "\r\n"
        text += ",".join(["Frame", "Time (Seconds)", "TimeCode", *axes]) + "\r\n"
        for i in range(9):
            values = [f"{j + i / 1000:.6f}" for j in range(19)]
            text += ",".join([str(i), f"{i / 25:.6f}", f"15:26:46:{i:02d}.02", *values]) + "\r\n"
        path = make(tmp_path, "a.csv", text)
        assert labels_of(path) == ("RB:1", "RB:2")
        recording = read(path, ["RB:1", "RB:2"])
        assert recording.frame_rate_hz == 25
        assert np.allclose(
            recording.position_mm[:, :, 0], [[16000, 17000, 18000], [12000, 13000, 14000]]
        )
        assert [n for n in recording.notes if "RB" in n] == [
            (
                "a.csv: RB:2: is the position that the solved body predicts for the marker, not "
                "a measured one"
            )
        ]
        assert "Y points up" in recording.notes[0]

    def test_rows_without_names(self, tmp_path):
        """Version 1.2: the rows of the header do not say what they are."""
        text = self.HEAD.format("1.2", "") + "\r\n" + ",,Marker,Marker,Marker\r\n,,A,A,A\r\n"
        text += ",,1,1,1\r\n,,Position,Position,Position\r\nFrame,Time (Seconds),X,Y,Z\r\n"
        text += "".join(f"{i},{i / 50},{i}.5,2.25,3.125\r\n" for i in range(9))
        recording = read(make(tmp_path, "a.csv", text), ["A"])
        assert np.allclose(recording.position_mm[0, :, 1], [1500, 2250, 3125])
        assert recording.frame_rate_hz == 50

    def test_a_count_that_is_too_low(self, tmp_path):
        """Exports of a part of a take are known to state another number."""
        text = motive(LABELS, 100, TAKE).replace("Exported Frames,40", "Exported Frames,39")
        recording = same(read(make(tmp_path, "a.csv", text)), within=1e-6)
        assert recording.notes[1] == "a.csv: has 40 frames, Total Exported Frames states 39"

    @pytest.mark.parametrize(
        ("old", "new"),
        [
            ("Take Notes,", 'Take Notes,"calm, then\r\nCapture Frame Rate,7\r\n\r\nwind"'),
            ("Take Notes,", 'Take Notes,"said ""go"", twice"'),
            ("Take Notes,", "Take Notes,at last, with three, commas"),
            ("Take Notes,", "Take Notes,at last, with two"),
            ("Take 1", "Length Units"),
            ("Take 1", "Total Exported Frames"),
            ("Take 1", "Take Notes"),
            ("Take 1", 'the 5" rod'),
            ("Take 1", "Take, 1"),
            ("Rotation Type,Quaternion,", "Some Thing,New,Rotation Type,Quaternion,"),
        ],
    )
    def test_whatever_a_take_is_called_and_said_of_it(self, tmp_path, old, new):
        text = motive(LABELS, 100, TAKE)
        assert text.count(old) == 1
        recording = same(read(make(tmp_path, "a.csv", text.replace(old, new))), within=1e-6)
        assert (recording.frame_rate_hz, recording.units) == (100, "Millimeters")
        assert recording.segments[0].frame_count_source == "Total Exported Frames"

    def test_columns_of_two_types_are_no_marker(self, tmp_path):
        text = motive(LABELS, 100, TAKE).replace("Marker\r\n", "Maker\r\n", 1)
        assert labels_of(make(tmp_path, "a.csv", text)) == LABELS[:1]


class TestNexus:
    BEFORE = "Devices\r\n1000\r\n,,Force\r\nFrame,Sub Frame,Fx\r\n,,N\r\n" + "".join(
        f"{i // 10 + 1},{i % 10},{i}.25\r\n" for i in range(400)
    )

    def test_sections(self, tmp_path):
        after = "\r\nModel Outputs\r\n100\r\n,,J\r\nFrame,Sub Frame,X\r\n,,deg\r\n1,0,nonsense\r\n"
        for end in ("", after, ",,,,,,,\r\n" + after):
            text = nexus(("S:A", "S:B"), 100, TAKE, before=self.BEFORE + "\r\n", after=end)
            same(read(make(tmp_path, "a.csv", text)))
        twice = make(tmp_path, "b.csv", text + "\r\n" + nexus(LABELS, 100, TAKE + 1))
        assert "begins another section Trajectories" in refusal(twice, ("S:A",))

    @pytest.mark.parametrize("title", ["Objects", "Segments"])
    def test_bodies_where_there_are_no_markers(self, tmp_path, title):
        """As Tracker and Nexus write them; markers are read where a file has both."""
        head = [title, "100", ",,Global Angle S:A,,,,,,S:B,,,,,"]
        head += ["Frame,Sub Frame" + ",RX,RY,RZ,TX,TY,TZ" * 2, "," + ",rad,rad,rad,mm,mm,mm" * 2]
        numbers = [[f",1,2,3,{x},{y},{z}" for x, y, z in frame] for frame in TAKE.tolist()]
        rows = [f"{i},0{''.join(cells)}" for i, cells in enumerate(numbers, start=1)]
        text = "\r\n".join([*head, *rows, ""])
        recording = same(read(make(tmp_path, "a.csv", text)))
        assert "B: is a body: its position" in str(recording.notes)
        assert points_by_kind(tmp_path / "a.csv") == {"body": ("S:A", "S:B")}
        both = nexus(("S:A", "S:B"), 100, TAKE, before=text + "\r\n")
        assert "body" not in str(same(read(make(tmp_path, "b.csv", both))).notes)
