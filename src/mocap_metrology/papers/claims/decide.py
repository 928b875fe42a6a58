"""Whether a claim holds: words, their statistics, and which function decides which claim.

`claims.tsv` lists the claims, how each is decided, and the numbers of its criterion (`arguments`).
A deciding function takes the numbers of a study (published or regenerated) and these arguments. It
returns the statistic (`Text`), then one or more answers (flags or words).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar

import numpy as np

from mocap_metrology.noise.model.components import NoiseModel

HOLDS, DOES_NOT, UNKNOWN = "holds", "does not", "undecided"
Answer = tuple[Any, ...]  # the statistic (a string or `Text`), then flags or words
F = TypeVar("F", bound=Callable[..., Answer])
RULES: dict[str, Callable[..., Answer]] = {}  # id as in `claims.tsv` -> deciding function


class Missing(KeyError):
    """Numbers that a claim needs and that are not available; the text gives the reason."""


class Quantity(NamedTuple):
    """A number to be written with so many digits, and with the prefixed unit if it has one."""

    value: float
    digits: int
    unit: str = ""


Text = tuple[str | Quantity, ...]


class Finding(NamedTuple):
    """The statistic with its numbers, and whether the claim holds by it."""

    value: Text
    word: str


def finding(text: str | Text, *answers: bool | str) -> Finding:
    """The claim holds if all answers do, does not hold if one does not, else it is undecided."""
    words = [a if isinstance(a, str) else HOLDS if a else DOES_NOT for a in answers]
    word = DOES_NOT if DOES_NOT in words else UNKNOWN if UNKNOWN in words else HOLDS
    return Finding((text,) if isinstance(text, str) else text, word)


def decides(*ids: str) -> Callable[[F], F]:
    """Registers a function as the one that decides the claims with these ids."""

    def register(function: F) -> F:
        RULES.update(dict.fromkeys(ids, function))
        return function

    return register


def at_least(flags: Sequence[bool], least: float) -> str:
    """Whether flags are true in a share of `least`: undecided where the 95 % interval of the share
    (Clopper-Pearson) contains it, except if all are true."""
    from scipy.stats import binomtest

    if not flags:
        return UNKNOWN
    interval = binomtest(int(sum(flags)), len(flags)).proportion_ci(0.95)
    if all(flags) or interval.low >= least:
        return HOLDS
    return DOES_NOT if interval.high < least else UNKNOWN


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
    errors of the median, the share that is not positive, and all this as text."""

    low: float
    middle: float
    high: float
    error: float
    zeros: float
    text: Text

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
    points, unit = np.quantile(known, [0.05, 0.5, 0.95]), NoiseModel.UNITS[name]
    prefixed, behind = (unit, "") if unit == "mm" else ("", f" {unit}")
    low, middle, high = (Quantity(point, 2, prefixed) for point in points.tolist())
    zeros = len(values) - known.size
    end = f"), {zeros} of {len(values)} zero" if zeros else ")"
    text = (f"{name} ", middle, f"{behind} (5 to 95 %: ", low, " to ", high, end)
    error = median_error(np.log10(known))
    first, second, third = np.log10(points).tolist()
    return Orders(first, second, third, error, zeros / len(values), text)
