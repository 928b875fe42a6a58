"""The statement of uncertainty of a length: document, table, words."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mocap_metrology.accuracy.bar import Bar
from mocap_metrology.accuracy.components import FEWEST
from mocap_metrology.accuracy.statement import Statement, statements
from mocap_metrology.common.gum import Component
from mocap_metrology.present.tables import Row
from mocap_metrology.present.text.sentence import render

SAID = ("quantity", "where", "when", "correction", "method")
COMBINED = ("u_mm", "dof", "k", "U_mm", "U_of_mean_mm", "correction_mm", "passes", "dates")


def known_of(
    pair: Sequence[str],
    monitors: Sequence[Mapping[str, Any]] = (),
    points: Mapping[str, Any] | None = None,
) -> list[Component]:
    """Out of contents of monitor.json, the largest scatter of the length of this pair, and of
    <group>_points.json the standard error of the scale."""
    names = {f"length {'-'.join(order)}" for order in (pair, pair[::-1])}
    series = [s for one in monitors for n, s in one.get("series", {}).items() if n in names]
    scatter = [(one["scatter"], one["dof"]) for one in series if "scatter" in one]
    known = [Component("drift", "A", *max(scatter))] if scatter else []
    if points and (se := points.get("scale_se_ppm")):
        known.append(Component("scale", "A", 1e-6 * se, points["n"] - 1))
    return known


def statement_document(bar: Bar, pair: Sequence[str], known: Sequence[Component]) -> Row:
    """Contents of <group>_statement.json."""
    found = statements(bar, known)
    means = statements(bar, known, averaged=math.inf)
    middle = np.concatenate([take.middle_mm[:, take.known] for take in bar.takes], axis=1) / 1000
    ends = zip("xyz", middle.min(axis=1).tolist(), middle.max(axis=1).tolist(), strict=True)
    dated = bool(found) and bool(found[0].n_dates)
    document: Row = {
        "pair": list(pair),
        "certificate": None if bar.certificate is None else vars(bar.certificate),
        "reference_mm": float(f"{bar.reference_mm:.6g}"),
        "where_m": {axis: [low, high] for axis, low, high in ends},
        "passes": [take.name for take in bar.takes],
        "dates": sorted({take.date for take in bar.takes if take.date}),
        "undated": sum(not take.date for take in bar.takes),
        "has_drift": any(one.name == "drift" for one in known) and not dated,
        "statements": [_row(*both) for both in zip(found, means, strict=True)],
    }
    covered = dated or document["has_drift"]
    open_ends = ["latency", "volume", "other_lengths"]
    open_ends += ["directions"] * bool(found) + ["other_days"] * (not covered)
    open_ends += ["absolute"] * (bar.certificate is None)
    open_ends += ["exact"] * (bar.certificate is not None and not bar.certificate.u_mm)
    document["not_covered"] = [render(f"statement.{key}", **document) for key in open_ends]
    document["headline"] = _headline(document, max(len(one.passes) for one in bar.classes))
    if found:
        numbers = document["statements"][0] | document  # passes and dates by name
        document["said"] = {key: render(f"statement.{key}", **numbers) for key in SAID}
    return document


def _headline(document: Row, passes: int) -> list[str]:
    if not document["statements"]:
        return [render("statement.few", passes=passes, fewest=FEWEST)]
    precise = [] if document["certificate"] else [render("statement.precise")]
    return [render("statement.result", **document["statements"][0] | document), *precise]


def _row(one: Statement, mean: Statement) -> Row:
    budget = one.budget
    parts = [
        {"name": c.name, "contribution": render(f"part.{c.name}"), "type": c.kind, "u_mm": c.u,
         "dof": None if math.isinf(c.dof) else c.dof, "share": budget.share(c)}
        for c in budget.components
    ]  # fmt: skip
    return {
        "direction": one.direction,
        "passes": one.passes,
        "dates": one.n_dates,
        "correction_mm": round(one.correction_mm, 9),  # mm: what is smaller is arithmetic
        "u_mm": budget.u,
        "dof": None if math.isinf(budget.dof) else budget.dof,
        "k": budget.k,
        "U_mm": budget.expanded,
        "U_of_mean_mm": mean.budget.expanded,
        "budget": parts,
    }


def statement_rows(document: Row) -> list[Row]:
    """<group>_statement.csv: the budget of each direction, and a row of what follows from it."""
    rows: list[Row] = []
    for one in document["statements"]:
        named = {"direction": one["direction"]}
        rows += [
            named | {"contribution": part["contribution"], "type": part["type"],
                     "u_mm": part["u_mm"], "dof": part["dof"], "share_percent": 100 * part["share"]}
            for part in one["budget"]
        ]  # fmt: skip
        rows.append(named | {"contribution": "combined"} | {key: one[key] for key in COMBINED})
    return rows or [{"note": document["headline"][0]}]


def told(document: Row) -> str:
    """All sentences of a statement, in Markdown."""
    said = [f"{name.capitalize()}: {words}" for name, words in document.get("said", {}).items()]
    head = [f"{one.rstrip('.')}." for one in document["headline"]]
    return "\n\n".join([*head, *said, f"Not covered: {'; '.join(document['not_covered'])}."])
