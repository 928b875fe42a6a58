"""The errors of a bar: how large, where, and what they are made of, in a figure and in words."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mocap_metrology.accuracy.bar import STATISTICS, Bar
from mocap_metrology.accuracy.bar_rows import bar_numbers, place_rows
from mocap_metrology.accuracy.findings import Finding
from mocap_metrology.accuracy.statistics import FEWEST
from mocap_metrology.common.types import Record, Row
from mocap_metrology.present.plot import figure as plot
from mocap_metrology.present.tables import in_columns
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import ARITHMETIC, mm, significant
from mocap_metrology.present.text.sentence import render
from mocap_metrology.settings import Bar as Settings

HEIGHT_MM, ROW_MM = 112.0, 9.0
POINTS = 400  # of a cumulative curve
MAPS, CELLS = 4, 16  # at most
LEAST_FRAMES = 5  # of a square
FEW_SEEN = 0.9  # of the frames, below which the share is told
ROOM_MM, AROUND_MM = (75.0, 70.0), (14.0, 14.0)  # of all maps; of each for labels and title
PARTS = {  # of the mean square: colour, and whether the letters on it are white
    "bias": ("#0d2a6b", True),
    "pass": ("#5b7fc4", True),
    "place": ("#962c10", True),
    "rest": ("#d9a441", False),
    "frame": ("#e8dcc0", False),
}
NAMED = {"bias": "mean", "pass": "between passes", "place": "place", "rest": "rest",
         "frame": "frame to frame"}  # fmt: skip
LEAST_SHARE = 0.1  # of a bar, below which a part has no number on it
LOOKS = (*plot.LOOKS.values(), *plot.OTHER_LOOKS)


@plot.styled()
def bar_figure(
    bar: Bar, cell_mm: float, settings: Settings, texts: plot.Texts, still_mm: float | None = None
) -> plot.Picture:
    """The figure of `captions.BAR`. cell_mm: edge of the squares of maps, at least; still_mm:
    standard deviation at rest."""
    rows = len(bar.classes)
    body = plot.new_figure(texts, HEIGHT_MM + ROW_MM * rows)
    ratios = [4.5, 1.2 + 0.5 * rows]
    upper, lower = np.ravel(body.subfigures(2, 1, squeeze=False, height_ratios=ratios))
    left, right = np.ravel(upper.subfigures(1, 2, squeeze=False, width_ratios=[1.0, 1.1]))
    axes = left.subplots()
    _cumulative(axes, bar, settings, still_mm)
    plot.legend_below(left, [axes], columns=2)
    maps = _maps(right, bar, cell_mm)
    below = lower.subplots()
    _parts(below, bar)
    plot.letters([axes, *maps, below])
    return plot.Picture(body, captions.BAR)


def _cumulative(axes: plot.Axes, bar: Bar, settings: Settings, still_mm: float | None) -> None:
    """Share of the frames with a larger error, both axes logarithmic."""
    share = np.geomspace(1e-3, 1.0, POINTS)
    sizes = []
    for one, look in zip(bar.classes, itertools.cycle(LOOKS), strict=False):
        passes = [np.abs(e[np.isfinite(e)]) for e in one.errors]
        for errors in passes if len(passes) > 1 else []:
            axes.plot(np.quantile(errors, 1 - share), share, color=look.colour, lw=0.5, alpha=0.5)
        curve = np.quantile(np.concatenate(passes), 1 - share)
        sizes.append(curve)
        axes.plot(curve, share, color=look.colour, ls=look.dashes, lw=1.8, label=one.name)
    if still_mm:
        from scipy.stats import halfnorm

        still = halfnorm.isf(share, scale=still_mm)
        axes.plot(still, share, color=plot.GREY, lw=1.5, label="at rest")
    largest = max(float(curve.max()) for curve in sizes)
    least = min(float(np.interp(0.9, share, curve)) for curve in sizes)
    if bar.certificate:
        largest = max(largest, 1.2 * settings.usable_mm)
        least = min(least, settings.usable_mm / 1.2)
    least = max(least, 1e-3 * largest)
    limits = ((settings.good_mm, "good"), (settings.usable_mm, "usable")) if bar.certificate else ()
    for limit, word in limits:
        if limit > least:  # text beyond the axes would leave no room for them
            axes.axvline(limit, color=plot.GREY, ls=":", lw=0.8)
            how: plot.Keywords = {"xycoords": ("data", "axes fraction"), "rotation": 90}
            how |= {"xytext": (-1, 3), "textcoords": "offset points", "ha": "right"}
            how |= {"fontsize": plot.SMALL_PT, "color": plot.GREY}
            axes.annotate(word, (limit, 0.0), bbox={"color": "white", "pad": 0.5}, **how)
    axes.axhline(0.05, color=plot.FAINT, lw=0.8, zorder=0)
    plot.log_axes(axes, ((least, 1.2 * largest), (1e-3, 1.0)))
    axes.set_yticks([1, 0.5, 0.1, 0.05, 0.01, 0.001], ["100 %", "50", "10", "5", "1", "0.1"])
    axes.set_xlabel("error of the length (mm)" if bar.certificate else "length − its mean (mm)")
    axes.set_ylabel("frames with a larger error")
    plot.panel_title(axes, "How large")


def _maps(parent: plot.SubFigure, bar: Bar, cell_mm: float) -> list[plot.Axes]:
    """A map of each class on the plane in which the places extend most, in CELLS squares at
    most."""
    middles = np.concatenate([m for one in bar.classes for m in one.middles], axis=1)
    known = middles[:, np.isfinite(middles).all(axis=0)]
    extent = np.ptp(known, axis=1)
    across, up = sorted(np.argsort(-extent)[:2])
    cell = max(cell_mm, float(extent.max()) / CELLS)
    rows = place_rows(bar, cell, LEAST_FRAMES)
    shown = {one.name: [r for r in rows if r["class"] == one.name] for one in bar.classes}
    shown = dict([(name, cells) for name, cells in shown.items() if cells][:MAPS])
    if not shown:
        axes = parent.subplots()
        axes.axis("off")
        plot.write_message(axes, "too few frames in any cube for a map")
        return [axes]
    flat = _columns(len(shown), float(extent[across] / max(extent[up], cell)))
    ends = [((cells.min() - cell) / 1000, (cells.max() + cell) / 1000) for cells in known]
    panels = parent.subplots(-(-len(shown) // flat), flat, squeeze=False)
    errors = np.array([row["error_mm"] for row in rows], dtype=np.float64)
    reach = float(np.abs(errors).max()) or 1.0
    for axes, (name, cells) in zip(panels.flat, shown.items(), strict=False):
        x, y, values = _squares(cells, f"{'xyz'[across]}_mm", f"{'xyz'[up]}_mm", cell)
        how: plot.Keywords = {"cmap": "coolwarm", "vmin": -reach, "vmax": reach}
        drawn = axes.pcolormesh(x / 1000, y / 1000, values, edgecolor="white", lw=0.5, **how)
        axes.set(aspect="equal", xlim=ends[across], ylim=ends[up])
        axes.set(xlabel=f"{'xyz'[across]} (m)", ylabel=f"{'xyz'[up]} (m)")
        axes.label_outer()
        plot.panel_title(axes, name if flat == 1 else name.replace(", ", ",\n"))
    for axes in panels.flat[len(shown) :]:
        axes.axis("off")
    parent.colorbar(drawn, ax=list(panels.flat), label="mean error (mm)", shrink=0.8)
    return list(panels.flat[: len(shown)])


def _columns(n: int, wide: float) -> int:
    """The number of columns in which n maps of this ratio of width and height are largest."""

    def width(columns: int) -> float:
        rows = -(-n // columns)
        room = [ROOM_MM[0] / columns - AROUND_MM[0], ROOM_MM[1] / rows - AROUND_MM[1]]
        return min(room[0], wide * room[1])

    return max((1, 2), key=width)


def _squares(
    rows: Sequence[Row], across: str, up: str, cell: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Edges of squares and their mean errors, weighted by frames over what lies behind."""
    names = (across, up, "n_frames", "error_mm")
    x, y, n, error = np.array([[row[k] for row in rows] for k in names], dtype=np.float64)
    xs, ys = (v.min() + cell * (np.arange(round(np.ptp(v) / cell) + 2) - 0.5) for v in (x, y))
    sums, frames = (np.histogram2d(y, x, (ys, xs), weights=w)[0] for w in (n * error, n))
    with np.errstate(invalid="ignore"):
        return xs, ys, sums / frames


