"""Noise of an orientation: rows and figure."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from mocap_metrology.common.types import Record
from mocap_metrology.noise.motion.orientation import AXES, TURNS_RAD, Orientation, rms
from mocap_metrology.present.plot import curves
from mocap_metrology.present.plot import figure as plot
from mocap_metrology.present.recording import source_words
from mocap_metrology.present.tables import Row
from mocap_metrology.present.text import captions

HEIGHT_MM = 84.0
MAPS = {  # title and colours of each column that is drawn
    "sigma_mm": ("Noise of one frame (µm)", "viridis"),
    "deviation_mm": ("Mean − overall mean (µm)", "coolwarm"),
}
SENTENCE = (
    "Noise of the length differs by a factor of {factor:.2g} between places: {explained} by chance "
    "(p = {p:.2g}); its mean scatters by {bend_um:.3g} µm (SD)."
)


@plot.styled()
def orientation_figure(
    allan: Mapping[str, np.ndarray],
    orientation: Orientation,
    origin: Record,
    cluster: Sequence[str],
    refused: str,
) -> plot.Picture:
    """Allan deviation of the three components of the rotation vector, with intervals; or the words
    why there is none (`refused`)."""
    title = f"{origin['recording']}: Allan deviation of orientation"
    source = f"Source: {source_words(origin)}."
    if refused:
        return plot.words_picture(refused, title, source)
    words = [captions.ORIENTATION]
    residual = rms(orientation.residual_mm)
    if residual is not None:
        words.append(
            f"Cluster: {', '.join(cluster)} (Kabsch, frame by frame). The markers are "
            f"{orientation.spread_mm:.0f} mm from their centre (rms) and {1000 * residual:.3g} µm "
            "off a rigid body (rms)."
        )
    if orientation.range_rad > TURNS_RAD:
        degrees = np.degrees(orientation.range_rad)
        words.append(f"It turns by {degrees:.3g} degrees: the figure shows motion, not noise.")
    adev = curves.adev_curves(allan, {axis: axis for axis in AXES}, unit="rad")
    adev[["y", "lower", "upper"]] *= 1e6
    return curves.curves_picture(
        {"Orientation": adev},
        (title, source, " ".join(words)),
        origin["allan"]["confidence"],
        y_label="Allan deviation (µrad)",
        looks={f"r{axis}": look for axis, look in plot.LOOKS.items()},
    )


def place_sentence(even: Mapping[str, float]) -> str:
    """One sentence on all cells of a recording."""
    factor, p = even["worst_over_best"], even["p"]
    if math.isnan(factor):
        return "The pair stayed in one place."
    if math.isinf(factor):
        return "In some cubes the length never changes: the steps of the file exceed the noise."
    explained = "not explained" if p < 0.01 else "explained"
    bend_um = 1000 * even["bend_mm"]
    return SENTENCE.format(factor=factor, explained=explained, p=p, bend_um=bend_um)


@plot.styled()
def place_figure(rows: Sequence[Row], title: str, source: str, caption: str) -> plot.Picture:
    """Two maps from above: noise of the length, and deviation of its mean, a square a cell (the
    mean over the heights, weighted by frames); of no cell only the words of the caption."""
    if not rows:
        return plot.words_picture(caption, title, source)
    table = pd.DataFrame(rows)
    table[list(MAPS)] *= 1e3
    steps = np.concatenate([np.diff(np.unique(table[axis])) for axis in ("x_mm", "y_mm")])
    cell = float(steps.min(initial=np.inf)) if steps.size else 1.0
    x, y = (np.arange(c.min(), c.max() + cell / 2, cell) for c in (table["x_mm"], table["y_mm"]))
    body = plot.new_figure(title, source, HEIGHT_MM)
    panels = body.subplots(1, 2)
    for axes, (column, (name, colours)) in zip(panels, MAPS.items(), strict=True):
        weighted = table.assign(value=table[column] * table["n_frames"])
        sums = weighted.groupby(["y_mm", "x_mm"])[["value", "n_frames"]].sum()
        image = (sums["value"] / sums["n_frames"]).unstack()
        image = image.reindex(index=y, columns=x, method="nearest", tolerance=cell / 4)
        reach = float(np.nanmax(np.abs(image.to_numpy()))) or 1.0
        limits = {"vmin": -reach, "vmax": reach} if column == "deviation_mm" else {}
        how: plot.Keywords = {"cmap": colours, "edgecolor": "white", "lw": 0.8, **limits}
        edges = (np.append(c - cell / 2, c[-1] + cell / 2) for c in (x, y))
        squares = axes.pcolormesh(*edges, image, **how)
        axes.set_aspect("equal", adjustable="datalim")
        axes.set_xlabel("x (mm)")
        axes.figure.colorbar(squares, ax=axes, pad=0.02)
        plot.panel_title(axes, name)
    panels[0].set_ylabel("y (mm)")
    plot.letters(panels)
    heights = len({row["z_mm"] for row in rows if "z_mm" in row})
    more = f" A square is the mean over cubes of {heights} heights." if heights > 1 else ""
    return plot.Picture(body, f"{caption}{more}")
