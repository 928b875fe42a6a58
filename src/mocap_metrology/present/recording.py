"""Figures of one recording: Allan deviations, trajectories of a few frames to hours, orientation,
and the noise by place."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from mocap_metrology.common.types import Record
from mocap_metrology.noise.motion.orientation import AXES, TURNS_RAD, Orientation, rms
from mocap_metrology.noise.trace import MARKED_SIGMA, Trace, trace_of
from mocap_metrology.present.plot import curves as of_curves
from mocap_metrology.present.plot import figure as plot
from mocap_metrology.present.plot.curves import NOTHING, Limits, facets
from mocap_metrology.present.plot.figure import Picture, Texts, TimeAxis, length_unit, time_axis
from mocap_metrology.present.tables import Row, origin_words
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import mm, number, significant

Arrays = Mapping[str, np.ndarray]
MOST_NAMED = 2  # files
LEAST_STEP_MM = 1e-9  # as of float64; smaller sizes in mm are written as 0
MOST_PANELS = 20  # six markers and two distances; more are drawn as rows
COLUMNS = 660  # of samples in a panel, or over all panels side by side; as many as pixels
PANELS_MM, PANEL_MM = 140.0, (13.5, 45.0)
LABEL_AT = -0.1  # of the width of the axes
ROWS_MM, ROW_MM, NAME_MM = 190.0, (2.2, 9.0), 2.9
TYPICAL, ROW_OF_CORE = 0.9, 1.6  # a row is so many times this quantile of the series' ranges
RAW, CLEAN, MEAN, OUTLIER, GAP = "#949494", "#b4d3ee", "#10307a", "#cf4a2c", "#ececec"
CLEAN_EDGE = "#5f9bd1"  # darker, that a column of its own is seen


def source_words(origin: Record) -> str:
    """`simulated stand-in (twin) T40-10`, or `measured, take.c3d`; many segments are counted.

    origin: metadata of a table of the recording.
    """
    if origin["twin"]:
        return origin_words(origin["twin"])
    paths = (part["path"] for part in origin.get("segments") or ())
    files = list(dict.fromkeys(path.rpartition("/")[2] for path in paths))
    if len(files) > MOST_NAMED:
        return f"measured, {files[0]} and {len(files) - 1} more files"
    return ", ".join(["measured", " and ".join(files)] if files else ["measured"])


def step_words(resolution_mm: float, kind: str) -> str:
    """`step 61 nm (float32)`: of the stored values, in a unit that needs no power of ten."""
    if not resolution_mm > 0:
        return "step unknown"
    if resolution_mm < LEAST_STEP_MM:
        return f"step below 0.001 nm ({kind})"
    return f"step {mm(resolution_mm, 2)} ({kind})"


@plot.styled()
def allan_figure(
    columns: Arrays, texts: Texts, *, expected: Sequence[str] = (), confidence: float | None = None
) -> Picture:
    """Allan deviation of every series of a recording. columns: of `allan_masked.parquet`;
    `expected`: series that should be there, one that is not is drawn as without valid samples."""
    names = [*np.asarray(columns["series"]).astype(str).tolist(), *expected]
    curves = of_curves.adev_curves(columns, {name: name for name in names})
    facets = of_curves.facets(curves["curve"]).items()
    return of_curves.curves_picture(
        {title: curves[curves["curve"].isin(names)] for title, names in facets},
        texts._replace(caption=f"{captions.ADEV} {texts.caption}"),
        confidence,
    )


@plot.styled()
def trajectory_figure(
    raw: Arrays, clean: Arrays, outliers: Arrays, frame_rate_hz: float, texts: Texts
) -> Picture:
    """The figure of `captions.TRAJECTORY`, a panel a series; with more than 20 series, one row a
    marker and a column of axes a coordinate, all to one scale.

    raw, clean: name -> (n,) values in mm, NaN where missing; outliers: name -> (n,) bool.
    """
    if not raw:
        return plot.words_picture("No series.", texts)
    many = len(raw) > MOST_PANELS
    n_columns = COLUMNS // len(facets(raw, 0)) if many else COLUMNS
    traces = [
        trace_of(name, values, clean[name], outliers[name], frame_rate_hz, n_columns)
        for name, values in raw.items()
    ]
    time = time_axis(max(one.n for one in traces), frame_rate_hz)
    body = (_rows if many else _panels)(traces, time, texts)
    return plot.finished(body, body.axes, f"{captions.TRAJECTORY} {texts.caption}")


def draw(
    axes: plot.Axes, one: Trace, time: TimeAxis, scale: float, limits: Limits, offset: float = 0.0
) -> None:
    """Gaps at the back, then raw, cleaned, outliers, mean, each labelled for the legend.

    `scale * value + offset` is the place of a value within `limits` (mm); what lies beyond is
    marked at its edge. All but the mean becomes one image in an SVG (neighbours in zorder do).
    """
    from matplotlib.patches import StepPatch

    def place(values: pd.Series) -> np.ndarray:
        return np.asarray(scale * values.clip(*limits) + offset)

    edges = np.append(one.raw["first"], one.n) * time.per_frame
    middles = (edges[1:] + edges[:-1]) / 2
    empty = one.raw.assign(low=limits[0], high=limits[1])[["low", "high"]]
    empty[one.raw["n_valid"] > 0] = np.nan
    for rows, colour, edge, zorder, label in (
        (empty, GAP, GAP, 2.0, NOTHING),
        (one.raw, RAW, RAW, 2.1, "range of raw samples"),
        (one.clean, CLEAN, CLEAN_EDGE, 2.2, "range of cleaned samples"),
    ):
        if rows["low"].notna().any():
            how: plot.Keywords = {"fill": True, "fc": colour, "ec": edge, "lw": 0.5}
            how |= {"baseline": place(rows["low"]), "zorder": zorder, "rasterized": True}
            # `axes.stairs` would search each bin for limits, which are set already.
            axes.add_artist(StepPatch(place(rows["high"]), edges, label=label, **how))
    if len(one.means):
        at = (one.means["first"] + one.means["stop"]) / 2 * time.per_frame
        label = f"mean over {one.mean_s:.3g} s"
        axes.plot(at, place(one.means["mean"]), color=MEAN, lw=0.8, zorder=2.6, label=label)
    dots: plot.Keywords = {"ls": "", "mew": 0, "rasterized": True}
    inside = one.marked[one.marked.between(*limits)]
    if len(inside):
        how = {"marker": "o", "ms": 2.2, "color": OUTLIER, "zorder": 2.3, **dots}
        how["label"] = f"outliers beyond {MARKED_SIGMA:g} σ"
        axes.plot((inside.index + 0.5) * time.per_frame, place(inside), **how)
    dots |= {"ms": 3.4, "color": plot.INK, "clip_on": False, "zorder": 2.4}
    for over, limit, marker in (
        (one.raw["high"] > limits[1], limits[1], "^"),
        (one.raw["low"] < limits[0], limits[0], "v"),
    ):
        if over.any():  # else layout would make room for a sign at the origin
            edge_line = np.full(over.sum(), scale * limit + offset)
            axes.plot(middles[over], edge_line, marker=marker, label="beyond the axis", **dots)


def _panels(traces: Sequence[Trace], time: TimeAxis, texts: Texts) -> plot.SubFigure:
    """A panel a series, numbers beside it."""
    height = float(np.clip(PANELS_MM / len(traces), *PANEL_MM))
    body = plot.new_figure(texts, 30.0 + len(traces) * (height + 2.0))
    grid = body.subplots(len(traces), 1, sharex=True, squeeze=False)[:, 0]
    unit, per_mm = length_unit([np.ptp(one.limits) for one in traces if one.n_missing < one.n])
    for axes, one in zip(grid, traces, strict=True):
        axes.set(xlim=time.limits, ylim=np.multiply(one.limits, per_mm))
        axes.set_ylabel(f"{plot.short(one.name, 8)} ({unit})")
        axes.yaxis.set_label_coords(LABEL_AT, 0.5)  # faster than `align_ylabels` by half a second
        if one.n_missing == one.n:
            axes.set(facecolor=GAP, yticks=[])
            plot.write_message(axes, NOTHING)
            continue
        draw(axes, one, time, per_mm, one.limits)
        how: plot.Keywords = {"transform": axes.transAxes, "size": plot.SMALL_PT, "va": "center"}
        axes.text(1.02, 0.5, "\n".join(_numbers(one)), **how)
    grid[-1].set_xlabel(time.label)
    return body


def _numbers(one: Trace) -> list[str]:
    share = 100 * one.n_outliers / (one.n - one.n_missing)
    facts = [f"mean {number(one.centre, 3)} mm"]
    facts.append(f"outliers {number(one.n_outliers)} ({share:.2g} %)")
    if len(one.marked):
        facts.append(f"beyond {MARKED_SIGMA:g} σ: {number(len(one.marked))}")
    if one.n_missing:
        facts.append(f"missing {number(one.n_missing)} ({100 * one.n_missing / one.n:.2g} %)")
    if one.beyond.size:
        farthest = number(max(one.beyond.tolist(), key=abs), 2, sign=True)
        facts.append(f"off the axis {number(one.beyond.size)}, to {farthest} mm")
    return facts


def _rows(traces: Sequence[Trace], time: TimeAxis, texts: Texts) -> plot.SubFigure:
    """A row a marker, as high as nine in ten of the series need."""
    by_name = {one.name: one for one in traces}
    panels = facets(by_name, 0)
    ranges = [one.core for one in traces if one.core > 0]
    step = ROW_OF_CORE * float(np.quantile(ranges, TYPICAL)) if ranges else 1.0
    n_rows = max(len(names) for names in panels.values())
    row_mm = float(np.clip(ROWS_MM / n_rows, *ROW_MM))
    every = next(k for k in (1, 2, 5, 10, 20, 50) if k * row_mm >= NAME_MM or k == 50)
    body = plot.new_figure(texts, 35.0 + n_rows * row_mm)
    grid = body.subplots(1, len(panels), sharex=True, squeeze=False)[0]
    words: plot.Keywords = {"ha": "center", "va": "center_baseline", "fontsize": 6.0}
    for axes, (panel, names) in zip(grid, panels.items(), strict=True):
        axes.set(xlim=time.limits, ylim=(n_rows - 0.5, -0.5), xlabel=time.label)
        axes.grid(visible=len(names) == n_rows)
        for place, one in enumerate(by_name[name] for name in names):
            if one.n_missing < one.n:
                draw(axes, one, time, -1 / step, (-0.48 * step, 0.48 * step), place)
            else:
                axes.text(float(np.mean(time.limits)), place, NOTHING, color=plot.GREY, **words)
        shown = [k for k in range(len(names)) if k == 0 or (k + 1) % every == 0]
        marker = {k: names[k][1:] for k in shown if plot.coordinate_of(names[k])}
        labels = [marker.get(k, plot.short(names[k], 8)) for k in shown]
        axes.set_yticks(shown, labels, fontsize=plot.SMALL_PT)
        axes.tick_params(axis="y", length=0)
        n_outliers = sum(by_name[name].n_outliers for name in names)
        plot.panel_title(axes, panel if marker else "L", f"{number(n_outliers)} outliers")
    unit, per_mm = length_unit([step])
    grid[0].set_ylabel(f"Marker; a row is {significant(step * per_mm, 2)} {unit} high")
    return body


# ---- Orientation of a cluster, and a pair that is carried through the volume

MAP_MM = 84.0
MAPS = {  # title and colours of each column that is drawn
    "sigma_mm": ("Noise of one frame (µm)", "viridis"),
    "deviation_mm": ("Mean − overall mean (µm)", "coolwarm"),
}
SENTENCE = (
    "Noise of the length differs by a factor of {factor:.2g} between places: {why}; its mean "
    "scatters by {bend_um:.3g} µm (SD)."
)


@plot.styled()
def orientation_figure(
    allan: Arrays, orientation: Orientation, origin: Record, cluster: Sequence[str], refused: str
) -> Picture:
    """Allan deviation of the three components of the rotation vector, with intervals; or the words
    why there is none (`refused`)."""
    title = f"{origin['recording']}: Allan deviation of orientation"
    texts = Texts(title, f"Source: {source_words(origin)}.")
    if refused:
        return plot.words_picture(refused, texts)
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
    adev = of_curves.adev_curves(allan, {axis: axis for axis in AXES}, unit="rad")
    adev[["y", "lower", "upper"]] *= 1e6
    return of_curves.curves_picture(
        {"Orientation": adev},
        texts._replace(caption=" ".join(words)),
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
    why = f"{'not explained' if p < 0.01 else 'explained'} by chance (p = {p:.2g})"
    if math.isnan(p):
        why = "as no place was visited twice, it may change with time"
    return SENTENCE.format(factor=factor, why=why, bend_um=1000 * even["bend_mm"])


@plot.styled()
def place_figure(rows: Sequence[Row], texts: Texts) -> Picture:
    """Two maps from above: noise of the length, and deviation of its mean, a square a cell (the
    mean over the heights, weighted by frames); of no cell only the words of the caption."""
    if not rows:
        return plot.words_picture(texts.caption, texts)
    table = pd.DataFrame(rows)
    table[list(MAPS)] *= 1e3
    steps = np.concatenate([np.diff(np.unique(table[axis])) for axis in ("x_mm", "y_mm")])
    cell = float(steps.min(initial=np.inf)) if steps.size else 1.0
    x, y = (np.arange(c.min(), c.max() + cell / 2, cell) for c in (table["x_mm"], table["y_mm"]))
    body = plot.new_figure(texts, MAP_MM)
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
    return plot.Picture(body, f"{texts.caption}{more}")
