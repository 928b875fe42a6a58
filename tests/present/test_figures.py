"""Figures: what they show, also of odd recordings and of nothing; their bytes repeat."""

import math

import numpy as np
import pytest
from figure_data import ODD_TEXT, RATE, check, every_text, recording
from noise_data import allan

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.model.components import NoiseModel, PowerLaw
from mocap_metrology.noise.motion.orientation import of_cluster, orientation_rows, unknown
from mocap_metrology.present.plot.figure import Texts
from mocap_metrology.present.recording import (
    allan_figure,
    orientation_figure,
    place_figure,
    place_sentence,
    trajectory_figure,
)

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
    "29 frames": (recording(29), _gaps), "no frame": (recording(0, 1), None),
    "no series": (({}, {}, {}), None), "gaps": (recording(9000), _gaps),
    "constant": (recording(9000), _constant), "many markers": (recording(300, 8), _gaps),
}  # fmt: skip


@pytest.mark.parametrize("case", TRAJECTORIES)
def test_odd_trajectories(case):
    data, change = TRAJECTORIES[case]
    if change is not None:
        change(data)
    figure = trajectory_figure(*data, RATE, Texts(ODD_TEXT, ODD_TEXT))
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
    model = NoiseModel((PowerLaw(0, 2e-6), PowerLaw(-2, 1e-9)))
    data = allan(dict.fromkeys(names, model))
    chosen = data["series"] == "x1"
    if case == "infinite":
        data["adev_upper_mm"][5:], data["adev_lower_mm"][::3] = np.inf, np.nan
    elif case in ("few", "none"):
        kept = slice(None, None, 40) if case == "few" else slice(0)
        data = {key: values[kept] for key, values in data.items()}
    elif case == "zero":
        for key in ("adev_mm", "adev_lower_mm", "adev_upper_mm"):
            data[key][chosen] = 0.0
    elif case == "tiny":
        data["adev_mm"][chosen] = 1e-17
    figure = allan_figure(data, Texts(ODD_TEXT, ODD_TEXT), expected=names)
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
    assert "inf" not in words and "nan" not in words


def test_the_squares_of_a_map_are_the_cells() -> None:
    """A cell without frames is empty; of two heights the mean weighted by frames."""
    rows = [
        {"x_mm": x, "y_mm": y, "z_mm": z, "n_frames": n, "sigma_mm": s, "deviation_mm": 0.0}
        for x, y, z, n, s in (
            *((0.0, 0.0, 0.0, 100, 0.04), (0.0, 0.0, 250.0, 300, 0.08)),
            *((500.0, 0.0, 0.0, 100, 0.05), (0.0, 250.0, 0.0, 100, 0.06)),
        )
    ]
    figure = place_figure(rows, Texts("R: length by place", "Source: measured.", "A caption."))
    (squares, *_) = figure.figure.axes[0].collections
    shown = np.ma.filled(squares.get_array(), np.nan).reshape(2, 3)
    assert np.allclose(shown, [[70, np.nan, 50], [60, np.nan, np.nan]], equal_nan=True)
    assert squares.get_coordinates()[0, 0].tolist() == [-125.0, -125.0]
