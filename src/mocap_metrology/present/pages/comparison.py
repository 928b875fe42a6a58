"""Each table of both papers in short: published beside regenerated, and whether a regenerated
number agrees with the published one."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from mocap_metrology.common.types import Record
from mocap_metrology.papers.jansen import FACTOR, VARIANTS, Variant
from mocap_metrology.present.pages import site
from mocap_metrology.present.tables import read, readable, shown
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import significant, with_interval

AGREES, DIFFERS, CITED, OPEN = "agrees", "differs", "cited", "not compared"
BELOW, ALONE = "not detected", "no partner"
PERCENT, ERRORS = 0.1, 3.0  # Table 1 of S: rounding of the printed 1.038 is 0.05 %
ORDER = (AGREES, DIFFERS, BELOW, ALONE, OPEN, CITED)
PLURAL = {DIFFERS: "differ", ALONE: "without a partner"}
SIDE = ("published", "regenerated")
PARTNER = re.compile(r"[\w-]+: its \w+(; )?")  # by what name an estimator has the coefficient
OF_CLAIMS = Variant("paper", "kabsch", "ideal")  # as the claims on J
Columns = Mapping[str, Callable[[Record], str]]


@dataclass(frozen=True)
class Comparison:
    """A table in short; `counts`: how many numbers agree; `others`: the same by other variants."""

    counts: str
    meanings: Mapping[str, str]
    note: str
    table: site.Table
    others: site.Table | None = None


@dataclass(frozen=True)
class Rule:
    """How a table is compared: what its verdicts mean (in `captions.toml`), the columns that name a
    row, the verdict of a row, and further columns before and after it (functions of a row)."""

    text: str
    names: Mapping[str, str]
    verdict: Callable[[Record], str]
    before: Columns = field(default_factory=dict)
    after: Columns = field(default_factory=dict)
    note: str = ""


def known(row: Record, *names: str) -> bool:
    """Whether all these cells have a value."""
    return all(row.get(name) is not None and row[name] == row[name] for name in names)


def _agree(holds: object) -> str:
    return AGREES if holds else DIFFERS


def law(row: Record) -> str:
    """Point samples are what a camera takes, and no number of the paper."""
    if row["method"] == "point samples":
        return OPEN
    allowed = PERCENT / 100 * (abs(row["published"]) or 1.0)
    if row["method"] == "simulation":
        allowed = max(allowed, ERRORS * row["standard_error"])
    return _agree(abs(row["regenerated"] - row["published"]) <= allowed)


def cameras(row: Record) -> str:
    return _agree(row["published"] == row["regenerated"]) if known(row, "regenerated") else CITED


def moment(row: Record) -> str:
    """Whether a Gaussian quantity of S agrees: its published number is in the range of chance."""
    if not known(row, "regenerated"):
        return CITED
    inside = [row[name] for name in ("inside", "published_inside") if known(row, name)]
    return _agree(all(inside)) if inside else OPEN


def coefficient(row: Record) -> str:
    """Whether a published coefficient is inside the 95 % interval of the regenerated one."""
    value, status = row["published"], row["likelihood_status"]
    low, high = row["likelihood_lower_95"], row["likelihood_upper_95"]
    if row["source"] == CITED:
        return CITED
    if status == "unpaired":
        return ALONE
    if status == "not_detected" and known(row, "likelihood_upper_95"):
        return BELOW if value <= high else DIFFERS
    ends = known(row, "likelihood_lower_95", "likelihood_upper_95")
    return _agree(low <= value <= high) if ends else OPEN


def error_of_j(row: Record) -> str:
    """Whether an error of J agrees with the regenerated one within FACTOR."""
    if row["source"] == CITED:
        return CITED
    return _agree(1 / FACTOR <= row["ratio"] <= FACTOR) if known(row, "ratio") else OPEN


def _likelihood(row: Record) -> str:
    """The estimate by likelihood with its interval, or the limit where nothing was detected."""
    low, high = row["likelihood_lower_95"], row["likelihood_upper_95"]
    if row["likelihood_status"] == "not_detected" and known(row, "likelihood_upper_95"):
        return f"< {significant(high)}"
    return with_interval(row["likelihood"], low, high) or site.EMPTY


def _standard_error(row: Record) -> str:
    return significant(row["standard_error"], 2) if row["method"] == "simulation" else ""


def _span(row: Record, before: str = "") -> str:
    """`0.0125…0.0178`: what chance allows nine times in ten."""
    ends = (f"{before}lower_5", f"{before}upper_95")
    texts = [readable(row[end], row["quantity"]) for end in ends]
    return "…".join(texts) if all(texts) else ""


def _text(name: str) -> Callable[[Record], str]:
    return lambda row: str(row[name]) if known(row, name) else ""


def _note(row: Record) -> str:
    """Without the names by which estimators have the coefficient."""
    short = "recording too short for it" if row.get("supported") is False else ""
    return "; ".join(filter(None, [short, PARTNER.sub("", _text("note")(row))]))


SOURCE: Columns = {"source": _text("source")}
NOTE: Columns = {**SOURCE, "note": _note}
QUANTITY = {"quantity": "quantity"}
COEFFICIENTS = Rule(
    "COMPARED_COEFFICIENTS",
    {"n_cameras": "cameras", "series": "series", "parameter": "coefficient", "unit": "unit"},
    coefficient,
    {"likelihood (95 % interval)": _likelihood},
    NOTE,
    "Regenerated: by the estimator of the paper, which has no interval.",
)
ERRORS_OF_J = Rule(
    "COMPARED_ERRORS",
    {"noise": "noise", "setup": "setup"} | QUANTITY,
    error_of_j,
    {"ratio": lambda row: significant(row["ratio"], 2)},
    {"calibrations": _text("n"), **SOURCE},
    "Regenerated: by {variant}.",
)
RULES = {
    "skurowski_table1": Rule(
        "COMPARED_LAWS",
        {"noise": "noise"} | QUANTITY | {"tau_s": "τ (s)", "method": "method"},
        law,
        {"standard error": _standard_error},
        NOTE,
    ),
    "skurowski_table2": Rule(
        "COMPARED_TYPES",
        {"camera_type": "camera"} | QUANTITY | {"unit": "unit"},
        lambda row: CITED,
        after={"note": _note},
    ),
    "skurowski_table3": Rule(
        "COMPARED_CAMERAS", {"camera_type": "camera", "n_cameras": "cameras"}, cameras, after=SOURCE
    ),
    "skurowski_table4": Rule(
        "COMPARED_MOMENTS",
        {"camera_type": "camera"} | QUANTITY,
        moment,
        {"5…95 %, this length": _span, "5…95 %, nine hours": lambda row: _span(row, "nine_hours_")},
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
    rows = read(path).to_dict("records")
    return compare(path.stem, [{str(k): v for k, v in row.items()} for row in rows])


def compare(name: str, rows: Sequence[Record]) -> Comparison | None:
    """What is read first of a table of that name, given the rows of its CSV; None of a table that
    is in neither paper."""
    rule = RULES.get(name)
    if rule is None:
        return None
    rows = [row for row in rows if known(row, "published")]  # other terms are no numbers of it
    if rule is not ERRORS_OF_J:
        return _of(rule, rows)
    variants: dict[Variant, list[Record]] = {v: [] for v in (OF_CLAIMS, *VARIANTS)}
    for row in rows:
        variants[Variant(row["estimator"], row["stage"], row["optics"])].append(row)
    of = {variant: rows for variant, rows in variants.items() if rows}
    each = [(str(variant), counts(map(rule.verdict, rows))) for variant, rows in of.items()]
    first = next(iter(of))
    short = _of(replace(rule, note=rule.note.format(variant=first)), of[first])
    return replace(short, others=site.table(("variant", "numbers"), each, words=(0, 1)))


def _of(rule: Rule, rows: Sequence[Record]) -> Comparison:
    names = {name: head for name, head in rule.names.items() if any(name in row for row in rows)}
    verdicts = [rule.verdict(row) for row in rows]
    lines = [
        [
            *(shown(row, name) if known(row, name) else "" for name in names),
            *(shown(row, k) if known(row, k) else site.EMPTY for k in SIDE),
            *(cell(row) for cell in rule.before.values()),
            site.word(verdict),
            *(cell(row) for cell in rule.after.values()),
        ]
        for row, verdict in zip(rows, verdicts, strict=True)
    ]
    head = (*names.values(), *SIDE, *rule.before, "verdict", *rule.after)
    limits = {"percent": PERCENT, "errors": ERRORS, "factor": FACTOR}
    texts = captions.texts("COMPARED") | captions.texts(rule.text)
    meanings = {k: texts[k].format(**limits) for k in ORDER if k in texts and k in verdicts}
    return Comparison(counts(verdicts), meanings, rule.note, site.table(head, lines, first=head))


def counts(words: Iterable[str]) -> str:
    """`44 of 52 agree, 8 differ`; `all cited`."""
    number = Counter(words)
    compared = sum(number[kind] for kind in ORDER[:4])
    if not compared:
        return ", ".join(f"all {kind}" for kind in ORDER if number[kind]) or "no numbers"
    rest = [f"{number[kind]} {PLURAL.get(kind, kind)}" for kind in ORDER[1:] if number[kind]]
    return ", ".join([f"{number[AGREES]} of {compared} agree", *rest])
