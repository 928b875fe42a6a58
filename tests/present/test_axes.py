"""Ticks of logarithmic axes, titles that wrap, and which series share a panel."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from mocap_metrology.present.plot.curves import facets
from mocap_metrology.present.plot.figure import log_axis, log_label, new_figure, styled

DRAWS = np.random.default_rng(5)


def labels(limits, which, size_inches) -> list[str]:
    """Texts of the ticks of an axis within its limits."""
    axes = Figure(figsize=(size_inches, size_inches)).subplots()
    log_axis(axes, which, limits)
    axes.figure.draw_without_rendering()
    axis = axes.xaxis if which == "x" else axes.yaxis
    inside = slice(limits[0] * (1 - 1e-9), limits[1] * (1 + 1e-9))
    return [
        tick.label1.get_text()
        for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks())
        if inside.start <= tick.get_loc() <= inside.stop and tick.label1.get_text()
    ]


def test_two_labels_at_least() -> None:
    for _ in range(150):
        low = 10 ** DRAWS.uniform(-9, 4)
        limits = low, low * 10 ** DRAWS.uniform(0.05, 14)
        for which in ("x", "y"):
            assert len(labels(limits, which, DRAWS.uniform(1, 6))) >= 2, limits


@pytest.mark.parametrize(
    ("limits", "expected"),
    [
        ((3e-4, 1.2e-2), ["10⁻³", "10⁻²", "5×10⁻⁴", "2×10⁻³", "5×10⁻³"]),
        ((1.5e-3, 3e-2), ["0.002", "0.005", "0.01", "0.02"]),
        ((1e-2, 20.0), ["0.01", "0.1", "1", "10"]),
        ((11.0, 19.0), ["12", "14", "16", "18"]),
    ],
)
def test_every_label_is_whole(limits, expected) -> None:
    """No bare 5 between 10⁻³ and 10⁻²."""
    assert set(expected) <= set(labels(limits, "y", 3.0))


def test_labels_of_numbers() -> None:
    assert [log_label(v, False) for v in (1e-3, 5e-3, 1.2e5)] == ["10⁻³", "5×10⁻³", "1.2×10⁵"]
    assert [log_label(v, True) for v in (1e-3, 5e-3, 1000.0)] == ["0.001", "0.005", "1000"]


def test_a_number_and_its_unit_stay_in_one_line() -> None:
    text = "One frame is uncertain by 0.0426 mm (at 250 Hz) about the mean of 2 min, by 5 % of it."
    for width in range(40, 170, 3):
        with styled():
            figure = new_figure(text, "", 60.0, width).get_figure(root=True)
            figure.draw_without_rendering()
            title = figure.get_suptitle()
            lines = next(t for t in figure.texts if t.get_text() == title)._get_wrapped_text()
        words = [line.split(" ")[0].strip(",;.)") for line in lines.split("\n")]
        assert not {"mm", "Hz", "min", "%"} & set(words), lines


@pytest.mark.parametrize(
    ("series", "most", "panels"),
    [
        ("x1 y1 z1 L x1", 6, {"Marker 1": ["x1", "y1", "z1"], "Distance": ["L"]}),
        ("y2 x1 L L_1_3", 2, {"Marker 1": ["x1"], "Marker 2": ["y2"], "Distances": ["L", "L_1_3"]}),
        ("x1 x2 z2 y3", 2, {"x": ["x1", "x2"], "y": ["y3"], "z": ["z2"]}),
        ("x1 L", 0, {"x": ["x1"], "Distance": ["L"]}),
        ("", 6, {}),
    ],
)
def test_series_have_a_panel_a_marker_or_a_coordinate(series, most, panels) -> None:
    found = facets(series.split(), most)
    assert found == panels and list(found) == list(panels)
