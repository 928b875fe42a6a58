"""Sheets as files: what editors do to them, and what is no sheet."""

import csv
import io
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


@pytest.mark.parametrize(
    "content",
    [
        SHEET.encode("utf-8-sig"),
        SHEET.replace("\n", "\r\n").encode(),
        SHEET.replace("\n", "\r").encode(),
        SHEET.replace("\n", "\t\t \n").encode(),
        SHEET.replace("A\t", " A \t").encode(),
        f"# a word first\n\n{SHEET}\t\t\t\n  # and last".encode(),
        SHEET.replace("a.c3d", '"a.c3d"').encode(),
    ],
    ids=["BOM", "CRLF", "CR", "trailing tabs", "blanks", "comments", "quotes"],
)
def test_what_editors_do_to_a_sheet_is_tolerated(folder: Path, content: bytes) -> None:
    found = written(folder, content)
    assert isinstance(found, dict), found
    assert found["A"].paths == ("a.c3d",)


def of_a_spreadsheet(delimiter: str) -> str:
    """As csv writes a table: cells that hold the delimiter in quotes, all rows of one width."""
    rows = [
        ["# a title, of ours; with all", "", "", "", ""],
        ["recording", "path", "markers", "group", "comment"],
        ["", "", "", "", ""],
        ["A", "a.c3d;b.c3d", "M1; M2", "g", 'warm, then "cold"'],
        ["B", "a.c3d", "M1", "g", ""],
    ]
    stream = io.StringIO()
    csv.writer(stream, delimiter=delimiter).writerows(rows)
    return stream.getvalue()


@pytest.mark.parametrize("bom", ["", "\ufeff"])
@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_what_a_spreadsheet_saves_is_read(folder: Path, delimiter: str, bom: str) -> None:
    content = bom + of_a_spreadsheet(delimiter)
    found = written(folder, content.encode())
    assert isinstance(found, dict), found
    assert found["A"].paths == ("a.c3d", "b.c3d") and found["A"].markers == ("M1", "M2")
    assert found["A"].comment == 'warm, then "cold"' and found["B"].markers == ("M1",)
    faults = written(folder, content.replace("M1; M2", "").encode())
    assert isinstance(faults, list)
    assert faults[0].startswith('sheet.tsv, row 4 (recording "A"), column markers: nothing;')


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (SHEET.encode("utf-16"), "sheet.tsv: UTF-16; expected UTF-8 text"),
        (SHEET.encode("utf-16-le"), "sheet.tsv: not a text file"),
        (b"PK\x03\x04 a spreadsheet", "sheet.tsv: not a text file"),
        (SHEET.replace("M1", "M\xe4").encode("latin-1"), "sheet.tsv, row 2: not UTF-8"),
        (b"", "sheet.tsv: no header; expected columns recording, path, markers"),
        (SHEET.replace("\t", "|").encode(), "sheet.tsv: cells are separated by bars"),
        (SHEET.replace("\t", "  ").encode(), "sheet.tsv: cells are separated by blanks"),
        (SHEET.replace("markers", "marker").encode(), '"marker": unknown; did you mean markers?'),
        (SHEET.replace("markers", "x_note").encode(), '"x_note": unknown; expected one of'),
        (SHEET.replace("markers", "group").encode(), "column group: repeated; expected once"),
        (SHEET.replace("markers", "").encode(), "sheet.tsv: column 3 has no name"),
        (SHEET.replace("\tgroup", "").encode(), "sheet.tsv: no column group; expected"),
        (SHEET.replace("\tg\n", "\tg\tmore\n").encode(), "sheet.tsv, row 2: 5 cells; expected 4"),
        (
            SHEET.replace("a.c3d", '"a.c3d').encode(),
            "sheet.tsv, row 2: a quote without its closing quote",
        ),
    ],
)
def test_a_sheet_that_is_none_is_refused_in_one_line(
    folder: Path, content: bytes, expected: str
) -> None:
    lines = written(folder, content)
    assert isinstance(lines, list), lines
    assert expected in lines[0]
    assert len(lines) == 1


def test_rows_are_counted_as_an_editor_does(folder: Path) -> None:
    lines = written(folder, b"# one\n\n" + SHEET.replace("M1", "").encode())
    assert lines[0].startswith('sheet.tsv, row 4 (recording "A"), column markers')


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
