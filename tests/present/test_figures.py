"""Figures: what they show, and that their bytes repeat."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from figure_data import (
    NINE_HOURS,
    RATE,
    allan_columns,
    check,
    check_saved,
    every_text,
    join,
    recording,
)
from matplotlib.colors import to_rgb
from PIL import Image

from mocap_metrology.present.plot.figure import LOOKS, caption_of, save
from mocap_metrology.present.recording.recording_figures import allan_figure
from mocap_metrology.present.recording.trajectory import trajectory_figure

pytestmark = pytest.mark.filterwarnings("error")


# ---- files


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


def test_a_figure_saved_twice_has_the_same_bytes(tmp_path):
    figure = allan_figure(allan_columns(["x1", "y1", "L"]), "t", "n")
    first = [path.read_bytes() for path in save(figure, tmp_path / "a.b")]
    again = [path.read_bytes() for path in save(figure, tmp_path / "a.b")]
    assert first == again and (tmp_path / "a.b.svg").exists()


DRAW = """
import sys
sys.path.insert(0, {folder!r})
from figure_data import allan_columns, recording, RATE
from mocap_metrology.present.recording.recording_figures import allan_figure
from mocap_metrology.present.recording.trajectory import trajectory_figure
from mocap_metrology.present.plot.figure import save
save(allan_figure(allan_columns(["x1", "y1", "L"]), "t", "n"), "allan")
save(trajectory_figure(*recording(9000, 1, pairs=False), RATE, "t", "n"), "trajectory")
assert "matplotlib.pyplot" not in sys.modules
"""


def test_bytes_do_not_depend_on_where_and_when(tmp_path):
    running = []
    surroundings = (
        {"PYTHONHASHSEED": "1", "TZ": "UTC", "LC_ALL": "C.UTF-8"},
        {"PYTHONHASHSEED": "2", "TZ": "Asia/Tokyo", "SOURCE_DATE_EPOCH": "1"},
    )
    rc = tmp_path / "matplotlibrc"
    rc.write_text("lines.linewidth: 5\nfont.size: 20\nsvg.fonttype: none\nsavefig.dpi: 50\n")
    for k, extra in enumerate(surroundings):
        folder = tmp_path / str(k)
        folder.mkdir()
        environment = os.environ | extra | ({"MATPLOTLIBRC": str(rc)} if k else {})
        script = DRAW.format(folder=str(Path(__file__).parent))
        command = [sys.executable, "-c", script]
        running.append(subprocess.Popen(command, cwd=folder, env=environment))
    assert [process.wait() for process in running] == [0, 0]
    files = [sorted((tmp_path / str(k)).iterdir()) for k in range(2)]
    assert [path.name for path in files[0]] == [path.name for path in files[1]]
    assert len(files[0]) == 4
    digests = [[hashlib.sha256(path.read_bytes()).digest() for path in side] for side in files]
    assert digests[0] == digests[1]


# ---- what is shown


def test_a_spike_of_one_sample_in_nine_hours_shows(tmp_path):
    rng = np.random.default_rng(4)
    values = 0.02 * rng.standard_normal(NINE_HOURS)
    with_spike = values.copy()
    at = NINE_HOURS // 3
    with_spike[at] = 0.2
    nothing = {"x1": np.zeros(NINE_HOURS, dtype=bool)}
    images = []
    for k, series in enumerate((values, with_spike)):
        # One axis for both: a corner sample as high as the spike, at the very end
        series[-1] = 0.21
        figure = trajectory_figure({"x1": series}, {"x1": series}, nothing, RATE, "t", "")
        image = Image.open(check_saved(figure, tmp_path / str(k))).convert("L")
        images.append(np.asarray(image))
    changed = np.abs(images[0].astype(int) - images[1]) > 40
    rows, places = np.nonzero(changed[:, : changed.shape[1] * 6 // 10])
    assert np.ptp(rows) > 0.25 * changed.shape[0] * 0.5  # from the noise up to 0.2 mm
    assert np.ptp(places) <= 6  # and no wider than a column
    box = figure.figure.axes[-1].get_position()
    assert places.mean() / changed.shape[1] == pytest.approx(box.x0 + box.width / 3, abs=0.004)


def test_real_numbers_from_series_to_figures():
    from mocap_metrology.common.hampel import hampel
    from mocap_metrology.noise.allan.confidence import allan_curve
    from mocap_metrology.noise.allan.variance import averaging_factors

    raw, _, _ = recording(1800)
    raw["y2"][700:1100] = np.nan
    cleaned = {name: hampel(values, 60) for name, values in raw.items()}
    allan = {key: [] for key in allan_columns(["x1"])}
    for name, one in cleaned.items():
        curve = allan_curve(one.values, RATE, averaging_factors(one.values.size))
        rows = (curve.m, curve.tau_s, curve.deviation, curve.edf, curve.lower, curve.upper)
        for key, values in zip(
            allan, ([name] * curve.m.size, ["oadev"] * curve.m.size, *rows), strict=True
        ):
            allan[key].append(values)
    figures = (
        allan_figure({key: join(v) for key, v in allan.items()}, "A", "n", confidence=0.683),
        trajectory_figure(
            raw,
            {name: one.values for name, one in cleaned.items()},
            {name: one.outlier for name, one in cleaned.items()},
            RATE,
            "T",
            "n",
        ),
    )
    for figure in figures:
        check(figure)
    shown = every_text(figures[0])
    assert {r"Averaging time $\tau$ (s)", "Allan deviation (mm)", "68.3 % interval"} <= set(shown)
    assert {"Time (s)", "x1 (µm)", "L (µm)"} <= set(every_text(figures[1]))
    n_y2 = int(cleaned["y2"].outlier.sum())
    assert any(
        f"outliers {n_y2} " in t and "missing 400 (22 %)" in t for t in every_text(figures[1])
    )


def test_colours_differ_in_lightness():
    """CIE L* of the three coordinates, at least 14 apart: enough for a grey print."""
    lightness = []
    for look in LOOKS.values():
        linear = [
            c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(look.colour)
        ]
        lightness.append(116 * np.dot([0.2126, 0.7152, 0.0722], linear) ** (1 / 3) - 16)
    assert np.diff(sorted(lightness)).min() > 14 and max(lightness) < 75
    assert (
        len({look.marker for look in LOOKS.values()} | {str(v.dashes) for v in LOOKS.values()}) == 6
    )


@pytest.mark.parametrize("names", [["x1"], ["x1", "x2", "L"], ["x1", "x2", "x3", "L"]])
def test_slopes_of_the_key_are_those_of_the_panels(names):
    figure = allan_figure(allan_columns(names), "t", "n")
    panel, key = figure.figure.axes[0], figure.figure.axes[len({n[1:] for n in names})]
    figure.figure.draw_without_rendering()
    ends = panel.transData.transform([(1.0, 1e-2), (100.0, 1e-3)])  # slope -1/2
    on_paper = np.diff(ends[:, 1]) / np.diff(ends[:, 0])
    lines = [key.transData.transform(line.get_xydata()) for line in key.lines]
    starts = [tuple(line[0]) for line in lines]
    fan = [line for line in lines if starts.count(tuple(line[0])) == 5]
    rises = [(y[1] - y[0]) / (x[1] - x[0]) for x, y in (line.T for line in fan)]
    assert len(rises) == 5 and np.isclose(rises, on_paper).sum() == 1


def test_what_is_long_is_printed_whole(tmp_path):
    title, note = "title " * 40, " ".join(f"word{k}" for k in range(60))
    picture = allan_figure(allan_columns(["x1"]), title, note, note.upper())
    check(picture)
    shown = " ".join(every_text(picture)).replace("\n", " ")
    assert title.strip() in shown and note in shown
    assert caption_of(save(picture, tmp_path / "a")[1]) == (title.strip(), picture.caption)
    assert picture.caption.endswith(note.upper())
