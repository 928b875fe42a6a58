"""S Figures 14 to 16: power-law and correlated noises against the number of cameras."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR, S_ESTIMATOR, unit_key
from mocap_metrology.noise.model.components import ALPHAS
from mocap_metrology.present.drawing.axes import Limits, decade_axis, linear_axis, log_limits
from mocap_metrology.present.drawing.legend import Entry, strip, strip_height
from mocap_metrology.present.drawing.style import (
    FAINT,
    GREY,
    INK,
    LOOKS,
    MARGIN_MM,
    SMALL_PT,
    WIDTH_MM,
    Keywords,
    Look,
    blank_sheet,
    head,
    label_axes,
    say,
    styled,
)
from mocap_metrology.present.groups import slots
from mocap_metrology.present.tables import Row
from mocap_metrology.present.text.coefficients import symbol, unit
from mocap_metrology.present.text.numbers import power_of_ten

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
        text = f"×{power_of_ten(exponent)}"
        beside = 1 + 1.5 / slots.WIDE_MM, 1 - 5.0 / ROW_MM
        axes.text(*beside, text, transform=axes.transAxes, va="top", size=SMALL_PT, color=GREY)


TITLE_MM, TERMS_ROW_MM, SCATTER_MM, TERMS_LABELS_MM = 5.5, 24.0, 52.0, 11.0
NOTE = (
    "A limit of q_c holds for a class of T_c; intervals are cut at an arrow a factor of "
    f"{slots.LONGEST:g} below their number. Dashed: ends of the range searched for T_c by "
    f"{S_ESTIMATOR}, where terms pile up that no T_c within it suits."
)
END: Keywords = {"color": INK, "lw": 0.7, "ls": (0, (4, 2)), "zorder": 0.8}
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
    entries, types = slots.key_entries(), _type_entries()
    block = slots.block_mm(TERMS_ROW_MM)
    key_top = TITLE_MM + 2 * block + 5.0
    second = key_top + strip_height(entries, width) + 4.0 + TITLE_MM
    last = second + SCATTER_MM + TERMS_LABELS_MM
    body = last + strip_height(types, width) + 1.5
    sheet = blank_sheet(body, title, f"{NOTE} {note}".strip())
    ends = searched_ends(rows)
    cameras = sorted({r["n_cameras"] for r in rows})
    for row, name in enumerate(("T_c", "q_c")):
        of_it = [r for r in rows if unit_key(r["parameter"].split(" ")[0]) == name]
        limits = slots.floor_limits(of_it)
        panels = slots.block_axes(
            sheet, TITLE_MM + row * block, TERMS_ROW_MM, f"{name} ({unit(name)})"
        )
        for camera_type, axes in zip(slots.TYPES, panels, strict=True):
            shown = [r for r in of_it if r["camera_type"] == camera_type]
            slots.camera_axis(axes, cameras, axes is panels[-1])
            slots.log_axis(axes, limits, TERMS_ROW_MM, labels=True)
            for end in ends if name == "T_c" else ():
                axes.axhline(end, **END)
            slots.draw(axes, shown, cameras, slots.raised)
        if row == 0:
            head(panels[0], "(a) By number of cameras")
        label_axes(panels[-1], x="Number of cameras" if row == 1 else "")
    strip(sheet, MARGIN_MM, key_top, width, entries)
    pairs = {source: term_pairs(rows, source) for source, _ in SOURCES}
    every = [pair for some in pairs.values() for pair in some]
    x_limits, (low, high) = (log_limits([np.array([p[k] for p in every])]) for k in (0, 1))
    of_scatter = x_limits, (low / 30, high * 10)  # room for the words
    for column, (source, name) in enumerate(SOURCES):
        axes = slots.panel_axes(sheet, column, second, SCATTER_MM)
        at_end = _at_end(rows, source) if source == "regenerated" else 0
        for end in ends if at_end else ():
            axes.axvline(end, 0.07, 0.91, **END)
        _scatter(axes, pairs[source], of_scatter, hollow=source == "published")
        axes.tick_params(labelleft=column == 0)
        label_axes(axes, x="T_c (s)", y=f"q_c ({unit('q_c')})" if column == 0 else "", y_mm=13.5)
        head(axes, f"(b) {name}" if column == 0 else name)
        how: Keywords = {"transform": axes.transAxes, "ha": "right", "va": "top", "size": SMALL_PT}
        text = f"{len(pairs[source])} terms" + (f", {at_end} at an end" if at_end else "")
        axes.text(0.98, 0.98, text, color=GREY, **how)
    strip(sheet, MARGIN_MM, last, width, types)
    return sheet.figure


def searched_ends(rows: Sequence[Row]) -> list[float]:
    """The T_c, in s, at which the search of S's estimator ended: shortest and longest."""
    found = [row["regenerated"] for row in rows if _ended(row, "regenerated")]
    return sorted({min(found), max(found)}) if found else []


def _ended(row: Row, source: str) -> bool:
    return str(row["parameter"]).startswith("T_c") and bool(row[f"{source}_status"] == "at_bound")


def _at_end(rows: Sequence[Row], source: str) -> int:
    return sum(_ended(row, source) for row in rows)


def term_pairs(rows: Sequence[Row], source: str) -> list[Pair]:
    """(T_c, q_c, camera type, supported) of every Gauss-Markov term that `source`, a column of
    `table_a`, has both numbers of; `supported` is False where one is less than its least standard
    error."""
    found: dict[tuple[str, int, str, str], dict[str, Row]] = {}
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
    entries.append(Entry("end of the range searched", line=END))
    return [*entries, Entry("classes of T_c (S 4.6)", patch=band)]


def _dot(look: Look, **how: object) -> Keywords:
    return {"color": look.colour, "marker": look.marker, "markersize": 3.2, "mew": 0.7} | how


def _scatter(
    axes: Axes, pairs: Sequence[Pair], limits: tuple[Limits, Limits], hollow: bool
) -> None:
    decade_axis(axes, "x", limits[0], slots.PANEL_MM)
    decade_axis(axes, "y", limits[1], SCATTER_MM)
    slots.shade_classes(axes, limits[0])
    for camera_type, look in CAMERAS.items():
        for fine in (False, True):
            own = [p for p in pairs if p[2] == camera_type and p[3] == fine]
            if own:
                how: Keywords = {"markerfacecolor": "none"} if hollow else {"mew": 0}
                how |= {"markersize": 3.6 if hollow else 3.0, "alpha": 1.0 if fine else slots.PALE}
                axes.plot(*np.array([p[:2] for p in own]).T, ls="", **_dot(look, **how))
