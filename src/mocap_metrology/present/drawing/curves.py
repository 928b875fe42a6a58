"""Panels of log-log curves of one recording: a panel a marker, one for the distances, and a key.

With more than six markers a panel holds one coordinate of all markers instead.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.present.drawing.axes import Limits, decade_axis, slope_fan
from mocap_metrology.present.drawing.legend import Entry, columns_of
from mocap_metrology.present.drawing.style import (
    GREY,
    LOOKS,
    OTHER_LOOKS,
    SMALL_PT,
    WIDTH_MM,
    Keywords,
    Look,
    Sheet,
    blank_sheet,
    coordinate_of,
    head,
    label_axes,
    lines_mm,
    shorten,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_MARKERS = 6  # with a panel each
MOST_SINGLE = len(OTHER_LOOKS)  # curves in one panel that can be told apart
LEFT_MM, RIGHT_MM, GAP_MM = 16.5, 3.0, 7.0
TITLE_MM, LABELS_MM = 5.5, 10.0
MOST_VECTORS = 60  # lines of a family; more become an image
SLOPES_BESIDE_MM = 90.0  # a key this wide has its slopes beside the entries, else below
NAME_MM = 34.0  # of a series or recording, in the key
NOTHING = "no valid samples"


@dataclass(frozen=True)
class Curve:
    """One line: x, y (k,); `band` between two such arrays, or None, its upper edge drawn if
    `outlined`; `extra`: (name, x, y) of the same series by other estimators, drawn thin."""

    name: str
    x: np.ndarray
    y: np.ndarray
    band: tuple[np.ndarray, np.ndarray] | None = None
    outlined: bool = False
    extra: tuple[tuple[str, np.ndarray, np.ndarray], ...] = ()

    @property
    def drawable(self) -> bool:
        return bool(np.any(np.isfinite(self.y) & (self.y > 0)))


@dataclass(frozen=True)
class Key:
    """What the key says: `band` explains the shaded band, `extras` the thin lines; `slopes` (as
    in `slope_fan`) are those of `slopes_of`."""

    slopes: Sequence[tuple[float, str]]
    slopes_of: str
    band: str
    extras: Sequence[str] = ()


@dataclass
class Panel:
    """Curves under one title; a family when there are too many to tell apart. `looks` by name of a
    curve; without them curves are series, which have their own."""

    title: str
    curves: list[Curve] = field(default_factory=list)
    looks: Mapping[str, Look] = field(default_factory=dict)

    @property
    def family(self) -> bool:
        return len(self.curves) > MOST_SINGLE and not self.looks

    def look(self, name: str) -> Look:
        others = [c.name for c in self.curves if not coordinate_of(c.name)]
        return self.looks.get(name) or look_of(name, others)

    def called(self, name: str) -> str:
        """Name of a curve in the key: markers share one for each coordinate."""
        return name[0] if not self.looks and coordinate_of(name) else name


EXTRA_DASHES = {"mdev": (0, (1, 1.2)), "hdev": (0, (3, 1.2, 1, 1.2))}


def arrange(curves: Sequence[Curve]) -> list[Panel]:
    """A panel a marker (or a coordinate, with many markers), then one of all other series."""
    markers: dict[int, list[Curve]] = {}
    others = Panel("Distance")
    for curve in curves:
        found = coordinate_of(curve.name)
        if found:
            markers.setdefault(found[1], []).append(curve)
        else:
            others.curves.append(curve)
    if len(others.curves) > 1:
        others.title = "Distances"
    panels = [Panel(f"Marker {k}", markers[k]) for k in sorted(markers)]
    if len(markers) > MOST_MARKERS:
        each = [curve for panel in panels for curve in panel.curves]
        panels = [Panel(axis, [curve for curve in each if curve.name[0] == axis]) for axis in LOOKS]
    panels += [others] if others.curves else []
    return [panel for panel in panels if panel.curves] or [Panel("")]


def look_of(name: str, others: Sequence[str]) -> Look:
    """The look of a series; `others` are the panel's series that are no coordinates, in order."""
    if coordinate_of(name):
        return LOOKS[name[0]]
    return OTHER_LOOKS[others.index(name) % len(OTHER_LOOKS)]


