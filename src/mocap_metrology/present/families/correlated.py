"""Correlated noise of a group of recordings, as S Figure 16: T_c and q_c, and q_c against T_c."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR
from mocap_metrology.present.drawing.decades import decade_axis, log_limits
from mocap_metrology.present.drawing.legend import Entry, strip, strip_height
from mocap_metrology.present.drawing.style import (
    FAINT,
    MARGIN_MM,
    OTHER_LOOKS,
    WIDTH_MM,
    Look,
    blank_sheet,
    head,
    label_axes,
    styled,
    words_figure,
)
from mocap_metrology.present.families import slots
from mocap_metrology.present.families.coefficients import (
    LEFT_MM,
    NO_MODEL,
    WIDE_MM,
    Noise,
    group_rows,
    panels_mm,
    series_of,
    slot_panels,
)
from mocap_metrology.present.families.members import Family, left_out
from mocap_metrology.present.numbers import unit
from mocap_metrology.present.skurowski.correlated import shade_classes
from mocap_metrology.present.tables import Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TITLE_MM, SCATTER_MM, LABELS_MM, BETWEEN_MM = 5.5, 62.0, 11.0, 4.0
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
    second = key_top + strip_height(entries, width) + BETWEEN_MM + TITLE_MM
    last = second + SCATTER_MM + LABELS_MM
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


def _dot(look: Look) -> dict[str, object]:
    return {"color": look.colour, "marker": look.marker, "markersize": 3.4, "mew": 0}


def _scatter(axes: Axes, terms: Sequence[Term], looks: dict[str, Look]) -> None:
    values = {
        name: np.array([term[name][DEFAULT_ESTIMATOR] for _, term in terms], dtype=np.float64)
        for name in ("T_c", "q_c")
    }
    limits = {name: log_limits([v], 2.0) if v.size else NOTHING[name] for name, v in values.items()}
    decade_axis(axes, "x", limits["T_c"], WIDE_MM)
    decade_axis(axes, "y", (limits["q_c"][0] / 4, limits["q_c"][1] * 2), SCATTER_MM)
    shade_classes(axes, limits["T_c"])
    if not terms:
        how = {"transform": axes.transAxes, "ha": "center", "va": "center"}
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
