"""Coordinates in m where a file says mm, or the other way round: refused until the user states it.

The numbers are those of a take in mm, written in the wrong unit; what is read once the unit is
stated is the take again.
"""

import re
from pathlib import Path

import numpy as np
import pytest
from text_files import LABELS, WRITERS, make, read, refusal, still, trc

from mocap_metrology.common.errors import Refusal, UnknownUnit
from mocap_metrology.io.c3d.write import write_c3d
from mocap_metrology.io.units import KNOWN, METRE, MILLIMETRE, read_unit

TAKE = still(60) + 300.0  # mm
EXPECTED = TAKE.transpose(1, 2, 0)
CELLS = {".c3d": "mm", ".trc": "mm", ".motive.csv": "Millimeters", ".nexus.csv": "mm"}


def written(folder: Path, kind: str, values: np.ndarray, unit: str) -> Path:
    """A file of these numbers whose header says `unit`; Qualisys names none, and means mm."""
    if kind == ".c3d":
        write_c3d(folder / "a.c3d", LABELS, 100, [values], len(values), units=unit)
        return folder / "a.c3d"
    options = {} if kind == ".tsv" else {"unit": unit}
    text = WRITERS[kind](LABELS, 100, values, digits=8, **options)
    return make(folder, f"a.{kind.rpartition('.')[2]}", text)


@pytest.mark.parametrize("kind", [*CELLS, ".tsv", ".fp.tsv", ".table.csv"])
def test_a_wrong_unit_is_refused_until_the_right_one_is_stated(tmp_path: Path, kind: str) -> None:
    says = CELLS.get(kind, "mm")
    path = written(tmp_path, kind, TAKE / 1000, says)
    with pytest.raises(UnknownUnit) as caught:
        read(path)
    largest = f"{TAKE.max() / 1000:.3g}"
    assert str(caught.value) == (
        f"{path.name}: no coordinate exceeds {largest} mm (mm: the file's unit), so they may be in"
        " metres: state the unit, m or mm"
    )
    stated = read(path, unit="m")
    np.testing.assert_allclose(stated.position_mm, EXPECTED, rtol=1e-6)
    assert (stated.units, stated.unit_source) == ("m", "given")
    assert f"{path.name}: its unit is m, as given; the file says {says!r}" in stated.notes
    # Whoever states what the file says is believed, too
    np.testing.assert_allclose(read(path, unit="mm").position_mm, EXPECTED / 1000, rtol=1e-6)
    if kind != ".tsv":
        path = written(tmp_path, kind, TAKE, "m")
        with pytest.raises(UnknownUnit) as caught:
            read(path)
        assert str(caught.value) == (
            f"{path.name}: coordinates reach {TAKE.max():.4g} m (m: the file's unit), so they may"
            " be in mm: state the unit, mm or m"
        )
        np.testing.assert_allclose(read(path, unit="mm").position_mm, EXPECTED, rtol=1e-6)


@pytest.mark.parametrize(
    ("unit", "plausible", "wrong"),
    [(MILLIMETRE, 20.001, 20.0), (MILLIMETRE, 1e9, 0.5), (METRE, 1e5, 1.00001e5),
     (METRE, 0.1, 1e6)],
)  # fmt: skip
@pytest.mark.parametrize("sign", [1, -1])
def test_sizes_that_are_believed_up_to_their_limit(unit, plausible, wrong, sign) -> None:
    position = np.array([[0.1, np.nan, 0.0]])
    for size in (plausible, wrong):
        position[0, 0] = sign * size
        if size == plausible:
            unit.check_size(position, "a")
        else:
            with pytest.raises(UnknownUnit, match=r"^a: .*state the unit"):
                unit.check_size(position, "a")
        for other in (read_unit(["cm"], "Units", "a"), unit.stated("mm", "a")):
            other.check_size(position, "a")
            with pytest.raises(Refusal, match=r"^a: a coordinate is 2e\+12 mm: the file"):
                other.check_size(np.append(position, sign * 2e12), "a")


def test_every_spelling_of_a_unit() -> None:
    for stem, mm in (("millimet", 1), ("centimet", 10), ("met", 1000), ("MILLIMET", 1)):
        for ending in ("re", "res", "er", "ers", "e"):
            assert read_unit([f" {stem}{ending} "], "U", "a").mm == mm
    known = {"mm": 1, "[cm]": 10, "m": 1000, "(M)": 1000, "µm": 1e-3, "in": 25.4}
    for short, mm in known.items():
        assert read_unit(["", short, short], "U", "a").mm == mm
    strange = read_unit(["furlong"], "U", "a")
    assert strange.stated("mm", "a").mm == 1
    assert strange.remark == f"U is 'furlong', expected one of {KNOWN}"
    for of_points, said in ((False, r"\(mm, cm\)"), (True, r"between points \(cm, mm\)")):
        with pytest.raises(Refusal, match=rf"^a: U differ {said}, expected one unit$"):
            read_unit(["mm", "cm"], "U", "a", of_points)


def test_what_names_no_unit_is_taken_for_mm_and_says_so(tmp_path: Path) -> None:
    path = make(tmp_path, "take.trc", trc(LABELS, 100, TAKE, unit=""))
    recording = read(path)
    assert (recording.units, recording.unit_source) == ("mm", "assumed")
    assert "take.trc: no unit in Units: mm is assumed" in recording.notes
    near = make(tmp_path, "near.trc", trc(LABELS, 100, TAKE / 1000, unit="", digits=8))
    assert "(mm: assumed, as the file names none)" in refusal(near)
    stated = read(near, unit="m")
    np.testing.assert_allclose(stated.position_mm, EXPECTED, rtol=1e-6)
    assert "near.trc: its unit is m, as given; the file names none" in stated.notes
    assert refusal(path, unit="inch") == "take.trc: unit is 'inch', expected mm or m"


@pytest.mark.parametrize(
    ("kind", "text", "without", "said"),
    [
        (".motive.csv", "Length Units,Millimeters", "A,B", "line 1 has no Length Units, without"),
        (".table.csv", " [mm]", "", "no column names the unit of its coordinates: state it, m or"),
    ],
)
def test_where_no_unit_may_be_assumed_it_is_stated(tmp_path, kind, text, without, said) -> None:
    header = WRITERS[kind](LABELS, 100, TAKE / 1000, digits=8).replace(text, without)
    path = make(tmp_path, "a.csv", header)
    with pytest.raises(UnknownUnit, match=f"^a.csv: {re.escape(said)}"):
        read(path)
    np.testing.assert_allclose(read(path, unit="m").position_mm, EXPECTED, rtol=1e-6)
