"""Sheets: every wrong cell is named, all of them at once, and nothing else is."""

from pathlib import Path

import pytest
from mocap_workflow import rows, startup
from mocap_workflow.recordings import RecordingRow
from pydantic import ValidationError
from running import faults_of, write_sheet

from mocap_metrology.common.entries import load_twins
from mocap_metrology.common.faults import Faults

HEADER = list(RecordingRow.columns())
OF_BAR = ("length_mm", "length_u_mm", "bar_pose")
GOOD = {"recording": "A", "path": "a.c3d", "markers": "M1;M2;M3", "group": "g"}


def load(folder: Path, *cells: dict[str, str]) -> dict[str, RecordingRow]:
    return rows.load(RecordingRow, write_sheet(folder, HEADER, *cells), ["T", "crump"])


def faults(folder: Path, *cells: dict[str, str]) -> list[str]:
    return faults_of(load, folder, *cells)


def test_the_order_of_rows_is_nothing(folder: Path) -> None:
    cells = [GOOD | {"recording": name} for name in ("T40-10", "b", "T40-2", "A")]
    assert list(load(folder, *cells)) == ["A", "b", "T40-2", "T40-10"]
    assert list(load(folder, *reversed(cells))) == ["A", "b", "T40-2", "T40-10"]


def test_a_right_row_becomes_values_of_their_types(folder: Path) -> None:
    row = GOOD | {
        "path": "a.c3d; b.c3d",
        "camera_type": "T40",
        "n_cameras": "2",
        "camera_ids": "3; 7",
        "pairs": "M1-M3;M2-M3",
        "frame_rate_hz": "119,88",
        "unit": "m",
        "column_names": "t x y z",
        "truncated": "accept",
        "sha256": "AB" * 32 + ";" + "0" * 64,
        "date": "2019-03-25 21:30",
        "compare_with": "B",
        "covariate": "b.c3d",
        "cluster": "M1;M2;M3",
        "place": "corner",
        "monitor": "hall",
        "baseline": "restart",
        "comment": "of the left wall",
    }
    assert set(HEADER) - set(row) == {"bar", *OF_BAR, "point", "reference"}
    found = load(folder, row, GOOD | {"recording": "B", "date": "2019-03-25"})
    plain = found["B"]
    assert (plain.date, plain.compare_with, plain.covariate) == ("2019-03-25", None, None)
    typed = {
        **dict.fromkeys(("twin", "bar", *OF_BAR, "point", "reference")),
        **{"source": "measured", "paths": ("a.c3d", "b.c3d"), "markers": ("M1", "M2", "M3")},
        **{"pairs": (("M1", "M3"), ("M2", "M3")), "cluster": ("M1", "M2", "M3")},
        **{"n_cameras": 2, "camera_ids": (3, 7), "frame_rate_hz": 119.88},
        **{"accept_truncated": True, "sha256": ("ab" * 32, "0" * 64)},
        "date": "2019-03-25T21:30:00",
    }
    told = found["A"].model_dump()
    assert told == {name: row.get(name) for name in told} | typed
    with pytest.raises(ValidationError, match="frozen"):
        found["A"].group = "h"


def test_a_bar_and_its_certificate(folder: Path) -> None:
    pose = '{"quaternion_xyzw": [0, 0, 0, 1]}'
    bar = dict(zip(("bar", *OF_BAR), ("M1-M2", "500,02", ".05", pose), strict=True))
    found = load(folder, GOOD | bar)["A"]
    assert (found.bar, found.length_mm, found.length_u_mm) == ("M1-M2", 500.02, 0.05)
    assert found.bar_pose is not None and found.about == "bar"
    assert load(folder, GOOD | bar | {"markers": "", "pairs": "", "cluster": ""})["A"].markers == ()
    for column, value in (("monitor", "hall"), ("point", "P1")):
        with pytest.raises(Faults, match=f"column {column}.*expected nothing in a row with a bar"):
            load(folder, GOOD | bar | {column: value})


