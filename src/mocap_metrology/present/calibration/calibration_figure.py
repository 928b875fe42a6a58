"""The picture a lab looks at after a calibration: where the stations are, and how sure that is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from textwrap import fill, wrap

import numpy as np

from mocap_metrology.common.types import Record
from mocap_metrology.lighthouse.assess import calibration_files as data
from mocap_metrology.lighthouse.assess.calibration_files import CalibrationFiles
from mocap_metrology.lighthouse.records import AXES, MASTER, ROLES
from mocap_metrology.present.calibration import pose_text, stations
from mocap_metrology.present.calibration.stations import ALL_COLOURS, ALL_MARKS, thinned
from mocap_metrology.present.plot import figure
from mocap_metrology.present.plot.curves import log_limits
from mocap_metrology.present.plot.figure import (
    GREY,
    INK,
    Keywords,
    Picture,
    panel_title,
    write_message,
)
from mocap_metrology.present.tables import origin_words
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import mm, significant

DENSE = 500  # so many dots are an image in an SVG
MOST_DOTS, MOST_MARKS = 4000, 300
LEAST_URAD = 20.0  # half height of the panels of means
HIGHEST = 4.0  # of a diode's residual, over the median
REASON, FACT, LINE_MM = 84, 54, 4.2  # characters in a line; its height
RESULT_MM, ROW_MM, LEGEND_MM = 78.0, 50.0, 32.0
MEANS = {  # what mean residuals are shown against
    "azimuth": ("angle_deg", "Azimuth (°)"),
    "elevation": ("angle_deg", "Elevation (°)"),
    "time": ("time_s", "Time (s)"),
}
SLAVE_SEEN = ["right", "horizontal", "vertical"]
PLANES = ("plane 0", "plane 1")  # of the second generation, in the place of `AXES`
BY_BATCH = [SLAVE_SEEN, ["path", "azimuth", "elevation"], ["time", "diodes", "seen"]]
BY_BOARD_POSES = [SLAVE_SEEN, ["path", "apart", "poses"], ["seen", "seen", "seen"]]
DOT: Keywords = {"ls": "", "markersize": 1.5, "mew": 0, "alpha": 0.7}
DOTTED: Keywords = {"color": INK, "lw": 0.8, "ls": (0, (1, 1.5))}


@figure.styled()
def calibration_figure(files: CalibrationFiles) -> Picture:
    """The figure of `captions.CALIBRATION`; panels without data state why.

    Two plane views show the stations rather than one in 3-D, in which a point has no place that
    can be read off the paper.
    """
    entry: Record = dict(files.chosen or {})
    residuals = (entry.get("details") or {}).get("residuals")
    places = BY_BATCH if residuals else BY_BOARD_POSES
    reason = wrap(figure.wrapped(files.pose["verdict"]["reason"]), REASON)
    head_mm = LINE_MM * max(len(reason), 2)
    heights = [head_mm, RESULT_MM, ROW_MM * len(places) + LEGEND_MM]
    whose = stations.station_words(files.reference_name)
    source = f"Source: {origin_words(files.twin)}. All positions are in the frame of {whose}."
    texts = figure.Texts(f"{files.name}: calibration", source)
    page = figure.new_figure(texts, sum(heights))
    head, result, evidence = page.subfigures(3, 1, squeeze=False, height_ratios=heights)[:, 0]
    word = files.pose["verdict"]["word"]
    colour, behind = figure.VERDICT_WORDS.get(word, figure.UNKNOWN_WORD)  # as on the pages
    box = {"boxstyle": "round,pad=0.35", "facecolor": behind, "edgecolor": colour, "lw": 0.6}
    head.text(0.02, 0.9, word, weight="bold", color=colour, bbox=box, va="top")
    head.text(0.15, 0.98, "\n".join(reason), va="top", linespacing=1.3)
    numbers, above = result.subplots(1, 2, width_ratios=[5, 6])
    evidence.suptitle("Evidence", x=0.01, ha="left")
    axes: dict[str, figure.Axes] = evidence.subplot_mosaic(places)
    _write_pose(numbers, files)
    stations.draw_view(above, files, stations.ABOVE)
    stations.draw_view(axes["right"], files, stations.RIGHT)
    panel_title(above, "Stations from above")
    panel_title(axes["right"], "From the right")
    still = entry.get("stage") == "static"
    seen_from = stations.draw_path(axes["path"], files, still)
    panel_title(axes["path"], f"{'At rest,' if still else 'Path'} {seen_from}".strip(" ,"))
    stations.draw_ellipses([axes["horizontal"], axes["vertical"]], files)
    known = [name for name, entry in files.entries.items() if entry is not None]
    slave = f"Station {known[0]}," if known and known[0].isdigit() else "Slave from"
    panel_title(axes["horizontal"], f"{slave} above")
    panel_title(axes["vertical"], f"{slave} right")
    remarks = []
    if residuals:
        _draw_means(axes, residuals, files.names)
        noise = entry["details"]["noise_hit_urad"]
        remarks.append(_draw_diodes(axes["diodes"], residuals, len(files.board), noise))
    else:
        _draw_disagreement(axes["apart"], files)
        _draw_residuals(axes["poses"], files)
    for empty in (axes[name] for name in ("path", "apart", "poses") if name in axes):
        if not empty.lines:
            empty.set(xticks=[], yticks=[])
            write_message(empty, fill(_why_empty(files), 22))
    remarks.append(_draw_seen(axes["seen"], files))
    figure.letters([above, *axes.values()])
    figure.legend_below(evidence, [above, *axes.values()])
    remarks.append(captions.BEYOND_SIGMA if data.beyond_sigma(entry) else "")
    fit = captions.CALIBRATION_BATCH if residuals else captions.CALIBRATION_BOARD_POSES
    return Picture(evidence, " ".join((captions.CALIBRATION, fit, *remarks)))


def _write_pose(axes: figure.Axes, files: CalibrationFiles) -> None:
    """The pose as a table, and below it the data behind it."""
    axes.axis("off")
    rows = pose_text.all_rows(files)
    lines = [line for fact in pose_text.facts(files) for line in wrap(figure.wrapped(fact), FACT)]
    lines = lines if rows else ["No pose of the slave.", *lines]
    if rows:
        labels, cells = zip(*rows, strict=True)
        where: Keywords = {"bbox": (0.48, 1 - 0.07 * len(rows), 0.72, 0.07 * len(rows))}
        table = axes.table(cellText=cells, rowLabels=labels, edges="open", **where)
        table.auto_set_font_size(value=False)
        table.set_fontsize(figure.SMALL_PT)
    how: Keywords = {"size": figure.SMALL_PT, "va": "top", "linespacing": 1.4}
    axes.text(0.0, 0.95 - 0.07 * len(rows), "\n".join(lines), transform=axes.transAxes, **how)


def _why_empty(files: CalibrationFiles) -> str:
    if files.chosen is None:
        return "No pose of the slave: verdict failed"
    if files.shown_paths() is not None:
        return "No moment with a pose from both stations"
    still = files.chosen["stage"] == "static"
    return "The board was at rest: no path" if still else "No board poses of this estimate"


def _draw_disagreement(axes: figure.Axes, files: CalibrationFiles) -> None:
    """Distance between both paths over time; mirrored moments and those of one station marked."""
    panel_title(axes, "Distance of the paths")
    both = files.agreement()
    if both is None:
        return
    value = np.maximum(both.apart_mm, 1e-3)
    median, most = float(np.median(value)), float(np.percentile(value, 95))
    axes.set(xlim=(0.0, files.duration_s), xlabel="Time (s)", ylabel="Distance (mm)")
    figure.log_axis(axes, "y", log_limits([np.maximum(value, median / 300)], 2.0))
    few = thinned(value.size, MOST_DOTS)
    dots: Keywords = DOT | {"color": "#4d4d4d", "rasterized": value.size > DENSE}
    axes.plot(both.time_s[few], value[few], "o", **dots)
    text = f"median distance: {mm(median, 2)}, 95 % below {mm(most, 2)}"
    axes.axhline(median, color=INK, lw=0.7, ls=(0, (5, 2)), label=text)
    if (turned := np.flatnonzero(both.mirrored)).size:
        turned = turned[thinned(turned.size, MOST_MARKS)]
        how: Keywords = stations.MIRRORED | {"ls": "", "label": "mirrored pose of one station"}
        axes.plot(both.time_s[turned], value[turned], zorder=4, **how)
    for station, alone in enumerate(both.alone_s):
        if alone.size:
            at, label = np.full(alone.size, 0.97 - station / 20), f"only {ROLES[station]} sees it"
            how = {"ms": 3.0, "mew": 0.5, "color": ALL_COLOURS[station], "label": label}
            across = axes.get_xaxis_transform()
            axes.plot(alone, at, "|", transform=across, rasterized=alone.size > DENSE, **how)


def _draw_residuals(axes: figure.Axes, files: CalibrationFiles) -> None:
    """sqrt(epsilon / n_angles) of each board pose over time, both stations, and the noise of one
    angle to expect."""
    panel_title(axes, "Residuals of poses")
    paths = files.shown_paths()
    if paths is None:
        return
    expected = data.expected_urad(files.pose)
    values = [data.residuals_urad(path) for path in paths]
    shown = [np.maximum(v, np.median(v) / 100) for v in values]
    axes.set(xlim=(0.0, files.duration_s), xlabel="Time (s)", ylabel="Residual (µrad)")
    figure.log_axis(axes, "y", log_limits([*shown, np.array([1.5 * expected])]))
    for station, path in enumerate(paths):
        few, colour, mark = thinned(len(path), MOST_DOTS), ALL_COLOURS[station], ALL_MARKS[station]
        how: Keywords = DOT | {"color": colour, "rasterized": len(path) > DENSE}
        axes.plot(path.time_s[few], shown[station][few], mark, zorder=2.2 - station, **how)
        median = significant(float(np.median(values[station])), 2)
        text = f"residuals by the {ROLES[station]}: median {median} µrad"
        axes.plot([], [], mark, color=colour, ms=3.0, mew=0, label=text)
    axes.axhline(expected, label=f"expected noise of an angle: {expected:.0f} µrad", **DOTTED)


def _draw_means(panels: Mapping[str, figure.Axes], residuals: Record, names: Sequence[str]) -> None:
    """Mean residuals with their standard deviations by noise, against azimuth, elevation and time,
    all on one scale."""
    reach = [LEAST_URAD]
    called = dict(zip(AXES, PLANES if names[0].isdigit() else AXES, strict=True))
    for key, (against, label) in MEANS.items():
        axes, typical = panels[key], [0.0]
        of = called.get(key, key).capitalize()
        panel_title(axes, "Mean residuals" if key == "time" else f"{of} residuals")
        axes.axhline(0.0, color=GREY, lw=0.8)
        for row in residuals["against"]:
            if row["against"] != against or key not in ("time", row["axis"]):
                continue
            mean, sd = np.array(row["mean_urad"]), np.array(row["sd_urad"])
            typical.append(float(np.median(sd)))
            reach.append(float(np.abs(mean).max()) + typical[-1])
            station, open_ = names.index(row["station"]), row["axis"] == AXES[1]
            how: Keywords = {"color": ALL_COLOURS[station], "lw": 0.9, "ms": 3.2, "mew": 0.8}
            how |= {"marker": ALL_MARKS[station], "ls": (0, (3, 1.5)) if open_ else "-"}
            how |= {"markerfacecolor": "none"} if open_ else {}
            if key == "time":
                axes.plot(row["at"], mean, label=f"{row['station']}, {called[row['axis']]}", **how)
            else:
                axes.errorbar(row["at"], mean, sd, elinewidth=0.7, **how)
        axes.set(xlabel=label.replace(key.capitalize(), of), ylabel="Mean (µrad)")
    band: Keywords = {"color": GREY, "alpha": 0.2, "lw": 0, "label": "1 σ of a mean by noise"}
    panels["time"].axhspan(-max(typical), max(typical), **band)
    for key in MEANS:
        panels[key].set_ylim(-1.12 * max(reach), 1.12 * max(reach))


def _station_offset(station: int, many: int, half: float) -> float:
    """The offset at which one of many stations is drawn, from -half to half."""
    return half * (2 * station / max(many - 1, 1) - 1)


def _draw_diodes(axes: figure.Axes, residuals: Record, n: int, expected: float) -> str:
    """Root mean square residual of each diode by each station, those of excluded diodes crossed,
    and the noise of a hit. Those far above the rest stand at the upper end. Returns a sentence on
    diodes that the estimate excludes."""
    panel_title(axes, "Residuals of diodes")
    every = np.concatenate([row["rms_urad"] for row in residuals["by_diode"]])
    if not every.size:
        return ""
    top = max(float(min(1.12 * every.max(), HIGHEST * np.median(every))), 1.5 * expected)
    excluded = []
    for station, row in enumerate(residuals["by_diode"]):
        diode, rms = np.array(row["diode"]), np.array(row["rms_urad"])
        at = diode + _station_offset(station, len(residuals["by_diode"]), 0.16)
        shown = np.minimum(rms, 0.96 * top)
        axes.plot(at, shown, ALL_MARKS[station], color=ALL_COLOURS[station], ms=3.2, mew=0)
        out = np.isin(diode, row["excluded"])
        if out.any():
            axes.plot(at[out], shown[out], "x", color=INK, ms=6, mew=1.1, label="excluded diode")
            pairs = zip(diode[out], rms[out], strict=True)
            named = ", ".join(f"{k} ({r:.0f} µrad)" for k, r in pairs)
            excluded.append(f"{row['station']}: {named}")
    axes.axhline(expected, label=f"noise of a hit: {expected:.0f} µrad", **DOTTED)
    axes.set(xlim=(-0.8, n - 0.2), ylim=(0, top), xlabel="Diode (from 0)", ylabel="rms (µrad)")
    return f"Excluded from the estimate, {'; '.join(excluded)}." if excluded else ""


def _draw_seen(axes: figure.Axes, files: CalibrationFiles) -> str:
    """Share of either station's sweeps that each diode saw, pale where it is seldom; dead ones
    crossed. Returns the diodes that are dead, or seen seldom or never, by number."""
    n = len(files.board)
    many = len(files.names)
    shares = data.seen_shares(files.sweeps, n, many)
    sentences, counts = [], {"dead": 0, "faint": 0}
    for station, name in enumerate(files.names):
        states = data.faint_diodes(shares, files.board, station)
        at = np.arange(n) + _station_offset(station, many, 0.4 - 0.4 / many)
        bars = axes.bar(at, 100 * shares[station], 0.8 / many, color=ALL_COLOURS[station])
        for k in states["seldom"]:
            bars[k].set_alpha(0.5)
        dead = states["dead"]
        if dead.size and station == MASTER:
            axes.plot(dead, np.full(dead.size, 9.0), "x", color=INK, ms=4, mew=1.1, label="dead")
        known = {word: diodes for word, diodes in states.items() if diodes.size}
        counts["dead"] = dead.size
        counts["faint"] += sum(diodes.size for word, diodes in known.items() if word != "dead")
        words = "; ".join(
            f"{word}: {', '.join(map(str, diodes))}" for word, diodes in known.items()
        )
        words = words if shares[station].any() else "no sweep seen"
        sentences += [f"Diodes of {stations.station_words(name)}, {words}."] if words else []
    axes.set(xlim=(-0.8, n - 0.2), xlabel="Diode (from 0)", ylabel="Seen (%)")
    axes.set(ylim=(0, 105), yticks=[0, 50, 100])
    axes.grid(visible=False, axis="x")
    remark = ", ".join(f"{count} {word}" for word, count in counts.items() if count)
    panel_title(axes, "Diodes", remark or "all seen")
    return " ".join(sentences)
