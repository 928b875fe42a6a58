"""A claim of a paper, its decision rule and its result.

`claims.tsv` lists what both papers claim and how each claim is decided; the criterion's numbers are
its `arguments`. The other modules compute the statistics; `decides` of each connects a function
with the claims that it decides. Claims of S are decided by its published numbers or by recordings
of the workflow, those of J by its tables or by calibrations.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

import numpy as np

from mocap_metrology.noise.model.components import NoiseModel
from mocap_metrology.present.tables import Row
from mocap_metrology.present.text.numbers import significant, with_unit

HOLDS, DOES_NOT, UNKNOWN = "holds", "does not", "undecided"
COLUMNS = (
    *("id", "paper", "section", "claim", "statistic", "criterion"),
    *("published", "published_word", "regenerated", "realisations", "regenerated_word"),
    *("source", "note"),
)


class Source(Protocol):
    """The numbers that decide claims: those of a paper, or regenerated ones."""

    @property
    def of_paper(self) -> bool: ...


class Missing(KeyError):
    """Numbers that a claim needs and that are not available; the text gives the reason."""


@dataclass(frozen=True)
class Finding:
    """The statistic with its numbers, and whether the claim holds by it."""

    value: str
    word: str


Function = Callable[..., Finding]  # of a source and the arguments in `claims.tsv`
F = TypeVar("F", bound=Function)


class Rules(dict[str, Function]):
    """Ids as in `claims.tsv` -> the function that decides them; decorates these functions."""

    def __call__(self, *ids: str) -> Callable[[F], F]:
        def register(function: F) -> F:
            self.update(dict.fromkeys(ids, function))
            return function

        return register


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
    function: Function

    @property
    def paper(self) -> str:
        return self.id[0]

    def decide(self, source: Any) -> Finding:
        """By the numbers of a source; `KeyError` where it lacks some."""
        return self.function(source, *self.arguments)

    def find(self, source: Source | None) -> Finding:
        """The same; undecided without a source, or if it lacks numbers."""
        if source is None:
            return unknown("no recordings")
        if source.of_paper and self.not_published:
            return unknown(self.not_published)
        try:
            return self.decide(source)
        except KeyError as missing:
            return unknown(str(missing.args[0]))

    def row(self, published: Finding, found: Finding, source: str, realisations: str) -> Row:
        """A line of `claims.csv`."""
        cells = (
            *(self.id, self.paper, self.section, self.claim, self.statistic, self.criterion),
            *(published.value, published.word, found.value, realisations, found.word),
            *("" if found.word == UNKNOWN else source, self.note),
        )
        return dict(zip(COLUMNS, cells, strict=True))


def unknown(why: str) -> Finding:
    return Finding(why, UNKNOWN)


def decided(value: str, *answers: bool | str) -> Finding:
    """The claim holds if all answers (words or flags) do, and does not hold if one does not."""
    words = [a if isinstance(a, str) else HOLDS if a else DOES_NOT for a in answers]
    word = UNKNOWN if UNKNOWN in words else HOLDS
    return Finding(value, DOES_NOT if DOES_NOT in words else word)


def at_least(flags: Sequence[bool], least: float) -> str:
    """Whether flags are true in a share of `least`: undecided where the 95 % interval of the share
    (Clopper-Pearson) contains it, except if all are true."""
    from scipy.special import betaincinv

    hits, total = int(np.sum(flags)), len(flags)
    if not total:
        return UNKNOWN
    low = betaincinv(hits, total - hits + 1, 0.025) if hits else 0.0
    high = betaincinv(hits + 1, total - hits, 0.975) if hits < total else 1.0
    if hits == total or low >= least:
        return HOLDS
    return DOES_NOT if high < least else UNKNOWN


def median_error(values: Sequence[float] | np.ndarray) -> float:
    """Two standard errors of the median of values (k,): those of a normal distribution with the
    same 16 and 84 % points; infinite for fewer than three."""
    if len(values) < 3:
        return np.inf
    low, high = np.quantile(values, [0.16, 0.84])
    return float(2 * 1.2533 * (high - low) / 2 / np.sqrt(len(values)))


def within(value: float, error: float, low: float, high: float) -> str:
    """Whether a number lies between low and high: undecided where value +- error spans a limit."""
    if low <= value - error and value + error <= high:
        return HOLDS
    return DOES_NOT if value + error < low or value - error > high else UNKNOWN


def share(flags: Sequence[bool]) -> str:
    """`12 of 14 (86 %)`."""
    total = len(flags)
    return f"{sum(flags)} of {total} ({100 * sum(flags) / max(total, 1):.0f} %)"


@dataclass(frozen=True)
class Orders:
    """log10 of the 5 %, 50 % and 95 % points of the positive ones of some values, two standard
    errors of the median, and their text; `zeros`: how many of `total` are not positive."""

    low: float
    middle: float
    high: float
    error: float
    zeros: int
    total: int
    text: str

    def near(self, exponent: float, decades: float) -> str:
        """Whether the median is of the order of 10^exponent."""
        return within(self.middle, self.error, exponent - decades, exponent + decades)

    def between(self, low: float, high: float) -> bool:
        """Whether nine in ten of the positive values are between 10^low and 10^high."""
        return low <= self.low and self.high <= high


def orders(values: Sequence[float], name: str) -> Orders:
    """Orders of magnitude of a coefficient's values, in the unit of that coefficient; `Missing` if
    none is positive."""
    known = np.asarray([v for v in values if v > 0])
    if not known.size:
        raise Missing(f"no {name} above zero")
    points = np.quantile(known, [0.05, 0.5, 0.95])
    unit, zeros = NoiseModel.UNITS[name], len(values) - known.size
    shown = [with_unit(p, unit, 2) if unit == "mm" else significant(p, 2) for p in points.tolist()]
    end = "" if unit == "mm" else f" {unit}"
    text = f"{name} {shown[1]}{end} (5 to 95 %: {shown[0]} to {shown[2]})"
    if zeros:
        text += f", {zeros} of {len(values)} zero"
    low, middle, high = np.log10(points).tolist()
    error = median_error(np.log10(known))
    return Orders(low, middle, high, error, zeros, len(values), text)
