"""Reference points from recordings: the table of a group, and files that are no reference."""

import json
from pathlib import Path

import numpy as np
import pytest

from mocap_metrology.accuracy.points import Points, check
from mocap_metrology.common.errors import Refusal
from mocap_metrology.present.accuracy.points import points_figure
from mocap_metrology.present.plot.figure import Texts
from mocap_metrology.recording.points import RecordedPoint, read_reference, write_points


def test_a_group_of_markers(tmp_path: Path) -> None:
    """Eight places 5 ppm apart in scale, in another frame, with 0.1 mm: headline near that."""
    rng = np.random.default_rng(1)
    places = rng.uniform(-1000, 1000, (8, 3))
    truth = places[:, [1, 2, 0]] + [5.0, 6.0, 7.0] + 0.1 * rng.standard_normal((8, 3))
    lines = [f"P{k},{x},{y},{z}\n" for k, (x, y, z) in enumerate(truth)]
    (tmp_path / "ref.csv").write_text("point,x_mm,y_mm,z_mm\n" + "".join(lines))
    rows = [{"recording": f"r{k}", "point": f"P{k}", "source": "measured"} for k in range(8)]
    recorded = [RecordedPoint(place, 0.05, np.eye(3)) for place in places]
    found = tmp_path / "lab_points.json", tmp_path / "lab_points.svg"
    write_points("lab", rows, recorded, tmp_path / "ref.csv", *found)
    document = json.loads(found[0].read_text())
    assert 0.1 < document["left_out_rms_mm"] < 0.4 and document["findings"] == []
    assert document["lever_mm"] is None and abs(document["scale_ppm"]) < 300
    assert "r7" in (tmp_path / "lab_points.csv").read_text()
    assert "No difference of scale is claimed" in (tmp_path / "lab_points.md").read_text()
    rows[3]["point"] = "P9"
    with pytest.raises(Refusal, match=r"ref\.csv: has no point P9; it has P0, "):
        write_points("lab", rows, recorded, tmp_path / "ref.csv", *found)
    swapped = [*rows[:3], rows[3] | {"point": "P4"}, rows[4] | {"point": "P3"}, *rows[5:]]
    write_points("lab", swapped, recorded, tmp_path / "ref.csv", *found)
    assert json.loads(found[0].read_text())["findings"][0] == "does_not_fit"
    whole = (tmp_path / "ref.csv").read_text()
    (tmp_path / "ref.csv").write_text(whole.replace(f"P6,{truth[6, 0]}", f"P6,{truth[6, 0] + 50}"))
    write_points(
        "lab", rows[:3] + rows[4:], recorded[:3] + recorded[4:], tmp_path / "ref.csv", *found
    )
    told = json.loads(found[0].read_text())
    assert told["wrong_point"] == "P6" and "without it the others fit to" in told["sentences"][-1]
    recorded[2] = RecordedPoint(places[2], 30.0, np.eye(3))
    write_points(
        "lab", rows[:3] + rows[4:], recorded[:3] + recorded[4:], tmp_path / "ref.csv", *found
    )
    told = json.loads(found[0].read_text())
    assert told["unsteady"] == ["P2"] and told["wrong_point"] == "P6"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (np.diag([1e-3, 1e-3, 1e-3]), "0.001 times as far apart as their recordings; expected mm"),
        (np.diag([1, 1, -1]), "a mirror image of their recordings; expected a frame that is right"),
        (np.eye(3)[[1, 0, 2]], "no two columns exchanged"),
    ],
)
def test_another_unit_and_a_left_handed_frame_are_refused(change: np.ndarray, words: str) -> None:
    rng = np.random.default_rng(2)
    places = rng.uniform(-1000, 1000, (8, 3))
    with pytest.raises(Refusal, match=words):
        check(Points(places, np.tile(np.eye(3), (8, 1, 1)), places @ change.T), "lab")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a,b\n1,2\n", "columns a, b; expected point, x_mm, y_mm, z_mm"),
        ("point,x_mm,y_mm,z_mm\nP,1,2\n", "expected numbers of mm"),
        ("point,x_mm,y_mm,z_mm\nP,1,2,nan\n", "line 2"),
        ("point,x_mm,y_mm,z_mm\nP,1,2,3\nP,1,2,3\n", "point P stands twice"),
        ("", "columns nothing; expected point"),
        ("point,x_mm,y_mm,z_mm\n\xc4,1,2,3\n", "cannot be read"),
        ("point,x_mm,y_mm,z_mm\nP,1,2,3,4\n", "line 2 has 5 cells, expected 4"),
        ("point,x_mm,y_mm,z_mm,x_mm\nP,1,2,3,4\n", "columns point, x_mm, y_mm, z_mm, x_mm"),
        ("point,x_mm,y_mm,z_mm\n,1,2,3\n", "line 2"),
        ("point,x_mm,y_mm,z_mm\nP,1,2," + 200_000 * "3", "field larger than field limit"),
    ],
)
def test_what_is_no_reference_is_refused(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "ref.csv"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(Refusal) as refused:
        read_reference(path)
    assert words in str(refused.value) and str(refused.value).startswith("ref.csv")


def test_a_reference_as_a_spreadsheet_saves_it(tmp_path: Path) -> None:
    """Decimal commas between semicolons, blank lines, blanks round names."""
    path = tmp_path / "ref.csv"
    path.write_text("point; x_mm;y_mm;z_mm;u_mm\nP ;1,5;2;3;0,1\n;;;;\n\nQ;4;5;6;\n")
    found = read_reference(path)
    assert {name: [*place, u] for name, (place, u) in found.items()} == {
        "P": [1.5, 2, 3, 0.1],
        "Q": [4, 5, 6, 0],
    }


def test_arrows_of_a_gross_error_stay_on_the_map() -> None:
    """Of eight points within 2 m one is off by 1 m, the others by 1 mm."""
    rng = np.random.default_rng(3)
    places = rng.uniform(-1000, 1000, (8, 3))
    off = np.ones((8, 3))
    off[2, 0] = 1000
    points = Points(places, np.tile(np.eye(3), (8, 1, 1)), places)
    labels = [f"P{k}" for k in range(8)]
    picture = points_figure(points, off, labels, (), Texts("lab", ""))
    assert all(np.ptp(axes.get_xlim()) < 6 for axes in picture.figure.axes[:2])
