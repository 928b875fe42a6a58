"""S Figures 14 and 15: power-law coefficients against the number of cameras."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.model.components import ALPHAS
from mocap_metrology.present.drawing.decades import SUPERSCRIPT
from mocap_metrology.present.drawing.legend import strip, strip_height
from mocap_metrology.present.drawing.linear import linear_axis
from mocap_metrology.present.drawing.style import (
    GREY,
    MARGIN_MM,
    SMALL_PT,
    WIDTH_MM,
    blank_sheet,
    label_axes,
    say,
    styled,
)
from mocap_metrology.present.families import slots
from mocap_metrology.present.numbers import symbol, unit
from mocap_metrology.present.tables import Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TOP_MM, ROW_MM, LABELS_MM = 2.0, 20.0, 5.0
ORDER = (
    "S has a column for each camera type, here a panel each, one below the other. In each group "
    "from left to right: x1, y1, z1, x2, y2, z2, L; the numbers of one series stand in one line. "
    "Nine cameras there were of Vantage alone."
)
LOGARITHMIC = (
    f"Intervals are cut at an arrow a factor of {slots.LONGEST:g} below their number; in the grey "
    "band: less than 10⁻²⁰."
)
LINEAR = (
    "Each panel has its own power of ten and holds nine tenths of its numbers that are not zero; "
    "arrows at the top: larger ones, and intervals that go on. Limits above a panel are left out."
)
HELD = 0.9  # share of the positive numbers within a linear axis


@styled()
def colour_figure(
    rows: Sequence[Row], title: str, note: str = "", *, logarithmic: bool = True
) -> Figure:
    """Coefficients h_-2 ... h_2 of the rows of `table_a` (of any camera types): S Figure 14
    (logarithmic) or 15 (linear, each panel to its own scale)."""
    entries = slots.key_entries(slots.DOWN if logarithmic else slots.UP)
    width, block = WIDTH_MM - 2 * MARGIN_MM, slots.block_mm(ROW_MM)
    key_top = TOP_MM + len(ALPHAS) * block + LABELS_MM
    body = key_top + strip_height(entries, width) + 1.5
    how = LOGARITHMIC if logarithmic else LINEAR
    sheet = blank_sheet(body, title, f"{ORDER} {how} {note}".strip())
    cameras = sorted({r["n_cameras"] for r in rows})
    for k, alpha in enumerate(ALPHAS):
        name = f"h_{alpha}"
        of_it = [r for r in rows if r["parameter"].split(" ")[0] == name]
        limits = slots.floor_limits(of_it)
        panels = slots.block_axes(
            sheet, TOP_MM + k * block, ROW_MM, f"{symbol(name)} ({unit(name)})"
        )
        for camera_type, axes in zip(slots.TYPES, panels, strict=True):
            shown = [r for r in of_it if r["camera_type"] == camera_type]
            slots.camera_axis(axes, cameras, axes is panels[-1])
            if logarithmic:
                slots.log_axis(axes, limits, ROW_MM, labels=True)
                slots.draw(axes, shown, cameras, slots.raised)
            else:
                _linear(axes, shown, cameras)
            if not shown:
                say(axes, "no numbers")
        label_axes(panels[-1], x="Number of cameras" if k == len(ALPHAS) - 1 else "")
    strip(sheet, MARGIN_MM, key_top, width, entries)
    return sheet.figure


def _linear(axes: Axes, rows: Sequence[Row], cameras: Sequence[int]) -> None:
    """From zero up to nine tenths of the positive numbers, in units of a power of ten that stands
    beside the panel."""
    values = slots.column_values([r for r in rows if not slots.at_end(r)])
    values = values[np.isfinite(values) & (values > 0)]
    greatest = float(np.quantile(values, HELD)) if values.size else 0.0
    exponent = int(np.floor(np.log10(greatest))) if greatest > 0 else 0
    scale = 10.0**exponent
    top = 1.12 * greatest / scale if greatest > 0 else 1.0
    linear_axis(axes, "y", (-0.08 * top, top), 5)
    slots.draw(axes, rows, cameras, lambda v: v / scale)
    if greatest > 0:
        text = f"×10{str(exponent).translate(SUPERSCRIPT)}"
        beside = 1 + 1.5 / slots.WIDE_MM, 1 - 5.0 / ROW_MM
        axes.text(*beside, text, transform=axes.transAxes, va="top", size=SMALL_PT, color=GREY)
