"""Noise coefficients of a group of recordings side by side, as S Figures 14 and 16."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR, unit_key
from mocap_metrology.noise.model.components import ALPHAS
from mocap_metrology.present.fits.parts import limit_class
from mocap_metrology.present.groups import slots
from mocap_metrology.present.groups.members import Family, left_out, shown_series
from mocap_metrology.present.plot.curves import log_limits
from mocap_metrology.present.plot.figure import (
    FAINT,
    OTHER_LOOKS,
    Keywords,
    Look,
    Picture,
    coordinate_of,
    legend_below,
    letters,
    log_axes,
    new_figure,
    panel_title,
    say,
    short,
    styled,
    words_picture,
)
from mocap_metrology.present.tables import Record, Row
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.coefficients import mathtext, unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ROW_MM, SCATTER_MM, REST_MM = 34.0, 84.0, 30.0  # heights: a panel, (c), titles and legend
NAME_MM = 1.6  # of a letter of a recording written upright
NO_MODEL = (
    "No recording has noise coefficients, so there is nothing to draw. The table of noise states "
    "why."
)
NO_TERM = "Correlated noise was not detected in any recording."
MOST_COLUMNS = 8  # of a legend
MOST_SLOTS = 260  # across a panel; with more recordings only the distance is shown
ANY = Look(OTHER_LOOKS[2].colour, "-", "o")  # where there are too many recordings to distinguish
Noise = Mapping[str, Sequence[Record]]  # rows of noise.csv by recording
Term = tuple[str, dict[str, Row]]  # label of its recording, rows of T_c and q_c


def group_rows(family: Family, noise: Noise) -> list[Row]:
    """Estimates of the default estimator as `slots.draw` needs them; the published part is empty,
    and `n_cameras` is the label of the recording."""
    empty = dict.fromkeys(("published", "regenerated", "supported"))
    return [
        empty
        | {"n_cameras": label, "series": row["series"], "parameter": row["parameter"]}
        | {DEFAULT_ESTIMATOR: _known(row["value"]), "limit_class": limit_class(row)}
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
def coefficients_figure(
    family: Family, noise: Noise, title: str, source: str, remarks: str = ""
) -> Picture:
    """Coefficients h_-2 ... h_2 of every recording by the likelihood estimator, with intervals: a
    group a recording or number of cameras, a slot a series. source: the line at the foot; remarks:
    what the caption adds."""
    shown, others = series_of(noise, len(family.labels))
    rows = [row for row in group_rows(family, noise) if row["series"] in shown]
    if not rows:
        return words_picture(NO_MODEL, title, source)
    body = new_figure(title, source, REST_MM + len(ALPHAS) * ROW_MM + _names_mm(family))
    panels = body.subplots(len(ALPHAS), sharex=True)
    for axes, alpha in zip(panels, ALPHAS, strict=True):
        draw_slots(axes, rows, f"h_{alpha}", shown, family)
    panels[-1].set_xlabel(family.by)
    slots.label_series(panels[0], shown)
    slots.label_intervals(panels[0])
    slots.label_limits(panels[0])
    legend_below(body, panels, MOST_COLUMNS)
    order = captions.SLOTS.format(order=", ".join(shown))
    return Picture(body, f"{captions.COEFFICIENTS} {order} {left_out(others)} {remarks}")


def _names_mm(family: Family) -> float:
    """Height of the labels of groups, where they are vertical."""
    labels = [short(label) for label in family.labels.values()]
    return NAME_MM * max(map(len, labels)) if slots.upright(labels) else 0.0


def draw_slots(
    axes: Axes, rows: Sequence[Row], name: str, shown: Sequence[str], family: Family
) -> None:
    """The panel of one coefficient (h_0, T_c, ...) on an axis of groups."""
    of_it = [row for row in rows if unit_key(row["parameter"]) == name]
    groups = list(family.labels.values())
    slots.group_axis(axes, groups)
    slots.floor_axis(axes, slots.floor_limits(of_it) if of_it else (1e-3, 1.0))
    slots.draw(axes, of_it, groups, slots.raised, shown, coloured=True)
    axes.set_ylabel(f"{mathtext(name)} ({unit(name)})")
    if not of_it:
        say(axes, "not detected in any recording")


def terms_of(rows: Sequence[Row]) -> list[Term]:
    """Gauss-Markov terms with both numbers, out of `group_rows`."""
    found: dict[tuple[str, str, str], dict[str, Row]] = {}
    for row in rows:
        if row["parameter"][1:3] == "_c" and row[DEFAULT_ESTIMATOR] is not None:
            key = row["n_cameras"], row["series"], row["parameter"][3:]
            found.setdefault(key, {})[row["parameter"][:3]] = row
    return [(key[0], term) for key, term in found.items() if len(term) == 2]


@styled()
def correlated_figure(
    family: Family, noise: Noise, title: str, source: str, remarks: str = ""
) -> Picture:
    """Gauss-Markov terms of every recording by the likelihood estimator, with 95 % intervals: (a)
    T_c and (b) q_c by recording or number of cameras, (c) q_c against T_c, the classes of S 4.6
    shaded; where no recording has such a term, the limits of q_c alone."""
    shown, others = series_of(noise, len(family.labels))
    every = [row for row in group_rows(family, noise) if row["series"] in shown]
    if not every:
        return words_picture(NO_MODEL, title, source)
    rows = [row for row in every if row["parameter"][1:3] == "_c"]
    if not rows:
        return words_picture(NO_TERM, title, source)
    terms = terms_of(rows)
    names = ("T_c", "q_c") if terms else ("q_c",)
    above = 12.0 + len(names) * ROW_MM + _names_mm(family)
    heights = [above, SCATTER_MM] if terms else [above]
    body = new_figure(title, source, sum(heights) + 18.0)
    parts = body.subfigures(len(heights), height_ratios=heights, squeeze=False)[:, 0]
    panels = parts[0].subplots(len(names), sharex=True, squeeze=False)[:, 0]
    for axes, name in zip(panels, names, strict=True):
        draw_slots(axes, rows, name, shown, family)
        panel_title(axes, {"T_c": "Correlation time", "q_c": "Amplitude"}[name])
    panels[-1].set_xlabel(family.by)
    slots.label_series(panels[0], shown)
    slots.label_limits(panels[0], classes=True)
    if terms:
        slots.label_intervals(panels[0])
        scatter = parts[1].subplots()
        _scatter(scatter, terms, family)
        legend_below(parts[1], [scatter])
        letters([*panels, scatter])
    legend_below(parts[0], panels, MOST_COLUMNS)
    found = captions.CORRELATED if terms else f"{NO_TERM} {captions.CORRELATED_LIMITS}"
    order = captions.SLOTS.format(order=", ".join(shown))
    return Picture(body, f"{found} {order} {left_out(others)} {remarks}")


def _scatter(axes: Axes, terms: Sequence[Term], family: Family) -> None:
    """q_c against T_c, a look a recording, with bars as long as the intervals that are known."""
    values = [
        np.array([term[name][DEFAULT_ESTIMATOR] for _, term in terms], dtype=np.float64)
        for name in ("T_c", "q_c")
    ]
    across, (low, high) = (log_limits([v], 2.0) for v in values)
    log_axes(axes, (across, (low / 4, high * 2)))
    slots.shade_classes(axes, across)
    for label, look in family.looks.items() or (("", ANY),):
        own = [k for k, (of, _) in enumerate(terms) if label in ("", of)]
        if own:
            text = short(family.said(label)) if label else None
            _draw_terms(axes, [terms[k][1] for k in own], look, text)
    axes.fill([], [], color=FAINT, alpha=0.8, lw=0, label="classes of $T_c$ (S 4.6)")
    panel_title(axes, "Amplitude against correlation time", f"{len(terms)} terms")
    axes.set(xlabel="$T_c$ (s)", ylabel=f"$q_c$ ({unit('q_c')})")


def _draw_terms(axes: Axes, terms: Sequence[dict[str, Row]], look: Look, text: str | None) -> None:
    (x, x_bars), (y, y_bars) = (_bars([term[name] for term in terms]) for name in ("T_c", "q_c"))
    how: Keywords = {"ls": "", "marker": look.marker, "markersize": 3.4, "mew": 0, "alpha": 0.9}
    how |= {"color": look.colour, "elinewidth": 0.4, "label": text}
    axes.errorbar(x, y, yerr=y_bars, xerr=x_bars, **how)


def _bars(rows: Sequence[Row]) -> tuple[np.ndarray, np.ndarray]:
    """Estimates (n,) and how far their intervals reach (2, n), 0 where unknown."""
    keys = (DEFAULT_ESTIMATOR, *(f"{DEFAULT_ESTIMATOR}_{end}_95" for end in ("lower", "upper")))
    value, low, high = (np.array([row[key] for row in rows], dtype=np.float64) for key in keys)
    known = np.isfinite(low) & np.isfinite(high)
    return value, np.where(known, [value - np.maximum(low, 1e-30), high - value], 0.0)