def _parts(axes: plot.Axes, bar: Bar) -> None:
    """A row a class: shares of the mean square error, sizes in mm on them."""
    for row, one in enumerate(bar.classes):
        start = 0.0
        sizes = one.parts.of_mean_square
        total = sum(size**2 for size in sizes.values()) or 1.0
        for name, size in sizes.items():
            share = size**2 / total
            colour, white = PARTS[name]
            label = NAMED[name] if row == 0 else None
            axes.barh(row, share, left=start, color=colour, label=label, height=0.7)
            if share > LEAST_SHARE:
                how: plot.Keywords = {"ha": "center", "va": "center", "fontsize": plot.SMALL_PT}
                ink = "white" if white else plot.INK
                axes.text(start + share / 2, row, mm(size, 2), color=ink, **how)
            start += share
    axes.set_yticks(range(len(bar.classes)), [one.name for one in bar.classes])
    axes.invert_yaxis()
    axes.set_xlim(0, 1)
    axes.set_xticks([0, 0.25, 0.5, 0.75, 1], ["0", "25", "50", "75", "100 %"])
    axes.set_xlabel("share of the mean square")
    axes.legend(ncols=len(PARTS), loc="lower right", bbox_to_anchor=(1.01, 0.97), frameon=False,
                fontsize=plot.SMALL_PT, columnspacing=1.2, handlelength=1.2)  # fmt: skip
    plot.panel_title(axes, "Made of")


