"""The table of claims of both papers: rows of `claims.csv`, and their text."""

from __future__ import annotations

from collections.abc import Sequence

from mocap_metrology.papers.claims.decide import UNKNOWN, Text
from mocap_metrology.papers.claims.table import Decision
from mocap_metrology.present.tables import Row, document
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


# ---- Figures of the two papers that are not regenerated, and why

LEFT_OUT_CAPTION = (
    "All other figures and all tables of both papers are regenerated, from twins or theory."
)
OF_LEFT_OUT = ("paper", "figure", "shows", "reason")
S, J = captions.PAPERS["skurowski"], captions.PAPERS["jansen"]
LEFT_OUT = (
    (S, "Figure 4", "camera locations: a view in Vicon Blade and a photograph of the laboratory",
     "a photograph, and places of cameras of which the paper prints no coordinates"),
    (S, "Figure 5", "drawing of the calibration wand (T-frame)",
     "a drawing of a vendor's part, without data"),
    (J, "Fig. 1", "a person with receivers on the limbs, and the pose found",
     "a photograph of an earlier experiment (reference 19 there); its recording was not published"),
    (J, "Fig. 2", "illustration of a Lighthouse seen from the front",
     "an illustration of the device, without data"),
    (J, "Fig. 4", "the calibration board with its 32 photodiodes",
     "a photograph; the diodes' places are in the board file of each calibration"),
    (J, "Fig. 9", "two Lighthouses with markers for motion capture",
     "a photograph; the twins' marker mounts are in their mount files"),
)  # fmt: skip


def left_out() -> list[Row]:
    """One row a figure."""
    return [dict(zip(OF_LEFT_OUT, line, strict=True)) for line in LEFT_OUT]
