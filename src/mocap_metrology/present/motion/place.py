"""Noise by place: a map of a moving pair, and recordings of several places side by side."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.changes.compare import ratios_to_mean
from mocap_metrology.present.changes.compare import curve_of, series_of
from mocap_metrology.present.plot.figure import (
    Keywords,
    Picture,
    letters,
    new_figure,
    panel_title,
    styled,
    words_picture,
)
from mocap_metrology.present.tables import Record, Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes

HEIGHT_MM = 62.0
CAPTION = (
    "Length of a pair of markers while it is carried through the volume, by cubes of {cell:g} "
    "mm: noise of one frame (Allan deviation at one frame, with its 95 % interval) and the mean "
    "minus that of the whole recording."
)
PLACES_CAPTION = (
    "Allan deviation of each recording over the geometric mean of all places, at one frame and "
    "at 1 s, with 95 % intervals: If `factor` is above 1, the recording is noisier than the "
    "mean, significantly so if its whole interval is above 1 (by chance alone this occurs in one "
    "row of forty). `quietest` has the smallest Allan deviation at one frame, which may be by "
    "chance."
)


def place_sentence(even: Mapping[str, float]) -> str:
    """One sentence on all cells of a recording."""
    if math.isnan(even["worst_over_best"]):
        return "The pair stayed in one place."
    if math.isinf(even["worst_over_best"]):
        return "In some cubes the length never changes: the steps of the file exceed the noise."
    differ = even["p"] < 0.01
    return (
        (
            f"Noise of the length differs by a factor of {even['worst_over_best']:.2g} between "
            "places: "
        )
        + ("not explained by chance" if differ else "explained by chance")
        + f" (p = {even['p']:.2g}); its mean scatters by {1000 * even['bend_mm']:.3g} µm (SD)."
    )


@styled()
def place_figure(rows: Sequence[Row], title: str, source: str, caption: str) -> Picture:
    """Two maps from above: noise of the length, and deviation of its mean, a square a cell; of no
    cell only the words of the caption."""
    if not rows:
        return words_picture(caption, title, source)
    body = new_figure(title, source, HEIGHT_MM + 22.0)
    panels = body.subplots(1, 2)
    _map(panels[0], rows, "sigma_mm", "viridis")
    _map(panels[1], rows, "deviation_mm", "coolwarm")
    panel_title(panels[0], "Noise of one frame (µm)")
    panel_title(panels[1], "Mean − overall mean (µm)")
    panels[0].set_ylabel("y (mm)")
    letters(panels)
    heights = len({row["z_mm"] for row in rows if "z_mm" in row})
    more = f" A square is the mean over cubes of {heights} heights." if heights > 1 else ""
    return Picture(body, f"{caption}{more}")


def _map(axes: Axes, rows: Sequence[Row], column: str, colours: str) -> None:
    """Cells of all heights over x and y: the mean over the heights, weighted by frames."""
    cells: dict[tuple[float, float], list[Row]] = {}
    for row in rows:
        cells.setdefault((row["x_mm"], row["y_mm"]), []).append(row)
    places = np.array(list(cells))
    values = [
        1e3 * np.average([r[column] for r in own], weights=[r["n_frames"] for r in own])
        for own in cells.values()
    ]
    x, y, image = _grid(places, np.array(values))
    limits: Keywords = {}
    if column == "deviation_mm":
        reach = float(np.nanmax(np.abs(image))) or 1.0
        limits = {"vmin": -reach, "vmax": reach}
    squares = axes.pcolormesh(x, y, image, cmap=colours, edgecolor="white", lw=0.8, **limits)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="x (mm)")
    axes.figure.colorbar(squares, ax=axes, pad=0.02)


def _grid(places: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Edges along x and y, and the image, NaN where there is no cell. places: (k, 2) centres, on a
    square grid."""
    steps = np.concatenate([np.diff(np.unique(own)) for own in places.T])
    cell = float(steps[steps > 0].min()) if steps.size else 1.0
    first = places.min(axis=0)
    column, row = np.round((places - first) / cell).astype(int).T
    image = np.full((int(row.max()) + 1, int(column.max()) + 1), np.nan)
    image[row, column] = values
    x, y = (first[k] + cell * (np.arange(n + 1) - 0.5) for k, n in enumerate(image.shape[::-1]))
    return x, y, image


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