def bar_document(
    bar: Bar,
    findings: Sequence[Finding],
    settings: Settings,
    pair: Sequence[str],
    warnings: Sequence[str] = (),
    **parts: Any,
) -> Row:
    """Contents of bar.json: its numbers (`bar_numbers`, as `parts`) and words."""
    document = bar_numbers(bar, findings, settings, pair, **parts)
    document["reason"] = reason(document)
    document["sentences"] = sentences(document)
    little = [render("bar.seen", seen=bar.seen)] if bar.seen < FEW_SEEN else []
    document["warnings"] = [*warnings, *little]
    return document


def reason(document: Record) -> str:
    """The sentence of the word."""
    worst = next(c for c in document["classes"] if c["class"] == document["worst"])
    numbers = {"p95": worst["statistics_mm"]["p95"]["value"], "one": len(document["classes"]) == 1}
    return render("bar.precise" if document["certificate"] is None else "bar.accuracy",
                  **{**document, **numbers})  # fmt: skip


def sentences(document: Record) -> list[str]:
    """What follows from a bar beside its word: the mean and the scale, findings, what else would be
    needed."""
    said = []
    if document["certificate"]:
        known = document["certificate"] | {"fewest": FEWEST}
        said += [render("bar.mean", c=c, **known) for c in document["classes"]]
    of_class = {one["class"]: len(one["passes"]) for one in document["classes"]}
    means = {
        one["class"]: dict(zip(one["passes"], one["pass_means_mm"], strict=True))
        for one in document["classes"]
    }
    for one in document["findings"]:
        earlier, later = document["pair"][:: 1 if one["value"] > 0 else -1]
        known = {"passes": of_class.get(one["series"], 0), "earlier": earlier, "later": later}
        if one["code"] == "by_pass":
            known["farthest"], known["away"] = _farthest(means[one["series"]])
        said.append(render(f"bar.{one['code']}", **one, **known, fewest=FEWEST))
    if document["scale"] and not any(f["code"] == "scale_slope" for f in document["findings"]):
        said.append(render("bar.no_slope", **document["scale"]))
    if document["certificate"] and not document["certificate"]["u_mm"]:
        said.append(render("bar.exact"))
    passes = len({name for one in document["classes"] for name in one["passes"]})
    if few := sum(count < FEWEST for count in of_class.values()):
        said.append(render("bar.few", few=few, of=len(of_class), passes=passes, fewest=FEWEST))
    return said


def _farthest(means: Mapping[str, float]) -> tuple[str, float]:
    """The pass whose mean is farthest from the median of all, and by how much."""
    middle = float(np.median(list(means.values())))
    name = max(means, key=lambda one: abs(means[one] - middle))
    return name, means[name] - middle


def bar_words(documents: Sequence[Record]) -> list[str]:
    """Word, reason, sentences and warnings of some bars, each with its markers where they are
    several."""
    said = []
    for one in documents:
        name = f" on {' and '.join(one['pair'])}" if len(documents) > 1 else ""
        said += [f"Verdict{name}: {one['word']}. {one['reason']}", *one["sentences"]]
        said += [f"Warning: {words}." for words in one["warnings"]]
    return said


def bar_lines(document: Record) -> list[str]:
    """What `check --bar` prints."""
    rows = [["", "passes", "frames", "n_eff", *STATISTICS]]
    for one in document["classes"]:
        values = (one["statistics_mm"][name]["value"] for name in STATISTICS)
        sizes = [significant(v if abs(v) > ARITHMETIC["mm"] else 0.0) for v in values]
        counts = [len(one["passes"]), one["n_frames"], f"{one['n_eff']:.0f}"]
        rows.append([one["class"], *map(str, counts), *sizes])
    against = "certificate" if document["certificate"] else "mean"
    pair = " and ".join(document["pair"])
    length = f"{against}, {document['reference_mm']:.6g} mm"
    head = f"Error of the length of {pair} against its {length}, in mm:"
    clusters = [render("bar.cluster", **one) for one in document["clusters"]]
    return [
        f"{document['recording']}: {document['word']}",
        document["reason"],
        *document["sentences"],
        *clusters,
        "",
        head,
        *in_columns(rows),
        "",
        f"Not covered: {', '.join(document['not_covered'])}.",
        *(f"warning: {words}" for words in document["warnings"]),
    ]
