"""Noise coefficients of a group of recordings side by side, as S Figures 14 and 16."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from mocap_metrology.common.types import Record
from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR, limit_class
from mocap_metrology.noise.model.components import ALPHAS
from mocap_metrology.present.groups import slots
from mocap_metrology.present.groups.adev import RECORDING, Family, left_out, shown_series
from mocap_metrology.present.plot import figure as fig
from mocap_metrology.present.plot.curves import groups_of, log_limits
from mocap_metrology.present.plot.figure import FAINT, OTHER_LOOKS, Keywords, Picture
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.coefficients import mathtext, unit

ROW_MM, SCATTER_MM, REST_MM = 34.0, 84.0, 30.0  # heights: a panel, (c), titles and legend
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
    body = fig.new_figure(texts, REST_MM + len(ALPHAS) * ROW_MM + _names_mm(family))
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
    own, groups = marks[marks["coefficient"] == name], list(family.labels.values())
    slots.group_axis(axes, groups)
    slots.floor_axis(axes, own)
    slots.draw(axes, own, groups, shown, slots.FLOOR, coloured=True)
    axes.set_ylabel(f"{mathtext(name)} ({unit(name)})")
    if own.empty:
        fig.say(axes, "not detected in any recording")


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
    heights = [12.0 + len(names) * ROW_MM + _names_mm(family)] + [SCATTER_MM] * (len(names) - 1)
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
    for label, own in groups_of(terms, "group"):
        look = family.looks.get(label, ANY)
        how: Keywords = {"ls": "", "marker": look.marker, "markersize": 3.4, "mew": 0, "alpha": 0.9}
        how |= {"color": look.colour, "elinewidth": 0.4}
        how |= {"label": fig.short(family.full_label(label))} if family.looks else {}
        for name, which in (("T_c", "xerr"), ("q_c", "yerr")):
            ends = own[f"{name}_lower"].clip(lower=own[name] / 1e3)  # zero is not on this axis
            how |= {which: np.nan_to_num([own[name] - ends, own[f"{name}_upper"] - own[name]])}
        axes.errorbar(own["T_c"], own["q_c"], **how)
    axes.fill([], [], color=FAINT, alpha=0.8, lw=0, label="classes of $T_c$ (S 4.6)")
    fig.panel_title(axes, "Amplitude against correlation time", f"{len(terms)} terms")
    axes.set(xlabel="$T_c$ (s)", ylabel=f"$q_c$ ({unit('q_c')})")
