"""Figures 8, 12, 13 and A1 of S: recordings compared by their Allan deviations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.present.drawing.axes import Limits, decade_axis
from mocap_metrology.present.drawing.curves import Curve, Panel, draw_panel
from mocap_metrology.present.drawing.legend import Entry, strip, strip_height
from mocap_metrology.present.drawing.style import (
    FAINT,
    GREY,
    LOOKS,
    MARGIN_MM,
    OTHER_LOOKS,
    WIDTH_MM,
    Keywords,
    Look,
    Sheet,
    blank_sheet,
    head,
    label_axes,
    styled,
)
from mocap_metrology.present.groups.adev import adev_limits, compared_figure, panels_figure
from mocap_metrology.present.groups.members import count_looks, curve_of
from mocap_metrology.present.groups.slots import look_of
from mocap_metrology.present.skurowski.camera_tables import TABLE_4, standing_for
from mocap_metrology.present.skurowski.gather import PAPER
from mocap_metrology.present.tables import Record

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
LAW: Keywords = {"color": GREY, "lw": 0.8, "ls": (0, (1.2, 1.2))}
DROP: Keywords = {"color": FAINT, "alpha": 0.8, "lw": 0}
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
            labels[0].set_horizontalalignment("left")
            labels[-1].set_horizontalalignment("right")
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


TITLES = {
    7: f"{PAPER}, Figure 7: a seismic crump",
    8: f"{PAPER}, Figure 8: Vantage with and without the failing camera",
    12: f"{PAPER}, Figure 12: Allan deviation by number of cameras",
    13: f"{PAPER}, Figure 13: Allan deviation by camera type",
    "A1": f"{PAPER}, Figure A1: z1 after the failing camera was replaced",
}
NOTE_A1 = "S's own: nine hours before the repair, a length it does not state after it."
TYPES = ("T40", "Bonita", "Vantage")
TYPE_LOOKS = dict(zip((*TYPES, "All"), (*LOOKS.values(), OTHER_LOOKS[0]), strict=True))
SERIES_A1 = "z1"
ALL_NOTE = (
    "No coefficients were published of all cameras: their twin is T40-10 with x1 and x2 made to "
    "meet Table 4, y and z as they are."
)
Rows = Mapping[str, Record]
Allan = Mapping[str, Mapping[str, np.ndarray]]  # columns of allan.parquet by recording


def subsets_of(rows: Rows) -> dict[str, dict[int, str]]:
    """Recordings of Figure 12 by camera type and number of cameras, without the failing camera."""
    return {
        kind: {
            n: name
            for n in sorted({r["n_cameras"] for r in rows.values() if r["camera_type"] == kind})
            if n <= TABLE_4[kind] and (name := standing_for(rows, kind, n)) is not None
        }
        for kind in TYPES
    }


def numbers_figure(rows: Rows, allan: Allan, note: str) -> Figure:
    """S Figure 12: each camera type by number of cameras."""
    columns = {
        kind: {n: allan[name] for n, name in names.items()}
        for kind, names in subsets_of(rows).items()
    }
    return subsets_figure(columns, TITLES[12], f"Vantage without the failing camera. {note}")


def failing_figure(rows: Rows, allan: Allan, note: str, confidence: float) -> Figure | None:
    """S Figure 8: ten Vantage cameras, one of them failing, against nine; None without both."""
    ten, nine = (standing_for(rows, "Vantage", n) for n in (10, 9))
    if ten is None or nine is None:
        return None
    shown = {
        "10 cameras, one failing": (allan[ten], LOOKS["y"]),
        "9 cameras, without it": (allan[nine], LOOKS["x"]),
    }
    return compared_figure(shown, SERIES, TITLES[8], note, confidence)


def types_figure(rows: Rows, allan: Allan, note: str, confidence: float) -> Figure:
    """S Figure 13: all sound cameras of each type, and of all types."""
    names = {kind: standing_for(rows, kind, n) for kind, n in TABLE_4.items()}
    shown = {
        f"{kind} ({TABLE_4[kind]})": (allan[name], TYPE_LOOKS[kind])
        for kind, name in names.items()
        if name is not None
    }
    text = f"{_remark(rows, names['All'])} {note}"
    return compared_figure(shown, SERIES, TITLES[13], text, confidence)


def _remark(rows: Rows, name: str | None) -> str:
    """What must be known of the recording of all cameras, if it is a twin."""
    return "" if name is None or rows[name]["twin"] is None else ALL_NOTE


@styled()
def repaired_figure(rows: Rows, others: Rows, allan: Allan, note: str, confidence: float) -> Figure:
    """S Figure A1: z1 of every camera type after the repair, and left of it of those that the
    sheet compares them with.

    rows: of the repaired recordings; others: of those named in their `compare_with`; allan: of all
    of them.
    """
    looks = {
        _label(row): TYPE_LOOKS.get(row["camera_type"], OTHER_LOOKS[1]) for row in rows.values()
    }
    after = {_label(row): name for name, row in rows.items()}
    before = {
        _label(row): row["compare_with"] for row in rows.values() if row["compare_with"] in others
    }
    panels = [
        Panel(title, [curve_of(allan[n], SERIES_A1, k, True) for k, n in names.items()], looks)
        for title, names in (("Before the repair", before), ("After the repair", after))
        if names
    ]
    remarks = [f"{name}: {row['comment']}." for name, row in rows.items() if row["comment"]]
    remarks.append(_remark(rows, standing_for(rows, "All", TABLE_4["All"])))
    text = f"{' '.join(remarks)} {note} {NOTE_A1}"
    return panels_figure(panels, TITLES["A1"], text, confidence)


def guess_a1(limits_s: Sequence[float]) -> str:
    """What repaired twins lack: Gauss-Markov terms below these T_c."""
    said = " or ".join(f"{limit:g} s" for limit in dict.fromkeys(limits_s))
    return (
        "S prints no coefficients after the repair, so what it takes from a twin is a guess: "
        f"correlated noise of T_c below {said}."
    )


def _label(row: Record) -> str:
    return f"{row['camera_type']} ({row['n_cameras']})"