def test_what_is_left_out_is_derived(folder: Path) -> None:
    found = load(
        folder,
        GOOD | {"camera_ids": "1;2;3"},
        GOOD | {"recording": "one", "markers": "M1"},
        GOOD | {"recording": "twin", "path": "simulate: crump", "markers": ""},
    )
    assert found["A"].n_cameras == 3
    assert found["A"].pairs == (("M1", "M2"),)
    assert found["one"].pairs == ()
    twin = found["twin"]
    assert (twin.twin, twin.paths, twin.source) == ("crump", (), "twin")


@pytest.mark.parametrize(
    ("column", "value", "expected"),
    [
        ("bar", "M1", '"M1"; expected two markers joined by "-", auto, or nothing'),
        ("bar_pose", "{}", '"{}"; expected nothing without a bar in column bar'),
        ("length_u_mm", "0.1", '"0.1"; expected nothing without a length in column length_mm'),
        ("length_mm", "50 cm", '"50 cm"; expected a number of mm or nothing'),
        ("recording", "", 'nothing; expected a name of letters, digits, "_", "." and "-"'),
        ("recording", "a/b", '"a/b"; expected a name'),
        ("group", "", "nothing; expected a name"),
        ("path", "", "nothing; expected a C3D file"),
        ("path", "no.c3d", '"no.c3d"; expected a file (no.c3d does not exist)'),
        ("path", "a.c3d,b.c3d", '(a.c3d,b.c3d does not exist; separate files with ";")'),
        ("path", r"C:\data\a 1.c3d", "does not exist; in WSL that is /mnt/c/data/a 1.c3d)"),
        ("path", r"sub\a.c3d", "does not exist; with slashes it is sub/a.c3d)"),
        ("covariate", r"C:\b.csv", "does not exist; in WSL that is /mnt/c/b.csv)"),
        ("unit", "cm", '"cm"; expected mm, m or nothing'),
        ("path", "a.c3d;;b.c3d", "none empty, none repeated"),
        ("path", "{x}.c3d", "expected a path without any of < > { }"),
        ("path", "a.c3d;simulate:T", "expected files, or simulate:<twin> by itself"),
        ("path", "simulate:crumb", "unknown; did you mean crump?"),
        ("markers", "", "nothing; expected the labels of one or more markers"),
        ("markers", "M1;M1", "none empty, none repeated"),
        ("n_cameras", "ten", '"ten"; expected a whole number from 1 to 9999, or nothing'),
        ("camera_ids", "1;1", "expected each camera once"),
        ("frame_rate_hz", "0", '"0"; expected a number of Hz > 0'),
        ("frame_rate_hz", "1e-9", '"1e-9"; expected a number of Hz > 0, from 0.001 to 1e+06, or'),
        ("frame_rate_hz", "1,000", '"1,000"; expected a number of Hz > 0 (1000, not 1,000)'),
        ("truncated", "yes", '"yes"; expected accept or nothing'),
        ("sha256", "abc", "expected 64 hexadecimal digits for each file"),
        ("sha256", "a" * 64 + ";" + "b" * 64, "expected one for each file of column path (1)"),
        ("date", "2019-02-29", "expected a day and time that exist (day is out of range"),
        ("date", "2019-03-25T21:30+01:00", "expected a date such as"),
        ("compare_with", "A", '"A"; expected another recording than this one'),
        ("compare_with", "B", '"B"; expected a recording of the sheet (unknown'),
        ("covariate", "no.csv", '"no.csv"; expected a file (no.csv does not exist)'),
        ("pairs", "M1", '"M1"; expected two of the chosen markers (M1, M2, M3) joined by "-"'),
        ("pairs", "M1-M1", "expected two different markers"),
        ("pairs", "M1-M2;M2-M1", '"M2-M1"; expected each pair once'),
    ],
)
def test_a_wrong_cell_is_named(folder: Path, column: str, value: str, expected: str) -> None:
    lines = faults(folder, GOOD | {column: value})
    assert len(lines) == 1, lines
    assert lines[0].startswith("sheet.tsv, row 2")
    assert f", column {column}: " in lines[0]
    assert expected in lines[0]


