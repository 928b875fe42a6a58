"""Coordinates in m where a file says mm, or the other way round: refused until the user states it.

The numbers are those of a take in mm, written in the wrong unit; what is read once the unit is
stated is the take again.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from text_files import LABELS, WRITERS, make, read, still, trc

from mocap_metrology.common.errors import Refusal, UnknownUnit
from mocap_metrology.io.c3d.write import write_c3d
from mocap_metrology.io.read import orientation_of

TAKE = still(60) + 300.0  # mm
EXPECTED = TAKE.transpose(1, 2, 0)
NAMES = {"take.c3d": ".c3d", "take.trc": ".trc", "m.csv": ".motive.csv", "n.csv": ".nexus.csv"}
NAMES |= {"take.tsv": ".tsv"}
IN_METRES = r": no coordinate exceeds .* mm \(mm: the file's unit\), .* metres: state the unit"
IN_MM = r": coordinates reach .* m \(m: the file's unit\), .* mm: state the unit"


def written(folder: Path, name: str, values: np.ndarray, unit: str) -> Path:
    """A file of these numbers whose header says `unit`; Qualisys names none, and means mm."""
    if name == "take.c3d":
        write_c3d(folder / name, LABELS, 100, [values], len(values), units=unit)
        return folder / name
    text = WRITERS[NAMES[name]](LABELS, 100, values, digits=8)
    if unit == "m":
        for inside in ("\tmm\t", "Length Units,Millimeters", ",mm"):
            text = text.replace(inside, inside.replace("Millimeters", "m").replace("mm", "m"))
    return make(folder, name, text)


@pytest.mark.parametrize("name", NAMES)
def test_metres_under_mm(tmp_path: Path, name: str) -> None:
    path = written(tmp_path, name, TAKE / 1000, "mm")
    with pytest.raises(UnknownUnit, match=f"^{name}{IN_METRES}, m or mm$"):
        read(path)
    stated = read(path, unit="m")
    assert np.allclose(stated.position_mm, EXPECTED, rtol=1e-6, atol=0)
    assert (stated.units, stated.unit_source) == ("m", "given")
    says = "Millimeters" if name == "m.csv" else "mm"
    assert f"{name}: its unit is m, as given; the file says {says!r}" in stated.notes
    # Whoever states what the file says is believed, too
    assert np.allclose(read(path, unit="mm").position_mm, EXPECTED / 1000, rtol=1e-6, atol=0)


@pytest.mark.parametrize("name", [name for name in NAMES if name != "take.tsv"])
def test_mm_under_metres(tmp_path: Path, name: str) -> None:
    path = written(tmp_path, name, TAKE, "m")
    with pytest.raises(UnknownUnit, match=f"^{name}{IN_MM}, mm or m$"):
        read(path)
    assert np.allclose(read(path, unit="mm").position_mm, EXPECTED, rtol=1e-6, atol=0)


def test_poses_are_in_metres_and_their_orientation_has_no_unit(tmp_path: Path) -> None:
    poses = np.tile([1.0, 0, 0, 300, 0, 1, 0, 400, 0, 0, 1, 500], (20, 1))
    rows = "\n".join(" ".join(map(str, row)) for row in poses)
    path = make(tmp_path, "p.txt", f"# Freq: 100\n{rows}\n")
    with pytest.raises(UnknownUnit, match=f"^p.txt{IN_MM}"):
        read(path, ["tracker"])
    stated = read(path, ["tracker"], unit="mm")
    assert stated.position_mm[0, :, 0].tolist() == [300, 400, 500]
    assert np.allclose(orientation_of([path], "tracker").T, [0, 0, 0, 1])


def test_what_names_no_unit_is_taken_for_mm_and_says_so(tmp_path: Path) -> None:
    path = make(tmp_path, "take.trc", trc(LABELS, 100, TAKE, unit=""))
    found = read(path)
    assert (found.units, found.unit_source) == ("mm", "assumed")
    assert "take.trc: no unit in Units: mm is assumed" in found.notes
    near = make(tmp_path, "near.trc", trc(LABELS, 100, TAKE / 1000, unit="", digits=8))
    with pytest.raises(UnknownUnit, match=r"mm: assumed, as the file names none"):
        read(near)
    stated = read(near, unit="m")
    assert np.allclose(stated.position_mm, EXPECTED, rtol=1e-6, atol=0)
    assert "near.trc: its unit is m, as given; the file names none" in stated.notes


def test_motive_without_its_unit_is_read_once_it_is_stated(tmp_path: Path) -> None:
    text = WRITERS[".motive.csv"](LABELS, 100, TAKE / 1000, digits=8)
    path = make(tmp_path, "m.csv", text.replace("Length Units,Millimeters", "Some,Thing"))
    with pytest.raises(UnknownUnit, match="line 1 has no Length Units, without which m and mm"):
        read(path)
    assert np.allclose(read(path, unit="m").position_mm, EXPECTED, rtol=1e-6, atol=0)


def test_one_marker_away_from_the_origin_shows_the_unit(tmp_path: Path) -> None:
    """A board's corner on the origin and one 300 mm off it: mm, no question."""
    near = TAKE.copy()
    near[:, 0] -= near[0, 0] - 5
    path = written(tmp_path, "take.trc", near, "mm")
    assert read(path).units == "mm"
    with pytest.raises(UnknownUnit):
        read(path, ["A"])


def test_another_unit_than_mm_and_m_cannot_be_stated(tmp_path: Path) -> None:
    path = written(tmp_path, "take.trc", TAKE, "mm")
    with pytest.raises(Refusal, match=r"^take\.trc: unit is 'inch', expected mm or m$"):
        read(path, unit="inch")
