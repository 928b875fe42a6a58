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
    "What Skurowski & Pawlyta 2019 (S) and Jansen et al. 2019 (J) say that data can decide, by the "
    "published tables and by what this run regenerated. Twins of S are made from its published "
    "coefficients, so they answer alike wherever the coefficients decide; regenerated coefficients "
    "are those of annealing-ant-colony without what ended at a limit of its search, periodic "
    "disturbances those of likelihood. ±: two standard errors; a criterion that lies within "
    "them is undecided. realisations: standard deviations and covariances of nine "
    "hours are mostly random walk; such a claim holds if it does in 95 % of many recordings drawn "
    "from the same coefficients, of those that are precise enough to decide; does not if in 5 % or "
    "fewer; and undecided between, or where fewer than half decide."
)
SHOWN = ("claim", "decided by", "published", "regenerated")


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
        return unknown(f"not there: {' '.join(str(part) for part in missing.args[:2])}")


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
