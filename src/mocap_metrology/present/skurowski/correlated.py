"""S Figure 16: correlated noises against the number of cameras, and q_c against T_c."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mocap_metrology.noise.estimates import CLASSES, DEFAULT_ESTIMATOR, S_ESTIMATOR, unit_key
from mocap_metrology.present.drawing.decades import Limits, decade_axis, log_limits
from mocap_metrology.present.drawing.legend import Entry, strip, strip_height
from mocap_metrology.present.drawing.style import (
    FAINT,
    GREY,
    LOOKS,
    MARGIN_MM,
    SMALL_PT,
    WIDTH_MM,
    Look,
    blank_sheet,
    head,
    label_axes,
    styled,
)
from mocap_metrology.present.families import slots
from mocap_metrology.present.numbers import unit
from mocap_metrology.present.tables import Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TITLE_MM, ROW_MM, SCATTER_MM, BETWEEN_MM, LABELS_MM = 5.5, 40.0, 52.0, 3.0, 11.0
CAMERAS = dict(zip(slots.TYPES, LOOKS.values(), strict=True))
SOURCES = (
    ("published", "published"),
    ("regenerated", S_ESTIMATOR),
    (DEFAULT_ESTIMATOR, DEFAULT_ESTIMATOR),
)
Pair = tuple[float, float, str, bool]  # T_c, q_c, camera type, supported


@styled()
def correlated_figure(rows: Sequence[Row], title: str, note: str = "") -> Figure:
    """S Figure 16 of the rows of `table_a` (of any camera types): (a) T_c and q_c against the
    number of cameras, (b) q_c against T_c with the classes of S 4.6 shaded, a panel a source."""
    rows = [row for row in rows if row["parameter"][1:3] == "_c"]
    width = WIDTH_MM - 2 * MARGIN_MM
    entries, types = slots.key_entries(limits=False), _type_entries()
    key_top = TITLE_MM + 2 * ROW_MM + BETWEEN_MM + LABELS_MM
    second = key_top + strip_height(entries, width) + 4.0 + TITLE_MM
    last = second + SCATTER_MM + LABELS_MM
    sheet = blank_sheet(last + strip_height(types, width) + 1.5, title, note)
    for row, name in enumerate(("T_c", "q_c")):
        of_it = [r for r in rows if unit_key(r["parameter"].split(" ")[0]) == name]
        limits = slots.floor_limits(of_it)
        for column, camera_type in enumerate(slots.TYPES):
            shown = [r for r in of_it if r["camera_type"] == camera_type]
            axes = slots.panel_axes(sheet, column, TITLE_MM + row * (ROW_MM + BETWEEN_MM), ROW_MM)
            cameras = sorted({r["n_cameras"] for r in shown})
            slots.camera_axis(axes, cameras, labels=row == 1)
            slots.log_axis(axes, limits, ROW_MM, labels=column == 0)
            slots.draw(axes, shown, cameras, slots.raised)
            label_axes(
                axes,
                x="Number of cameras" if row == 1 else "",
                y=f"{name} ({unit(name)})" if column == 0 else "",
                y_mm=13.5,
            )
            if row == 0:
                head(axes, f"(a) {camera_type}" if column == 0 else camera_type)
    strip(sheet, MARGIN_MM, key_top, width, entries)
    pairs = {source: term_pairs(rows, source) for source, _ in SOURCES}
    every = [pair for some in pairs.values() for pair in some]
    x_limits, (low, high) = (log_limits([np.array([p[k] for p in every])]) for k in (0, 1))
    limits = x_limits, (low / 30, high * 10)  # room for the words
    for column, (source, name) in enumerate(SOURCES):
        axes = slots.panel_axes(sheet, column, second, SCATTER_MM)
        _scatter(axes, pairs[source], limits, hollow=source == "published")
        axes.tick_params(labelleft=column == 0)
        label_axes(axes, x="T_c (s)", y=f"q_c ({unit('q_c')})" if column == 0 else "", y_mm=13.5)
        head(axes, f"(b) {name}" if column == 0 else name)
        how = {"transform": axes.transAxes, "ha": "right", "va": "top", "size": SMALL_PT}
        axes.text(0.98, 0.98, f"{len(pairs[source])} terms", color=GREY, **how)
    strip(sheet, MARGIN_MM, last, width, types)
    return sheet.figure


def term_pairs(rows: Sequence[Row], source: str) -> list[Pair]:
    """(T_c, q_c, camera type, supported) of every Gauss-Markov term that `source`, a column of
    `table_a`, has both numbers of; `supported` is False where nine hours could not support one."""
    found: dict[tuple[Any, ...], dict[str, Row]] = {}
    for row in (r for r in rows if r["parameter"][1:3] == "_c"):
        key = row["camera_type"], row["n_cameras"], row["series"], row["parameter"][3:]
        found.setdefault(key, {})[row["parameter"][:3]] = row
    pairs = []
    for (camera_type, *_), term in found.items():
        if len(term) == 2 and all(row[source] is not None for row in term.values()):
            supported = not any(row["supported"] is False for row in term.values())
            fine = supported or source != "published"
            pairs.append((term["T_c"][source], term["q_c"][source], camera_type, fine))
    return pairs


def _type_entries() -> list[Entry]:
    entries = [
        Entry(name, dot=_dot(look, markerfacecolor="none")) for name, look in CAMERAS.items()
    ]
    entries.append(Entry("published", dot=_dot(Look(GREY, "-", "o"), markerfacecolor="none")))
    entries.append(Entry("regenerated", dot=_dot(Look(GREY, "-", "o"), mew=0)))
    band = {"color": FAINT, "alpha": 0.8, "lw": 0}
    return [*entries, Entry("classes of T_c (S 4.6)", patch=band)]


def _dot(look: Look, **how: Any) -> dict[str, Any]:
    return {"color": look.colour, "marker": look.marker, "markersize": 3.2, "mew": 0.7} | how


def shade_classes(axes: Axes, limits: Limits) -> None:
    """Shade the classes of T_c (S 4.6) on an axis of these limits, and name them."""
    for name, low, high in CLASSES:
        low, high = max(low, limits[0]), min(high, limits[1])
        if low >= high:
            continue
        axes.axvspan(low, high, color=FAINT, alpha=0.9 if name == "medium" else 0.5, lw=0, zorder=0)
        how = {"size": SMALL_PT, "color": GREY, "ha": "center", "va": "bottom"}
        place = axes.get_xaxis_transform()
        axes.text(float(np.sqrt(low * high)), 0.02, name, transform=place, **how)


def _scatter(
    axes: Axes, pairs: Sequence[Pair], limits: tuple[Limits, Limits], hollow: bool
) -> None:
    decade_axis(axes, "x", limits[0], slots.PANEL_MM)
    decade_axis(axes, "y", limits[1], SCATTER_MM)
    shade_classes(axes, limits[0])
    for camera_type, look in CAMERAS.items():
        for fine in (False, True):
            own = [p for p in pairs if p[2] == camera_type and p[3] == fine]
            if own:
                how = {"markerfacecolor": "none"} if hollow else {"mew": 0}
                how |= {"markersize": 3.0 if hollow else 2.6, "alpha": 1.0 if fine else slots.PALE}
                axes.plot(*np.array([p[:2] for p in own]).T, ls="", **_dot(look, **how))
