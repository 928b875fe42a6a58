"""S Figure 7: a shock in the trajectories of a marker, and what it does to the Allan deviation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from mocap_metrology.noise.allan.variance import allan_variance
from mocap_metrology.noise.diagnosis.shock import Shock, find_shock
from mocap_metrology.present.plot.curves import (
    ADEV_AXES,
    adev_curves,
    curve_limits,
    draw_curves,
    groups_of,
)
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

BEFORE_S, AFTER_S = 5.0, 25.0  # shown round the shock
AXES = ("x1", "y1", "z1")
RECORDED, CLEANED, CUT = "(b) as recorded", "(b) after the Hampel filter", "(b) shock cut out"
RAW: Keywords = {"color": GREY, "lw": 0.5, "label": "(a) as recorded"}
CLEAN: Keywords = {"color": LOOKS["x"].colour, "lw": 0.6, "label": "(a) after the Hampel filter"}
CURVES = {RECORDED: LOOKS["y"], CLEANED: LOOKS["x"], CUT: LOOKS["z"]}
OTHER = Look(OTHER_LOOKS[0].colour, (0, (1.2, 1.2)), "D")
LEAST_MM = 5e-4  # of half the axis
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

    def curves(self, shock: Shock | None, series: str = "L") -> pd.DataFrame:
        """Allan deviation of one series as recorded, after cleaning, and after cleaning without
        the frames of the shock."""
        cleaned = adev_curves(self.allan, {series: CLEANED}, band=False)
        cleaned = cleaned[cleaned["thin"] == ""]
        own = (self.allan["series"] == series) & (self.allan["estimator"] == "oadev")
        m = self.allan["m"][own].astype(np.int64)
        values = {RECORDED: self.raw[series]}
        if shock is not None:
            cut = np.array(self.clean[series], dtype=np.float64)
            cut[shock.start : shock.stop] = np.nan
            values[CUT] = cut
        others = [
            cleaned.assign(
                curve=name,
                y=np.sqrt(allan_variance(of, m, min_coverage=self.min_coverage).variance),
            )
            for name, of in values.items()
        ]
        return pd.concat([others[0], cleaned, *others[1:]], ignore_index=True)


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
        curves = pd.concat([curves, adev_curves(other[1], {"L": name}, band=False)])
        looks[name] = OTHER
    traces = _traces(given, 0 if shock is None else shock.onset)
    half = 1.08 * max(traces["raw"].abs().max(), 1e3 * LEAST_MM)
    body = new_figure(title, source, 118.0)
    grid = body.subplot_mosaic([[series, "L"] for series in AXES], width_ratios=(5, 4))
    for series, own in groups_of(traces, "series"):
        axes = grid[series]
        axes.set(xlim=(-BEFORE_S, AFTER_S), ylim=(-half, half), ylabel=f"{series} (µm)")
        axes.plot(own["time_s"], own["raw"], **RAW)
        axes.plot(own["time_s"], own["clean"], **CLEAN)
        axes.label_outer()
    grid["x1"].set_title("(a) Marker 1")
    grid["z1"].set_xlabel("Time from the shock (s)")
    limits = curve_limits(curves)
    log_axes(grid["L"], limits)
    draw_curves(grid["L"], curves, limits[1], looks)
    grid["L"].set(title="(b) Distance L", xlabel=ADEV_AXES[0], ylabel=ADEV_AXES[1])
    legend_below(body, [grid["x1"], grid["L"]], columns=3)
    return Picture(body, f"{captions.SKUROWSKI[7]} {_remark(given, shock)} {remarks}")


def _traces(given: Shaken, at: int) -> pd.DataFrame:
    """`series`, `time_s` from frame `at`, `raw` and `clean` in µm about the median of the raw."""
    rate, parts = given.frame_rate_hz, []
    first = max(at - round(BEFORE_S * rate), 0)
    part = slice(first, at + round(AFTER_S * rate))
    for series in AXES:
        raw = np.asarray(given.raw[series][part], dtype=np.float64)
        middle = float(np.nanmedian(raw)) if np.isfinite(raw).any() else 0.0
        clean = np.asarray(given.clean[series][part], dtype=np.float64)
        rows = {"series": series, "time_s": (np.arange(raw.size) + first - at) / rate}
        rows |= {"raw": 1e3 * (raw - middle), "clean": 1e3 * (clean - middle)}
        parts.append(pd.DataFrame(rows))
    return pd.concat(parts)


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
