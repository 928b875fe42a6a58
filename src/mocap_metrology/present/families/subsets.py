"""S Figure 12: families of Allan deviations by number of cameras, a row a camera type."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.present.drawing.curves import Curve, Panel, draw_panel
from mocap_metrology.present.drawing.decades import Limits, decade_axis
from mocap_metrology.present.drawing.legend import Entry, strip, strip_height
from mocap_metrology.present.drawing.style import (
    FAINT,
    GREY,
    MARGIN_MM,
    WIDTH_MM,
    Look,
    Sheet,
    blank_sheet,
    head,
    label_axes,
    styled,
)
from mocap_metrology.present.families.adev import adev_limits
from mocap_metrology.present.families.members import count_looks, curve_of
from mocap_metrology.present.families.slots import look_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SERIES = ("x1", "x2", "L")
SLICE_S = 10.0  # averaging time of the panel against the number of cameras
DROPS = {"T40": 3, "Bonita": 5, "Vantage": 4}  # S 4.3: "notably better suited" setups
LEFT_MM, GAP_MM, SLICE_GAP_MM, RIGHT_MM = 16.5, 4.0, 6.0, 3.0
PANEL_MM = (WIDTH_MM - LEFT_MM - RIGHT_MM - 2 * GAP_MM - SLICE_GAP_MM) / 4
TITLE_MM, ROW_MM, BETWEEN_MM, LABELS_MM = 5.5, 45.0, 2.5, 11.0
CAMERA_LIMITS = 1.4, 10.6
LAW = {"color": GREY, "lw": 0.8, "ls": (0, (1.2, 1.2))}
DROP = {"color": FAINT, "alpha": 0.8, "lw": 0}
SLICE_LOOKS = {
    "x1": look_of("x1"),
    "x2": Look("#cf4a2c", (0, (5, 1.6)), "s"),
    "L": look_of("L"),
}
Subsets = Mapping[int, Mapping[str, np.ndarray]]  # columns of allan.parquet by number of cameras


@dataclass(frozen=True)
class TypeRow:
    """One camera type: its family of curves of each series, and the limits they share."""

    name: str
    families: Mapping[str, Sequence[Curve]]
    limits: tuple[Limits, Limits]

    @classmethod
    def of(cls, name: str, subsets: Subsets) -> TypeRow:
        families = {
            series: [curve_of(subsets[n], series, str(n), False) for n in sorted(subsets)]
            for series in SERIES
        }
        return cls(name, families, adev_limits([c for f in families.values() for c in f]))


@styled()
def subsets_figure(types: Mapping[str, Subsets], title: str, note: str = "") -> Figure:
    """Allan deviations of x1, x2 and L by number of cameras, and at one averaging time against it.

    types: columns of allan.parquet by camera type and number of cameras. The column of the number
    that S calls notably better suited is shaded.
    """
    types = {name: subsets for name, subsets in types.items() if subsets}
    looks = {str(n): v for n, v in count_looks([n for s in types.values() for n in s]).items()}
    rows = [TypeRow.of(name, subsets) for name, subsets in types.items()]
    note = note if rows else f"No recording is of such a subset. {note}"
    entries, slices = _entries(looks)
    width = WIDTH_MM - 2 * MARGIN_MM
    key_top = len(rows) * (TITLE_MM + ROW_MM + BETWEEN_MM) - BETWEEN_MM + LABELS_MM
    body = key_top + strip_height(entries, width) + strip_height(slices, width) + 2.0
    sheet = blank_sheet(body, title, note)
    for k, row in enumerate(rows):
        _draw_row(sheet, k, row, looks, k == len(rows) - 1)
    strip(sheet, MARGIN_MM, key_top, width, entries)
    strip(sheet, MARGIN_MM, key_top + strip_height(entries, width) + 0.5, width, slices)
    return sheet.figure


def _entries(looks: Mapping[str, Look]) -> tuple[list[Entry], list[Entry]]:
    """Keys of the families and of the last column."""
    numbers = [
        Entry(f"{n} cameras" if k == 0 else n, look=v) for k, (n, v) in enumerate(looks.items())
    ]
    slices = [Entry(series, look=look) for series, look in SLICE_LOOKS.items()]
    slices += [Entry("∝ 1/√n", line=LAW), Entry("notably better suited (S 4.3)", patch=DROP)]
    return numbers, slices


def _draw_row(sheet: Sheet, k: int, row: TypeRow, looks: Mapping[str, Look], lowest: bool) -> None:
    top = TITLE_MM + k * (TITLE_MM + ROW_MM + BETWEEN_MM)
    for column, (series, curves) in enumerate(row.families.items()):
        axes = sheet.axes(LEFT_MM + column * (PANEL_MM + GAP_MM), top, PANEL_MM, ROW_MM)
        decade_axis(axes, "x", row.limits[0], PANEL_MM)
        decade_axis(axes, "y", row.limits[1], ROW_MM)
        axes.tick_params(labelleft=column == 0, labelbottom=lowest)
        labels = axes.get_xticklabels()
        if len(labels) > 1:  # those of neighbours would touch
            labels[0].set_ha("left")
            labels[-1].set_ha("right")
        draw_panel(axes, Panel(series, list(curves), looks), row.limits[1])
        head(axes, f"{row.name}: {series}" if column == 0 else series)
        label_axes(axes, x="τ (s)" if lowest else "")
        label_axes(axes, y="Allan deviation (mm)" if column == 0 else "", y_mm=13.5)
    left = LEFT_MM + 3 * PANEL_MM + 2 * GAP_MM + SLICE_GAP_MM
    axes = sheet.axes(left, top, PANEL_MM, ROW_MM)
    decade_axis(axes, "y", row.limits[1], ROW_MM)
    axes.tick_params(labelleft=False, labelbottom=lowest)
    _draw_slice(axes, row)
    head(axes, f"at τ = {SLICE_S:g} s")
    label_axes(axes, x="Cameras n" if lowest else "")


def at_tau(curve: Curve, tau_s: float) -> float:
    """Deviation at an averaging time, between two computed ones along the line in the figure; NaN
    beyond them."""
    known = np.isfinite(curve.y) & (curve.y > 0)
    if not known.any():
        return np.nan
    x, y = np.log(curve.x[known]), np.log(curve.y[known])
    return float(np.exp(np.interp(np.log(tau_s), x, y, left=np.nan, right=np.nan)))


def _draw_slice(axes: Axes, row: TypeRow) -> None:
    """Deviation at one averaging time against the number of cameras."""
    from matplotlib.ticker import MultipleLocator

    counts = np.array([int(curve.name) for curve in row.families[SERIES[0]]])
    axes.set_xlim(*CAMERA_LIMITS)
    axes.xaxis.set_major_locator(MultipleLocator(2))
    if DROPS.get(row.name) in counts:
        axes.axvspan(DROPS[row.name] - 0.35, DROPS[row.name] + 0.35, zorder=0, **DROP)
    for series, curves in row.families.items():
        look = SLICE_LOOKS[series]
        values = np.array([at_tau(curve, SLICE_S) for curve in curves])
        axes.plot(counts, values, look.marker, ls=look.dashes, color=look.colour, mfc="white")
        if series == "x1" and np.isfinite(values[-1]):
            n = np.linspace(counts[0], counts[-1])
            axes.plot(n, values[-1] * np.sqrt(n[-1] / n), **LAW, zorder=1)
