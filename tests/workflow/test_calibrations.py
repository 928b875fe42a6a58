"""The sheet of calibrations: plain values of right rows, a line for each wrong cell."""

from pathlib import Path

import pytest
from mocap_workflow import rows, startup
from mocap_workflow.calibrations import CalibrationRow
from running import faults_of, write_sheet

from mocap_metrology.common.faults import Faults

CALIBRATION = {
    "calibration": "s1-1", "setup": "s1", "group": "g", "path": "dump.bin", "format": "gpio-dump",
    "board": "board.csv",
}  # fmt: skip


BAR = {"bar": "T20-T21", "length_mm": "267.86", "length_u_mm": "0.1", "board": "T20"}
BAR |= {"format": "libsurvive-rec"}
POSE = '{"quaternion_xyzw": [0, 0, 0, 1]}'
LENGTH = "diode 0 at 2.0 s - diode 0 at 7.0 s"


def load(folder: Path, **cells: str) -> CalibrationRow:
    path = write_sheet(folder, list(CalibrationRow.columns()), CALIBRATION | cells)
    return rows.load(CalibrationRow, path, ["T"])["s1-1"]


def faults(folder: Path, **cells: str) -> list[str]:
    return faults_of(load, folder, **cells)


def test_every_column_reaches_the_row(folder: Path) -> None:
    labels = {"reference_labels_master": ("M1", "M2"), "reference_labels_slave": ("S1", "S2")}
    labels["receiver_labels"] = ("R1", "R2")
    files = {
        **{"factory": "poses.json", "reference": "ref.c3d", "mount": "board.csv"},
        **{"check_against": "poses.json", "tracked_with": "poses.json"},
        **{"world_points": "board.csv", "board": "board.csv", "path": "dump.bin"},
        **{"receiver": "ref.c3d", "receiver_unit": "m"},
    }
    others = {"known_length": "stations 4.33 0.005", "sha256": "ab" * 32, "comment": "moved"}
    others |= {"reference_unit": "m", "bar": "board-deck", "bar_pose": POSE}
    lengths = {"length_mm": 500.0, "length_u_mm": 0.05}
    joined = {name: ";".join(value) for name, value in labels.items()}
    row = CALIBRATION | files | others | joined | {k: str(v) for k, v in lengths.items()}
    assert set(row) == set(CalibrationRow.columns())
    derived = {"twin": None, "source": "measured"}
    assert load(folder, **row).model_dump() == row | labels | lengths | derived


def test_groups_and_setups_that_differ_in_case_alone_are_refused(folder: Path) -> None:
    """Also between the sheets, as pages of groups are made of both."""
    rows_of = [("s1-1", "Hall", "s1"), ("s1-2", "hall", "S1"), ("s1-3", "Hall", "s1")]
    cells = [
        CALIBRATION | {"calibration": name, "group": group, "setup": setup}
        for name, group, setup in rows_of
    ]
    path = write_sheet(folder, list(CalibrationRow.columns()), *cells)
    calibrations = str(Path(path).rename(folder / "calibrations.tsv"))
    row = {"recording": "A", "path": "a.c3d", "markers": "M", "group": "HALL"}
    recordings = write_sheet(folder, list(row), row)
    lines = faults_of(startup.sheets, {"recordings": recordings, "calibrations": calibrations}, [])
    assert lines[1:3] == [
        'calibrations, calibration "s1-2", column group: "hall"; '
        'expected "HALL" as of recording "A", or another name',
        'calibrations, calibration "s1-2", column setup: "S1"; '
        'expected "s1" as of calibration "s1-1", or another name',
    ]
    assert len(lines) == 4  # group of s1-1 and s1-3


