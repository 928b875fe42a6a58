"""Figures of odd recordings, with warnings as errors."""

from __future__ import annotations

import numpy as np
import pytest
from figure_data import ODD_TEXT, RATE, allan_columns, check, check_saved, every_text, recording

from mocap_metrology.present.recording.recording_figures import allan_figure
from mocap_metrology.present.recording.trajectory import trajectory_figure

pytestmark = pytest.mark.filterwarnings("error")


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


def _lone_frame(data):
    for series in data[:2]:
        series["x1"][:] = np.nan
        series["x1"][7] = 1.0


TRAJECTORIES = {
    "one marker": (recording(500, 1, pairs=False), None),
    "29 frames": (recording(29), _gaps),
    "one frame": (recording(1, 1), None),
    "no frame": (recording(0, 1), None),
    "no series": (({}, {}, {}), None),
    "gaps": (recording(9000), _gaps),
    "constant": (recording(9000), _constant),
    "constant and short": (recording(200, 1), _constant),
    "lone frame": (recording(9000, 1, pairs=False), _lone_frame),
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


def test_odd_names_and_masked_outliers(tmp_path):
    raw, clean, outliers = recording(300, 1, pairs=False)
    for name in raw:
        clean[name][outliers[name]] = np.nan
    raw["x1"][:200], clean["x1"][:200], outliers["x1"][:200] = 7.0, np.nan, True
    for data in (raw, clean, outliers):
        data |= dict.fromkeys(["L_1_3", "_hidden", "$x_1$", "µ" * 60], data["x1"])
    check(trajectory_figure(raw, clean, outliers, RATE, "t", "n"))
    figure = allan_figure(allan_columns(list(raw)), "t", "n")
    check_saved(figure, tmp_path)
    assert {"L_1_3", "_hidden", "$x_1$"} <= set(every_text(figure))


def _names(n_markers, pairs=()):
    return [f"{a}{k}" for k in range(1, n_markers + 1) for a in "xyz"] + list(pairs)


@pytest.mark.parametrize(
    ("case", "text"),
    [
        *(("zero", "x1: zero"), ("tiny", "x1: below the axis"), ("none", "no valid samples")),
        *(("missing", "x1: no valid samples"), ("three", "mdev"), ("alone", "all zero")),
        *(("infinite", "x"), ("few", "x")),
    ],
)
def test_odd_allan_curves(case, text):
    names = _names(2, ["L"])
    data = allan_columns([] if case == "none" else names)
    chosen = data["series"] == ("L" if case == "alone" else "x1")
    if case == "infinite":
        data["adev_upper_mm"][5:], data["adev_lower_mm"][::3] = np.inf, np.nan
    elif case == "few":
        data = {key: values[::40] for key, values in data.items()}
    elif case in ("zero", "alone"):
        for key in ("adev_mm", "adev_lower_mm", "adev_upper_mm"):
            data[key][chosen] = 0.0
    elif case == "tiny":
        data["adev_mm"][chosen] = 1e-17
    elif case == "missing":
        data = {key: values[~chosen] for key, values in data.items()}
    elif case == "three":
        data = allan_columns(names, estimators=("oadev", "mdev", "hdev"))
    figure = allan_figure(data, ODD_TEXT, ODD_TEXT, expected=names)
    check(figure)
    assert every_text(figure).count(text) == (3 if case == "none" else 1)
