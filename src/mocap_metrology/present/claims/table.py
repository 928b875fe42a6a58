"""All claims of both papers: rows of `claims.csv`, and their text."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping, Sequence
from functools import lru_cache
from importlib.resources import files
from typing import Any

from mocap_metrology.present.claims import coefficients, curves, jansen, remedies, scaling
from mocap_metrology.present.claims.claim import Claim
from mocap_metrology.present.claims.jansen import Calibrations, PublishedTables
from mocap_metrology.present.claims.realisations import of_realisations
from mocap_metrology.present.claims.study import Drawn, Published, Regenerated
from mocap_metrology.present.tables import Row, aligned

DECIDED_BY = (
    coefficients.decides | curves.decides | scaling.decides | remedies.decides | jansen.decides
)
TITLE = "Claims of both papers"
CAPTION = (
    "Claims of Skurowski & Pawlyta 2019 (S) and Jansen et al. 2019 (J) that data can decide, "
    "tested with the published tables and with the results of this run. Simulated stand-ins "
    "(twins) for S are made from its published coefficients, so they give the same answer "
    "wherever the coefficients decide. Regenerated coefficients are those of "
    "annealing-ant-colony, excluding those at a limit of its search; periodic disturbances are "
    "those of likelihood. ±: two standard errors; a claim is undecided if its criterion lies "
    "within them. realisations: standard deviations and covariances of nine hours are mostly "
    "random walk, so many recordings are simulated from the same coefficients. Of those precise "
    "enough to decide, such a claim must hold in 95 %; it does not hold if it does in 5 % or "
    "fewer. Between, or if fewer than half decide, it is undecided."
)
SHOWN = ("claim", "decision rule", "published", "regenerated")


@lru_cache(maxsize=1)
def claims() -> Mapping[str, Claim]:
    """All claims by id, in the order of `claims.tsv`.

    A row with several lists of arguments, separated by `;`, is a claim for each of them; `{0}` in
    its texts is the first argument.
    """
    text = (files("mocap_metrology") / "present/claims/claims.tsv").read_text(encoding="utf-8")
    found = {}
    for line in csv.DictReader(text.splitlines(), delimiter="\t", quoting=csv.QUOTE_NONE):
        for part in line["arguments"].split(";"):
            given = tuple(_value(word) for word in part.split())
            cells: dict[str, Any] = {name: cell.format(*given) for name, cell in line.items()}
            cells |= {"arguments": given, "by_chance": bool(line["by_chance"])}
            claim = Claim(**cells, function=DECIDED_BY[line["id"]])
            found[claim.id] = claim
    return found


def _value(word: str) -> Any:
    """A number, or else a name."""
    try:
        return json.loads(word)
    except ValueError:
        return word


def claim_rows(
    study: Regenerated | None,
    calibrations: Calibrations | None,
    sources: tuple[str, str],
    draws: Sequence[Drawn] = (),
) -> list[Row]:
    """Rows of all claims.

    study, calibrations: regenerated numbers of S and J, None without recordings; sources: where
    they come from (`twin`, `measured`, ...); draws: more realisations of the twins of S
    (`realisations.draw`).
    """
    rows = []
    for claim in claims().values():
        printed = Published() if claim.paper == "S" else PublishedTables()
        found = claim.find(study if claim.paper == "S" else calibrations)
        found, counted = of_realisations(claim, found, draws)
        source = sources[claim.paper == "J"]
        rows.append(claim.row(claim.find(printed), found, source, counted))
    return rows


def claims_markdown(rows: Sequence[Row]) -> str:
    """Title, caption, numbers of claims that hold or not, and a table of what readers need."""
    lines = [SHOWN] + [_line(row) for row in rows]
    kinds = ("published", "regenerated")
    words = dict.fromkeys(row[f"{kind}_word"] for kind in kinds for row in rows)
    counts = [
        f"{kind}: " + ", ".join(f"{w} {sum(r[f'{kind}_word'] == w for r in rows)}" for w in words)
        for kind in kinds
    ]
    table = "\n".join(aligned(lines))
    return f"# {TITLE}\n\n{CAPTION}\n\nOf {len(rows)} claims, {'; '.join(counts)}.\n\n{table}\n"


def _line(row: Row) -> tuple[str, ...]:
    """A row as shown, words before their reasons."""
    answers = [f"{row[f'{kind}_word']}: {row[kind]}" for kind in ("published", "regenerated")]
    if row["realisations"]:
        answers[1] += f"; {row['realisations']}"
    note = f" ({row['note']})" if row["note"] else ""
    rule = f"{row['statistic']}; holds if {row['criterion']}{note}"
    return (f"{row['id']}: {row['claim']}", rule, *answers)