@pytest.mark.parametrize(
    ("cells", "expected"),
    [({"format": "csv"}, "expected one of gpio-dump, libsurvive-rec, crazyflie-uart"),
     ({"setup": ""}, "column setup: nothing; expected a name"),
     ({"board": ""}, "expected a CSV file x_m,y_m,z_m in diode order"),
     ({"board": "", "format": "libsurvive-rec"}, "the name of the tracked object"),
     ({"board": "no.csv"}, "expected a file (no.csv does not exist)"),
     ({"reference": "ref.c3d"}, "column reference_labels_slave: nothing; expected labels"),
     ({"tracked_with": "s1-1"}, 'column tracked_with: "s1-1"; expected another calibration'),
     ({"tracked_with": "s2"}, "expected a calibration of the sheet ("),
     ({"tracked_with": "no.json"}, "column tracked_with"),
     ({"known_length": "4.33"}, "expected `stations 4.330 0.005`"),
     ({"known_length": "points"}, "expected a length, as the row names no world_points"),
     (BAR | {"bar": "T20"}, 'column bar: "T20"; expected two objects joined by "-"'),
     (BAR | {"bar": "T20-s2:T21"}, "a calibration of the sheet ("),
     ({"receiver_labels": "A"}, 'column receiver_labels: "A"; expected nothing without a file'),
     ({"path": "simulate:T", "receiver": "ref.c3d"},
      'column receiver: "ref.c3d"; expected nothing for a simulated calibration'),
     (BAR | {"bar": ""}, 'column length_mm: "267.86"; expected nothing without a bar'),
     (BAR | {"length_mm": ""}, "expected nothing without a length in column length_mm"),
     (BAR | {"known_length": LENGTH + " 0.268 0.002"}, "another length than known_length"),
     (BAR | {"path": "simulate:T"}, 'column bar: "T20-T21"; expected nothing for a simulated'),
     ({"path": "simulate:T", "sha256": "0" * 64}, "nothing for a simulated calibration"),
     ({"reference_labels_master": "a"}, "expected nothing, as the reference is no C3D file"),
     ({"sha256": "1"}, "expected 64 hexadecimal digits or nothing"),
     ({"path": "simulate:U"}, "unknown; expected one of T")],
)  # fmt: skip
def test_a_wrong_calibration_is_named(folder: Path, cells: dict, expected: str) -> None:
    lines = faults(folder, **cells)
    assert any(expected in line for line in lines), lines


def test_tracked_with_a_file_or_another_row(folder: Path) -> None:
    row = load(folder, tracked_with="poses.json")
    assert (row.tracked_with_file, row.tracked_with_row) == ("poses.json", None)
    names = ("s1-1", "s2", "s3")
    others = dict(zip(names, ("s2", "s3", ""), strict=True))
    cells = [CALIBRATION | {"calibration": n, "tracked_with": others[n]} for n in names]
    path = write_sheet(folder, list(CalibrationRow.columns()), *cells)
    found = rows.load(CalibrationRow, path, [])
    assert (found["s2"].tracked_with_file, found["s2"].tracked_with_row) == (None, "s3")
    assert faults_of(startup.sheets, {"recordings": None, "calibrations": path}, []) == [
        'calibrations, calibration "s1-1", column tracked_with: "s2"; expected a calibration whose'
        " own tracked_with is empty"
    ]


def test_a_rotation_that_is_none_is_refused_before_anything_runs(folder: Path) -> None:
    with pytest.raises(Faults, match=r'column bar_pose: "\{\}"; expected JSON such as'):
        load(folder, **BAR, bar_pose="{}")


def test_a_bar_ends_in_the_recording_or_in_another_row_of_the_setup(folder: Path) -> None:
    row = load(folder, **BAR, bar_pose=POSE)
    assert (row.bar, row.bar_row, row.length_mm, row.length_u_mm) == ("T20-T21", None, 267.86, 0.1)
    cells = [
        CALIBRATION | BAR | {"bar": "LHR-A1-s-2:T21", "board": "LHR-A1"},
        CALIBRATION | BAR | {"calibration": "s-2", "setup": "s2", "board": "T21"},
    ]
    path = write_sheet(folder, list(CalibrationRow.columns()), *cells)
    assert rows.load(CalibrationRow, path, [])["s1-1"].bar_row == "s-2"
    assert faults_of(startup.sheets, {"recordings": None, "calibrations": path}, []) == [
        'calibrations, calibration "s1-1", column bar: "LHR-A1-s-2:T21"; expected a calibration of'
        " setup s1"
    ]
