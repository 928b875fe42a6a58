"""S Figure 7: a shock in the trajectories of a marker, and what it does to the Allan deviation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from mocap_metrology.noise.allan.variance import allan_variance
from mocap_metrology.papers.shock import Shock, find_shock
from mocap_metrology.present.plot import curves as plot
from mocap_metrology.present.plot import figure as fig
from mocap_metrology.present.plot.figure import GREY, LOOKS, OTHER_LOOKS
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.captions import PAPER, SKUROWSKI

BEFORE_S, AFTER_S = 5.0, 25.0  # shown round the shock
AXES = ("x1", "y1", "z1")
RECORDED, CLEANED, CUT = "(b) as recorded", "(b) after the Hampel filter", "(b) shock cut out"
LEAST_MM = 5e-4  # of half the axis
NO_SHOCK = "No shock was found."
ASSUMED = (
    "The shock (crump) of the twin is assumed, because the paper prints no numbers for it: up to "
    "{amplitude_mm:g} mm, {frequency_hz:g} Hz, decaying in {decay_s:g} s. "
)
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

    def curves(self, shock: Shock | None) -> pd.DataFrame:
        """Allan deviation of L as recorded, after cleaning, and after cleaning without
        the frames of the shock."""
        cleaned = plot.adev_curves(self.allan, {"L": CLEANED}, band=False)
        cleaned = cleaned[cleaned["thin"] == ""]
        own = (self.allan["series"] == "L") & (self.allan["estimator"] == "oadev")
        m = self.allan["m"][own].astype(np.int64)

        def of(curve: str, values: np.ndarray) -> pd.DataFrame:
            found = allan_variance(values, m, min_coverage=self.min_coverage)
            return cleaned.assign(curve=curve, y=np.sqrt(found.variance))

        curves = [of(RECORDED, self.raw["L"]), cleaned]
        if shock is not None:
            cut = np.array(self.clean["L"], dtype=np.float64)
            cut[shock.start : shock.stop] = np.nan
            curves.append(of(CUT, cut))
        return pd.concat(curves, ignore_index=True)

    def traces(self, at: int) -> dict[str, pd.DataFrame]:
        """Marker 1 round frame `at`: `time_s` from there, `raw` and `clean` in µm about the median
        of the raw, by series."""
        first = max(at - round(BEFORE_S * self.frame_rate_hz), 0)
        part = slice(first, at + round(AFTER_S * self.frame_rate_hz))
        traces = {}
        for series in AXES:
            both = {"raw": self.raw[series][part], "clean": self.clean[series][part]}
            table = pd.DataFrame(both, dtype=np.float64)
            table = 1e3 * (table - np.nan_to_num(table["raw"].median()))
            traces[series] = table.assign(time_s=(table.index + first - at) / self.frame_rate_hz)
        return traces

    def remark(self, shock: Shock | None) -> str:
        """Where the shock is, and how few of its samples a filter of single outliers replaces."""
        if shock is None:
            return NO_SHOCK
        part, rate = slice(shock.start, shock.stop), self.frame_rate_hz
        replaced = [self.raw[s][part] != self.clean[s][part].astype(np.float64) for s in AXES]
        numbers = {"replaced": np.count_nonzero(replaced), "all": np.size(replaced)}
        return captions.SHOCK.format(from_s=shock.onset / rate, to_s=shock.stop / rate, **numbers)


@fig.styled()
def crump_figure(
    shaken: Shaken, other: tuple[str, Series] | None, source: str, remarks: str
) -> fig.Picture:
    """Marker 1 round the strongest shake of a recording, and the Allan deviation of the distance
    with and without it; other: label and columns of allan.parquet of a recording without one;
    source: the line at the foot; remarks: what the caption adds."""
    coordinates = {k: v for k, v in shaken.raw.items() if k != "L"}
    shock = find_shock(coordinates, shaken.frame_rate_hz)
    curves = shaken.curves(shock)
    looks = {RECORDED: LOOKS["y"], CLEANED: LOOKS["x"], CUT: LOOKS["z"]}
    if other is not None:
        name = f"(b) {other[0]}"
        curves = pd.concat([curves, plot.adev_curves(other[1], {"L": name}, band=False)])
        looks[name] = fig.Look(OTHER_LOOKS[0].colour, (0, (1.2, 1.2)), "D")
    traces = shaken.traces(0 if shock is None else shock.onset)
    half = 1.08 * max(1e3 * LEAST_MM, *(table["raw"].abs().max() for table in traces.values()))
    body = fig.new_figure(f"{PAPER}, Figure 7: a seismic crump", source, 118.0)
    grid = body.subplot_mosaic([[series, "L"] for series in AXES], width_ratios=(5, 4))
    for series, table in traces.items():
        axes, time_s = grid[series], table["time_s"]
        axes.set(xlim=(-BEFORE_S, AFTER_S), ylim=(-half, half), ylabel=f"{series} (µm)")
        axes.plot(time_s, table["raw"], color=GREY, lw=0.5, label="(a) as recorded")
        how: fig.Keywords = {"lw": 0.6, "label": "(a) after the Hampel filter"}
        axes.plot(time_s, table["clean"], color=LOOKS["x"].colour, **how)
        axes.label_outer()
    grid["x1"].set_title("(a) Marker 1")
    grid["z1"].set_xlabel("Time from the shock (s)")
    limits = plot.curve_limits(curves)
    fig.log_axes(grid["L"], limits)
    plot.draw_curves(grid["L"], curves, limits[1], looks)
    x_label, y_label = plot.ADEV_AXES
    grid["L"].set(title="(b) Distance L", xlabel=x_label, ylabel=y_label)
    return fig.finished(
        body, [grid["x1"], grid["L"]], f"{SKUROWSKI[7]} {shaken.remark(shock)} {remarks}", columns=3
    )


def guessed(crumps: Sequence[Mapping[str, float]]) -> str:
    """Of the shock of a twin (settings of `twins.Crump`), none for a real recording."""
    return ASSUMED.format(**crumps[0]) if crumps else ""
