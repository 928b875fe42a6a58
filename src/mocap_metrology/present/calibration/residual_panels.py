"""Residuals of the estimator `batch`: means by angle and over time, root mean square by diode."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.lighthouse.records import AXES, ROLES
from mocap_metrology.present.calibration.views import COLOURS
from mocap_metrology.present.plot.figure import GREY, INK, Keywords, panel_title
from mocap_metrology.present.tables import Record

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PANELS: Mapping[str, tuple[str, str]] = {
    "azimuth": ("angle_deg", "Azimuth residuals"),
    "elevation": ("angle_deg", "Elevation residuals"),
    "time": ("time_s", "Residuals over time"),
}
MARKS = "os"  # of master and slave
LEAST_URAD = 20.0  # half height of the panels of means
HIGHEST = 4.0  # of a bar, over the median
ROOM = 1.12
MOST_NAMED = 3  # diodes


def residuals_of(entry: Mapping[str, object] | None) -> Record | None:
    """Residuals of an estimate, None where it has none (all but `batch`)."""
    details: Record = dict((entry or {}).get("details") or {})  # type: ignore[call-overload]
    return details.get("residuals")


def draw_means(panels: Mapping[str, Axes], residuals: Record) -> None:
    """Mean residuals with their standard deviations by noise, against azimuth, elevation and time,
    all on one scale."""
    reach = [LEAST_URAD]
    for key, (against, title) in PANELS.items():
        axes, typical = panels[key], [0.0]
        panel_title(axes, title)
        axes.axhline(0.0, color=GREY, lw=0.8)
        for row in residuals["against"]:
            if row["against"] != against or key not in ("time", row["axis"]):
                continue
            mean, sd = np.array(row["mean_urad"]), np.array(row["sd_urad"])
            typical.append(float(np.median(sd)))
            reach.append(float(np.abs(mean).max()) + typical[-1])
            how = _look(ROLES.index(row["station"]), row["axis"] == AXES[1])
            if key == "time":
                axes.plot(row["at"], mean, label=f"{row['station']}, {row['axis']}", **how)
            else:
                axes.errorbar(row["at"], mean, sd, elinewidth=0.7, **how)
        if key == "time":
            band: Keywords = {
                "color": GREY,
                "alpha": 0.2,
                "lw": 0,
                "label": "1 σ of a mean by noise",
            }
            axes.axhspan(-max(typical), max(typical), **band)
    half = ROOM * max(reach)
    for key, axes in panels.items():
        axes.set(ylim=(-half, half))
        axes.set_xlabel("Time (s)" if key == "time" else f"{key.capitalize()} (°)")
        if key != "azimuth":
            axes.tick_params(labelleft=False)
    panels["azimuth"].set_ylabel("Mean (µrad)")


def _look(station: int, elevation: bool) -> Keywords:
    """Colour and mark of a station, for the elevation open and dashed."""
    how: Keywords = {"color": COLOURS[station], "lw": 0.9, "ms": 3.2, "mew": 0.8}
    how |= {"marker": MARKS[station], "ls": (0, (3, 1.5)) if elevation else "-"}
    return how | ({"markerfacecolor": "none"} if elevation else {})


def draw_diode_residuals(axes: Axes, residuals: Record, n: int, expected: float) -> str:
    """Root mean square residual of each diode by each station, those of excluded diodes crossed,
    and the noise of a hit. Those far above the rest stand at the upper end. Returns a sentence on
    diodes that the estimate excludes."""
    gone = sorted({k for row in residuals["by_diode"] for k in row["excluded"]})
    few = 0 < len(gone) <= MOST_NAMED
    remark = f"excluded: {', '.join(map(str, gone)) if few else len(gone)}" if gone else ""
    panel_title(axes, "Residuals of diodes", remark)
    every = np.concatenate([row["rms_urad"] for row in residuals["by_diode"]])
    if not every.size:
        return ""
    top = min(ROOM * every.max(), HIGHEST * np.median(every))
    top, out = max(float(top), 1.5 * expected), []
    for station, row in enumerate(residuals["by_diode"]):
        diode, rms = np.array(row["diode"]), np.array(row["rms_urad"])
        at = diode + 0.16 * (2 * station - 1)
        how: Keywords = {"color": COLOURS[station], "ls": "", "ms": 3.2, "mew": 0}
        axes.plot(at, np.minimum(rms, 0.96 * top), marker=MARKS[station], **how)
        excluded = np.isin(diode, row["excluded"])
        if excluded.any():
            cross: Keywords = {"marker": "x", "color": INK, "ls": "", "ms": 6.0, "mew": 1.1}
            label = "excluded diode"
            axes.plot(at[excluded], np.minimum(rms, 0.96 * top)[excluded], label=label, **cross)
            out.append(
                f"{row['station']}: "
                + ", ".join(
                    f"{k} ({r:.0f} µrad)"
                    for k, r in zip(diode[excluded], rms[excluded], strict=True)
                )
            )
    dots: Keywords = {"color": INK, "lw": 0.8, "ls": (0, (1, 1.5))}
    axes.axhline(expected, label=f"noise of a hit: {expected:.0f} µrad", **dots)
    axes.set(xlim=(-0.8, n - 0.2), ylim=(0, top), xlabel="Diode (from 0)", ylabel="rms (µrad)")
    axes.set_xticks(range(0, n, 4 if n > 16 else 2))
    return f"Excluded from the estimate, {'; '.join(out)}." if out else ""
