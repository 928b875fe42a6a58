"""S Figure 7: a shock in the trajectories of a marker, and what it does to the Allan deviation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.allan.variance import allan_variance
from mocap_metrology.noise.diagnosis.shock import Shock, find_shock
from mocap_metrology.present.groups.adev import AXES as ADEV_AXES
from mocap_metrology.present.groups.adev import adev_limits
from mocap_metrology.present.groups.members import curve_of
from mocap_metrology.present.plot.curves import Curve, Panel, draw_panel
from mocap_metrology.present.plot.figure import (
    GREY,
    LOOKS,
    OTHER_LOOKS,
    Keywords,
    Look,
    Picture,
    legend_below,
    log_axes,
    new_figure,
    styled,
)
from mocap_metrology.present.text import captions

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BEFORE_S, AFTER_S = 5.0, 25.0  # shown round the shock
AXES = ("x1", "y1", "z1")
RECORDED, CLEANED, CUT = "(b) as recorded", "(b) after the Hampel filter", "(b) shock cut out"
RAW: Keywords = {"color": GREY, "lw": 0.5, "label": "(a) as recorded"}
CLEAN: Keywords = {
    "color": LOOKS["x"].colour, "lw": 0.6, "label": "(a) after the Hampel filter"
}  # fmt: skip
CURVES = {RECORDED: LOOKS["y"], CLEANED: LOOKS["x"], CUT: LOOKS["z"]}
OTHER = Look(OTHER_LOOKS[0].colour, (0, (1.2, 1.2)), "D")
Series = Mapping[str, np.ndarray]


@dataclass(frozen=True)
class Shaken:
    """A recording with a shock: raw and cleaned coordinates and L, (n,) mm each, by name, and
    columns of allan.parquet, which are of the cleaned ones."""

    raw: Series
    clean: Series
    allan: Mapping[str, np.ndarray]
    frame_rate_hz: float
    min_coverage: float = 0.5

    def curves(self, shock: Shock | None, series: str = "L") -> list[Curve]:
        """Allan deviation of one series as recorded, after cleaning, and after cleaning without
        the frames of the shock."""
        cleaned = curve_of(self.allan, series, CLEANED, False)
        own = (self.allan["series"] == series) & (self.allan["estimator"] == "oadev")
        m = self.allan["m"][own].astype(np.int64)
        cut = np.array(self.clean[series], dtype=np.float64)
        if shock is not None:
            cut[shock.start : shock.stop] = np.nan
        found = [Curve(RECORDED, cleaned.x, self._adev(self.raw[series], m)), cleaned]
        return [*found, Curve(CUT, cleaned.x, self._adev(cut, m))] if shock else found

    def _adev(self, values: np.ndarray, m: np.ndarray) -> np.ndarray:
        adev: np.ndarray = np.sqrt(
            allan_variance(values, m, min_coverage=self.min_coverage).variance
        )
        return adev


@styled()
def crump_figure(
    given: Shaken,
    other: tuple[str, Mapping[str, np.ndarray]] | None,
    title: str,
    source: str,
    remarks: str = "",
) -> Picture:
    """Marker 1 round the strongest shake of a recording, and the Allan deviation of the distance
    with and without it; other: label and columns of allan.parquet of a recording without one;
    source: the line at the foot; remarks: what the caption adds."""
    coordinates = {k: v for k, v in given.raw.items() if k != "L"}
    shock = find_shock(coordinates, given.frame_rate_hz)
    curves, looks = given.curves(shock), dict(CURVES)
    if other is not None:
        name = f"(b) {other[0]}"
        curves.append(curve_of(other[1], "L", name, False))
        looks[name] = OTHER
    body = new_figure(title, source, 118.0)
    grid = body.subplot_mosaic([[series, "L"] for series in AXES], width_ratios=(5, 4))
    for series in AXES:
        _trace(grid[series], given, series, 0 if shock is None else shock.onset)
        grid[series].label_outer()
    grid["x1"].set_title("(a) Marker 1")
    grid["z1"].set_xlabel("Time from the shock (s)")
    limits = adev_limits(curves)
    log_axes(grid["L"], limits)
    draw_panel(grid["L"], Panel("", curves, looks), limits[1])
    grid["L"].set(title="(b) Distance L", xlabel=ADEV_AXES[0], ylabel=ADEV_AXES[1])
    legend_below(body, [grid["x1"], grid["L"]], columns=3)
    return Picture(body, f"{captions.SKUROWSKI[7]} {_remark(given, shock)} {remarks}")


def guessed(crumps: Sequence[Mapping[str, float]]) -> str:
    """Of the shock of a twin (settings of `twins.Crump`), none for a real recording."""
    return "".join(
        "The shock (crump) of the twin is assumed, because the paper prints no numbers for it: "
        f"up to {c['amplitude_mm']:g} mm, {c['frequency_hz']:g} Hz, decaying in {c['decay_s']:g} "
        "s. "
        for c in crumps[:1]
    )


def _remark(given: Shaken, shock: Shock | None) -> str:
    """Where the shock is, and how few of its samples a filter of single outliers replaces."""
    if shock is None:
        return "No shock was found."
    part, rate = slice(shock.start, shock.stop), given.frame_rate_hz
    found = [given.raw[s][part] != given.clean[s][part].astype(np.float64) for s in AXES]
    return (
        f"The markers shake from {shock.onset / rate:.1f} s to {shock.stop / rate:.1f} s. There "
        f"the Hampel filter replaces {np.count_nonzero(found)} of {np.size(found)} coordinates "
        "of marker 1: an oscillation is not a single outlier."
    )


def _half_range(given: Shaken, part: slice) -> float:
    """Greatest deviation from the median that the three coordinates show there, in mm."""
    shown = [given.raw[series][part] for series in AXES]
    off = [np.abs(values - np.nanmedian(values)) for values in shown if np.isfinite(values).any()]
    return max((float(np.nanmax(values)) for values in off), default=1e-3)


def _trace(axes: Axes, given: Shaken, series: str, at: int) -> None:
    """One coordinate about its median, raw behind cleaned, time from frame `at`."""
    rate = given.frame_rate_hz
    first = max(at - round(BEFORE_S * rate), 0)
    part = slice(first, at + round(AFTER_S * rate))
    raw, clean = given.raw[series][part], given.clean[series][part]
    middle = float(np.nanmedian(raw)) if np.isfinite(raw).any() else 0.0
    t = (np.arange(raw.size) + first - at) / rate
    half = 1.08e3 * max(_half_range(given, part), 5e-4)
    axes.set(xlim=(-BEFORE_S, AFTER_S), ylim=(-half, half), ylabel=f"{series} (µm)")
    axes.plot(t, 1e3 * (raw - middle), **RAW)
    axes.plot(t, 1e3 * (clean - middle), **CLEAN)
