"""Ticks of logarithmic axes, and which series share a panel."""

import pytest
from matplotlib.figure import Figure

from mocap_metrology.present.plot.curves import facets
from mocap_metrology.present.plot.figure import log_axis


def labels(limits, which, size_inches) -> list[str]:
    """Texts of the ticks of an axis within its limits."""
    axes = Figure(figsize=(size_inches, size_inches)).subplots()
    log_axis(axes, which, limits)
    axes.figure.draw_without_rendering()
    axis = axes.xaxis if which == "x" else axes.yaxis
    low, high = limits[0] * (1 - 1e-9), limits[1] * (1 + 1e-9)
    ticks = [tick for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high]
    return [tick.label1.get_text() for tick in ticks if tick.label1.get_text()]


@pytest.mark.parametrize(
    ("limits", "expected"),
    [  # no bare 5 between 10⁻³ and 10⁻²
        ((3e-4, 1.2e-2), ["5×10⁻⁴", "10⁻³", "2×10⁻³", "5×10⁻³", "10⁻²"]),
        ((1.5e-3, 3e-2), ["0.002", "0.005", "0.01", "0.02"]),
        ((1e-2, 20.0), ["0.01", "0.1", "1", "10"]),
        ((11.0, 19.0), ["12", "14", "16", "18"]),
    ],
)
def test_every_label_is_whole(limits, expected) -> None:
    assert labels(limits, "y", 3.0) == expected


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
