"""Reference points: what they show in words, and from above and from the side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mocap_metrology.accuracy.points import Points
from mocap_metrology.present.plot import figure as plot
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import mm
from mocap_metrology.present.text.sentence import render

HEIGHT_MM = 150.0
SHOWN, LONGEST = 0.08, 0.4  # of the largest extent: the median arrow; none is longer


def sentences(document: Mapping[str, Any]) -> list[str]:
    """What contents of <group>_points.json show."""
    codes = document["findings"]
    said = ["headline", *codes, *([] if codes else ["no_scale"])]
    said += [key for key in ("wrong_point", "exchanged", "unsteady") if document[key]]
    if "does_not_fit" in codes and not (document["wrong_point"] or document["exchanged"]):
        said.insert(said.index("does_not_fit") + 1, "causes")
    return [render(f"points.{code}", **document) for code in said]


@plot.styled()
def points_figure(
    points: Points,
    off_mm: np.ndarray,
    labels: Sequence[str],
    cuts: Sequence[int],
    texts: plot.Texts,
) -> plot.Picture:
    """Arrows of the left-out points, enlarged alike in both views, and their sizes in the order in
    which they were taken; lines where the frame jumped."""
    body = plot.new_figure(texts, HEIGHT_MM)
    panels = body.subplot_mosaic([["above", "side"], ["size", "size"]], height_ratios=[1.6, 1.0])
    size = np.linalg.norm(off_mm, axis=1)
    extent = float(np.ptp(points.reference, axis=0).max())
    times = SHOWN * extent / max(float(np.median(size)), SHOWN / LONGEST * float(size.max()), 1e-9)
    look: plot.Keywords = {"angles": "xy", "scale_units": "xy", "scale": 1, "width": 0.004}
    for name, (a, b) in (("above", (0, 1)), ("side", (0, 2))):
        axes = panels[name]
        places, arrows = points.reference[:, [a, b]] / 1000, off_mm[:, [a, b]] * times / 1000
        axes.plot(*places.T, ".", color=plot.GREY, ms=4)
        axes.quiver(*places.T, *arrows.T, color=plot.LOOKS["y"].colour, **look)
        ends = np.concatenate([places, places + arrows])
        axes.update_datalim(ends)
        axes.autoscale_view()
        axes.set(xlabel=f"{'xyz'[a]} (m)", ylabel=f"{'xyz'[b]} (m)")
        axes.set_aspect("equal", adjustable="datalim")
        plot.panel_title(axes, f"{'xyz'[a]} and {'xyz'[b]}", f"arrows × {times:.3g}")
    axes = panels["size"]
    axes.bar(range(len(size)), size, color=plot.LOOKS["x"].colour, width=0.7)
    for cut in cuts:
        axes.axvline(cut - 0.5, color=plot.LOOKS["y"].colour, ls="--", lw=1.2)
    names = [plot.short(label, 8) for label in labels]
    axes.set_xticks(range(len(size)), names, rotation=90, fontsize=plot.SMALL_PT)
    axes.set(ylabel="left out (mm)", xlim=(-0.6, len(size) - 0.4))
    whole = mm(float(np.sqrt((size**2).mean())))
    remark = f"rms {whole}" + ("; dashed: the frame jumped" if cuts else "")
    plot.panel_title(axes, "In the order of their recording", remark)
    plot.letters(panels[name] for name in ("above", "side", "size"))
    return plot.Picture(body, captions.POINTS)
