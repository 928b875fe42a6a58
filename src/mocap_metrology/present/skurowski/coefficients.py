"""S Figures 14 and 15: power-law coefficients against the number of cameras."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.model import ALPHAS
from mocap_metrology.present.drawing.decades import SUPERSCRIPT
from mocap_metrology.present.drawing.legend import strip, strip_height
from mocap_metrology.present.drawing.linear import linear_axis
from mocap_metrology.present.drawing.style import (
    GREY,
    MARGIN_MM,
    SMALL_PT,
    WIDTH_MM,
    blank_sheet,
    head,
    label_axes,
    styled,
)
from mocap_metrology.present.families import slots
from mocap_metrology.present.numbers import symbol, unit
from mocap_metrology.present.tables import Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TITLE_MM, ROW_MM, BETWEEN_MM, LABELS_MM = 5.5, 36.0, 3.0, 11.0
ORDER = (
    "In each group from left to right: x1, y1, z1, x2, y2, z2, L. Published and regenerated "
    "numbers of one series stand in one line."
)


@styled()
def colour_figure(
    rows: Sequence[Row], title: str, note: str = "", *, logarithmic: bool = True
) -> Figure:
    """Coefficients h_-2 ... h_2 of the rows of `table_a` (of any camera types): S Figure 14
    (logarithmic) or 15 (linear, each panel to its own scale)."""
    entries = slots.key_entries()
    width = WIDTH_MM - 2 * MARGIN_MM
    key_top = TITLE_MM + len(ALPHAS) * (ROW_MM + BETWEEN_MM) - BETWEEN_MM + LABELS_MM
    body = key_top + strip_height(entries, width) + 1.5
    sheet = blank_sheet(body, title, f"{ORDER} {note}".strip())
    for row, alpha in enumerate(ALPHAS):
        name = f"h_{alpha}"
        of_it = [r for r in rows if r["parameter"].split(" ")[0] == name]
        limits = slots.floor_limits(of_it)
        for column, camera_type in enumerate(slots.TYPES):
            shown = [r for r in of_it if r["camera_type"] == camera_type]
            axes = slots.panel_axes(sheet, column, TITLE_MM + row * (ROW_MM + BETWEEN_MM), ROW_MM)
            lowest = row == len(ALPHAS) - 1
            cameras = sorted({r["n_cameras"] for r in rows if r["camera_type"] == camera_type})
            slots.camera_axis(axes, cameras, lowest)
            if logarithmic:
                slots.log_axis(axes, limits, ROW_MM, labels=column == 0)
                slots.draw(axes, shown, cameras, slots.raised)
            else:
                _linear(axes, shown, cameras)
            label_axes(
                axes,
                x="Number of cameras" if lowest else "",
                y=f"{symbol(name)} ({unit(name)})" if column == 0 else "",
                y_mm=13.5,
            )
            if row == 0:
                head(axes, camera_type)
            if not shown:
                how = {"transform": axes.transAxes, "ha": "center", "va": "center"}
                axes.text(0.5, 0.5, "no numbers", color=GREY, **how)
    strip(sheet, MARGIN_MM, key_top, width, entries)
    return sheet.figure


def _linear(axes: Axes, rows: Sequence[Row], cameras: Sequence[int]) -> None:
    """From zero to the greatest number, in units of a power of ten that the panel names."""
    values = slots.column_values(rows)
    values = values[np.isfinite(values)]
    greatest = float(values.max(initial=0.0))
    exponent = int(np.floor(np.log10(greatest))) if greatest > 0 else 0
    scale = 10.0**exponent
    top = 1.12 * greatest / scale if greatest > 0 else 1.0
    linear_axis(axes, "y", (-0.06 * top, top), 6)
    slots.draw(axes, rows, cameras, lambda v: v / scale)
    if greatest > 0:
        text = f"×10{str(exponent).translate(SUPERSCRIPT)}"
        how = {"transform": axes.transAxes, "ha": "right", "va": "top", "size": SMALL_PT}
        axes.text(0.985, 0.96, text, color=GREY, **how)
