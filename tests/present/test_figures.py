"""Figures: what they show, also of odd recordings and of nothing; their bytes repeat."""

import hashlib
import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from figure_data import ODD_TEXT, RATE, allan_columns, check, every_text, recording

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.motion.orientation import of_cluster, orientation_rows, unknown
from mocap_metrology.present.motion import orientation_figure, place_figure, place_sentence
from mocap_metrology.present.plot.figure import save
from mocap_metrology.present.recording import allan_figure, trajectory_figure

pytestmark = pytest.mark.filterwarnings("error")
DRAW = """
import sys
sys.path.insert(0, {folder!r})
from figure_data import allan_columns, recording, RATE
from mocap_metrology.present.recording import allan_figure
from mocap_metrology.present.recording import trajectory_figure
from mocap_metrology.present.plot.figure import save
for _ in range(2):
    save(allan_figure(allan_columns(["x1", "y1", "L"]), "t", "n"), "allan.b")
save(trajectory_figure(*recording(9000, 1, pairs=False), RATE, "t", "n"), "trajectory.svg")
assert "matplotlib.pyplot" not in sys.modules
"""


def test_a_failed_figure_leaves_nothing(tmp_path, monkeypatch):
    figure = allan_figure(allan_columns(["x1"]), "t", "n")
    savefig = type(figure.figure).savefig

    def fails_on_png(self, path, format, **options):
        savefig(self, path, format="svg")
        if format == "png":
            raise OSError("disk full")

    monkeypatch.setattr(type(figure.figure), "savefig", fails_on_png)
    with pytest.raises(OSError, match="disk full"):
        save(figure, tmp_path / "figure")
    assert not list(tmp_path.iterdir())


def test_bytes_do_not_depend_on_where_and_when(tmp_path):
    """In two processes, the figure saved twice in each."""
    rc = tmp_path / "matplotlibrc"
    rc.write_text("lines.linewidth: 5\nfont.size: 20\nsvg.fonttype: none\nsavefig.dpi: 50\n")
    places = (
        {"PYTHONHASHSEED": "1", "TZ": "UTC", "LC_ALL": "C.UTF-8"},
        {"PYTHONHASHSEED": "2", "TZ": "Asia/Tokyo", "SOURCE_DATE_EPOCH": "1", "MATPLOTLIBRC": rc},
    )
    script = DRAW.format(folder=str(Path(__file__).parent))
    digests = []
    for k, place in enumerate(places):
        folder = tmp_path / str(k)
        folder.mkdir()
        subprocess.run(
            [sys.executable, "-c", script], cwd=folder, env=os.environ | place, check=True
        )
        files = sorted(folder.iterdir())
        digests.append({path.name: hashlib.sha256(path.read_bytes()).digest() for path in files})
    assert digests[0] == digests[1]
    assert set(digests[0]) == {
        f"{n}.{kind}" for n in ("allan.b", "trajectory") for kind in ("png", "svg")
    }


def test_numbers_beside_the_panels_are_those_of_the_series():
    raw, clean, outliers = recording(1800)
    for series in (raw, clean):
        series["y2"][700:1100] = np.nan
    raw["x1"][5], outliers["x1"][5] = 90.0, True
    figure = trajectory_figure(raw, clean, outliers, RATE, "T", "n")
    check(figure)
    texts = every_text(figure)
    assert {"Time (s)", "x1 (µm)", "L (µm)"} <= set(texts)
    (of_y2,) = (text for text in texts if "missing" in text)
    count = int((outliers["y2"] & np.isfinite(raw["y2"])).sum())
    assert of_y2.startswith(f"mean {np.nanmean(clean['y2']):.3f} mm\noutliers {count} (")
    assert "missing 400 (22 %)" in of_y2
    (of_x1,) = (text for text in texts if text.endswith("to −10.00 mm"))
    marked = int(outliers["x1"].sum())
    assert f"outliers {marked} (" in of_x1 and f"beyond 6 σ: {marked}" in of_x1


def _gaps(data):
    for series in data[:2]:
        series["x1"][10:20] = np.nan
        series["y2"][:] = np.nan
        series["z1"][1::2] = np.nan
        series["z2"][5] = np.inf