def test_all_wrong_cells_come_at_once_in_the_order_of_the_sheet(folder: Path) -> None:
    lines = faults(
        folder,
        GOOD | {"n_cameras": "x", "frame_rate_hz": "y", "path": "no.c3d"},
        GOOD | {"recording": "a", "markers": ""},
        GOOD | {"recording": "B", "n_cameras": "3", "camera_ids": "1;2"},
    )
    starts = [line.split(":")[0].rpartition("), ")[2] for line in lines]
    assert starts[:3] == ["column n_cameras", "column frame_rate_hz", "column path"]
    assert "expected a name of its own (row 2 has it)" in lines[3]
    assert "column markers" in lines[4]
    assert '"1;2"; expected as many as in column n_cameras (3)' in lines[5]
    assert len(lines) == 6


def test_labels_with_a_dash_split_where_both_sides_are_markers(folder: Path) -> None:
    row = GOOD | {"markers": "L-knee;R-knee", "pairs": "L-knee-R-knee"}
    assert load(folder, row)["A"].pairs == (("L-knee", "R-knee"),)
    row = GOOD | {"markers": "a;a-a;a-b;b", "pairs": "a-a-b"}
    assert (
        "expected a single interpretation, not several (a and a-b or a-a and b)"
        in faults(folder, row)[0]
    )


def test_a_twin_needs_no_labels_but_pairs_do(folder: Path) -> None:
    row = GOOD | {"path": "simulate:T", "markers": "", "pairs": "M1-M2"}
    assert "none: column markers is empty" in faults(folder, row)[0]
    row = GOOD | {"path": "simulate:T", "sha256": "0" * 64}
    assert "expected nothing for a simulated recording" in faults(folder, row)[0]


def test_files_are_relative_to_the_sheet(folder: Path) -> None:
    (folder / "deep").mkdir()
    write_sheet(folder / "deep", HEADER, GOOD | {"path": "../a.c3d"})
    assert rows.load(RecordingRow, "deep/sheet.tsv", [])["A"].paths == ("a.c3d",)
    absolute = folder / "deep/sheet.tsv"
    assert rows.load(RecordingRow, str(absolute), [])["A"].paths == (str(folder / "a.c3d"),)
    assert rows.beside("config/x.tsv", "/data/y.c3d") == "/data/y.c3d"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("twins: {}", None),
        ("other: {}", "no section twins"),
        ("- a", "no section twins"),
        ("twins: [a", "no readable YAML: "),
        ("twins:\n  T: {seed: 1}\n  T: {seed: 2}", "line 3: key T is repeated; expected once"),
        ("twins: {a/b: {}}", 'twins, "a/b": expected a name'),
        ("twins: {a: 1}", 'twins, "a": expected a name .* and a section of settings'),
        ("twins: {}\ndefault: {}", "section default: unknown; did you mean defaults?"),
        ("twins: {}\nsetups: {a: 1}", 'setups, "a": expected a name .* and a section of settings'),
        ("twins: {}\ndefaults: [a]", "section defaults: .* expected names with settings"),
    ],
)
def test_file_of_twins(folder: Path, text: str, expected: str | None) -> None:
    (folder / "twins.yaml").write_text(text)
    assert load_twins(None)["twins"] == {}
    if expected is None:
        assert set(load_twins("twins.yaml")) == {"twins", "defaults", "setups", "factories"}
    else:
        with pytest.raises(Faults, match=expected):
            load_twins("twins.yaml")
    with pytest.raises(Faults, match=r"^gone\.yaml: no such file"):
        load_twins("gone.yaml")


def test_a_path_of_the_configuration_is_sought_here_then_in_the_project(folder: Path) -> None:
    (folder / "project").mkdir()
    (folder / "project/only-there.tsv").touch()
    assert startup.located("a.c3d", folder / "project") == "a.c3d"
    assert startup.located("only-there.tsv", folder / "project") == str(
        folder / "project/only-there.tsv"
    )
    assert startup.located("nowhere.tsv", folder / "project") == "nowhere.tsv"
    assert startup.located(None, folder) is None
