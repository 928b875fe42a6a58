"""Allan deviation of the angles of a board at rest."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.lighthouse.records import ROLES
from mocap_metrology.present.plot.curves import log_limits
from mocap_metrology.present.plot.figure import (
    BAND,
    GREY,
    INK,
    LOOKS,
    Keywords,
    log_axes,
    panel_title,
    say,
)
from mocap_metrology.present.tables import Record

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOURS = LOOKS["x"].colour, LOOKS["y"].colour  # of master and slave
DASHES: dict[str, object] = {"common": "-", "independent": (0, (4, 1.5))}
EDGES = np.sqrt(24)  # a pulse's middle has two edges, each rounded by step / sqrt(12)


def draw_angles(axes: Axes, allan: Mapping[str, np.ndarray], noise: Record, axis: str) -> None:
    """Common and independent part of both stations against the averaging time, with intervals, and
    the rounding of the clock: white noise of step / sqrt(24), as far as it is dithered."""
    panel_title(axes, f"Angles at rest, {axis}")
    shown, taus = [], []
    for role, colour in zip(ROLES, COLOURS, strict=True):
        for part, dashes in DASHES.items():
            own = (allan["series"] == f"{role}_{axis}_{part}") & (allan["estimator"] == "oadev")
            if not own.any():
                continue
            tau, adev, low, high = (
                np.asarray(allan[name][own], dtype=np.float64) * scale
                for name, scale in (
                    *(("tau_s", 1.0), ("adev_rad", 1e6)),
                    *(("adev_lower_rad", 1e6), ("adev_upper_rad", 1e6)),
                )
            )
            how: Keywords = {"color": colour, "ls": dashes, "lw": 1.1}
            axes.plot(tau, adev, label=f"{role}, {part} part", **how)
            axes.fill_between(tau, low, high, color=colour, **BAND)
            shown += [adev]
            taus.append(tau)
    if not taus:
        say(axes, "No diode was hit in half of the sweeps")
        return
    x = log_limits(taus, 1.0)
    steps = [r["step_rad"] for r in noise["rotors"] if r["step_rad"]]
    if steps:
        first = min(float(tau[0]) for tau in taus)
        rounding = 1e6 * steps[0] / EDGES * np.sqrt(first / np.array(x))
        how = {"color": INK, "lw": 0.8, "ls": (0, (1, 1.5))}
        axes.plot(x, rounding, label="rounding by the clock, dithered", **how)
        axes.axhline(1e6 * steps[0], color=GREY, lw=0.8, label="step of the clock")
        shown.append(np.array([1e6 * steps[0], rounding[0]]))
    log_axes(axes, (x, log_limits(shown, 1.0)))
    axes.set(xlabel="Averaging time τ (s)", ylabel="Allan deviation (µrad)")
