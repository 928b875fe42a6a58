"""Boards of photodiodes, and every file of one that is refused."""

from pathlib import Path

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.board import check_count, flat_board, read_board, read_normals

SQUARE = ["0,0,0", "0,0.1,0", "0,0.1,0.1", "0,0,0.1"]


def line(width: float) -> list[str]:
    """Diodes whose root sum of squares off their line is `width`."""
    return [f"0,{y},{z * width / 2}" for y, z in ((0, 1), (0.3, -1), (0.6, -1), (0.9, 1))]


def written(folder: Path, rows: list[str], header: str = "x_m,y_m,z_m") -> Path:
    path = folder / "board.csv"
    path.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8-sig")
    return path


def test_a_board_is_read_in_the_order_of_the_file(tmp_path: Path) -> None:
    """Blank lines, further columns, spaces and the byte order mark of a spreadsheet are no part."""
    rows = [row + ",note" for row in SQUARE]
    path = written(tmp_path, [*rows[:2], "", *rows[2:], ", ,,"], "x_m, y_m ,z_m,comment")
    assert read_board(path).tolist() == [[0, 0, 0], [0, 0.1, 0], [0, 0.1, 0.1], [0, 0, 0.1]]


@pytest.mark.parametrize(
    ("normal", "why"),
    [
        ("0,0,x", "line 5 is '.*,0,0,x'; expected numbers"),
        ("0,0,nan", "nx,ny,nz of diode 3 have the length nan; expected unit vectors"),
        ("0,1,1", "nx,ny,nz of diode 3 have the length 1.41421; expected unit vectors"),
    ],
)
def test_directions_of_diodes_are_unit_vectors(tmp_path: Path, normal: str, why: str) -> None:
    rows = [f"{row},0.6,0,0.8" for row in SQUARE[:3]]
    header = "x_m,y_m,z_m,nx,ny,nz"
    found = read_normals(written(tmp_path, [*rows, f"{SQUARE[3]},1.001,0,0"], header))
    np.testing.assert_allclose(found, [[0.6, 0, 0.8]] * 3 + [[1, 0, 0]])
    with pytest.raises(Refusal, match=f"^board.csv: {why}"):
        read_normals(written(tmp_path, [*rows, f"{SQUARE[3]},{normal}"], header))
    assert read_normals(written(tmp_path, SQUARE)) is None


@pytest.mark.parametrize(
    ("rows", "why"),
    [
        ([], "expected three finite numbers per diode"),
        ([*SQUARE, "0,nan,0"], "expected three finite numbers per diode"),
        ([*SQUARE, "0,x,0"], "line 6 is '0,x,0'; expected numbers, positions in metres"),
        (SQUARE[:3], "3 diodes; a calibration needs at least 4"),
        (["0,0,0", "0,2.0001,0", "0,1,1", "0,0,1"], "the diodes span 2.0001 m; expected metres"),
        ([*SQUARE, "0,0.1,0.000099"], "diodes 1 and 4 have the same position"),
        (line(0.99e-3), "all diodes are on one line; expected a surface"),
    ],
)
def test_what_is_no_board_is_refused(tmp_path: Path, rows: list[str], why: str) -> None:
    with pytest.raises(Refusal, match=f"^board.csv: {why}"):
        read_board(written(tmp_path, rows))


def test_a_board_has_the_diodes_that_the_recording_shows() -> None:
    board = flat_board(4, 2)
    check_count(board, 32, 7, "dump.bin")
    check_count(board, 8, 0, "dump.bin")
    for n_diodes, highest in ((32, 8), (7, 6), (7, 0)):
        with pytest.raises(Refusal, match=rf"diode {highest} of {n_diodes} .*has 8 diodes"):
            check_count(board, n_diodes, highest, "dump.bin")


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("0,0.1,0.2,0,0.3,0.4", "line 3 has 6 cells, expected 3"),  # two lines joined
        ("0,0.\u0661,0.2", "line . is .*; expected numbers"),  # float of Python takes it
        ("0,0_1,0.2", "line . is .*; expected numbers"),
        ("0,0," + "1" * 200_000, "cannot be read"),
        ('0,0.1,"0.2', "cannot be read"),
        ("0,0.1,0.2\v", "control character, '.x0b'"),
    ],
)
def test_damaged_lines(tmp_path: Path, line: str, message: str) -> None:
    rows = ["x_m,y_m,z_m", "0,0,0", line, "0,0.1,0", "0,0,0.1", "0,0.1,0.1", ""]
    (tmp_path / "board.csv").write_text("\n".join(rows))
    with pytest.raises(Refusal, match=message):
        read_board(tmp_path / "board.csv")
