"""The statement of uncertainty of a length: document, table, words."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from mocap_metrology.accuracy.bar import Bar
from mocap_metrology.accuracy.statement import statement_numbers
from mocap_metrology.accuracy.statistics import FEWEST
from mocap_metrology.common.files import whole
from mocap_metrology.common.gum import Component
from mocap_metrology.present.plot import figure as plot
from mocap_metrology.present.tables import Row
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import number, percent, significant
from mocap_metrology.present.text.sentence import render

SAID = ("quantity", "where", "when", "correction", "method")
OF_PART = ("contribution", "type", "u_mm", "dof")
COMBINED = ("u_mm", "dof", "k", "U_mm", "U_of_mean_mm", "correction_mm", "passes", "dates")
PAGE_MM, MARGIN, COLUMN = (210.0, 297.0), 20.0, 50.0
LINE_MM, ROW_MM = 4.3, 5.6
SMALL: plot.Keywords = {"fontsize": plot.SMALL_PT, "color": plot.GREY}
U_C = r"$\mathbf{u_c}$"
BUDGET = {"Contribution": 20.0, "type": 92.0, "u (mm)": 112.0, "dof": 132.0}  # first: where it
TABLE = {  # begins, others: where they end
    **{"Direction": 20.0, "passes": 64.0, "days": 76.0, "correction (mm)": 108.0, U_C: 121.0},
    **{"dof": 133.0, "k": 145.0, "U, one frame": 171.0, "U, mean": 190.0},
}
SHARE = (136.0, 40.0)  # where bars begin, and length of the whole
LEAST_SHARE = 0.005  # that has a bar
MOST = 6  # directions


def statement_document(bar: Bar, pair: Sequence[str], known: Sequence[Component]) -> Row:
    """Contents of <group>_statement.json: its numbers, and what they mean."""
    document, open_ends = statement_numbers(bar, pair, known)
    for one in document["statements"]:
        named = [{"name": p["name"], "contribution": render(f"part.{p['name']}")} | p
                 for p in one["budget"]]  # fmt: skip
        one["budget"] = named
    document["not_covered"] = [render(f"statement.{key}", **document) for key in open_ends]
    if not document["statements"]:
        passes = max(len(one.passes) for one in bar.classes)
        return document | {"headline": [render("statement.few", passes=passes, fewest=FEWEST)]}
    numbers = document["statements"][0] | document  # passes and dates by name
    precise = [] if document["certificate"] else [render("statement.precise")]
    document["headline"] = [render("statement.result", **numbers), *precise]
    document["said"] = {key: render(f"statement.{key}", **numbers) for key in SAID}
    return document


def statement_rows(document: Row) -> list[Row]:
    """<group>_statement.csv: the budget of each direction, and a row of what follows from it."""
    rows: list[Row] = []
    for one in document["statements"]:
        named = {"direction": one["direction"]}
        for part in one["budget"]:
            share = {"share_percent": 100 * part["share"]}
            rows.append(named | {key: part[key] for key in OF_PART} | share)
        rows.append(named | {"contribution": "combined"} | {key: one[key] for key in COMBINED})
    return rows or [{"note": document["headline"][0]}]


def statement_words(document: Row) -> str:
    """All sentences of a statement, in Markdown."""
    said = [f"{name.capitalize()}: {words}" for name, words in document.get("said", {}).items()]
    head = [f"{one.rstrip('.')}." for one in document["headline"]]
    return "\n\n".join([*head, *said, f"Not covered: {'; '.join(document['not_covered'])}."])


@plot.styled()
def statement_page(document: Row, group: str, source: str) -> plot.Figure:
    """The figure; its axes are the page in mm, y downwards."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(PAGE_MM[0] * plot.MM, PAGE_MM[1] * plot.MM))
    figure.set_label(f"{group}: statement of uncertainty")
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(0, PAGE_MM[0]), ylim=(PAGE_MM[1], 0))
    axes.axis("off")
    _text(axes, MARGIN, 24, ["Statement of uncertainty"], fontsize=17, fontweight="bold")
    pair = " and ".join(plot.clipped(label, 24) for label in document["pair"])
    of = f"{plot.clipped(group)}: length between {pair}"
    _text(axes, MARGIN, 31, [of], fontsize=11, color=plot.GREY)
    first, *others = document["headline"]
    y = _text(axes, MARGIN, 43, [first], 64, 6.0, fontsize=13, fontweight="bold")
    y = _text(axes, MARGIN, y, others, 92, 5.0, fontsize=9.5) + 4
    for name, words in document.get("said", {}).items():
        _text(axes, MARGIN, y, [name.capitalize()], color=plot.GREY)
        y = _text(axes, COLUMN, y, [words]) + 1.5
    if document["statements"]:
        y = _budget(axes, y + 4, document["statements"][0])
        y = _directions(axes, y + 7, document["statements"])
    _text(axes, MARGIN, y + 6, ["Not covered"], color=plot.GREY)
    _text(axes, COLUMN, y + 6, [f"• {one}" for one in document["not_covered"]])
    _text(axes, MARGIN, 284, [plot.clipped(source, 240)], 125, **SMALL)
    return figure


