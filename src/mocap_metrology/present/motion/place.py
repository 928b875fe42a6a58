"""Noise by place: a map of a moving pair, and recordings of several places side by side."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.changes.compare import ratios_to_mean
from mocap_metrology.present.changes.compare import curve_of, series_of
from mocap_metrology.present.drawing.axes import linear_axis
from mocap_metrology.present.drawing.style import (
    GREY,
    SMALL_PT,
    WIDTH_MM,
    Keywords,
    blank_sheet,
    head,
    label_axes,
    styled,
    words_figure,
)
from mocap_metrology.present.tables import Record, Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import PathCollection
    from matplotlib.figure import Figure

LEFT_MM, GAP_MM, HEIGHT_MM, BAR_MM = 16.0, 26.0, 56.0, 3.0
CAPTION = (
    "Length of a pair of markers while it is carried through the volume, by cubes of {cell:g} mm: "
    "noise of one frame (Allan deviation at one frame, with its 95 % interval) and mean less that "
    "of the whole recording."
)
PLACES_CAPTION = (
    "Allan deviation of each recording over the geometric mean of all places, at one frame and at "
    "1 s, with 95 % intervals: `factor` above 1 is noisier than the mean, by more than chance "
    "where the interval is above 1, as in one of forty rows by chance alone. `quietest` has the "
    "smallest Allan deviation at one frame, be it by chance."
)


def place_sentence(even: Mapping[str, float]) -> str:
    """What the cells of a recording say together."""
    if math.isnan(even["worst_over_best"]):
        return "The pair stayed in one place."
    if math.isinf(even["worst_over_best"]):
        return (
            "In some cubes the length never changes: the file's steps are coarser than its noise."
        )
    differ = even["p"] < 0.01
    return (
        f"Noise of the length differs by a factor of {even['worst_over_best']:.2g} between places, "
        + ("more than chance" if differ else "no more than chance")
        + f" (p = {even['p']:.2g}); its mean scatters by {1000 * even['bend_mm']:.3g} µm (SD)."
    )


@styled()
def place_figure(rows: Sequence[Row], title: str, note: str) -> Figure:
    """Two maps from above: noise of the length, and deviation of its mean, a square a cell; of no
    cell only the words."""
    if not rows:
        return words_figure(note, title, "")
    sheet = blank_sheet(HEIGHT_MM + 16.0, title, note)
    width = (WIDTH_MM - LEFT_MM - GAP_MM - 18.0) / 2
    panels = (
        ("Noise of one frame (µm)", "sigma_mm", "viridis"),
        ("Mean less overall mean (µm)", "deviation_mm", "coolwarm"),
    )
    for k, (name, column, colours) in enumerate(panels):
        left = LEFT_MM + k * (width + GAP_MM)
        axes = sheet.axes(left, 5.0, width, HEIGHT_MM)
        scatter = _map(axes, rows, column, colours, (width, HEIGHT_MM))
        bar = sheet.axes(left + width + 2.0, 5.0, BAR_MM, HEIGHT_MM)
        sheet.figure.colorbar(scatter, cax=bar)
        head(axes, name)
        label_axes(axes, x="x (mm)", y="y (mm)" if k == 0 else "", y_mm=13.0)
    return sheet.figure


def _map(
    axes: Axes, rows: Sequence[Row], column: str, colours: str, size_mm: tuple[float, float]
) -> PathCollection:
    """Cells of all heights over x and y: the mean over the heights, weighted by frames."""
    cells: dict[tuple[float, float], list[Row]] = {}
    for row in rows:
        cells.setdefault((row["x_mm"], row["y_mm"]), []).append(row)
    x, y = np.array(list(cells)).T
    value = [
        1e3 * np.average([r[column] for r in own], weights=[r["n_frames"] for r in own])
        for own in cells.values()
    ]
    limits: Keywords = {}
    if column == "deviation_mm":
        reach = float(np.abs(value).max()) or 1.0
        limits = {"vmin": -reach, "vmax": reach}
    span = max(np.ptp(x), np.ptp(y), 1.0) * 1.25
    middle = (x.min() + x.max()) / 2, (y.min() + y.max()) / 2
    ratio = size_mm[0] / size_mm[1]
    linear_axis(axes, "x", (middle[0] - span * ratio / 2, middle[0] + span * ratio / 2), 5)
    linear_axis(axes, "y", (middle[1] - span / 2, middle[1] + span / 2), 6)
    steps = np.diff(np.unique(np.concatenate([x, y])))
    cell = float(steps[steps > 0].min()) if np.any(steps > 0) else span / 4
    side_pt = size_mm[1] / span * cell * 72 / 25.4 * 0.92
    dots = axes.scatter(x, y, c=value, s=side_pt**2, marker="s", cmap=colours, lw=0, **limits)
    if len(rows) > len(cells):
        text = f"{len(rows)} cells of several heights"
        axes.text(0.02, 0.02, text, transform=axes.transAxes, size=SMALL_PT, color=GREY)
    return dots


def places_rows(
    recordings: Sequence[Record],
    allan: Mapping[str, Mapping[str, np.ndarray]],
    means: Mapping[str, Mapping[str, float]],
) -> list[Row]:
    """One row a recording and series: where it was, its noise, and by what `factor` it exceeds the
    geometric mean of all places (`ratios_to_mean`), at one frame and at 1 s."""
    rows: list[Row] = []
    names = [row["recording"] for row in recordings]
    series = [s for s in series_of(allan[names[0]]) if all(s in series_of(allan[n]) for n in names)]
    for one in series:
        curves = {name: curve_of(allan[name], one).usable() for name in names}
        taus = np.array(
            [max([c.tau_s[0] for c in curves.values() if c.tau_s.size], default=0.0), 1.0]
        )
        at = {name: curve.at(taus) for name, curve in curves.items()}
        if not any(np.isfinite(a.adev[0]) for a in at.values()):
            continue
        best = min(names, key=lambda n: np.nan_to_num(at[n].adev[0], nan=np.inf))
        ratios = ratios_to_mean([curves[name] for name in names], taus)
        for row, ratio in zip(recordings, ratios, strict=True):
            name = row["recording"]
            values = {"recording": name, "place": row["place"], **means[name], "series": one}
            for k, label in enumerate(("1_frame", "1_s")):
                values[f"adev_{label}_mm"] = at[name].adev[k]
                values[f"factor_{label}"] = ratio.value[k]
                values[f"factor_{label}_lower"] = ratio.lower[k]
                values[f"factor_{label}_upper"] = ratio.upper[k]
            rows.append(values | {"quietest": name == best})
    if not rows:
        raise Refusal(f"{', '.join(names)}: expected a series that all places have")
    return rows
