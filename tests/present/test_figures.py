"""Figures: what they show, and that their bytes repeat."""

import hashlib
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from figure_data import RATE, allan_columns, check, every_text, recording

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
