"""Recordings of a group side by side: Allan deviations (a panel a series, a curve a recording; by
number of cameras also their ratio to the first), and noise coefficients, as S Figures 14 and 16."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import cycle

import numpy as np
import pandas as pd

from mocap_metrology.common.types import Record
from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR, limit_class
from mocap_metrology.noise.model.components import ALPHAS
from mocap_metrology.present.groups import slots
from mocap_metrology.present.plot import curves as plot
from mocap_metrology.present.plot import figure as fig
from mocap_metrology.present.plot.curves import groups_of, log_limits
from mocap_metrology.present.plot.figure import FAINT, LOOKS, OTHER_LOOKS, Keywords, Look, Picture
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.coefficients import mathtext, unit

COLUMNS = 3
ROW_MM = 66.0  # a panel with its ratios
WITHIN, PAD = (0.005, 0.995), 0.06  # quantiles of the ratios that their axis holds, and beyond them
MOST_BANDS = 3  # curves in a panel up to which their intervals are drawn
LEAST_RANGE = 0.1
Allan = Mapping[str, Mapping[str, np.ndarray]]  # columns of allan_masked.parquet by recording
Panels = Mapping[str, pd.DataFrame]
Rows = Mapping[str, Record]
CAMERAS, RECORDING = "Number of cameras", "Recording"
NAMED_LOOKS = (*LOOKS.values(), *OTHER_LOOKS)  # so many recordings can be distinguished by name
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "h", "<", ">", "p", "8")
MAP, LIGHTEST, DARKEST = "inferno", 0.55, 0.0  # colours whose lightness falls evenly
MOST_MARKERS, MOST_DISTANCES = 3, 3  # with panels of their own


def series_curves(
    allan: Allan, series: str, labels: Mapping[str, str], band: bool = True
) -> pd.DataFrame:
    """Curves of one series of several recordings by the overlapping Allan deviation; labels: name
    of the curve by recording."""
    curves = [
        plot.adev_curves(allan[name], {series: label}, band) for name, label in labels.items()
    ]
    frame = pd.concat(curves, ignore_index=True)
    return frame[frame["thin"] == ""]


def ratio_picture(panels: Panels, looks: plot.Looks, texts: fig.Texts) -> Picture:
    """A panel a series, and under it the curves of that panel divided by its first curve, where
    both have the averaging time. Call it within `styled`."""
    rows, limits = -(-len(panels) // COLUMNS), plot.curve_limits(pd.concat(panels.values()))
    body = fig.new_figure(texts, 24.0 + rows * ROW_MM)
    grid = body.subplots(2 * rows, COLUMNS, sharex=True, squeeze=False, height_ratios=(5, 3) * rows)
    above, below = grid[::2].ravel(), grid[1::2].ravel()
    tables = [ratios(curves) for curves in panels.values()]
    ends = pd.concat(tables)["ratio"].quantile(list(WITHIN)).fillna(1.0)
    low, high = min(*ends, 1.0), max(*ends, 1.0)
    room = max(high - low, LEAST_RANGE) * PAD
    for k, (title, curves) in enumerate(panels.items()):
        fig.log_axes(above[k], limits)
        plot.draw_curves(above[k], curves, limits[1], looks)
        fig.panel_title(above[k], fig.short(title))
        below[k].set_ylim(max(low - room, 0.0), high + room)
        below[k].locator_params(axis="y", nbins=5)
        for order, (name, curve) in enumerate(plot.groups_of(tables[k], "curve")):
            every = plot.markers_every(len(curve), order)
            below[k].plot(curve["x"], curve["ratio"], **looks[name].line(markevery=every))
        for axes in (above[k], below[k]):
            axes.tick_params(labelleft=k % COLUMNS == 0, which="both")
        if k % COLUMNS == 0:
            above[k].set_ylabel(plot.ADEV_AXES[1])
            below[k].set_ylabel(f"Ratio to\n{fig.short(curves['curve'].iloc[0])}")
        if k + COLUMNS >= len(panels):
            below[k].set_xlabel(plot.ADEV_AXES[0])
            below[k].tick_params(labelbottom=True)
    for axes in (*above[len(panels) :], *below[len(panels) :]):
        axes.axis("off")
    if len(panels) < above.size:
        fig.log_axes(above[len(panels)], limits)
        plot.slope_fan(above[len(panels)], limits)
    return fig.finished(body, above[: len(panels)], texts.caption)


def ratios(curves: pd.DataFrame) -> pd.DataFrame:
    """`curve`, `x` and `ratio` to the first curve, where both have that x and are positive."""
    first = curves[curves["curve"] == curves["curve"].iloc[0]].set_index("x")["y"]
    ratio = curves["y"] / curves["x"].map(first)
    both = curves.assign(ratio=ratio.where(np.isfinite(ratio) & (ratio > 0)))
    return both.loc[both["x"].isin(first.index), ["curve", "x", "ratio"]]


@fig.styled()
def family_figure(
    family: Family,
    allan: Allan,
    expected: Mapping[str, Sequence[str]],
    texts: fig.Texts,
    confidence: float | None = None,
) -> Picture:
    """Allan deviations of a family of recordings, as S Figures 8, 12 and 13.

    expected: series that should be there, by recording; a panel shows those that should have its
    series. Subsets of cameras are drawn with their ratio to the smallest one; up to three other
    recordings with their intervals, of that `confidence` (0 to 1).
    """
    shown, others = shown_series([name for names in expected.values() for name in names])
    subsets = family.by == CAMERAS and bool(family.looks)
    band = len(family.labels) <= MOST_BANDS and not subsets
    labels = {name: family.full_label(label) for name, label in family.labels.items()}
    looks = {family.full_label(label): look for label, look in family.looks.items()}
    panels = {}
    for series in shown:
        in_panel = {name: label for name, label in labels.items() if series in expected[name]}
        panels[series] = series_curves(allan, series, in_panel, band)
    words = f"{left_out(others)} {texts.caption}"
    if subsets:
        caption = f"{captions.ADEV} {captions.ADEV_RATIOS} {words}"
        return ratio_picture(panels, looks, texts._replace(caption=caption))
    names = [
        f"{series}: {' and '.join(plot.family_ends(curves))}"
        for series, curves in ({} if looks else panels).items()
        if curves["curve"].nunique() > plot.MOST_SINGLE and (curves["y"] > 0).any()
    ]
    note = captions.ADEV_ENDS.format(names="; ".join(names)) if names else ""
    texts = texts._replace(caption=f"{captions.ADEV} {note} {words}")
    return plot.curves_picture(panels, texts, confidence, looks=looks or None)


def compared_panels(
    allan: Allan, series: Sequence[str], labels: Mapping[str, str], band: bool = True
) -> Panels:
    """A panel a series with the curves of named recordings; labels: by recording."""
    return {one: series_curves(allan, one, labels, band) for one in series}


@dataclass(frozen=True)
class Family:
    """Recordings that are shown together, in the order of the key.

    by: `CAMERAS` or `RECORDING`. labels: of each recording; looks: by label, none where
    there are too many to distinguish.
    """

    by: str
    labels: Mapping[str, str]
    looks: Mapping[str, Look]

    def full_label(self, label: str) -> str:
        """A label that is understood by itself."""
        return f"{label} cameras" if self.by == CAMERAS else label


def family_of(rows: Rows) -> Family:
    """Recordings by their number of cameras where they are subsets of one camera type, no two with
    as many; else by name. rows: of the sheet, by recording."""
    counts = {name: row["n_cameras"] for name, row in rows.items()}
    numbers, types = set(counts.values()), {row["camera_type"] for row in rows.values()}
    if None not in numbers and len(numbers) == len(rows) > 1 and len(types) == 1:
        labels = {name: str(counts[name]) for name in sorted(rows, key=lambda n: counts[n])}
        looks = {str(n): look for n, look in count_looks(list(numbers)).items()}
        return Family(CAMERAS, labels, looks if len(looks) <= len(MARKERS) else {})
    few = len(rows) <= len(NAMED_LOOKS)
    looks = dict(zip(rows, NAMED_LOOKS, strict=False)) if few else {}
    return Family(RECORDING, {name: name for name in rows}, looks)


def count_looks(counts: Sequence[int]) -> dict[int, Look]:
    """Looks of numbers of cameras: the more, the darker, in even steps; a marker each."""
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    counts = sorted(set(counts))
    shades = np.linspace(DARKEST, LIGHTEST, len(counts))[::-1]
    looks = zip(counts, shades, cycle(MARKERS), strict=False)
    return {n: Look(to_hex(colormaps[MAP](shade)), "-", marker) for n, shade, marker in looks}


def shown_series(names: Sequence[str]) -> tuple[list[str], list[str]]:
    """Series with a panel of their own (those of the first three markers, and the first three
    distances), and the others; both in their order."""
    panels = plot.facets(names, len(names))
    markers = [of for title, of in panels.items() if title.startswith("Marker")]
    distances = [of[:MOST_DISTANCES] for title, of in panels.items() if title.startswith("Dist")]
    chosen = {name for of in [*markers[:MOST_MARKERS], *distances] for name in of}
    names = list(dict.fromkeys(names))
    return [name for name in names if name in chosen], [
        name for name in names if name not in chosen
    ]


def left_out(names: Sequence[str]) -> str:
    """A note on series that a figure does not show."""
    if not names:
        return ""
    text = ", ".join(names) if len(names) <= 6 else f"{len(names)} further series"
    return f"Not shown: {text}."


# ---- Noise coefficients

PANEL_MM, SCATTER_MM, REST_MM = 34.0, 84.0, 30.0  # heights: a panel, (c), titles and legend
NAME_MM = 1.6  # of a letter of a recording written upright
NO_TERM = "Correlated noise was not detected in any recording."
MOST_COLUMNS = 8  # of a legend
MOST_FULL = 8  # recordings with a slot a series; of more only the distance, ordered by its noise
# Where there are too many recordings to distinguish
ANY = fig.Look(OTHER_LOOKS[2].colour, "-", "o")
Noise = Mapping[str, Sequence[Record]]  # rows of noise.csv by recording


def marks_of(family: Family, noise: Noise) -> pd.DataFrame:
    """Estimates of the default estimator; `group` is the label of the recording."""
    columns = ("value", "lower_95", "upper_95")
    marks = [
        {"group": label} | slots.estimate_mark(row, [row[k] for k in columns], limit_class(row))
        for name, label in family.labels.items()
        for row in noise[name]
        if row["estimator"] == DEFAULT_ESTIMATOR and row["status"] != "refused"
    ]
    return slots.frame_of(marks)


def _shown(family: Family, marks: pd.DataFrame) -> tuple[Family, pd.DataFrame, list[str], str]:
    """Recordings in their order, marks and series that are drawn, and what the caption says of
    both: of many recordings the distance (or the first series) alone, ordered by its white noise,
    the noisiest first."""
    names = list(dict.fromkeys(marks["series"]))
    shown, others = shown_series(names)
    words = [captions.SLOTS.format(order=", ".join(shown)), left_out(others)]
    if len(family.labels) > MOST_FULL:
        shown = [name for name in shown if not fig.coordinate_of(name)][:1] or shown[:1]
        words = [captions.ONE_SERIES.format(series=", ".join(shown))]
        if family.by == RECORDING:
            h_0 = marks[(marks["coefficient"] == "h_0") & marks["series"].isin(shown)]
            level = h_0.set_index("group")["value"].to_dict()
            order = sorted(family.labels.items(), key=lambda item: -level.get(item[1], 0.0))
            family = replace(family, labels=dict(order))
            words.append(captions.NOISIEST_FIRST)
    return family, marks[marks["series"].isin(shown)], shown, " ".join(filter(None, words))


@fig.styled()
def coefficients_figure(family: Family, noise: Noise, texts: fig.Texts) -> Picture:
    """Coefficients h_-2 ... h_2 of every recording by the likelihood estimator, with intervals: a
    group a recording or number of cameras, a slot a series."""
    family, marks, shown, words = _shown(family, marks_of(family, noise))
    if marks.empty:
        return fig.words_picture(captions.COEFFICIENTS_NONE, texts)
    body = fig.new_figure(texts, REST_MM + len(ALPHAS) * PANEL_MM + _names_mm(family))
    panels = body.subplots(len(ALPHAS), sharex=True)
    for axes, alpha in zip(panels, ALPHAS, strict=True):
        _panel(axes, marks, f"h_{alpha}", shown, family)
    panels[-1].set_xlabel(family.by)
    slots.label_marks(panels[0], marks[marks["coefficient"].str.startswith("h_")], shown)
    caption = f"{captions.COEFFICIENTS} {words} {texts.caption}"
    return fig.finished(body, panels, caption, columns=MOST_COLUMNS)


def _names_mm(family: Family) -> float:
    """Height of the labels of groups, where they are vertical."""
    labels = [fig.short(label) for label in family.labels.values()]
    return NAME_MM * max(map(len, labels)) if slots.upright(labels) else 0.0


def _panel(
    axes: fig.Axes, marks: pd.DataFrame, name: str, shown: Sequence[str], family: Family
) -> None:
    """The panel of one coefficient (h_0, T_c, ...) on an axis of groups."""
    rows, groups = marks[marks["coefficient"] == name], list(family.labels.values())
    slots.group_axis(axes, groups)
    slots.floor_axis(axes, rows)
    slots.draw(axes, rows, groups, shown, slots.FLOOR, coloured=True)
    axes.set_ylabel(f"{mathtext(name)} ({unit(name)})")
    if rows.empty:
        fig.write_message(axes, "not detected in any recording")


@fig.styled()
def correlated_figure(family: Family, noise: Noise, texts: fig.Texts) -> Picture:
    """The figure of `captions.CORRELATED`; where no recording has a Gauss-Markov term, the limits
    of q_c alone."""
    family, marks, shown, words = _shown(family, marks_of(family, noise))
    if marks.empty:
        return fig.words_picture(captions.COEFFICIENTS_NONE, texts)
    marks = marks[marks["coefficient"].isin(["T_c", "q_c"])]
    if marks.empty:
        return fig.words_picture(NO_TERM, texts)
    terms = slots.terms_of(marks)
    names = ["q_c"] if terms.empty else ["T_c", "q_c"]
    heights = [12.0 + len(names) * PANEL_MM + _names_mm(family)] + [SCATTER_MM] * (len(names) - 1)
    body = fig.new_figure(texts, sum(heights) + 18.0)
    parts = body.subfigures(len(heights), height_ratios=heights, squeeze=False)[:, 0]
    panels = parts[0].subplots(len(names), sharex=True, squeeze=False)[:, 0]
    for axes, name in zip(panels, names, strict=True):
        _panel(axes, marks, name, shown, family)
        fig.panel_title(axes, {"T_c": "Correlation time", "q_c": "Amplitude"}[name])
    panels[-1].set_xlabel(family.by)
    slots.label_marks(panels[0], marks, shown)
    if len(terms):
        scatter = parts[1].subplots()
        _scatter(scatter, terms, family)
        fig.legend_below(parts[1], [scatter])
        fig.letters([*panels, scatter])
    fig.legend_below(parts[0], panels, MOST_COLUMNS)
    caption = captions.CORRELATED if len(terms) else f"{NO_TERM} {captions.CORRELATED_LIMITS}"
    return Picture(body, f"{caption} {words} {texts.caption}")


def _scatter(axes: fig.Axes, terms: pd.DataFrame, family: Family) -> None:
    """q_c against T_c, a look a recording, with bars as long as the intervals that are known."""
    across, (low, high) = (log_limits([terms[name]], 2.0) for name in ("T_c", "q_c"))
    fig.log_axes(axes, (across, (low / 4, high * 2)))
    slots.shade_classes(axes, across)
    for label, rows in groups_of(terms, "group"):
        look = family.looks.get(label, ANY)
        how: Keywords = {"ls": "", "marker": look.marker, "markersize": 3.4, "mew": 0, "alpha": 0.9}
        how |= {"color": look.colour, "elinewidth": 0.4}
        how |= {"label": fig.short(family.full_label(label))} if family.looks else {}
        for name, which in (("T_c", "xerr"), ("q_c", "yerr")):
            ends = rows[f"{name}_lower"].clip(lower=rows[name] / 1e3)  # zero is not on this axis
            how |= {which: np.nan_to_num([rows[name] - ends, rows[f"{name}_upper"] - rows[name]])}
        axes.errorbar(rows["T_c"], rows["q_c"], **how)
    axes.fill([], [], color=FAINT, alpha=0.8, lw=0, label="classes of $T_c$ (S 4.6)")
    fig.panel_title(axes, "Amplitude against correlation time", f"{len(terms)} terms")
    axes.set(xlabel="$T_c$ (s)", ylabel=f"$q_c$ ({unit('q_c')})")
