"""All claims of both papers, decided by published and by regenerated numbers."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from typing import Any, NamedTuple

from mocap_metrology.papers.claims import coefficients, curves, decide, jansen, scaling
from mocap_metrology.papers.claims.study import Moments, Published, Realisation, Regenerated

DECIDING = coefficients, curves, jansen, scaling  # modules that fill `decide.RULES`
REPEATS = 200  # realisations of the twins of S
SLOW_SAMPLES = 1 << 12  # of each, every eight seconds of nine hours: moments need no more
SURE = 0.95
ENOUGH = 0.5  # share of realisations that must decide


@dataclass(frozen=True)
class Claim:
    """A row of `claims.tsv`. `by_chance`: moments of whole recordings decide it. These are mostly
    random walk, so more realisations are drawn. `not_published`: why the paper's own numbers cannot
    decide it."""

    id: str
    section: str
    claim: str
    statistic: str
    criterion: str
    arguments: tuple[Any, ...]
    by_chance: bool
    not_published: str
    note: str
    rule: str  # id in `decide.RULES`

    @property
    def paper(self) -> str:
        return self.id[0]

    def find(self, source: Any) -> decide.Finding:
        """The finding on the claim by the numbers of a source; undecided without a source, or where
        it lacks some."""
        if source is None:
            return decide.finding("no recordings", decide.UNKNOWN)
        try:
            return decide.finding(*decide.RULES[self.rule](source, *self.arguments))
        except KeyError as missing:
            return decide.finding(str(missing.args[0]), decide.UNKNOWN)


@lru_cache(maxsize=1)
def claims() -> Mapping[str, Claim]:
    """All claims by id, in the order of `claims.tsv`.

    A row with several lists of arguments, separated by `;`, is a claim for each of them; `{0}` in
    its texts is the first argument.
    """
    text = (files("mocap_metrology") / "papers/claims/claims.tsv").read_text(encoding="utf-8")
    by_id = {}
    for row in csv.DictReader(text.splitlines(), delimiter="\t", quoting=csv.QUOTE_NONE):
        for words in row["arguments"].split(";"):
            arguments = tuple(map(_number_or_name, words.split()))
            cells: dict[str, Any] = {name: cell.format(*arguments) for name, cell in row.items()}
            cells |= {"arguments": arguments, "by_chance": bool(row["by_chance"])}
            claim = Claim(**cells, rule=row["id"])
            by_id[claim.id] = claim
    return by_id


def _number_or_name(word: str) -> Any:
    try:
        return json.loads(word)
    except ValueError:
        return word


class Decision(NamedTuple):
    """A claim by published and by regenerated numbers; realisations: in how many it holds; source:
    of the regenerated numbers (`twin`, `measured`, ...)."""

    claim: Claim
    published: decide.Finding
    regenerated: decide.Finding
    realisations: str
    source: str


def decisions(
    study: Regenerated | None,
    calibrations: jansen.Calibrations | None,
    sources: tuple[str, str],
    moments: Moments | None = None,
) -> list[Decision]:
    """All claims, decided.

    study, calibrations: regenerated numbers of S and J, None without recordings; sources: where
    they come from; moments: of `REPEATS` more realisations of each twin of S, (repeats,) by name.
    """
    draws = realisations(moments or {})
    decided = []
    for claim in claims().values():
        of_s = claim.paper == "S"
        published = Published() if of_s else jansen.PublishedTables()
        reason = claim.not_published
        printed = decide.finding(reason, decide.UNKNOWN) if reason else claim.find(published)
        again, counted = of_realisations(claim, claim.find(study if of_s else calibrations), draws)
        decided.append(Decision(claim, printed, again, counted, sources[not of_s]))
    return decided


def realisations(moments: Moments) -> list[Realisation]:
    """The k-th realisation of every twin side by side, for all k."""
    repeats = min((len(v) for of in moments.values() for v in of.values()), default=0)
    return [
        Realisation({key: {q: float(v[k]) for q, v in of.items()} for key, of in moments.items()})
        for k in range(repeats)
    ]


def of_realisations(
    claim: Claim, one: decide.Finding, draws: Sequence[Realisation]
) -> tuple[decide.Finding, str]:
    """The finding of one recording with the word that realisations give it, and in how many it
    holds.

    A realisation that is not precise enough decides nothing. Of those that decide, the claim holds
    in 95 % and more (it holds) or in 5 % and fewer (it does not). It is undecided between these
    shares, and where fewer than half decide. The finding is unchanged and there is no count if the
    claim is not by chance, or if not all of its recordings are twins.
    """
    if not claim.by_chance or not draws:
        return one, ""
    rule = decide.RULES[claim.rule]
    try:
        words = [decide.finding(*rule(draw, *claim.arguments)).word for draw in draws]
    except KeyError:
        return one, ""
    holds, deciding = words.count(decide.HOLDS), len(words) - words.count(decide.UNKNOWN)
    word = decide.UNKNOWN
    if deciding >= ENOUGH * len(draws):
        word = decide.HOLDS if holds >= SURE * deciding else word
        word = decide.DOES_NOT if holds <= (1 - SURE) * deciding else word
    counted = f"holds in {holds} of {deciding}"
    if deciding < len(draws):
        counted += f" that decide, {len(draws)} drawn"
    return decide.Finding(one.value, word), counted
