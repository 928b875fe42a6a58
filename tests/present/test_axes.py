"""Ticks of linear and logarithmic axes: two at least, none that is misread."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from mocap_metrology.present.drawing.axes import decade_axis, decade_label, labelled, round_ticks
from mocap_metrology.present.drawing.style import wrap

DRAWS = np.random.default_rng(5)


def test_linear_axes_have_two_ticks_at_least() -> None:
    """Any limits: all ticks within them, evenly spaced, and no more than asked for."""
    for _ in range(2000):
        low = DRAWS.normal() * 10 ** DRAWS.uniform(-3, 3)
        high, most = low + 10 ** DRAWS.uniform(-3, 3), int(DRAWS.integers(2, 12))
        ticks = round_ticks(low, high, most)
        assert 2 <= ticks.size <= most
        slack = 1e-9 * max(abs(low), abs(high))
        assert low - slack <= ticks[0] and ticks[-1] <= high + slack
        assert np.allclose(np.diff(ticks), ticks[1] - ticks[0])


@pytest.mark.parametrize(
    ("limits", "most", "ticks"),
    [
        ((-40.1, 40.3), 3, [-40, 0, 40]),  # a step of 50 leaves 0 alone
        ((-4.4, 4.4), 2, [-4, 4]),
        ((0, 10), 8, [0, 2, 4, 6, 8, 10]),
        ((-72, 81), 4, [-50, 0, 50]),
    ],
)
def test_linear_ticks(limits, most, ticks) -> None:
    assert round_ticks(*limits, most).tolist() == ticks


def test_logarithmic_axes_have_two_labels_at_least() -> None:
    for _ in range(2000):
        low = 10 ** DRAWS.uniform(-9, 4)
        limits, length = (low, low * 10 ** DRAWS.uniform(0.05, 14)), DRAWS.uniform(12, 140)
        for which, plain in (("x", True), ("x", False), ("y", True), ("y", False)):
            ticks = labelled(limits, length, which, plain)
            assert ticks.size >= 2
            assert limits[0] * (1 - 1e-9) <= ticks[0] and ticks[-1] <= limits[1] * (1 + 1e-9)


@pytest.mark.parametrize(
    ("limits", "plain", "labels"),
    [
        ((3e-4, 1.2e-2), None, ["10⁻³", "10⁻²"]),
        ((2e-5, 6e-4), None, ["10⁻⁴", "2×10⁻⁵", "2×10⁻⁴", "5×10⁻⁵", "5×10⁻⁴"]),
        ((1.5e-3, 3e-2), None, ["0.002", "0.005", "0.01", "0.02"]),
        ((1e-2, 20), False, ["10⁻²", "10⁻¹", "10⁰", "10¹"]),
        ((11.0, 19.0), None, ["12", "14", "16", "18"]),
    ],
)
def test_every_label_of_an_axis_is_whole(limits, plain, labels) -> None:
    """No bare 5 between 10⁻³ and 10⁻²."""
    axes = Figure().add_axes((0.2, 0.2, 0.7, 0.7))
    decade_axis(axes, "y", limits, 60.0, plain)
    axes.figure.draw_without_rendering()
    shown = [label.get_text() for label in axes.get_yticklabels()]
    assert sorted(shown) == sorted(labels)


def test_labels_of_numbers() -> None:
    assert [decade_label(v, False) for v in (1e-3, 5e-3, 1.2e5)] == ["10⁻³", "5×10⁻³", "1.2×10⁵"]
    assert [decade_label(v, True) for v in (1e-3, 5e-3, 1000.0)] == ["0.001", "0.005", "1000"]


def test_a_number_and_its_unit_stay_in_one_line() -> None:
    text = "One frame is uncertain by 0.0426 mm (at 250 Hz) about the mean of 2 min, by 5 % of it."
    for width in range(20, 90):
        lines = wrap(text, 8.5, width)
        assert " ".join(lines) == text
        assert not any(
            line.split(" ")[0].strip(",;.)") in ("mm", "Hz", "min", "%") for line in lines
        )