def _text(
    axes: plot.Axes,
    x: float,
    y: float,
    items: Sequence[str],
    letters: int = 78,
    step: float = LINE_MM,
    **how: Any,
) -> float:
    """Lines of so many letters from y on; where the next one begins."""
    for words in (line for item in items for line in textwrap.wrap(plot.literal(item), letters)):
        axes.text(x, y, re.sub(r"\bu_c\b", "$u_c$", words), **how)
        y += step
    return y


def _write(
    axes: plot.Axes, y: float, cells: Sequence[str], of: dict[str, float], **how: Any
) -> None:
    for k, (cell, end) in enumerate(zip(cells, of.values(), strict=False)):
        axes.text(end, y, cell, ha="right" if k else "left", **how)


def _rule(axes: plot.Axes, y: float) -> None:
    axes.hlines(y + 1.8, MARGIN, PAGE_MM[0] - MARGIN, color=plot.GREY, lw=0.6)


def _budget(axes: plot.Axes, y: float, one: Row) -> float:
    """Contributions with bars of their shares; what they add up to."""
    start, length = SHARE
    _write(axes, y, tuple(BUDGET), BUDGET, fontweight="bold")
    axes.text(start, y, r"share of $\mathbf{u_c^2}$", fontweight="bold")
    _rule(axes, y)
    for part in one["budget"]:
        y, share = y + ROW_MM, part["share"]
        words = percent(share, 2) if share >= LEAST_SHARE else f"< {percent(LEAST_SHARE)}"
        size, dof = significant(part["u_mm"], 2), _dof(part["dof"])
        _write(axes, y, (part["contribution"], part["type"], size, dof), BUDGET)
        axes.text(start + length * share + 1.5, y, words)
        if share >= LEAST_SHARE:
            axes.barh(y - 1.1, length * share, 2.8, left=start, color="#5b7fc4")
    _rule(axes, y)
    size, expanded = (significant(one[key], 2) for key in ("u_mm", "U_mm"))
    total = (f"Combined, {U_C}", "", size, _dof(one["dof"]))
    _write(axes, y + ROW_MM, total, BUDGET, fontweight="bold")
    cells = f"Expanded, U = k {U_C}", "", expanded
    _write(axes, y + 2 * ROW_MM, cells, BUDGET, fontweight="bold")
    axes.text(start, y + 2 * ROW_MM, f"k = {one['k']:.2f}", fontweight="bold")
    return y + 2 * ROW_MM + 3


def _directions(axes: plot.Axes, y: float, every: Sequence[Row]) -> float:
    _write(axes, y, tuple(TABLE), TABLE, fontweight="bold")
    _rule(axes, y)
    for one in every[:MOST]:
        y += ROW_MM
        keys = ("correction_mm", "u_mm", "U_mm", "U_of_mean_mm")
        sizes = [significant(one[key], 2) for key in keys]
        numbers = (*sizes[:2], _dof(one["dof"]), f"{one['k']:.2f}", *sizes[2:])
        cells = (one["direction"], str(one["passes"]), str(one["dates"] or "–"), *numbers)
        _write(axes, y, cells, TABLE)
    return _text(axes, MARGIN, y + ROW_MM, [render("statement.table")], 125, **SMALL)


def _dof(value: float | None) -> str:
    return "∞" if value is None else number(value)


@plot.styled()
def save_page(figure: plot.Figure, pdf: Path) -> None:
    """The PDF and a PNG beside it; the same figure gives the same bytes."""
    nothing = dict.fromkeys(("CreationDate", "Creator", "Producer"))
    with whole(pdf) as part:
        figure.savefig(part, format="pdf", metadata=nothing | {"Title": figure.get_label()})
    picture = plot.Picture(figure, captions.STATEMENT)  # type: ignore[arg-type]
    plot.save_png(picture, pdf.with_suffix(".png"))
