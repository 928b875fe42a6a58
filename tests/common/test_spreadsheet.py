"""Tables that a spreadsheet saves with semicolons or tabs and decimal commas are read alike."""

import csv
import io
from collections.abc import Callable
from operator import attrgetter
from pathlib import Path

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import write_csv
from mocap_metrology.common.spreadsheet import as_text
from mocap_metrology.io.text.covariate import read_covariate
from mocap_metrology.lighthouse.assess.reference import read_mount
from mocap_metrology.lighthouse.board import read_board
from mocap_metrology.lighthouse.decode.angles_csv import read_angles
from mocap_metrology.lighthouse.decode.crazyflie import read_log

PLACES = [[0.0, -0.05, 0.02], [0.0, 0.05, 0.02], [0.0, -0.05, -0.02], [0.0, 0.05, -0.02]]
LABELLED = [[name, *place] for name, place in zip("ABCD", PLACES, strict=True)]
HITS = [
    [station, axis, cycle, diode, cycle / 60 + axis / 120 + diode * 1e-5, 0.01 * diode]
    for cycle in range(20)
    for station in ("master", "slave")
    for axis in (0, 1)
    for diode in range(4)
]
TABLES: dict[str, tuple[str, list[list], Callable[[Path], object]]] = {
    "board": ("x_m,y_m,z_m", PLACES, read_board),
    "mount": ("label,x_m,y_m,z_m", LABELLED, lambda path: list(read_mount(path).values())),
    "covariate": ("time_s,room_C", [[k, 20 + 0.25 * k] for k in range(9)],
                  lambda path: np.stack(read_covariate(path)[1:])),
    "pulses of a deck": (
        "sensor,basestation,offset,timestamp2FPGA", [[0, 2, 0.0, 5e5], [1, 1, 161392.0, 5e5 + 9]],
        lambda path: attrgetter("hit_s", "begin_s")(read_log(path))[0],
    ),
    "angles": ("station,axis,cycle,diode,time_s,angle_rad", HITS,
               lambda path: attrgetter("time_s", "angle_rad")(read_angles(path)[0])),
}  # fmt: skip


def saved(header: str, table: list[list], between: str, mark: str) -> str:
    """As a spreadsheet saves it, with a BOM; `mark` is the decimal mark."""
    stream = io.StringIO("\ufeff", newline="")
    stream.seek(1)
    cells = [[str(cell).replace(".", mark) if isinstance(cell, float) else cell for cell in row]
             for row in table]  # fmt: skip
    csv.writer(stream, delimiter=between).writerows([header.split(","), *cells])
    return stream.getvalue()


@pytest.mark.parametrize("name", TABLES)
def test_semicolons_tabs_decimal_commas_blank_rows_and_the_mark_of_the_end(
    tmp_path: Path, name: str
) -> None:
    header, table, read = TABLES[name]
    found = []
    for between, mark in ((",", "."), (";", ","), (";", "."), ("\t", ","), ("\t", ".")):
        path = tmp_path / f"{name}{len(found)}.csv"
        rest = f"{between}{between}\r\n\r\n\x1a" if len(found) % 2 else ""
        path.write_bytes((saved(header, table, between, mark) + rest).encode())
        found.append(np.asarray(read(path), dtype=float))
    assert all(np.array_equal(found[0], one) for one in found[1:])


def test_a_log_that_is_cut_off_within_its_last_number_is_refused(tmp_path: Path) -> None:
    """Not one that only lacks the end of its last line, nor a board that a hand wrote."""
    rows = [f"{s},{a},{c},{d},{t:.5f},{r:.4f}" for s, a, c, d, t, r in HITS]
    text = "\n".join(["station,axis,cycle,diode,time_s,angle_rad", *rows])
    path = tmp_path / "a.csv"
    for cut in range(5):
        path.write_text(text[: len(text) - cut])
        if not cut:
            assert len(read_angles(path)[0]) == len(HITS)
            continue
        with pytest.raises(Refusal, match="every earlier number has more digits"):
            read_angles(path)
    path.write_text("x_m,y_m,z_m\n0.125,0.25,0.125\n0.125,0.5,0.375\n0.25,0.25,0.125\n0.5,0.5,0.5")
    assert len(read_board(path)) == 4


@pytest.mark.parametrize("cell", ["=cmd|' /C calc'!A0", "@SUM(1)", "+1+1", "-2+3+cmd"])
def test_no_text_of_a_result_is_a_formula(tmp_path: Path, cell: str) -> None:
    write_csv(tmp_path / "a.csv", [{"camera_type": cell, "value": -1.5, "text": "-1.5e-3"}])
    with (tmp_path / "a.csv").open(newline="") as stream:
        (row,) = csv.DictReader(stream)
    assert row == {"camera_type": f"'{cell}", "value": "-1.5", "text": "-1.5e-3"}
    assert as_text("x;=1+cmd|A0") == "x;'=1+cmd|A0"  # where semicolons separate cells
    assert as_text("a\t=1") == "a\\t'=1" and as_text("1;-2.5;+3e4") == "1;-2.5;+3e4"
    assert as_text("\x1b[2J\u202e") == r"\x1b[2J\u202e"
    assert as_text("T40") == "T40" and as_text("-") == "-" and as_text(float("nan")) == ""
