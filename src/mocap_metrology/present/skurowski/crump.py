"""S Figure 7: a shock in the trajectories of a marker, and what it does to the Allan deviation."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

from mocap_metrology.papers import shock as shocks
from mocap_metrology.present.plot import curves as plot
from mocap_metrology.present.plot import figure as fig
from mocap_metrology.present.plot.figure import GREY, LOOKS, OTHER_LOOKS
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.captions import PAPER, SKUROWSKI

LEAST_MM = 5e-4  # of half the axis
NO_SHOCK = "No shock was found."
ASSUMED = (
    "The shock (crump) of the twin is assumed, because the paper prints no numbers for it: up to "
    "{amplitude_mm:g} mm, {frequency_hz:g} Hz, decaying in {decay_s:g} s. "
)


@fig.styled()
def crump_figure(
    shaken: shocks.ShockRecording,
    other: tuple[str, Mapping[str, np.ndarray]] | None,
    source: str,
    remarks: str,
) -> fig.Picture:
    """Marker 1 round the strongest shake of a recording, and the Allan deviation of the distance
    with and without it; other: label and columns of allan.parquet of a recording without one."""
    coordinates = {k: v for k, v in shaken.raw.items() if k != "L"}
    shock = shocks.find_shock(coordinates, shaken.frame_rate_hz)
    curves = shaken.curves(shock).assign(thin="")
    curves["curve"] = "(b) " + curves["curve"]
    looks = {shocks.RECORDED: LOOKS["y"], shocks.CLEANED: LOOKS["x"], shocks.CUT: LOOKS["z"]}
    looks = {f"(b) {curve}": look for curve, look in looks.items()}
    if other is not None:
        name = f"(b) {other[0]}"
        curves = pd.concat([curves, plot.adev_curves(other[1], {"L": name}, band=False)])
        looks[name] = fig.Look(OTHER_LOOKS[0].colour, (0, (1.2, 1.2)), "D")
    traces = shaken.traces(0 if shock is None else shock.onset)
    half = 1.08 * max(1e3 * LEAST_MM, *(table["raw"].abs().max() for table in traces.values()))
    body = fig.new_figure(f"{PAPER}, Figure 7: a seismic crump", source, 118.0)
    grid = body.subplot_mosaic([[series, "L"] for series in shocks.AXES], width_ratios=(5, 4))
    for series, table in traces.items():
        axes, time_s = grid[series], table["time_s"]
        axes.set(
            xlim=(-shocks.BEFORE_S, shocks.AFTER_S), ylim=(-half, half), ylabel=f"{series} (µm)"
        )
        axes.plot(time_s, table["raw"], color=GREY, lw=0.5, label=f"(a) {shocks.RECORDED}")
        how: fig.Keywords = {"lw": 0.6, "label": f"(a) {shocks.CLEANED}"}
        axes.plot(time_s, table["clean"], color=LOOKS["x"].colour, **how)
        axes.label_outer()
    grid["x1"].set_title("(a) Marker 1")
    grid["z1"].set_xlabel("Time from the shock (s)")
    limits = plot.curve_limits(curves)
    fig.log_axes(grid["L"], limits)
    plot.draw_curves(grid["L"], curves, limits[1], looks)
    x_label, y_label = plot.ADEV_AXES
    grid["L"].set(title="(b) Distance L", xlabel=x_label, ylabel=y_label)
    remark = NO_SHOCK
    if shock is not None:
        replaced, every = shaken.replaced(shock)
        span = {
            "from_s": shock.onset / shaken.frame_rate_hz,
            "to_s": shock.stop / shaken.frame_rate_hz,
        }
        remark = captions.SHOCK.format(replaced=replaced, all=every, **span)
    return fig.finished(
        body, [grid["x1"], grid["L"]], f"{SKUROWSKI[7]} {remark} {remarks}", columns=3
    )
