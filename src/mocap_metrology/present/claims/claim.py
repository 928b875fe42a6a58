"""What a claim is, and what was found of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

HOLDS, DOES_NOT, UNKNOWN = "holds", "does not", "cannot be told"
COLUMNS = (
    *("id", "paper", "section", "claim", "statistic", "criterion"),
    *("published", "published_word", "regenerated", "realisations", "regenerated_word"),
    *("source", "note"),
)


@dataclass(frozen=True)
class Finding:
    """The statistic in words with its numbers, and whether the claim holds by it; not `there`:
    cannot be told for want of numbers, not of precision."""

    value: str
    word: str
    there: bool = True


@dataclass(frozen=True)
class Claim:
    """A claim of `section`, in the paper's sense; `statistic` and `criterion` say how it is
    decided; `find` does, of published numbers and of regenerated ones alike. `by_chance`: it is
    moments of whole recordings that decide, mostly random walk, so more realisations are asked."""

    id: str
    section: str
    claim: str
    statistic: str
    criterion: str
    find: Callable[[Any], Finding]
    note: str = ""
    by_chance: bool = False


def decided(value: str, holds: bool) -> Finding:
    return Finding(value, HOLDS if holds else DOES_NOT)


def by_count(value: str, flags: Sequence[bool], least: float) -> Finding:
    """Whether a share of `least` of such cases is as said: what the 95 % interval (Clopper-Pearson)
    of the share leaves open cannot be told. All of fewer than it takes hold too."""
    from scipy.special import betaincinv

    hits, total = int(np.sum(flags)), len(flags)
    if not total:
        return unknown("no cases")
    low = betaincinv(hits, total - hits + 1, 0.025) if hits else 0.0
    high = betaincinv(hits + 1, total - hits, 0.975) if hits < total else 1.0
    if hits == total or low >= least:
        return decided(value, True)
    return decided(value, False) if high < least else Finding(value, UNKNOWN)


def median_error(values: Sequence[float]) -> float:
    """Two standard errors of the median of values (k,): of a normal distribution as wide as they
    are between 16 and 84 %; infinite of fewer than three."""
    if len(values) < 3:
        return np.inf
    low, high = np.quantile(values, [0.16, 0.84])
    return float(2 * 1.2533 * (high - low) / 2 / np.sqrt(len(values)))


def within(value: float, error: float, low: float, high: float) -> str:
    """Whether a number lies between low and high: cannot be told where value +- error spans one."""
    if low <= value - error and value + error <= high:
        return HOLDS
    return DOES_NOT if value + error < low or value - error > high else UNKNOWN


def together(words: Sequence[str]) -> str:
    """All hold, one does not, or it cannot be told."""
    if DOES_NOT in words:
        return DOES_NOT
    return UNKNOWN if UNKNOWN in words else HOLDS


def unknown(why: str, there: bool = True) -> Finding:
    return Finding(why, UNKNOWN, there)


def row(
    claim: Claim,
    paper: str,
    published: Finding,
    regenerated: Finding,
    source: str,
    realisations: str = "",
) -> dict:
    """A line of `claims.csv`."""
    cells = (
        *(claim.id, paper, claim.section, claim.claim, claim.statistic, claim.criterion),
        *(published.value, published.word, regenerated.value, realisations, regenerated.word),
        *(source if regenerated.word != UNKNOWN else "", claim.note),
    )
    return dict(zip(COLUMNS, cells, strict=True))


def orders(values: Sequence[float]) -> tuple[float, float, float]:
    """log10 of the 5 %, 50 % and 95 % points of what is positive."""
    known = np.asarray([v for v in values if v > 0])
    return tuple(np.log10(np.quantile(known, [0.05, 0.5, 0.95])).tolist())


def share(flags: Sequence[bool]) -> str:
    """`12 of 14 (86 %)`."""
    total = len(flags)
    return f"{sum(flags)} of {total} ({100 * sum(flags) / max(total, 1):.0f} %)"
