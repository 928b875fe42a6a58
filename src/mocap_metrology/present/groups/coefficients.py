"""Noise coefficients of a group of recordings side by side, as S Figures 14 and 16."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR, unit_key
from mocap_metrology.noise.model.components import ALPHAS
from mocap_metrology.present.drawing.axes import Limits, decade_axis, log_limits
from mocap_metrology.present.drawing.legend import Entry, strip, strip_height
from mocap_metrology.present.drawing.style import (
    FAINT,
    GREY,
    MARGIN_MM,
    OTHER_LOOKS,
    SMALL_PT,
    WIDTH_MM,
    Keywords,
    Sheet,
    blank_sheet,
    coordinate_of,
    head,
    label_axes,
    shorten,
    styled,
    text_mm,
    words_figure,
)
from mocap_metrology.present.groups import slots
from mocap_metrology.present.groups.members import Family, left_out, shown_series
from mocap_metrology.present.plot.figure import Look
from mocap_metrology.present.tables import Record, Row
from mocap_metrology.present.text.coefficients import symbol, unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LEFT_MM, RIGHT_MM, TOP_MM, ROW_MM, BETWEEN_MM, LABELS_MM = 17.0, 3.0, 3.0, 32.0, 3.0, 5.0
WIDE_MM = WIDTH_MM - LEFT_MM - RIGHT_MM
NAME_MM = 30.0  # of a recording written upright
NO_MODEL = (
    "No recording has noise coefficients, so there is nothing to draw; the table of noise says "
    "why. Every group has this figure, so it stands here as a sentence."
)
MOST_SLOTS = 260  # across a panel; with more recordings only the distance is shown
Noise = Mapping[str, Sequence[Record]]  # rows of noise.csv by recording


def group_rows(family: Family, noise: Noise) -> list[Row]:
    """Estimates of the default estimator as `slots.draw` takes them; what is published is empty,
    and `n_cameras` is the label of the recording."""
    empty = dict.fromkeys(("published", "regenerated", "supported"))
    return [
        empty
        | {"n_cameras": label, "series": row["series"], "parameter": row["parameter"]}
        | {DEFAULT_ESTIMATOR: _known(row["value"])}
        | {f"{DEFAULT_ESTIMATOR}_{end}": _known(row[end]) for end in ("lower_95", "upper_95")}
        for name, label in family.labels.items()
        for row in noise[name]
        if row["estimator"] == DEFAULT_ESTIMATOR and row["status"] != "refused"
    ]


def _known(value: float) -> float | None:
    return None if np.isnan(value) else float(value)


def series_of(noise: Noise, n_groups: int) -> tuple[list[str], list[str]]:
    """Series that have a slot in each group, and the others: with very many recordings only the
    first distance, or else the first series, has one."""
    names = list(dict.fromkeys(row["series"] for rows in noise.values() for row in rows))
    shown, others = shown_series(names)
    if n_groups * (len(shown) + slots.EMPTY_SLOTS) > MOST_SLOTS:
        shown = [name for name in shown if not coordinate_of(name)][:1] or shown[:1]
        others = [name for name in names if name not in shown]
    return shown, others


@styled()
def coefficients_figure(family: Family, noise: Noise, title: str, note: str = "") -> Figure:
    """Coefficients h_-2 ... h_2 of every recording by the likelihood estimator, with intervals: a
    group a recording or number of cameras, a slot a series."""
    shown, others = series_of(noise, len(family.labels))
    rows = [row for row in group_rows(family, noise) if row["series"] in shown]
    if not rows:
        return words_figure(NO_MODEL, title, note)
    names = [f"h_{alpha}" for alpha in ALPHAS]
    entries = slots.coloured_entries(shown)
    width = WIDTH_MM - 2 * MARGIN_MM
    key_top = TOP_MM + panels_mm(len(names), family)
    order = f"In each group from left to right: {', '.join(shown)}."
    sheet = blank_sheet(
        key_top + strip_height(entries, width) + 1.5, title, f"{order} {left_out(others)} {note}"
    )
    slot_panels(sheet, TOP_MM, rows, names, shown, family)
    strip(sheet, MARGIN_MM, key_top, width, entries)
    return sheet.figure


def panels_mm(count: int, family: Family) -> float:
    """Height of so many panels, with the labels below the last."""
    return count * (ROW_MM + BETWEEN_MM) - BETWEEN_MM + _names_mm(family) + LABELS_MM


def _names_mm(family: Family) -> float:
    """Height of the labels of groups: upright where they would touch side by side."""
    widths = [text_mm(label, SMALL_PT) for label in family.labels.values()]
    if max(widths, default=0.0) < 0.9 * WIDE_MM / max(len(widths), 1):
        return 5.0
    return min(max(widths), NAME_MM) + 3.0


def slot_panels(
    sheet: Sheet,
    top: float,
    rows: Sequence[Row],
    names: Sequence[str],
    shown: Sequence[str],
    family: Family,
) -> None:
    """A panel a coefficient, one below the other, on one axis of groups; `names`: h_0, T_c, ..."""
    groups = list(family.labels.values())
    for k, name in enumerate(names):
        of_it = [row for row in rows if unit_key(row["parameter"]) == name]
        axes = sheet.axes(LEFT_MM, top + k * (ROW_MM + BETWEEN_MM), WIDE_MM, ROW_MM)
        lowest = k == len(names) - 1
        slots.camera_axis(axes, groups, lowest)
        slots.log_axis(axes, _limits(of_it), ROW_MM, labels=True)
        slots.draw(axes, of_it, groups, slots.raised, shown, coloured=True)
        label_axes(axes, y=f"{symbol(name)} ({unit(name)})", y_mm=13.5)
        if lowest:
            _label_groups(axes, family)
        if not of_it:
            how: Keywords = {"transform": axes.transAxes, "ha": "center", "va": "center"}
            axes.text(0.5, 0.5, "not found in any recording", color=GREY, **how)


def _limits(rows: Sequence[Row]) -> Limits:
    return slots.floor_limits(rows) if rows else (1e-3, 1.0)


def _label_groups(axes: Axes, family: Family) -> None:
    """Labels side by side, or upright and shortened; as many as there is room for."""
    from matplotlib.ticker import FixedFormatter, FixedLocator

    labels, height = list(family.labels.values()), _names_mm(family)
    every = max(-(-len(labels) * 3 // int(WIDE_MM)), 1)
    texts = [shorten(label, SMALL_PT, NAME_MM) for label in labels]
    axes.xaxis.set_major_locator(FixedLocator(range(0, len(labels), every)))
    axes.xaxis.set_major_formatter(FixedFormatter(texts[::every]))
    upright = {"rotation": 90, "labelsize": SMALL_PT} if height > 5.0 else {}
    axes.tick_params(axis="x", **upright)
    label_axes(axes, x=family.by, x_mm=height + 1.5)


TITLE_MM, SCATTER_MM, SCATTER_LABELS_MM, SCATTER_BETWEEN_MM = 5.5, 62.0, 11.0, 4.0
NOTHING = {"T_c": (2e-3, 5e2), "q_c": (1e-4, 1.0)}  # limits where there is no term
ANY = Look(OTHER_LOOKS[2].colour, "-", "o")  # where recordings are too many to tell apart
Term = tuple[str, dict[str, Row]]  # label of its recording, rows of T_c and q_c


def terms_of(rows: Sequence[Row]) -> list[Term]:
    """Gauss-Markov terms with both numbers, out of `group_rows`."""
    found: dict[tuple[str, str, str], dict[str, Row]] = {}
    for row in rows:
        if row["parameter"][1:3] == "_c" and row[DEFAULT_ESTIMATOR] is not None:
            key = row["n_cameras"], row["series"], row["parameter"][3:]
            found.setdefault(key, {})[row["parameter"][:3]] = row
    return [(key[0], term) for key, term in found.items() if len(term) == 2]


@styled()
def correlated_figure(family: Family, noise: Noise, title: str, note: str = "") -> Figure:
    """Gauss-Markov terms of every recording by the likelihood estimator, with 95 % intervals: (a)
    T_c and q_c by recording or number of cameras, (b) q_c against T_c, the classes of S 4.6
    shaded."""
    shown, others = series_of(noise, len(family.labels))
    rows = [row for row in group_rows(family, noise) if row["series"] in shown]
    if not rows:
        return words_figure(NO_MODEL, title, note)
    entries, looks = slots.coloured_entries(shown), family.looks
    scatter = [Entry(family.said(label), dot=_dot(look)) for label, look in looks.items()]
    scatter.append(Entry("classes of T_c (S 4.6)", patch={"color": FAINT, "alpha": 0.8, "lw": 0}))
    width = WIDTH_MM - 2 * MARGIN_MM
    key_top = TITLE_MM + panels_mm(2, family)
    second = key_top + strip_height(entries, width) + SCATTER_BETWEEN_MM + TITLE_MM
    last = second + SCATTER_MM + SCATTER_LABELS_MM
    order = (
        f"In each group of (a) from left to right: {', '.join(shown)}. A limit of q_c holds for a "
        "class of T_c."
    )
    sheet = blank_sheet(
        last + strip_height(scatter, width) + 1.5, title, f"{order} {left_out(others)} {note}"
    )
    slot_panels(sheet, TITLE_MM, rows, ("T_c", "q_c"), shown, family)
    head(sheet.figure.axes[0], f"(a) By {family.by.lower()}")
    strip(sheet, MARGIN_MM, key_top, width, entries)
    axes = sheet.axes(LEFT_MM, second, WIDE_MM, SCATTER_MM)
    terms = terms_of(rows)
    _scatter(axes, terms, looks)
    head(axes, "(b) Amplitude against correlation time", f"{len(terms)} terms")
    label_axes(axes, x="T_c (s)", y=f"q_c ({unit('q_c')})", y_mm=13.5)
    strip(sheet, MARGIN_MM, last, width, scatter)
    return sheet.figure


def _dot(look: Look) -> Keywords:
    return {"color": look.colour, "marker": look.marker, "markersize": 3.4, "mew": 0}


def _scatter(axes: Axes, terms: Sequence[Term], looks: Mapping[str, Look]) -> None:
    values = {
        name: np.array([term[name][DEFAULT_ESTIMATOR] for _, term in terms], dtype=np.float64)
        for name in ("T_c", "q_c")
    }
    limits = {name: log_limits([v], 2.0) if v.size else NOTHING[name] for name, v in values.items()}
    decade_axis(axes, "x", limits["T_c"], WIDE_MM)
    decade_axis(axes, "y", (limits["q_c"][0] / 4, limits["q_c"][1] * 2), SCATTER_MM)
    slots.shade_classes(axes, limits["T_c"])
    if not terms:
        how: Keywords = {"transform": axes.transAxes, "ha": "center", "va": "center"}
        axes.text(0.5, 0.5, "no correlated noise was found", **how)
    for label, look in looks.items() or ((None, ANY),):
        own = [k for k, (of, _) in enumerate(terms) if label is None or of == label]
        if own:
            _draw_terms(axes, [terms[k][1] for k in own], look)


def _draw_terms(axes: Axes, terms: Sequence[dict[str, Row]], look: Look) -> None:
    """Points with bars as long as the intervals that are known."""
    x, y = ([term[name][DEFAULT_ESTIMATOR] for term in terms] for name in ("T_c", "q_c"))
    axes.plot(x, y, ls="", **_dot(look), alpha=0.9)
    for name, draw, across in (("T_c", axes.hlines, y), ("q_c", axes.vlines, x)):
        ends = [
            [term[name][f"{DEFAULT_ESTIMATOR}_{end}_95"] for term in terms]
            for end in ("lower", "upper")
        ]
        known = [k for k in range(len(terms)) if None not in (ends[0][k], ends[1][k])]
        low, high = (np.maximum([end[k] for k in known], 1e-30) for end in ends)
        draw([across[k] for k in known], low, high, color=look.colour, lw=0.4, alpha=0.6)
