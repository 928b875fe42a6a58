"""The picture of a tracked receiver: its path, and how sure its poses are."""

from __future__ import annotations

from typing import Any

import numpy as np

from mocap_metrology.common.types import Record
from mocap_metrology.lighthouse.assess.calibration_files import (
    Columns,
    deviations_mm,
    jitter,
    lengths,
    settled_poses,
)
from mocap_metrology.lighthouse.records import AXES, PLANES, ROLES
from mocap_metrology.present.calibration.stations import ALL_COLOURS, COLOURS, NAMES
from mocap_metrology.present.plot import figure
from mocap_metrology.present.plot.curves import log_limits
from mocap_metrology.present.tables import origin_words
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import significant

CURVES: dict[str, figure.Keywords] = {
    "total": {"label": "all, with optics and board", "color": figure.INK, "lw": 1.2},
    "calibration": {"label": "error of the calibration", "color": COLOURS[1], "ls": (0, (5, 1.6))},
    "noise": {"label": "noise of the hits", "color": COLOURS[0], "lw": 0.8},
}
HEIGHT_MM = 195.0
PLACES: list[Any] = [["path", "far"], ["place", "place"], ["mm", "mm"], ["deg", "deg"]]
ROWS = (64, 48, 40, 40)  # round: with others the last digits of the layout vary between runs
DENSE = 2000  # poses; more are an image in an SVG
ALONE: figure.Keywords = {"color": figure.FAINT, "lw": 0, "zorder": 0, "step": "mid"}
ALONE["label"] = "one station sees it"
DASHES: dict[str, object] = {"common": "-", "independent": (0, (4, 1.5))}
EDGES = np.sqrt(24)  # a pulse's middle has two edges, each rounded by step / sqrt(12)


@figure.styled()
def track_figure(
    name: str, twin: str | None, track: Columns, origin: Record, allan: Columns, noise: Record
) -> figure.Picture:
    """The figure of `captions.TRACK_PATH`, or TRACK_AT_REST (`allan`, `noise`: of the board's
    allan.parquet), and TRACK; where there is no track, words state why."""
    other = origin.get("tracked_with")
    whose = f"of {other}" if other else "of this recording's own calibration"
    of = f"station {origin['reference']}" if origin.get("reference") else "the master"
    source = f"Source: {origin_words(twin)}. Stations {whose}; frame of {of}."
    texts = figure.Texts(f"{name}: tracked receiver", source)
    if not np.isfinite(track["x_mm"]).any():
        why = origin.get("reason") or "no moment with a pose"
        return figure.words_picture(f"No path of the receiver: {why}.", texts)
    body = figure.new_figure(texts, HEIGHT_MM)
    axes: dict[str, figure.Axes] = body.subplot_mosaic(PLACES, height_ratios=ROWS)
    if noise.get("rotors"):
        above = captions.TRACK_AT_REST
        first, second = PLANES if "generation" in noise else AXES
        _draw_angles(axes["path"], allan, noise, first)
        _draw_angles(axes["far"], allan, noise, second)
    else:
        above = captions.TRACK_PATH
        _draw_path(body, axes["path"], track)
        _draw_distance(axes["far"], track)
    remark = _draw_place(axes["place"], track, bool(origin.get("still")))
    _draw_deviations(axes["mm"], track, "mm", "position", "Position (mm)")
    _draw_deviations(axes["deg"], track, "deg", "rotation", "Rotation (°)")
    one = np.sum([track[k] > 0 for k in track if k.startswith("n_hits_")], axis=0) == 1
    for key in ("place", "mm", "deg"):
        if one.any():
            how = ALONE | {"transform": axes[key].get_xaxis_transform()}
            axes[key].fill_between(track["time_s"], 0, 1, where=one, **how)
        axes[key].set(xlim=(track["time_s"][0], track["time_s"][-1]))
        axes[key].tick_params(labelbottom=key == "deg")
    axes["deg"].set_xlabel("Time (s)")
    figure.letters(axes.values())
    return figure.finished(body, axes.values(), f"{above} {captions.TRACK} {remark}".strip())


def _draw_path(body: figure.SubFigure, axes: figure.Axes, track: Columns) -> None:
    """y against x on one scale, axes as in the calibration's figure; colour: total sd."""
    figure.panel_title(axes, "Path from above")
    x, y, good = track["x_mm"] / 1e3, track["y_mm"] / 1e3, settled_poses(track)
    sd = lengths(track, "total" if np.isfinite(track["sd_x_mm"]).any() else "noise", "mm")
    low, high = sd[good].min(), sd[good].max()
    how: figure.Keywords = {"s": 7.0, "lw": 0, "cmap": "cividis", "rasterized": x.size > DENSE}
    dots = axes.scatter(x, y, c=sd, vmin=low, vmax=max(high, 1.001 * low), **how)
    half = max(np.ptp(v[good]) for v in (x, y)) * 0.58 + 1e-4
    across, up = ((v[good].max() + v[good].min()) / 2 + [-half, half] for v in (x, y))
    axes.set(xlim=across, ylim=up, aspect="equal", xlabel=NAMES[0], ylabel=NAMES[1])
    axes.locator_params(nbins=3, steps=[1, 2, 5, 10])
    bar = body.colorbar(dots, cax=axes.inset_axes((1.07, 0.05, 0.04, 0.88)))
    bar.ax.set_title("mm", fontsize=figure.SMALL_PT, fontweight="normal", loc="center")
    bar.outline.set_visible(False)


