"""S Figures 6, 7, 8, 12, 13, 17 and A1: Allan deviations of recordings side by side, fits to one of
them, a shock, and a line in spectra."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from mocap_metrology.noise.model.components import Form, NoiseModel, PowerLaw
from mocap_metrology.noise.model.curves import drawn_m, total_avar
from mocap_metrology.papers import shock as shocks
from mocap_metrology.papers import subsets
from mocap_metrology.present.groups.figures import (
    Allan,
    Rows,
    compared_panels,
    count_looks,
    series_curves,
)
from mocap_metrology.present.plot import curves as plot
from mocap_metrology.present.plot import figure as fig
from mocap_metrology.present.plot.figure import FAINT, GREY, INK, LOOKS, OTHER_LOOKS
from mocap_metrology.present.skurowski.gaussian_figures import SETS
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import significant

SERIES = ("x1", "x2", "L")
SLICE_S = 10.0  # averaging time of the panel against the number of cameras
DROPS = {"T40": 3, "Bonita": 5, "Vantage": 4}  # S 4.3: "notably better suited" setups
LAW: fig.Keywords = {"color": GREY, "lw": 0.8, "ls": (0, (1.2, 1.2)), "zorder": 1}
SLICE_LOOKS = {"x1": LOOKS["x"], "x2": LOOKS["y"], "L": OTHER_LOOKS[0]}


@fig.styled()
def numbers_figure(rows: Rows, allan: Allan, source: str, remarks: str = "") -> fig.Picture:
    """S Figure 12, a row a camera type. allan: columns of allan.parquet by recording."""
    texts = captions.of_figure("skurowski", 12, source, remarks)
    types = {kind: names for kind, names in subsets.sound_subsets(rows).items() if names}
    body = fig.new_figure(texts, 34.0 + max(len(types), 1) * 56.0)
    grid = body.subplots(max(len(types), 1), 4, sharey="row", sharex="col", squeeze=False)
    if not types:
        fig.write_message(grid[0, 0], "no recording of such a subset")
    counts = count_looks([n for names in types.values() for n in names])
    looks = {f"{n} cameras": look for n, look in counts.items()}
    for label, look in looks.items():  # in this order in the legend
        grid[0, 0].plot([], [], label=label, **look.line())
    families = {}
    for kind, names in types.items():
        labels = {name: f"{n} cameras" for n, name in names.items()}
        families[kind] = compared_panels(allan, SERIES, labels, band=False)
    taus = plot.log_limits([of[series]["x"] for of in families.values() for series in SERIES])
    for row, (kind, panels) in zip(grid, families.items(), strict=False):
        limits = taus, plot.curve_limits(pd.concat(panels.values()))[1]
        for axes, (series, curves) in zip(row, panels.items(), strict=False):
            fig.log_axes(axes, limits)
            plot.draw_curves(axes, curves, limits[1], looks)
            axes.set_title(f"{kind}: {series}")
        fig.log_axis(row[3], "y", limits[1])
        _draw_slice(row[3], panels, list(types[kind]), DROPS[kind])
        row[3].set_title(rf"{kind}: $\tau$ = {SLICE_S:g} s")
        row[0].set_ylabel(plot.ADEV_AXES[1])
    for axes, label in zip(grid[-1], (*3 * (r"$\tau$ (s)",), "Cameras n"), strict=True):
        axes.set_xlabel(label)
    return fig.finished(body, grid.flat, texts.caption)


def _draw_slice(
    axes: fig.Axes, panels: Mapping[str, pd.DataFrame], counts: Sequence[int], drop: int
) -> None:
    axes.set(xlim=(1.4, 10.6), xticks=range(2, 11, 2))
    for series, curves in panels.items():
        families = [
            curve.to_numpy().T for _, curve in curves.groupby("curve", sort=False)[["x", "y"]]
        ]
        at = np.array([subsets.at_tau(tau, adev, SLICE_S) for tau, adev in families])
        axes.plot(counts, at, label=series, **SLICE_LOOKS[series].line())
        if series == "x1":
            n = np.linspace(counts[0], counts[-1])
            axes.plot(n, at[-1] * np.sqrt(n[-1] / n), label=r"$\propto 1/\sqrt{n}$", **LAW)
    if drop in counts:
        how: fig.Keywords = {"color": FAINT, "alpha": 0.8, "lw": 0, "zorder": 0}
        axes.axvspan(drop - 0.35, drop + 0.35, label="notably better suited (S 4.3)", **how)


@fig.styled()
def failing_figure(
    rows: Rows, allan: Allan, source: str, remarks: str, confidence: float
) -> fig.Picture | None:
    """S Figure 8: ten Vantage cameras, one of them failing, against nine; None without both."""
    ten, nine = (subsets.standing_for(rows, "Vantage", n) for n in (10, 9))
    if ten is None or nine is None:
        return None
    labels = {ten: "10 cameras, one failing", nine: "9 cameras, without it"}
    looks = dict(zip(labels.values(), (LOOKS["y"], LOOKS["x"]), strict=True))
    texts = captions.of_figure("skurowski", 8, source, remarks)
    panels = compared_panels(allan, SERIES, labels)
    return plot.curves_picture(panels, texts, confidence, looks=looks, lettered=True)


@fig.styled()
def types_figure(
    rows: Rows, allan: Allan, source: str, remarks: str, confidence: float
) -> fig.Picture:
    """S Figure 13: all sound cameras of each type, and of all types."""
    names = subsets.largest_sets(rows)
    labels = {name: f"{kind} ({subsets.TABLE_4[kind]})" for kind, name in names.items()}
    looks = {labels[name]: SETS[kind] for kind, name in names.items()}
    texts = captions.of_figure("skurowski", 13, source, _of_all(rows), remarks)
    panels = compared_panels(allan, SERIES, labels)
    return plot.curves_picture(panels, texts, confidence, looks=looks, lettered=True)


def _of_all(rows: Rows) -> str:
    """What must be known of the recording of all cameras, if it is a twin."""
    name = subsets.standing_for(rows, "All", subsets.TABLE_4["All"])
    return "" if name is None or rows[name]["twin"] is None else captions.ALL_CAMERAS


@fig.styled()
def repaired_figure(
    rows: Rows, others: Rows, allan: Allan, source: str, remarks: str, confidence: float
) -> fig.Picture:
    """S Figure A1. rows: of the repaired recordings; others: of those named in their
    `compare_with`; allan: of all of them."""
    after = {name: f"{row['camera_type']} ({row['n_cameras']})" for name, row in rows.items()}
    old = {name: row["compare_with"] for name, row in rows.items()}
    before = {old[name]: label for name, label in after.items() if old[name] in others}
    looks = {after[n]: SETS.get(row["camera_type"], OTHER_LOOKS[1]) for n, row in rows.items()}
    panels = {"After the repair": series_curves(allan, "z1", after)}
    if before:
        panels = {"Before the repair": series_curves(allan, "z1", before)} | panels
    comments = " ".join(f"{n}: {row['comment']}." for n, row in rows.items() if row["comment"])
    texts = captions.of_figure("skurowski", "A1", source, comments, _of_all(rows), remarks)
    return plot.curves_picture(panels, texts, confidence, looks=looks, lettered=True)


# ---- Figure 6

DATA: fig.Keywords = {"color": INK, "marker": "o", "markersize": 2.6, "markerfacecolor": "white"}
START: fig.Keywords = {"color": OTHER_LOOKS[1].colour, "lw": 0.7, "ls": "-"}
FINAL: fig.Keywords = {"color": LOOKS["x"].colour, "lw": 1.5, "ls": "-"}
ORDINARY: fig.Keywords = {"color": LOOKS["y"].colour, "lw": 1.3, "ls": (0, (5, 1.6))}
QUANTILE, PERCENT = 0.9, (5.0, 10.0, 20.0, 50.0, 100.0)  # axis of the residuals: one of these
PER_DECADE = 200  # points of a curve: smooth where a sinusoid bends within a few frames


@fig.styled()
def regression_figure(
    data: tuple[np.ndarray, np.ndarray],
    starts: Sequence[NoiseModel],
    ordinary: NoiseModel,
    final: NoiseModel,
    frame_rate_hz: float,
    sources: tuple[str, str],
    form: Form,
) -> fig.Picture:
    """S Figure 6. data: averaging time in s and Allan deviation in mm, (k,) each; starts:
    annealing's results; sources: at the foot, and what the caption adds; form: of the Allan
    variances that were fitted. The axis of the residuals holds 90 % of each curve, of the final
    one all."""
    tau, adev = (np.asarray(values, dtype=np.float64) for values in data)
    tau, adev = tau[adev > 0], adev[adev > 0]
    texts = captions.of_figure("skurowski", 6, *sources)
    body = fig.new_figure(texts, 150.0)
    axes, below = body.subplots(2, sharex=True, height_ratios=(2, 1))
    low, high = plot.log_limits([adev], 1.0)
    fig.log_axes(axes, (plot.log_limits([tau]), (low / 1.2, high * 1.2)))
    m = (tau * frame_rate_hz).round().astype(np.int64)
    last = float(m.max(initial=2))
    fine = np.geomspace(1, last, int(np.log10(last) * PER_DECADE) + 2)
    reach = [1.0]
    for model, how in [*((s, START) for s in starts), (ordinary, ORDINARY), (final, FINAL)]:
        axes.plot(fine / frame_rate_hz, smooth_adev(model, fine, frame_rate_hz, form), **how)
        fitted = np.sqrt(total_avar(model.components, m, frame_rate_hz, form))
        residual = 100 * (adev / plot.positive(fitted) - 1)
        below.plot(tau, residual, **how)
        sizes = np.append(np.abs(np.nan_to_num(residual)), [0.0] * (not tau.size))
        reach.append(float(np.quantile(sizes, 1.0 if how is FINAL else QUANTILE)))
    limit = next((p for p in PERCENT if p >= 1.05 * max(reach)), PERCENT[-1])
    below.set(ylim=(-limit, limit), xlabel=plot.ADEV_AXES[0], ylabel="Data/model − 1 (%)")
    below.axhline(0, color=INK, lw=0.6)
    axes.plot(tau, adev, ls="", label="data", **DATA)
    for text, how in (
        (f"{len(starts)} start{'' if len(starts) == 1 else 's'} of annealing", START),
        ("ordinary least squares (Levenberg-Marquardt)", ORDINARY),
        ("weighted least squares: the best start after the ant colony", FINAL),
    ):
        axes.plot([], [], label=text, **how)
    fig.panel_title(axes, "Allan deviation", f"model: {form}")
    axes.set_ylabel(plot.ADEV_AXES[1])
    if not tau.size:
        fig.write_message(axes, plot.NOTHING)
    return fig.finished(body, [axes], texts.caption)


def smooth_adev(model: NoiseModel, m: np.ndarray, frame_rate_hz: float, form: Form) -> np.ndarray:
    """Allan deviation, mm, at any m >= 1 (k,), to draw: of sampled power laws, which have one at
    whole m only, on straight lines between these in logarithms."""
    if form == "continuous":
        return np.asarray(np.sqrt(model.avar(m, frame_rate_hz, form)))
    laws = [c for c in model.components if isinstance(c, PowerLaw)]
    whole = drawn_m(int(np.ceil(m.max())))
    of_laws = np.log(np.maximum(total_avar(laws, whole, frame_rate_hz, form), 1e-300))
    broad = np.exp(np.interp(np.log(m), np.log(whole), of_laws))
    others = [c for c in model.components if not isinstance(c, PowerLaw)]
    return np.asarray(np.sqrt(broad + total_avar(others, m, frame_rate_hz, form)))


# ---- Figure 17

LINE_HZ = 14.4  # S's "15 Hz": eight rows of Tables A1-A3 have 13.7 to 14.4 Hz
HALF_WIDTH_HZ = 2.0  # of the close view
BINS_PER_DECADE = 40
MARK: fig.Keywords = {"color": INK, "lw": 0.8, "ls": (0, (1.2, 1.2)), "zorder": 1}
UNITS = (("mm²", 1.0), ("µm²", 1e6), ("nm²", 1e12))  # how many are in 1 mm²
Spectra = Mapping[str, tuple[np.ndarray, np.ndarray]]


@fig.styled()
def periodic_figure(spectra: Spectra, source: str, remarks: str = "") -> fig.Picture:
    """S Figure 17. spectra: name (of a camera type) -> f in Hz, ascending, and density in mm^2/Hz,
    (k,) each. The whole is shown as medians of bins with bands up to their greatest values; the
    close views show every point."""
    texts = captions.of_figure("skurowski", 17, source, remarks)
    looks = dict(zip(spectra, (*LOOKS.values(), *OTHER_LOOKS), strict=False))
    rows = max(len(looks), 1)
    body = fig.new_figure(texts, 40.0 + max(29.0 * rows, 60.0))
    cells = body.add_gridspec(rows, 2, width_ratios=(2, 1))
    whole = body.add_subplot(cells[:, 0])
    close = [body.add_subplot(cells[k, 1]) for k in range(len(looks))]
    bins = {name: plot.log_bins(*spectra[name], BINS_PER_DECADE) for name in looks}
    y_limits = plot.log_limits([v for b in bins.values() for v in (b.median, b.high)], 2.0)
    fig.log_axes(whole, (plot.log_limits([b.centre for b in bins.values()]), y_limits))
    for axes, (name, look) in zip(close, looks.items(), strict=True):
        b = bins[name]
        whole.plot(b.centre, b.median, color=look.colour, ls=look.dashes, label=fig.short(name))
        whole.plot(b.centre, b.high, color=look.colour, lw=0.5)
        whole.fill_between(b.centre, b.median, b.high, color=look.colour, alpha=0.2, lw=0)
        _draw_close_up(axes, *spectra[name], name, look.colour)
        axes.tick_params(labelbottom=axes is close[-1])
    whole.fill([], [], color=GREY, alpha=0.25, lw=0, label="up to the maximum of a bin")
    whole.axvline(LINE_HZ, label=f"{LINE_HZ:g} Hz", **MARK)
    whole.set(title="Whole spectra", ylabel="Power spectral density (mm²/Hz)")
    for axes in (whole, *close[-1:]):
        axes.set_xlabel("Frequency (Hz)")
    if not any(b.centre.size for b in bins.values()):
        fig.write_message(whole, "no spectrum")
    fig.letters([whole, *close])
    return fig.finished(body, [whole], texts.caption)


def _draw_close_up(
    axes: fig.Axes, f_hz: np.ndarray, psd: np.ndarray, name: str, colour: str
) -> None:
    """Linear axes within 2 Hz of the line; over them the excess of its point."""
    near = (np.abs(f_hz - LINE_HZ) <= HALF_WIDTH_HZ) & np.isfinite(psd)
    f_hz, psd = f_hz[near], psd[near]
    greatest = float(psd.max(initial=0.0))
    unit, per_mm2 = next((u for u in UNITS if greatest * u[1] >= 1.0), UNITS[-1])
    axes.set_xlim(LINE_HZ - HALF_WIDTH_HZ, LINE_HZ + HALF_WIDTH_HZ)
    axes.set_ylim(0.0, 1.1 * greatest * per_mm2 or 1.0)
    axes.axvline(LINE_HZ, **MARK)
    axes.plot(f_hz, psd * per_mm2, color=colour, lw=0.6)
    times = f"{significant(greatest / float(np.median(psd)))} × median" if greatest > 0 else ""
    fig.panel_title(axes, fig.short(name), times)
    axes.set_ylabel(f"{unit}/Hz")


# ---- Figure 7

Other = tuple[str, Mapping[str, np.ndarray]]  # label and columns of allan.parquet
LEAST_MM = 5e-4  # of half the axis
NO_SHOCK = "No shock was found."
ASSUMED = (
    "The shock (crump) of the twin is assumed, because the paper prints no numbers for it: up to "
    "{amplitude_mm:g} mm, {frequency_hz:g} Hz, decaying in {decay_s:g} s. "
)


@fig.styled()
def crump_figure(
    shaken: shocks.ShockRecording, other: Other | None, source: str, remarks: str
) -> fig.Picture:
    """Marker 1 round the strongest shake of a recording, and the Allan deviation of the distance
    with and without it; other: a recording without one."""
    coordinates = {k: v for k, v in shaken.raw.items() if k != "L"}
    shock = shocks.find_shock(coordinates, shaken.frame_rate_hz)
    curves = shaken.curves(shock).assign(thin="")
    curves["curve"] = "(b) " + curves["curve"]
    colours = {shocks.RECORDED: "y", shocks.CLEANED: "x", shocks.CUT: "z"}
    looks = {f"(b) {curve}": LOOKS[axis] for curve, axis in colours.items()}
    if other is not None:
        name = f"(b) {other[0]}"
        curves = pd.concat([curves, plot.adev_curves(other[1], {"L": name}, band=False)])
        looks[name] = fig.Look(OTHER_LOOKS[0].colour, (0, (1.2, 1.2)), "D")
    traces = shaken.traces(0 if shock is None else shock.onset)
    half = 1.08 * max(1e3 * LEAST_MM, *(table["raw"].abs().max() for table in traces.values()))
    remark = NO_SHOCK
    if shock is not None:
        replaced, every = shaken.replaced(shock)
        from_s, to_s = (frame / shaken.frame_rate_hz for frame in (shock.onset, shock.stop))
        remark = captions.SHOCK.format(replaced=replaced, all=every, from_s=from_s, to_s=to_s)
    texts = captions.of_figure("skurowski", 7, source, remark, remarks)
    body = fig.new_figure(texts, 118.0)
    grid = body.subplot_mosaic([[series, "L"] for series in shocks.AXES], width_ratios=(5, 4))
    for series, table in traces.items():
        axes, time_s = grid[series], table["time_s"]
        axes.set(xlim=(-shocks.BEFORE_S, shocks.AFTER_S), ylim=(-half, half))
        axes.set_ylabel(f"{series} (µm)")
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
    return fig.finished(body, [grid["x1"], grid["L"]], texts.caption, columns=3)
