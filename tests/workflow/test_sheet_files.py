"""Sheets as files: rows, names and cells; `common/test_rows_of_sheets` has the rest."""

from pathlib import Path

import pytest
from mocap_workflow import rows
from mocap_workflow.recordings import RecordingRow

from mocap_metrology.common import sheets
from mocap_metrology.common.faults import Faults


def written(folder: Path, content: bytes) -> list[str] | dict[str, RecordingRow]:
    (folder / "sheet.tsv").write_bytes(content)
    try:
        return rows.load(RecordingRow, "sheet.tsv", [])
    except Faults as error:
        return error.lines


SHEET = "recording\tpath\tmarkers\tgroup\nA\ta.c3d\tM1\tg\n"


def test_no_sheet_an_empty_one_and_one_that_is_missing(folder: Path) -> None:
    assert rows.load(RecordingRow, None, []) == {}
    assert written(folder, SHEET.splitlines()[0].encode()) == {}
    with pytest.raises(Faults, match=r"^gone\.tsv: no such file; expected a sheet"):
        rows.load(RecordingRow, "gone.tsv", [])
    with pytest.raises(Faults, match=r"^\.: Is a directory; expected a sheet"):
        rows.load(RecordingRow, ".", [])


def test_a_cell_beyond_all_measure_is_refused_in_a_short_line(folder: Path) -> None:
    for cell in (
        "x" * 800_000,
        "1;" * 400_000,
        "-" * 100_000,
        "0" * 100_000 + "7",
        "a" * 300 + ".c3d",
    ):
        for column in (
            "recording",
            "path",
            "markers",
            "pairs",
            "camera_ids",
            "n_cameras",
            "frame_rate_hz",
        ):
            cells = {"recording": "A", "path": "a.c3d", "markers": "M1", "group": "g", column: cell}
            sheet = "\n".join("\t".join(line) for line in (cells.keys(), cells.values()))
            found = written(folder, sheet.encode())
            if isinstance(found, list):
                assert len(found) == 1 and len(found[0]) < 1000
                assert found[0].startswith("sheet.tsv, row 2")
            else:
                assert column in ("markers", "camera_ids") and len(cell) <= sheets.LONGEST


def test_control_characters_do_not_reach_the_terminal(folder: Path) -> None:
    row = "A\tno\x1b]0,title\x07.c3d\t\x1b[31mM1\tg \u202e"
    found = written(folder, SHEET.replace("A\ta.c3d\tM1\tg", row).encode())
    assert isinstance(found, list)
    assert all(line.isprintable() for line in found)
    assert r"no\x1b]0,title\x07.c3d" in found[1] and r"g \u202e" in found[0]
