"""Where there is nothing to draw, the page says why, and the table has a row with the reason."""

from __future__ import annotations

import math

import numpy as np
import pytest
from figure_data import check_saved, every_text

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.motion.orientation import of_cluster, unknown
from mocap_metrology.present.drawing.style import wrap
from mocap_metrology.present.motion.orientation import orientation_figure, orientation_rows
from mocap_metrology.present.motion.place import place_figure, place_sentence

pytestmark = pytest.mark.filterwarnings("error")
NOTHING = {k: np.array([]) for k in ("series", "tau_s", "adev_rad", "adev_lower_rad")}
ORIGIN = {"recording": "R", "twin": None, "allan": {"confidence": 0.683}}


def test_a_cluster_on_a_line(tmp_path) -> None:
    line = np.arange(3.0)[:, None, None] * np.array([240.0, 0, 0])[:, None]
    with pytest.raises(Refusal) as refused:
        of_cluster(line + np.random.default_rng(1).normal(0, 0.1, (3, 3, 50)))
    why, found = str(refused.value), unknown(50)
    rows = orientation_rows("R", "measured", NOTHING, found, why)
    assert [row["axis"] for row in rows] == ["rx", "ry", "rz"]
    assert all(row["note"] == why and row["turned_rad"] is None for row in rows)
    figure = orientation_figure(NOTHING, found, ORIGIN, ["A", "B", "C"], why)
    assert "lie on a line" in " ".join(every_text(figure))
    check_saved(figure, tmp_path)


def test_a_move_without_a_full_cube(tmp_path) -> None:
    figure = place_figure([], "R: length by place", "Too few frames in any cube.")
    assert "Too few frames in any cube." in every_text(figure)
    check_saved(figure, tmp_path)


def test_cubes_without_noise_have_no_infinite_factor() -> None:
    words = place_sentence({"p": math.nan, "worst_over_best": math.inf, "bend_mm": 0.1})
    assert "inf" not in words
    assert "nan" not in words


def test_a_number_and_its_unit_stay_in_one_line() -> None:
    text = "One frame is uncertain by 0.0426 mm (at 250 Hz) about the mean of 2 min, by 5 % of it."
    for width in range(20, 90):
        lines = wrap(text, 8.5, width)
        assert " ".join(lines) == text
        assert not any(
            line.split(" ")[0].strip(",;.)") in ("mm", "Hz", "min", "%") for line in lines
        )


def test_the_numbers_of_a_map_are_on_the_page(tmp_path) -> None:
    rows = [
        {"x_mm": 250.0 * k, "y_mm": 0.0, "n_frames": 100, "sigma_mm": 0.0402 + 0.0011 * k}
        | {"deviation_mm": 0.0031 * (k - 2)}
        for k in range(5)
    ]
    figure = place_figure(rows, "R: length by place", "Source: measured.")
    assert "Mean less overall mean (µm)" in every_text(figure)
    check_saved(figure, tmp_path)
