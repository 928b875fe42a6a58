"""Ratios of Allan deviations over averaging time, a row of panels a comparison."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.changes.compare import Ratio, adev_ratio
from mocap_metrology.present.changes.compare import Columns, curve_of, series_of
from mocap_metrology.present.drawing.axes import decade_axis, log_limits
from mocap_metrology.present.drawing.curves import look_of
from mocap_metrology.present.drawing.legend import Entry, strip, strip_height
from mocap_metrology.present.drawing.style import (
    GREY,
    INK,
    SMALL_PT,
    WIDTH_MM,
    Look,
    Sheet,
    blank_sheet,
    coordinate_of,
    head,
    label_axes,
    styled,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST = 6  # comparisons on a page; more are in the table
HEIGHT_MM, GAP_MM, LEFT_MM, TITLE_MM = 34.0, 5.0, 15.0, 5.5
LABELS_MM = 10.0
N_TAUS = 60
MARGIN = "#efd98f"


@dataclass(frozen=True)
class Comparison:
    """A recording beside the one it is held against: names, columns of `allan_masked.parquet`."""

    recording: str
    reference: str
    new: Columns
    old: Columns


@styled()
def compare_figure(
    comparisons: Sequence[Comparison], margin: float, confidence: float, title: str, note: str
) -> Figure:
    """Panels of marker 1, marker 2 (and more: all in one), distances; a row a comparison, the
    last `MOST` of them. Above 1 the recording is noisier; the band is the margin within which a
    change counts for none."""
    shown = comparisons[-MOST:]
    if len(shown) < len(comparisons):
        note += f" The last {MOST} of {len(comparisons)} comparisons; all are in the table."
    curves = [_ratios(c, confidence) for c in shown]
    columns = panels_of(list(dict.fromkeys(s for found in curves for s in found)))
    limits = (
        log_limits([r.tau_s for found in curves for r in found.values()]),
        _ratio_limits([r for found in curves for r in found.values()], margin),
    )
    entries = _key(columns, margin, confidence)
    width = WIDTH_MM - LEFT_MM - 3.0
    key_mm = strip_height(entries, width) + 2.0
    sheet = blank_sheet(key_mm + len(shown) * (HEIGHT_MM + TITLE_MM + 1.5) + LABELS_MM, title, note)
    strip(sheet, LEFT_MM, 0.5, width, entries)
    for k, (comparison, found) in enumerate(zip(shown, curves, strict=True)):
        top = key_mm + k * (HEIGHT_MM + TITLE_MM + 1.5) + TITLE_MM
        _row(sheet, top, comparison, found, columns, limits, margin, k == len(shown) - 1)
    return sheet.figure


def _ratios(comparison: Comparison, confidence: float) -> dict[str, Ratio]:
    found = {}
    both = [s for s in series_of(comparison.new) if s in series_of(comparison.old)]
    for series in both:
        new, old = (curve_of(c, series).usable() for c in (comparison.new, comparison.old))
        if not (new.tau_s.size and old.tau_s.size):
            continue
        low = max(new.tau_s[0], old.tau_s[0])
        high = min(new.tau_s[-1], old.tau_s[-1])
        if high > low:
            found[series] = adev_ratio(new, old, np.geomspace(low, high, N_TAUS), confidence)
    return found


def panels_of(series: Sequence[str]) -> dict[str, list[str]]:
    """Titles and series of the panels of a row: two markers and the distances, or all markers."""
    markers: dict[str, list[str]] = {}
    for name in series:
        place = coordinate_of(name)
        markers.setdefault(f"Marker {place[1]}" if place else "Distances", []).append(name)
    if len(markers) <= 3:
        return markers
    distances = markers.pop("Distances", [])
    return {"Markers": [s for own in markers.values() for s in own], "Distances": distances}


def _ratio_limits(ratios: Sequence[Ratio], margin: float) -> tuple[float, float]:
    """About the ratios themselves, 1 and its margin; wide intervals at long tau may leave."""
    values = np.concatenate([r.value for r in ratios] or [np.ones(1)])
    values = np.log(values[np.isfinite(values)])
    reach = max(np.abs(values).max(initial=0.0) * 1.25, 3 * np.log1p(margin))
    low = min(values.min(initial=0.0) * 1.25, -0.3 * reach)
    high = max(values.max(initial=0.0) * 1.25, 0.3 * reach)
    return float(np.exp(low)), float(np.exp(high))


def _key(columns: Mapping[str, Sequence[str]], margin: float, confidence: float) -> list[Entry]:
    axes = [a for a in "xyz" if any(s[0] == a for t, own in columns.items() for s in own)]
    others = list(columns.get("Distances", ()))
    looks = {axis: look_of(f"{axis}1", ()) for axis in axes}
    looks |= {name: look_of(name, others) for name in others}
    entries = [
        Entry(name, line={"color": look.colour, "ls": look.dashes}) for name, look in looks.items()
    ]
    band = {"color": GREY, "alpha": 0.25, "lw": 0}
    entries.append(Entry(f"{100 * confidence:.3g} % interval", patch=band))
    entries.append(
        Entry(f"no change: within {100 * margin:.3g} %", patch={"color": MARGIN, "lw": 0})
    )
    return entries


def _row(
    sheet: Sheet,
    top: float,
    comparison: Comparison,
    found: Mapping[str, Ratio],
    columns: Mapping[str, list[str]],
    limits: tuple[tuple[float, float], tuple[float, float]],
    margin: float,
    lowest: bool,
) -> None:
    width = (WIDTH_MM - LEFT_MM - 3.0 - GAP_MM * (len(columns) - 1)) / len(columns)
    for k, (title, series) in enumerate(columns.items()):
        axes = sheet.axes(LEFT_MM + k * (width + GAP_MM), top, width, HEIGHT_MM)
        decade_axis(axes, "x", limits[0], width)
        _ratio_axis(axes, limits[1])
        axes.tick_params(labelbottom=lowest, labelleft=k == 0)
        axes.axhspan(1 / (1 + margin), 1 + margin, color=MARGIN, lw=0, zorder=0)
        axes.axhline(1, color=INK, lw=0.6, zorder=1)
        for name in (s for s in series if s in found):
            _draw(axes, found[name], look_of(name, columns.get("Distances", [])), limits[1])
        axes.text(0.02, 0.97, title, transform=axes.transAxes, va="top", size=SMALL_PT, color=GREY)
        if k == 0:
            head(axes, f"{comparison.recording} / {comparison.reference}")
        if lowest:
            label_axes(axes, x="Averaging time τ (s)")
        if k == 0:
            label_axes(axes, y="ADEV ratio")


def _draw(axes: Axes, ratio: Ratio, look: Look, limits: tuple[float, float]) -> None:
    low, high = (np.clip(v, limits[0] / 2, limits[1] * 2) for v in (ratio.lower, ratio.upper))
    axes.fill_between(ratio.tau_s, low, high, color=look.colour, alpha=0.13, lw=0)
    axes.plot(ratio.tau_s, ratio.value, color=look.colour, ls=look.dashes, lw=1.1)


def _ratio_axis(axes: Axes, limits: tuple[float, float]) -> None:
    """Logarithmic, with ticks at round ratios."""
    from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

    axes.set_yscale("log")
    axes.set_ylim(limits)
    span = limits[1] / limits[0]
    steps = (
        [0.001, 0.01, 0.1, 1, 10, 100, 1000]
        if span > 200
        else [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50]
        if span > 6
        else [0.25, 0.33, 0.5, 0.67, 0.8, 1, 1.25, 1.5, 2, 3, 4]
        if span > 1.6
        else [0.8, 0.9, 0.95, 1, 1.05, 1.1, 1.25]
    )
    axes.yaxis.set_major_locator(FixedLocator([s for s in steps if limits[0] <= s <= limits[1]]))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _position: f"{value:g}"))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.grid(True)
