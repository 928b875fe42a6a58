"""Each table of both papers in short: published beside regenerated, and whether they agree."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from mocap_metrology.papers.jansen import VARIANTS, Variant
from mocap_metrology.present.jansen.jansen_text import FACTOR
from mocap_metrology.present.pages.site import EMPTY, Table, table, word
from mocap_metrology.present.tables import Record, read, readable, shown
from mocap_metrology.present.text.numbers import significant, with_interval

AGREES, DIFFERS, CITED, OPEN = "agrees", "differs", "cited", "not compared"
BELOW, ALONE = "not detected", "no partner"
ORDER = (AGREES, DIFFERS, BELOW, ALONE, OPEN, CITED)
Columns = Mapping[str, Callable[[Record], str]]
PERCENT, ERRORS = 0.1, 3.0  # Table 1 of S: rounding of the printed 1.038 is 0.05 %
OF_CLAIMS = Variant("paper", "kabsch", "ideal")  # as the claims on J
SIDE = ("published", "regenerated")
PARTNER = re.compile(r"[\w-]+: its \w+(; )?")  # by what name an estimator has the coefficient


@dataclass(frozen=True)
class Rule:
    """How a table is compared: what its verdicts mean, the columns that name a row, the verdict of
    a row, and further columns before and after it (functions of a row, by their head)."""

    meanings: Mapping[str, str]
    names: Mapping[str, str]
    verdict: Callable[[Record], str]
    before: Columns = field(default_factory=dict)
    after: Columns = field(default_factory=dict)
    note: str = ""


@dataclass(frozen=True)
class Comparison:
    """A table in short; `counts`: how many numbers agree; `others`: the same by other variants."""

    counts: str
    meanings: Mapping[str, str]
    note: str
    table: Table
    others: Table | None = None


def _known(row: Record, *names: str) -> bool:
    return all(row.get(name) is not None and row[name] == row[name] for name in names)


def _within(row: Record, lower: str, upper: str) -> str:
    return AGREES if row[lower] <= row["published"] <= row[upper] else DIFFERS


def _cited(row: Record) -> str:
    return CITED


def _law(row: Record) -> str:
    """Point samples are what a camera takes, and no number of the paper."""
    if row["method"] == "point samples":
        return OPEN
    off = abs(row["regenerated"] - row["published"])
    errors = ERRORS * row["standard_error"] if row["method"] == "simulation" else 0.0
    return AGREES if off <= max(PERCENT / 100 * (abs(row["published"]) or 1.0), errors) else DIFFERS


def _cameras(row: Record) -> str:
    if not _known(row, "regenerated"):
        return CITED
    return AGREES if row["published"] == row["regenerated"] else DIFFERS


def _moment(row: Record) -> str:
    if not _known(row, "regenerated"):
        return CITED
    found = [row[name] for name in ("inside", "published_inside") if _known(row, name)]
    return OPEN if not found else AGREES if all(map(bool, found)) else DIFFERS


def _coefficient(row: Record) -> str:
    status = row["likelihood_status"]
    if row["source"] == CITED:
        return CITED
    if status == "unpaired":
        return ALONE
    if status == "not_detected" and _known(row, "likelihood_upper_95"):
        return BELOW if row["published"] <= row["likelihood_upper_95"] else DIFFERS
    if not _known(row, "likelihood_lower_95", "likelihood_upper_95"):
        return OPEN
    return _within(row, "likelihood_lower_95", "likelihood_upper_95")


def _error(row: Record) -> str:
    if row["source"] == CITED:
        return CITED
    if not _known(row, "ratio"):
        return OPEN
    return AGREES if 1 / FACTOR <= row["ratio"] <= FACTOR else DIFFERS


def _likelihood(row: Record) -> str:
    """With its interval, or the limit of what was not detected."""
    ends = [row[f"likelihood_{end}_95"] for end in ("lower", "upper")]
    if row["likelihood_status"] == "not_detected" and _known(row, "likelihood_upper_95"):
        return f"< {significant(ends[1])}"
    return with_interval(row["likelihood"], *ends) or EMPTY


def _error_of_simulation(row: Record) -> str:
    return significant(row["standard_error"], 2) if row["method"] == "simulation" else ""


def _span(before: str = "") -> Callable[[Record], str]:
    """`0.0125…0.0178`: what chance allows nine times in ten."""
    ends = f"{before}lower_5", f"{before}upper_95"

    def of(row: Record) -> str:
        texts = [readable(row[end], row["quantity"]) for end in ends]
        return "…".join(texts) if all(texts) else ""

    return of


def _text(name: str) -> Callable[[Record], str]:
    return lambda row: str(row[name]) if _known(row, name) else ""


def _note(row: Record) -> str:
    short = ["recording too short for it"] if row.get("supported") is False else []
    return "; ".join([*short, *filter(None, [PARTNER.sub("", _text("note")(row))])])


SOURCE = {"source": _text("source")}
NOTE = SOURCE | {"note": _note}
COEFFICIENTS = Rule(
    {
        AGREES: "the published coefficient lies within the 95 % interval of the likelihood "
        "estimate.",
        DIFFERS: "it lies outside.",
        BELOW: "it lies below the upper 95 % limit of a coefficient that the recording does not "
        "show.",
        ALONE: "the estimate has no Gauss-Markov term like the published one.",
        OPEN: "the estimate has no interval.",
    },
    {"n_cameras": "cameras", "series": "series", "parameter": "coefficient", "unit": "unit"},
    _coefficient,
    {"likelihood (95 % interval)": _likelihood},
    NOTE,
    "Regenerated: by the estimator of the paper, which has no interval.",
)
ERRORS_OF_J = Rule(
    {
        AGREES: f"between 1/{FACTOR:g} and {FACTOR:g} times the published value. Places, paths and "
        "lasers of the twins are not those of the paper, so only the size of errors can agree."
    },
    {"noise": "noise", "setup": "setup", "quantity": "quantity"},
    _error,
    {"ratio": lambda row: significant(row["ratio"], 2)},
    {"calibrations": _text("n")} | SOURCE,
    "Regenerated: by {variant}.",
)
RULES = {
    "skurowski_table1": Rule(
        {
            AGREES: f"within {PERCENT:g} % of the printed value or, if simulated, within "
            f"{ERRORS:g} standard errors of it.",
            OPEN: "samples at points in time, as a camera takes them; the paper has no formula.",
        },
        {"noise": "noise", "quantity": "quantity", "tau_s": "τ (s)", "method": "method"},
        _law,
        {"standard error": _error_of_simulation},
        NOTE,
    ),
    "skurowski_table2": Rule(
        {CITED: "no recording contains what cameras weigh or resolve."},
        {"camera_type": "camera", "quantity": "quantity", "unit": "unit"},
        _cited,
        after={"note": _note},
    ),
    "skurowski_table3": Rule(
        {AGREES: "the sheet of recordings names the same cameras."},
        {"camera_type": "camera", "n_cameras": "cameras"},
        _cameras,
        after=SOURCE,
    ),
    "skurowski_table4": Rule(
        {
            AGREES: "the published value is within 5 to 95 % of what recordings of nine hours with "
            "the published coefficients show, and the regenerated one within that of recordings "
            "of its own length (one in ten lies outside by chance). A mean: the regenerated one "
            "is within three standard errors of the published one."
        },
        {"camera_type": "camera", "quantity": "quantity"},
        _moment,
        {"5…95 %, this length": _span(), "5…95 %, nine hours": _span("nine_hours_")},
        NOTE,
    ),
    **dict.fromkeys((f"skurowski_tableA{k}" for k in (1, 2, 3)), COEFFICIENTS),
    **dict.fromkeys((f"jansen_table{k}" for k in (1, 2, 3)), ERRORS_OF_J),
}


def paper_of(name: str) -> str:
    """Whose table that is (`skurowski`, `jansen`); nothing of one that is in neither paper."""
    return name.partition("_")[0] if name in RULES else ""


def of_file(path: Path) -> Comparison | None:
    """`compare` of a CSV of the folder tables."""
    if path.stem not in RULES:
        return None
    return compare(
        path.stem, [{str(k): v for k, v in row.items()} for row in read(path).to_dict("records")]
    )


def compare(name: str, rows: Sequence[Record]) -> Comparison | None:
    """What is read first of a table of that name, given the rows of its CSV; None of a table that
    is in neither paper."""
    rule = RULES.get(name)
    if rule is None:
        return None
    rows = [row for row in rows if _known(row, "published")]  # other terms are no numbers of it
    if rule is not ERRORS_OF_J:
        return _of(rule, rows)
    of = {v: [r for r in rows if _variant(r) == v] for v in (OF_CLAIMS, *VARIANTS)}
    of = {variant: own for variant, own in of.items() if own}
    each = [(str(variant), counts(map(rule.verdict, own))) for variant, own in of.items()]
    first = next(iter(of))
    short = _of(replace(rule, note=rule.note.format(variant=first)), of[first])
    return replace(short, others=table(("variant", "numbers"), each, words=(0, 1)))


def _variant(row: Record) -> Variant:
    return Variant(row["estimator"], row["stage"], row["optics"])


def _of(rule: Rule, rows: Sequence[Record]) -> Comparison:
    names = {name: head for name, head in rule.names.items() if any(name in row for row in rows)}
    verdicts = [rule.verdict(row) for row in rows]
    lines = [
        [
            *(shown(row, name) if _known(row, name) else "" for name in names),
            *(shown(row, name) if _known(row, name) else EMPTY for name in SIDE),
            *(cell(row) for cell in rule.before.values()),
            word(verdict),
            *(cell(row) for cell in rule.after.values()),
        ]
        for row, verdict in zip(rows, verdicts, strict=True)
    ]
    head = (*names.values(), *SIDE, *rule.before, "verdict", *rule.after)
    known = {CITED: "no recording or calibration of this run stands for it.", **rule.meanings}
    meanings = {kind: known[kind] for kind in ORDER if kind in known and kind in verdicts}
    return Comparison(counts(verdicts), meanings, rule.note, table(head, lines, first=head))


def counts(words: Iterable[str]) -> str:
    """`44 of 52 agree, 8 differ`; `all cited`."""
    found = Counter(words)
    compared = sum(found[kind] for kind in ORDER[:4])
    if not compared:
        return ", ".join(f"all {kind}" for kind in ORDER if found[kind]) or "no numbers"
    plural = {DIFFERS: "differ", ALONE: "without a partner"}
    rest = [f"{found[kind]} {plural.get(kind, kind)}" for kind in ORDER[1:] if found[kind]]
    return ", ".join([f"{found[AGREES]} of {compared} agree", *rest])