@dataclass(frozen=True)
class Grid:
    """Cells of equal size, in mm; the last one is the key's, as wide as what is left of its row."""

    n_panels: int

    @property
    def n_columns(self) -> int:
        return 2 if self.n_panels == 3 else 3

    @property
    def n_rows(self) -> int:
        return 1 if self.n_panels == 1 else -(-(self.n_panels + 1) // self.n_columns)

    @property
    def cell(self) -> tuple[float, float]:
        """Width and height of a panel."""
        free = WIDTH_MM - LEFT_MM - RIGHT_MM - GAP_MM * (self.n_columns - 1)
        width = free / self.n_columns
        if self.n_panels == 1:
            return 2 * width + GAP_MM, 62.0
        return width, 54.0 if self.n_columns == 2 else 46.0

    def corner(self, k: int) -> tuple[float, float]:
        """Left and top of cell k."""
        row, column = divmod(k, self.n_columns)
        width, height = self.cell
        return LEFT_MM + column * (width + GAP_MM), TITLE_MM + row * (height + TITLE_MM + 1.0)

    def lowest(self, k: int) -> bool:
        """Whether no panel lies below cell k."""
        return k + self.n_columns >= self.n_panels

    @property
    def key_box(self) -> tuple[float, float, float, float]:
        """Left, top, width, height of the key."""
        left, top = self.corner(self.n_panels)
        height = self.cell[1]
        below_labels = LABELS_MM if self.n_panels >= self.n_columns else 0.0
        right = WIDTH_MM - RIGHT_MM
        return left + 2.0, top + below_labels, right - left - 2.0, height - below_labels

    @property
    def height(self) -> float:
        return self.corner((self.n_rows - 1) * self.n_columns)[1] + self.cell[1] + LABELS_MM


def curves_figure(
    panels: Sequence[Panel],
    axis_labels: tuple[str, str],
    limits: tuple[Limits, Limits],
    key: Key,
    title: str,
    note: str,
) -> Figure:
    """Figure of the panels on common axes with the key in the last cell."""
    grid = Grid(len(panels))
    sheet = blank_sheet(grid.height, title, note)
    width, height = grid.cell
    for k, panel in enumerate(panels):
        axes = sheet.axes(*grid.corner(k), width, height)
        decade_axis(axes, "x", limits[0], width)
        decade_axis(axes, "y", limits[1], height)
        axes.tick_params(labelbottom=grid.lowest(k), labelleft=k % grid.n_columns == 0)
        if grid.lowest(k):
            label_axes(axes, x=axis_labels[0])
        if k % grid.n_columns == 0:
            label_axes(axes, y=axis_labels[1], y_mm=13.5)
        draw_panel(axes, panel, limits[1])
        head(axes, panel.title, "; ".join(_remarks(panel, limits[1])))
    across, up = (float(np.log10(high / low)) for low, high in limits)
    decade_mm = width / across, height / up
    _draw_key(sheet, grid.key_box, panels, key, decade_mm)
    return sheet.figure


def draw_panel(axes: Axes, panel: Panel, y_limits: Limits) -> None:
    if not any(curve.drawable for curve in panel.curves):
        known = any(np.isfinite(curve.y).any() for curve in panel.curves)
        middle: Keywords = {
            "transform": axes.transAxes,
            "ha": "center",
            "va": "center",
            "color": GREY,
        }
        axes.text(0.5, 0.5, "all zero" if known else NOTHING, **middle)
    elif panel.family:
        _draw_family(axes, panel.curves)
    else:
        for order, curve in enumerate(panel.curves):
            _draw_curve(axes, curve, panel.look(curve.name), order, y_limits)


def _positive(values: np.ndarray) -> np.ndarray:
    return np.where(np.isfinite(values) & (values > 0), values, np.nan)


def _draw_curve(axes: Axes, curve: Curve, look: Look, order: int, y_limits: Limits) -> None:
    y = _positive(curve.y)
    if curve.band is not None:
        low, high = curve.band
        with np.errstate(invalid="ignore"):
            shown = np.isfinite(y) & ~np.isnan(low) & ~np.isnan(high)
            low = np.clip(low, y_limits[0] / 10, y_limits[1] * 10)
            high = np.clip(high, y_limits[0] / 10, y_limits[1] * 10)
        axes.fill_between(curve.x, low, high, where=shown, color=look.colour, alpha=0.18, lw=0)
        if curve.outlined:
            axes.plot(curve.x, np.where(shown, high, np.nan), color=look.colour, lw=0.5)
    for name, x, values in curve.extra:
        axes.plot(x, _positive(values), color=look.colour, ls=EXTRA_DASHES[name], lw=0.8, alpha=0.7)
    every = max(curve.x.size // 8, 1)
    axes.plot(
        curve.x,
        y,
        color=look.colour,
        ls=look.dashes,
        lw=0.9 if curve.outlined else 1.2,
        marker=look.marker,
        markevery=1 if curve.x.size <= 15 else (every * order // 3 % every, every),
        markerfacecolor="white",
    )


def family_ends(curves: Sequence[Curve]) -> tuple[Curve, Curve] | None:
    """Lowest and highest curve, by the median of log y."""
    drawable = [curve for curve in curves if curve.drawable]
    if not drawable:
        return None
    level = [np.nanmedian(np.log(_positive(curve.y))) for curve in drawable]
    return drawable[int(np.argmin(level))], drawable[int(np.argmax(level))]


FAMILY: dict[str, Keywords] = {
    "median": {"color": "#111111", "lw": 1.5, "ls": "-"},
    "lowest": {"color": "#10307a", "lw": 1.1, "ls": (0, (5, 1.6))},
    "highest": {"color": "#cf4a2c", "lw": 1.1, "ls": (0, (6, 1.4, 1.4, 1.4))},
}
ONE: Keywords = {"color": "#9a9a9a", "lw": 0.5, "ls": "-"}


def _draw_family(axes: Axes, curves: Sequence[Curve]) -> None:
    for curve in curves:
        axes.plot(curve.x, _positive(curve.y), rasterized=len(curves) > MOST_VECTORS, **ONE)
    ends = family_ends(curves)
    for name, curve in zip(("lowest", "highest"), ends or (), strict=False):
        axes.plot(curve.x, _positive(curve.y), **FAMILY[name])
    x = np.unique(np.concatenate([curve.x for curve in curves]))
    table = np.full((len(curves), x.size), np.nan)
    for row, curve in zip(table, curves, strict=True):
        row[np.searchsorted(x, curve.x)] = _positive(curve.y)
    known = np.isfinite(table).sum(axis=0) * 2 >= len(curves)
    if known.any():
        axes.plot(x[known], np.nanmedian(table[:, known], axis=0), **FAMILY["median"])


def _remarks(panel: Panel, y_limits: Limits) -> list[str]:
    remarks: list[str] = []
    if panel.family and (ends := family_ends(panel.curves)) is not None:
        low, high = (_short(end.name) for end in ends)
        markers = all(coordinate_of(end.name) for end in ends)
        remarks.append(f"lowest: {low}, highest: {high}" if markers else f"{low} to {high}")
    if not any(curve.drawable for curve in panel.curves):
        return []
    why: dict[str, list[str]] = {}
    for curve in panel.curves:
        known = curve.y[np.isfinite(curve.y)]
        if not known.size:
            why.setdefault(NOTHING, []).append(curve.name)
        elif not known.max() > 0:
            why.setdefault("zero", []).append(curve.name)
        elif known.max() < y_limits[0]:
            why.setdefault("below the axis", []).append(curve.name)
    for reason, names in why.items():
        named = ", ".join(names) if len(names) <= 3 else f"{len(names)} series"
        # Names of recordings may be cut off, then the reason must not be
        remarks.append(f"{reason}: {named}" if panel.looks else f"{named}: {reason}")
    return remarks


def _short(name: str) -> str:
    found = coordinate_of(name)
    return str(found[1]) if found else name


def _draw_key(
    sheet: Sheet,
    box: tuple[float, float, float, float],
    panels: Sequence[Panel],
    key: Key,
    decade_mm: tuple[float, float],
) -> None:
    canvas = sheet.canvas(*box)
    width, height = box[2:]
    entries = _entries(panels, key)
    beside = width >= SLOPES_BESIDE_MM
    part = 0.45 * width if beside else width
    taken = columns_of(canvas, (part, height), entries)
    left, top = (part, height) if beside else (0.0, height - taken - 2.0)
    line = lines_mm(1, SMALL_PT)
    text = f"slopes of {key.slopes_of}"
    canvas.text(left, top - line / 2, text, size=SMALL_PT, va="center_baseline", color=GREY)
    slope_fan(canvas, (left, 0.0, width - left, top - line - 1.5), decade_mm, key.slopes)


def _entries(panels: Sequence[Panel], key: Key) -> list[Entry]:
    """The meaning of all that the panels show."""
    entries: list[Entry] = []
    for panel in (p for p in panels if not p.family):
        for curve in panel.curves:
            text = shorten(panel.called(curve.name), SMALL_PT, NAME_MM)
            if text not in {entry.text for entry in entries}:
                entries.append(Entry(text, look=panel.look(curve.name)))
    if any(c.band is not None for p in panels if not p.family for c in p.curves):
        entries.append(Entry(key.band, patch={"color": GREY, "alpha": 0.25, "lw": 0}))
    for name in key.extras if entries else ():
        how = {"color": GREY, "ls": EXTRA_DASHES[name], "lw": 0.8}
        entries.append(Entry(name, line=how))
    families = [len(panel.curves) for panel in panels if panel.family]
    if families:
        entries += [Entry(name, line=how) for name, how in FAMILY.items()]
        entries.append(Entry(f"one of {max(families)}", line=ONE))
    return entries
