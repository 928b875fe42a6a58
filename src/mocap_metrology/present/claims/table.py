"""All claims of both papers: rows of `claims.csv`, and their text."""

from __future__ import annotations

from collections.abc import Sequence

from mocap_metrology.present.claims import coefficients, curves, jansen, remedies, scaling
from mocap_metrology.present.claims.claim import (
    Claim,
    Drawn,
    Finding,
    Published,
    Regenerated,
    T,
    row,
    unknown,
)
from mocap_metrology.present.claims.curves import of_realisations
from mocap_metrology.present.tables import Row, aligned

S_CLAIMS = (*curves.CLAIMS, *scaling.CLAIMS, *coefficients.CLAIMS, *remedies.CLAIMS)
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


def claim_rows(
    study: Regenerated | None,
    calibrations: jansen.Calibrations | None,
    sources: tuple[str, str],
    draws: Sequence[Drawn] = (),
) -> list[Row]:
    """Rows of all claims; `sources` of S's and J's regenerated numbers (`twin`, `measured`, ...).

    study: `Regenerated`, or None without its recordings; calibrations: `Calibrations`, or None;
    draws: more realisations of the twins of S (`chance.draw`).
    """
    rows = []
    for claim in sorted(S_CLAIMS, key=lambda claim: claim.section):
        found, counted = of_realisations(claim, _found(claim, study), draws)
        rows.append(row(claim, "S", _found(claim, Published()), found, sources[0], counted))
    rows += [
        row(
            claim,
            "J",
            _found(claim, jansen.PublishedTables()),
            _found(claim, calibrations),
            sources[1],
        )
        for claim in jansen.CLAIMS
    ]
    return rows


def _found(claim: Claim[T], study: T | None) -> Finding:
    """A claim whose recordings are not there, or are too short, is undecided."""
    if study is None:
        return unknown("no recordings")
    try:
        return claim.find(study)
    except KeyError as missing:
        return unknown(f"missing: {' '.join(str(part) for part in missing.args[:2])}")


def claims_markdown(rows: Sequence[Row]) -> str:
    """Title, caption, count of words, and a table with what people read."""
    lines = [SHOWN] + [_line(row) for row in rows]
    counts = {
        kind: {word: sum(row[kind] == word for row in rows) for word in dict.fromkeys(_words(rows))}
        for kind in ("published_word", "regenerated_word")
    }
    said = "; ".join(
        f"{kind.split('_')[0]}: " + ", ".join(f"{word} {count}" for word, count in found.items())
        for kind, found in counts.items()
    )
    table = "\n".join(aligned(lines))
    return f"# {TITLE}\n\n{CAPTION}\n\nOf {len(rows)} claims, {said}.\n\n{table}\n"


def _line(row: Row) -> tuple[str, ...]:
    """What is read of a row, words before their reasons."""
    answers = [f"{row[f'{kind}_word']}: {row[kind]}" for kind in ("published", "regenerated")]
    if row["realisations"]:
        answers[1] += f"; {row['realisations']}"
    note = f" ({row['note']})" if row["note"] else ""
    decided_by = f"{row['statistic']}; holds if {row['criterion']}{note}"
    return (f"{row['id']}: {row['claim']}", decided_by, *answers)


def _words(rows: Sequence[Row]) -> list[str]:
    return [row[kind] for kind in ("published_word", "regenerated_word") for row in rows]
