"""Where there is nothing to draw, the page says why, and the table has a row with the reason."""

import math

import numpy as np
import pytest
from figure_data import check, every_text

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.motion.orientation import of_cluster, orientation_rows, unknown
from mocap_metrology.present.motion import orientation_figure, place_figure, place_sentence

pytestmark = pytest.mark.filterwarnings("error")
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