def _constant(data):
    for series in data[:2]:
        series["x1"][:] = 3.0
        series["L"][:] = 0.0


TRAJECTORIES = {
    "29 frames": (recording(29), _gaps),
    "no frame": (recording(0, 1), None),
    "no series": (({}, {}, {}), None),
    "gaps": (recording(9000), _gaps),
    "constant": (recording(9000), _constant),
    "many markers": (recording(300, 8), _gaps),
}


@pytest.mark.parametrize("case", TRAJECTORIES)
def test_odd_trajectories(case):
    data, change = TRAJECTORIES[case]
    if change is not None:
        change(data)
    figure = trajectory_figure(*data, RATE, ODD_TEXT, ODD_TEXT)
    check(figure)
    shown = every_text(figure)
    assert ("no valid samples" in shown) >= (case in ("gaps", "29 frames", "many markers"))


def _names(n_markers, pairs=()):
    return [f"{a}{k}" for k in range(1, n_markers + 1) for a in "xyz"] + list(pairs)


@pytest.mark.parametrize(
    ("case", "text"),
    [
        *(("zero", "x1: zero"), ("tiny", "x1: below the axis"), ("none", "no valid samples")),
        *(("infinite", "x"), ("few", "x")),
    ],
)
def test_odd_allan_curves(case, text):
    names = _names(2, ["L"])
    data = allan_columns([] if case == "none" else names)
    chosen = data["series"] == "x1"
    if case == "infinite":
        data["adev_upper_mm"][5:], data["adev_lower_mm"][::3] = np.inf, np.nan
    elif case == "few":
        data = {key: values[::40] for key, values in data.items()}
    elif case == "zero":
        for key in ("adev_mm", "adev_lower_mm", "adev_upper_mm"):
            data[key][chosen] = 0.0
    elif case == "tiny":
        data["adev_mm"][chosen] = 1e-17
    figure = allan_figure(data, ODD_TEXT, ODD_TEXT, expected=names)
    check(figure)
    assert every_text(figure).count(text) == (3 if case == "none" else 1)


NOTHING = {k: np.array([]) for k in ("series", "tau_s", "adev_rad", "adev_lower_rad")}
ORIGIN = {"recording": "R", "twin": None, "allan": {"confidence": 0.683}}


def test_a_cluster_on_a_line() -> None:
    line = np.arange(3.0)[:, None, None] * np.array([240.0, 0, 0])[:, None]
    with pytest.raises(Refusal) as refused:
        of_cluster(line + np.random.default_rng(1).normal(0, 0.1, (3, 3, 50)))
    why, found = str(refused.value), unknown(50)
    rows = orientation_rows("R", "measured", NOTHING, found, why)
    assert [row["axis"] for row in rows] == ["rx", "ry", "rz"]
    assert all(row["note"] == why and row["turned_rad"] is None for row in rows)
    figure = orientation_figure(NOTHING, found, ORIGIN, ["A", "B", "C"], why)
    assert "lie on a line" in " ".join(every_text(figure))
    check(figure)


def test_cubes_without_noise_have_no_infinite_factor() -> None:
    words = place_sentence({"p": math.nan, "worst_over_best": math.inf, "bend_mm": 0.1})
    assert "inf" not in words
    assert "nan" not in words


def test_the_squares_of_a_map_are_the_cells() -> None:
    """A cell without frames is empty; of two heights the mean weighted by frames."""
    rows = [
        {"x_mm": x, "y_mm": y, "z_mm": z, "n_frames": n, "sigma_mm": s, "deviation_mm": 0.0}
        for x, y, z, n, s in (
            *((0.0, 0.0, 0.0, 100, 0.04), (0.0, 0.0, 250.0, 300, 0.08)),
            *((500.0, 0.0, 0.0, 100, 0.05), (0.0, 250.0, 0.0, 100, 0.06)),
        )
    ]
    figure = place_figure(rows, "R: length by place", "Source: measured.", "A caption.")
    (squares, *_) = figure.figure.axes[0].collections
    shown = np.ma.filled(squares.get_array(), np.nan).reshape(2, 3)
    assert np.allclose(shown, [[70, np.nan, 50], [60, np.nan, np.nan]], equal_nan=True)
    assert squares.get_coordinates()[0, 0].tolist() == [-125.0, -125.0]
