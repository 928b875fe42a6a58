"""Figures of odd recordings, with warnings as errors."""

import numpy as np
import pytest
from figure_data import ODD_TEXT, RATE, allan_columns, check, every_text, recording

from mocap_metrology.present.recording import allan_figure, trajectory_figure

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
