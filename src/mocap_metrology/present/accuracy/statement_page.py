"""The statement of uncertainty on one page (A4)."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from mocap_metrology.common.files import whole
from mocap_metrology.present.plot import figure as plot
from mocap_metrology.present.tables import Row
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import number, percent, significant, with_unit
from mocap_metrology.present.text.sentence import render

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PAGE_MM, MARGIN, COLUMN = (210.0, 297.0), 20.0, 50.0
LINE_MM, ROW_MM = 4.3, 5.6
LETTERS = 78  # in a line of the right column
BUDGET = (20.0, 92.0, 112.0, 132.0, 136.0)  # contribution; ends of type, u, dof; start of share
SHARE_MM = 40.0
TABLE = (20.0, 66.0, 79.0, 102.0, 121.0, 133.0, 145.0, 169.0, 190.0)
HEAD = (
    "Direction",
    "passes",
    "days",
    "correction",
    r"$\mathbf{u_c}$",
    "dof",
    "k",
    "U, one frame",
    "U, mean",
)
LEAST_SHARE = 0.005  # below it a share has no bar
MOST = 8  # directions
BLUE = "#5b7fc4"


@plot.styled()
def statement_page(document: Row, group: str, source: str) -> Figure:
    """The figure; its axes are the page in mm, y downwards."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(PAGE_MM[0] * plot.MM, PAGE_MM[1] * plot.MM))
    figure.set_label(f"{group}: statement of uncertainty")
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(0, PAGE_MM[0]), ylim=(PAGE_MM[1], 0))
    axes.axis("off")
    pair = plot.literal(plot.clipped(" and ".join(document["pair"])))
    axes.text(MARGIN, 24, "Statement of uncertainty", fontsize=17, fontweight="bold")
    of = f"{plot.short(group)}: length between {pair}"
    axes.text(MARGIN, 31, of, fontsize=11, color=plot.GREY)
    y = 43.0
    for k, line in enumerate(document["headline"]):
        how: plot.Keywords = {"fontsize": 9.5 if k else 13, "fontweight": "normal" if k else "bold"}
        for words in textwrap.wrap(plot.literal(line), 95 if k else 66):
            axes.text(MARGIN, y, words, **how)
            y += 6.0
    y += 4.0
    for name, words in document.get("said", {}).items():
        y = _paragraph(axes, y, name, [words])
    if document["statements"]:
        y = _budget(axes, y + 4, document["statements"][0])
        y = _directions(axes, y + 6, document["statements"])
    _paragraph(axes, y + 6, "not covered", [f"• {one}" for one in document["not_covered"]])
    foot: plot.Keywords = {"fontsize": plot.SMALL_PT, "color": plot.GREY}
    for k, words in enumerate(textwrap.wrap(plot.literal(source), 120)[:3]):
        axes.text(MARGIN, 280 + 3.6 * k, words, **foot)
    return figure


def _paragraph(axes: Axes, y: float, name: str, items: Sequence[str]) -> float:
    axes.text(MARGIN, y, name.capitalize(), color=plot.GREY)
    for item in items:
        for words in textwrap.wrap(plot.literal(item), LETTERS):
            axes.text(COLUMN, y, words.replace("u_c", "$u_c$"))
            y += LINE_MM
    return y + 1.5


def _line(axes: Axes, y: float, cells: Sequence[str], ends: Sequence[float], bold: bool) -> None:
    """A row: the first cell begins at its place, the others end at theirs."""
    how: plot.Keywords = {"fontweight": "bold" if bold else "normal"}
    for k, (cell, end) in enumerate(zip(cells, ends, strict=False)):
        axes.text(end, y, cell, ha="right" if k else "left", **how)


def _rule(axes: Axes, y: float, width: float = 0.6) -> None:
    axes.hlines(y, MARGIN, PAGE_MM[0] - MARGIN, color=plot.GREY, lw=width)


def _budget(axes: Axes, y: float, one: Row) -> float:
    """Contributions with bars of their shares."""
    _line(axes, y, ("Contribution", "type", "u (mm)", "dof"), BUDGET, True)
    axes.text(BUDGET[-1], y, r"share of $\mathbf{u_c^2}$", fontweight="bold")
    _rule(axes, y + 1.8)
    for part in one["budget"]:
        y += ROW_MM
        dof = _dof(part["dof"])
        cells = (part["contribution"], part["type"], significant(part["u_mm"], 2), dof)
        _line(axes, y, cells, BUDGET, False)
        share = part["share"]
        words = percent(share, 2) if share >= LEAST_SHARE else f"< {percent(LEAST_SHARE)}"
        axes.text(BUDGET[-1] + SHARE_MM * share + 1.5, y, words)
        if share >= LEAST_SHARE:
            axes.barh(y - 1.1, SHARE_MM * share, 2.8, left=BUDGET[-1], color=BLUE)
    _rule(axes, y + 1.8)
    y += ROW_MM
    combined = (r"Combined, $\mathbf{u_c}$", "", significant(one["u_mm"], 2), _dof(one["dof"]))
    _line(axes, y, combined, BUDGET, True)
    y += ROW_MM
    _line(
        axes, y, (r"Expanded, U = k $\mathbf{u_c}$", "", significant(one["U_mm"], 2)), BUDGET, True
    )
    axes.text(BUDGET[-1], y, f"k = {one['k']:.2f}", fontweight="bold")
    return y + 3


def _directions(axes: Axes, y: float, every: Sequence[Row]) -> float:
    _line(axes, y, HEAD, TABLE, True)
    _rule(axes, y + 1.8)
    for one in every[:MOST]:
        y += ROW_MM
        sizes = (with_unit(one[key], "mm", 2, key == "correction_mm")
                 for key in ("correction_mm", "u_mm"))  # fmt: skip
        counts = (str(one["passes"]), str(one["dates"]) if one["dates"] else "–")
        both = (with_unit(one[key], "mm", 2) for key in ("U_mm", "U_of_mean_mm"))
        cells = (one["direction"], *counts, *sizes, _dof(one["dof"]), f"{one['k']:.2f}", *both)
        _line(axes, y, cells, TABLE, False)
    for words in textwrap.wrap(render("statement.table"), 125):
        y += ROW_MM - 1
        axes.text(MARGIN, y, words, fontsize=plot.SMALL_PT, color=plot.GREY)
    return y + 3


def _dof(value: float | None) -> str:
    return "∞" if value is None else number(value)


@plot.styled()
def save_page(figure: Figure, pdf: Path) -> None:
    """The PDF and a PNG beside it; the same figure gives the same bytes."""
    nothing = dict.fromkeys(("CreationDate", "Creator", "Producer"))
    with whole(pdf) as part:
        figure.savefig(part, format="pdf", metadata=nothing | {"Title": figure.get_label()})
    picture = plot.Picture(figure, captions.STATEMENT)  # type: ignore[arg-type]
    plot.save_png(picture, pdf.with_suffix(".png"))
