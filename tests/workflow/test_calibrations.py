"""The sheet of calibrations: plain values of right rows, a line for each wrong cell."""

from __future__ import annotations

from pathlib import Path

import pytest
from mocap_workflow import calibrations
from mocap_workflow.configuration import load_schema
from mocap_workflow.faults import Faults
from running import write_sheet

SCHEMAS = Path(__file__).resolve().parents[2] / "workflow/schemas"
CALIBRATIONS = load_schema(SCHEMAS / "calibrations.schema.yaml")
CALIBRATION = {
    "calibration": "s1-1",
    "setup": "s1",
    "group": "g",
    "path": "dump.bin",
    "format": "gpio-dump",
    "board": "board.csv",
}


def calibration(folder: Path, **cells: str) -> list[str] | dict:
    header = list(CALIBRATIONS["columns"])
    try:
        path = write_sheet(folder, header, CALIBRATION | cells)
        return calibrations.load(path, CALIBRATIONS, ["T"])["s1-1"]
    except Faults as error:
        return error.lines


def test_a_right_calibration_becomes_plain_values(folder: Path) -> None:
    row = calibration(folder, reference="poses.json")
    assert (row["path"], row["board"], row["reference"]) == ("dump.bin", "board.csv", "poses.json")
    assert row["mount"] is None
    twin = calibration(folder, path="simulate:T", board="")
    assert (twin["path"], twin["twin"], twin["board"]) == (None, "T", None)
    assert row["factory"] is None
    assert calibration(folder, factory="poses.json")["factory"] == "poses.json"
    tracked = calibration(folder, format="libsurvive-rec", board="LHR-1234")
    assert tracked["board"] == "LHR-1234"
    labels = {"reference_labels_master": "a;b;c", "reference_labels_slave": "d;e"}
    row = calibration(folder, reference="ref.c3d", **labels)
    assert row["reference_labels_master"] == ["a", "b", "c"]


@pytest.mark.parametrize(
    ("cells", "expected"),
    [
        ({"format": "csv"}, "expected one of gpio-dump, libsurvive-rec, angles-csv"),
        ({"setup": ""}, "column setup: nothing; expected a name"),
        ({"board": ""}, "expected a CSV file x_m,y_m,z_m in diode order"),
        ({"board": "", "format": "libsurvive-rec"}, "the name of the tracked object"),
        ({"board": "no.csv"}, "expected a file (no.csv does not exist)"),
        ({"mount": "no.csv"}, "column mount"),
        ({"factory": "no.json"}, "column factory"),
        ({"check_against": "no.json"}, "column check_against"),
        ({"path": "simulate:T", "sha256": "0" * 64}, "nothing for a simulated calibration"),
        ({"reference_labels_master": "a"}, "expected nothing, as the reference is no C3D file"),
        ({"sha256": "1"}, "expected 64 hexadecimal digits or nothing"),
        ({"path": "simulate:U"}, "unknown; expected one of T"),
    ],
)
def test_a_wrong_calibration_is_named(folder: Path, cells: dict, expected: str) -> None:
    lines = calibration(folder, **cells)
    assert isinstance(lines, list), lines
    assert any(expected in line for line in lines), lines


def test_most_columns_may_be_missing(folder: Path) -> None:
    path = write_sheet(folder, list(CALIBRATION), CALIBRATION)
    row = calibrations.load(path, CALIBRATIONS, [])["s1-1"]
    assert {row[column] for column in ("factory", "reference", "mount", "sha256")} == {None}
    assert row["reference_labels_master"] == []


def test_a_reference_in_c3d_needs_labels(folder: Path) -> None:
    lines = calibration(folder, reference="ref.c3d")
    assert [line.split(", column ")[1].split(":")[0] for line in lines] == [
        "reference_labels_master",
        "reference_labels_slave",
    ]
