"""The claims of both papers: rows of `claims.csv` and their text; the studies of those of J, as a
document of tables and a figure each."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from mocap_metrology.papers.claims.decide import UNKNOWN, Text
from mocap_metrology.papers.claims.table import Decision
from mocap_metrology.papers.studies import findings as studies
from mocap_metrology.present.plot import figure as fig
from mocap_metrology.present.plot.curves import log_limits
from mocap_metrology.present.tables import Part, Row, document
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import significant, with_unit

COLUMNS = (
    *("id", "paper", "section", "claim", "statistic", "criterion"),
    *("published", "published_word", "regenerated", "realisations", "regenerated_word"),
    *("source", "note"),
)
TITLE = "Claims of both papers"
SHOWN = ("claim", "decision rule", "published", "regenerated")


def claim_rows(decisions: Sequence[Decision]) -> list[Row]:
    """Rows of claims.csv."""
    rows = []
    for claim, published, regenerated, realisations, source in decisions:
        cells = (
            *(claim.id, claim.paper, claim.section, claim.claim, claim.statistic, claim.criterion),
            *(_text(published.value), published.word, _text(regenerated.value), realisations),
            *(regenerated.word, "" if regenerated.word == UNKNOWN else source, claim.note),
        )
        rows.append(dict(zip(COLUMNS, cells, strict=True)))
    return rows


def _text(parts: Text) -> str:
    return "".join(
        part
        if isinstance(part, str)
        else with_unit(part.value, part.unit, part.digits)
        if part.unit
        else significant(part.value, part.digits)
        for part in parts
    )


def claims_markdown(rows: Sequence[Row]) -> str:
    """Title, caption, numbers of claims that hold or not, and a table of what readers need."""
    kinds = ("published", "regenerated")
    words = dict.fromkeys(row[f"{kind}_word"] for kind in kinds for row in rows)
    counts = [
        f"{kind}: " + ", ".join(f"{w} {sum(r[f'{kind}_word'] == w for r in rows)}" for w in words)
        for kind in kinds
    ]
    told = f"Of {len(rows)} claims, {'; '.join(counts)}."
    return document(TITLE, captions.CLAIMS, told, [SHOWN, *map(_line, rows)])


def _line(row: Row) -> tuple[str, ...]:
    """A row as shown, words before their reasons."""
    answers = [f"{row[f'{kind}_word']}: {row[kind]}" for kind in ("published", "regenerated")]
    if row["realisations"]:
        answers[1] += f"; {row['realisations']}"
    note = f" ({row['note']})" if row["note"] else ""
    rule = f"{row['statistic']}; holds if {row['criterion']}{note}"
    return (f"{row['id']}: {row['claim']}", rule, *answers)


# ---- Studies

MORE = {
    "reconstruction": "batch needs no reconstruction and is the same in all columns. ",
    "lasers": "0 is drawn at a third of the next value; paper, final is in the table alone. ",
}
ALL_HAVE_POSES = "No recording was without a pose."
WORDS = {"full-interpolation": "full interpolation", "kabsch": "Kabsch"}
OF_POINTS = ("error mm", "error °", "ratio", "failed", "beyond 8°", "mirrored %")
WAYS = (("paper", "kabsch"), ("paper", "final"), ("paper-lm", "final"))
ROOM = 1.25  # factor between the first and last value and the edge of the axis
ASIDE, ASIDE_KINDS = 0.014, 0.04  # of the axis, from the bars of one method to those of the next
UNITS = {"mm": "Position error (mm)", "deg": "Rotation error (°)"}


def method_text(row: Mapping[str, Any], *columns: str) -> str:
    """`paper, Kabsch, weighted`, or some of these."""
    parts = (str(row[key]) for key in columns or ("estimator", "stage", "variant"))
    return ", ".join(WORDS.get(part, part) for part in parts if part)


def studies_markdown(rows: Sequence[Row], n: int, seconds: float, seed: int) -> str:
    """All studies: for each what J claims, a table of methods and one of points."""
    text = captions.STUDIES.format(n=n, seconds=seconds, seed=seed, noticeable=studies.NOTICEABLE)
    parts: list[Part] = []
    for shown in studies.SHOWN:
        if of_study := [row for row in rows if row["study"] == shown.name]:
            parts += [f"## {shown.number}. {shown.title.capitalize()}", *_tables(shown, of_study)]
    return document("Jansen et al. 2019: claims in simulated studies", text, *parts)


def _tables(shown: studies.StudyDisplay, rows: list[Row]) -> list[list[list[str]]]:
    """The table of methods, and that of points; with boards at several distances, by these."""

    def line(row: Row, *cells: str) -> list[str]:
        return [*([f"{row['board_m']:g}"] if head else []), *cells]

    head = ["board m"] if shown.name == "lasers" else []
    methods = [[*head, "method", "r", "ratio", "claim", "finding"]]
    for row in studies.first_of_methods(rows):
        kind = f": {row['value']}" if isinstance(row["value"], str) else ""
        numbers = _interval(row, "correlation_mm", 2), _interval(row, "overall_ratio", 3)
        methods.append(line(row, method_text(row) + kind, *numbers, row["claim"], row["finding"]))
    points = [[*head, "method", f"{shown.parameter} {shown.unit}".rstrip(), *OF_POINTS]]
    for row in rows:
        mirrored = row["mirrored_percent"]
        value = row["value"]
        cells = (
            value if isinstance(value, str) else f"{value:g}",
            _interval(row, "median_mm", 3, "mm"),
            _interval(row, "median_deg", 2, "deg"),
            _interval(row, "ratio", 3),
            f"{row['failed']} of {row['n']}",
            f"{row['beyond_8_deg']} of {row['n']}",
            "" if math.isnan(mirrored) else f"{mirrored:.0f}",
        )
        points.append(line(row, method_text(row), *cells))
    return [methods, points]


def _interval(row: Row, name: str, digits: int, unit: str = "") -> str:
    """`1.23 (1.02 to 1.50)`."""
    value, *ends = (row[key] for key in (name, f"lower_{unit or name}", f"upper_{unit or name}"))
    text = significant(value, digits)
    if any(map(math.isnan, (value, *ends))):
        return text
    return f"{text} ({significant(ends[0], digits)} to {significant(ends[1], digits)})"


def panels_of(shown: studies.StudyDisplay, rows: Sequence[Row]) -> pd.DataFrame:
    """Rows of a study with the title of their `panel` and the name of their `line`."""
    table = pd.DataFrame(rows)
    method = pd.Series(list(zip(table["estimator"], table["stage"], strict=True)))
    if shown.name == "reconstruction":
        batch = table[method == ("batch", "final")].assign(line="batch")
        parts = []
        for way in WAYS:
            of_method = table[method == way].assign(line=table["variant"].replace(WORDS))
            panel = ", ".join(WORDS.get(part, part) for part in way)
            parts.append(pd.concat([of_method, batch]).assign(panel=panel))
        return pd.concat(parts)
    if shown.name == "weights":
        return table.assign(panel=table["estimator"] + ", Kabsch", line=table["variant"])
    table["line"] = [method_text(row) for row in rows]
    if shown.name == "lasers":
        table["panel"] = [f"board at {row['board_m']:g} m" for row in rows]
        return table[method != ("paper", "final")]
    return table.assign(panel="")[method != ("paper-lm", "kabsch")]


@fig.styled()
def study_figure(shown: studies.StudyDisplay, rows: Sequence[Row], source: str) -> fig.Picture:
    """Errors of position and rotation, both axes logarithmic; recordings without a pose are
    counted in the panel."""
    table = panels_of(shown, rows)
    panels, lines = table["panel"].unique(), table["line"].unique()
    looks = dict(zip(lines, (*fig.LOOKS.values(), *fig.OTHER_LOOKS), strict=False))
    alone = len(panels) == 1
    title = f"Jansen et al. 2019, study {shown.number}: {shown.title}"
    body = fig.new_figure(fig.Texts(title, source), 92.0 if alone else 138.0)
    shape = (1, 2) if alone else (2, len(panels))
    grid = body.subplots(*shape, squeeze=False, sharex=True, sharey=False if alone else "row")
    values = table["value"].drop_duplicates()
    places = np.arange(1.0, len(values) + 1)  # of kinds, beside each other
    if not isinstance(values.iloc[0], str):  # numbers at their value, 0 at a third of the next
        places = values.where(values > 0, values[values > 0].min() / 3).to_numpy()
    at = pd.Series(places, values)
    x_label = shown.parameter[0].upper() + shown.parameter[1:]
    x_label += f" ({shown.unit})" if shown.unit else ""
    both = [(unit, panel) for unit in UNITS for panel in panels]
    for axes, (unit, panel) in zip(grid.flat, both, strict=True):
        of_panel = table[table["panel"] == panel]
        _draw_methods(axes, of_panel, unit, looks, at)
        _count_failures(axes, of_panel, at)
        where = axes.get_subplotspec()
        if where.is_first_row():
            axes.set_title(panel)
        if where.is_last_row():
            axes.set_xlabel(x_label, fontsize=fig.SMALL_PT if len(panels) > 2 else None)
        if alone or where.is_first_col():
            ends = [f"{key}_{unit}" for key in ("median", "lower", "upper")]
            axes.set_ylabel(UNITS[unit])
            fig.log_axis(axes, "y", log_limits([table[ends].to_numpy(float)]))
        if not alone:
            axes.label_outer()
    fig.letters(grid.flat)
    failed, n = (sum(row[key] for row in rows) for key in ("failed", "n"))
    more = MORE.get(shown.name, "")
    more += captions.STUDY_FAILED.format(n=n, failed=failed) if failed else ALL_HAVE_POSES
    most = max(row["n"] for row in rows)
    caption = captions.STUDY.format(parameter=shown.parameter, n=most, more=more)
    return fig.finished(body, grid.flat, caption)


def _draw_methods(
    axes: fig.Axes, table: pd.DataFrame, unit: str, looks: Mapping[str, fig.Look], at: pd.Series
) -> None:
    """Medians with their intervals, a line a method, those of one value beside each other."""
    names = table["line"].unique()
    order = np.arange(len(names)) - (len(names) - 1) / 2
    kinds = isinstance(at.index[0], str)
    if kinds:
        axes.set_xlim(0.5, len(at) + 0.5)
    else:
        axes.set(xscale="log", xlim=(at.min() / ROOM, at.max() * ROOM))
    axes.set_xticks(at, [value if kinds else f"{value:g}" for value in at.index])
    axes.set_xticks([], minor=True)
    for name, aside in zip(names, order, strict=True):
        line = table[table["line"] == name]
        x = line["value"].map(at).to_numpy()
        if kinds:
            x = x + ASIDE_KINDS * len(at) * aside
        else:
            x = x * (at.max() / at.min()) ** (ASIDE * aside)
        y, low, high = (line[f"{key}_{unit}"].to_numpy() for key in ("median", "lower", "upper"))
        how = looks[name].line(ms=4.0, lw=0.9, elinewidth=0.9, capsize=1.6, label=name)
        how |= {"ls": ""} if kinds else {}
        axes.errorbar(x, y, yerr=np.nan_to_num([y - low, high - y]), **how)


def _count_failures(axes: fig.Axes, table: pd.DataFrame, at: pd.Series) -> None:
    """At values where recordings have no pose: how many of all, over the methods."""
    how: fig.Keywords = {"color": fig.GREY, "fontsize": fig.SMALL_PT, "rotation": 90}
    how |= {"ha": "center", "va": "top", "transform": axes.get_xaxis_transform()}
    for value, at_value in table.groupby("value"):
        failed, n = at_value["failed"].sum(), at_value["n"].sum()
        if failed:
            text = "refused" if failed == n else f"{failed} of {n} failed"
            axes.text(at[value], 0.97, text, **how)