def _draw_distance(axes: figure.Axes, track: Columns) -> None:
    far = np.sqrt(sum((track[f"{axis}_mm"] / 1e3) ** 2 for axis in "xyz"))
    values = {kind: lengths(track, kind, "mm") for kind in CURVES}
    for kind, look in CURVES.items():
        how: figure.Keywords = {"ls": "", "marker": ".", "ms": 2.0, "mew": 0, "alpha": 0.6}
        axes.plot(far, values[kind], **how, color=look["color"], rasterized=far.size > DENSE)
    figure.log_axis(axes, "y", log_limits(values.values()))
    good = far[settled_poses(track)]
    room = 0.05 * np.ptp(good) + 1e-4
    figure.panel_title(axes, "Position against distance")
    axes.set(xlim=(good.min() - room, good.max() + room))
    axes.locator_params(axis="x", nbins=4)
    axes.set(xlabel="Distance from the master (m)", ylabel="Standard deviation (mm)")


def _draw_place(axes: figure.Axes, track: Columns, still: bool) -> str:
    """Position about its mean over time, at rest with the noise that is to be expected. Returns a
    sentence on a board at rest."""
    off, remark, sentence = deviations_mm(track), "", ""
    unit, scale = ("mm", 1.0) if still else ("m", 1e-3)
    if still:
        mm, deg = (significant(value, 2) for value in jitter(track))
        noise = significant(float(np.sqrt(np.nanmean(lengths(track, "noise", "mm") ** 2))), 2)
        remark = f"jitter {mm} mm, {deg}°"
        sentence = captions.TRACK_JITTER.format(mm=mm, noise=noise)
    for k, (name, look) in enumerate(figure.LOOKS.items()):
        how: figure.Keywords = {"color": look.colour, "ls": look.dashes, "lw": 0.9}
        axes.plot(track["time_s"], scale * off[:, k], label=f"{name}, about its mean", **how)
        if still:
            sd = track[f"sd_noise_{name}_mm"]
            axes.fill_between(track["time_s"], -sd, sd, color=look.colour, **figure.BAND)
    shown = scale * off[settled_poses(track)]
    room = 0.1 * np.ptp(shown) + 1e-6
    axes.set(ylim=(shown.min() - room, shown.max() + room), ylabel=f"Position ({unit})")
    figure.panel_title(axes, "Position", remark)
    return sentence


def _draw_deviations(axes: figure.Axes, track: Columns, unit: str, name: str, label: str) -> None:
    values = {kind: lengths(track, kind, unit) for kind in CURVES}
    for kind, look in CURVES.items():
        axes.plot(track["time_s"], values[kind], **look)
    figure.log_axis(axes, "y", log_limits(values.values()))
    figure.panel_title(axes, f"Standard deviation of {name}")
    axes.set_ylabel(label)


def _draw_angles(axes: figure.Axes, allan: Columns, noise: Record, axis: str) -> None:
    """Common and independent part of the stations against the averaging time, with intervals, and
    the rounding of the clock: white noise of step / sqrt(24), as far as it is dithered."""
    figure.panel_title(axes, f"Angles at rest, {axis.replace('plane', 'plane ')}")
    shown, taus = [], []
    for role, colour in zip(noise.get("stations", ROLES), ALL_COLOURS, strict=False):
        for part, dashes in DASHES.items():
            mask = (allan["series"] == f"{role}_{axis}_{part}") & (allan["estimator"] == "oadev")
            mask &= allan["adev_rad"] > 0
            if not mask.any():
                continue
            tau = np.asarray(allan["tau_s"][mask], dtype=np.float64)
            ends = [allan[f"adev{end}_rad"][mask] for end in ("", "_lower", "_upper")]
            adev, low, high = 1e6 * np.asarray(ends, dtype=np.float64)
            title = f"station {role}" if role.isdigit() else role
            axes.plot(tau, adev, label=f"{title}, {part} part", color=colour, ls=dashes, lw=1.1)
            axes.fill_between(tau, low, high, color=colour, **figure.BAND)
            shown.append(adev)
            taus.append(tau)
    if not taus:
        figure.write_message(axes, "No scatter, or no diode\nhit in half of the sweeps")
        return
    x = log_limits(taus, 1.0)
    steps = [1e6 * r["step_rad"] for r in noise["rotors"] if r["step_rad"]]
    if steps:
        rounding = steps[0] / EDGES * np.sqrt(min(float(tau[0]) for tau in taus) / np.array(x))
        how: figure.Keywords = {"color": figure.INK, "lw": 0.8, "ls": (0, (1, 1.5))}
        axes.plot(x, rounding, label="rounding by the clock, dithered", **how)
        axes.axhline(steps[0], color=figure.GREY, lw=0.8, label="step of the clock")
        shown.append(np.array([steps[0], rounding[0]]))
    figure.log_axes(axes, (x, log_limits(shown, 1.0)))
    axes.set(xlabel="Averaging time τ (s)", ylabel="Allan deviation (µrad)")
