"""Rows of sheets as text: what separates cells, what is no row, and every fault of one."""

from pathlib import Path

import pytest

from mocap_metrology.common.faults import Faults
from mocap_metrology.common.sheets import read

COLUMNS = ("name", "path", "note")


def rows(folder: Path, text: str | bytes, **how: bool) -> list[tuple[int, list[str]]]:
    path = folder / "s.tsv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return [(one.number, [*one.cells.values()]) for one in read(path, COLUMNS, ["name"], **how)]


def faults(folder: Path, text: str | bytes) -> list[str]:
    with pytest.raises(Faults) as refused:
        rows(folder, text)
    return [line.replace(f"{folder}/", "") for line in refused.value.lines]


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("sep", ["\t", ";", ","])
def test_rows_by_their_numbers_with_cells_left_out_empty(
    tmp_path: Path, sep: str, end: str
) -> None:
    """Without comments, empty rows, blanks round cells, and empty columns at the end."""
    lines = [
        "# title",
        f"Name{sep}NOTE{sep}{sep}",
        "",
        f" a {sep}b c{sep}{sep}",
        f"{sep}{sep} {sep}",
    ]
    lines += [f'"x{sep}y"{sep}', "  # end", f"{sep}z"]
    found = rows(tmp_path, "\ufeff" + end.join(lines) + end + "\x1a")
    assert found == [(4, ["a", "", "b c"]), (6, [f"x{sep}y", "", ""]), (8, ["", "", "z"])]


@pytest.mark.parametrize("first", ["sep=;", "SEP=;;;", '"sep=;"'])
@pytest.mark.parametrize("error", ["#REF!", "#N/A", "#DIV/0!", '"#WERT!"'])
def test_a_formula_that_failed_is_no_comment_and_sep_is_no_header(
    tmp_path: Path, first: str, error: str
) -> None:
    found = rows(tmp_path, f"{first}\nname;path\n{error};b\n#WARNING!\n# N/A;b\nc;d\n")
    assert found == [(3, [error.strip('"'), "b", ""]), (6, ["c", "d", ""])]


@pytest.mark.parametrize(
    ("text", "said"),
    [("", ["s.tsv: no header; expected columns name, path, note"]),
     ("# only a word\n\t\n", ["s.tsv: no header; expected columns name, path, note"]),
     ("name\n\xff",
      ['s.tsv, row 2: "\xff" is not UTF-8; expected UTF-8 text, "CSV UTF-8" of a spreadsheet']),
     ("name;path\rA;St\xfctz;b",
      ['s.tsv, row 2: "St\xfctz" is not UTF-8; expected UTF-8 text, "CSV UTF-8" of a spreadsheet']),
     ("name|path\na|b", ["s.tsv: cells are separated by bars; expected tabs"]),
     ("name path\na b", ["s.tsv: cells are separated by blanks; expected tabs"]),
     ("path\nb", ["s.tsv: no column name; expected a header with it"]),
     ("name\t\tpath\na", ["s.tsv: column 2 has no name; expected one in its header"]),
     ("name\tname\na", ["s.tsv, column name: repeated; expected once"]),
     ("name\tpath\na\tb\tc\nd", ["s.tsv, row 2: 3 cells; expected 2"]),
     ("name\tpath\na\tb\t\nd", []),
     ("name,path\na,b,c\nd,e,f",
      [f's.tsv, row {k}: 3 cells; expected 2, and quotes round a cell with ","' for k in (2, 3)]),
     ('name\tpath\na\t"b',
      ["s.tsv, row 2: a quote that its cell does not end with; expected a pair round the whole"
       " cell, in one line"]),
     ("name\n" + "x" * 100_001,
      ["s.tsv, row 2: 100001 letters; expected at most 100000 in a cell"]),
     ("name\tpath\n" + "x" * 100_000 + "\tb", [])],
)  # fmt: skip
def test_faults(tmp_path: Path, text: str, said: list[str]) -> None:
    raw = text.encode("latin-1")
    assert (faults(tmp_path, raw) if said else rows(tmp_path, raw) and []) == said


def test_what_is_no_text(tmp_path: Path) -> None:
    for raw in (b"\xff\xfen\0", b"\xfe\xff\0n"):
        assert faults(tmp_path, raw)[0].startswith("s.tsv: UTF-16; expected UTF-8")
    for raw in (b"PK\3\4", b"name\0"):
        assert faults(tmp_path, raw)[0].startswith("s.tsv: not a text file; expected UTF-8")
    with pytest.raises(Faults, match="no such file; expected a sheet, or an empty value"):
        read(tmp_path / "none.tsv", COLUMNS, ["name"])
    with pytest.raises(Faults, match="expected a sheet"):
        read(tmp_path, COLUMNS, ["name"])


def test_other_columns_where_a_sheet_may_have_them(tmp_path: Path) -> None:
    text = "name\tmore\na\tb"
    assert rows(tmp_path, text, others=True) == [(2, ["a", "", "", "b"])]
    assert faults(tmp_path, text)[0].startswith('s.tsv, column "more": unknown')
