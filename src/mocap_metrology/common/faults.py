"""Wrong input is reported completely, in lines a user can act on, never as a traceback."""

from __future__ import annotations

import difflib
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, NoReturn

from mocap_metrology.common.errors import one_line

if TYPE_CHECKING:
    from pydantic import ValidationError

Loc = tuple[int | str, ...]  # of a value in what pydantic checks


class Faults(Exception):
    """Everything wrong with an input, one line each."""

    def __init__(self, lines: Iterable[str]):
        self.lines = [one_line(line) for line in lines]
        super().__init__("\n".join(self.lines))


def stop(faults: Faults) -> NoReturn:
    """Print the lines on standard error and leave with status 1."""
    sys.exit("\n".join(faults.lines))


def quoted(value: object) -> str:
    """A value as the message shows it: text quoted, nothing called nothing, long things cut."""
    if value is None or value == "":
        return "nothing"
    if isinstance(value, bool):
        return "yes" if value else "no"
    text = f'"{value}"' if isinstance(value, str) else str(value)
    return shortened(text, 80)


def shortened(text: str, most: int = 300) -> str:
    """A text without its end where it is long."""
    return text if len(text) <= most else f"{text[: most - 5]}[...]"


def closest_word(word: str, known: Iterable[str]) -> str | None:
    """The known word that `word` was probably meant to be."""
    folded = {str(name).casefold(): name for name in known}
    near = nearest(str(word).strip().casefold(), folded)
    return folded[near[0]] if near else None


def nearest(word: str, known: Iterable[str]) -> list[str]:
    """Up to three words to which the fewest edits lead (a letter inserted, removed, replaced, or
    two neighbours exchanged), of those that resemble `word`."""
    close = difflib.get_close_matches(word, list(known), n=10, cutoff=0.6)
    edits = {other: _edits(word, other) for other in close}
    return [other for other in close if edits[other] == min(edits.values())][:3]


def _edits(first: str, second: str) -> int:
    """Optimal string alignment distance."""
    rows = [list(range(len(second) + 1))]
    for i, letter in enumerate(first, start=1):
        row = [i]
        for j, other in enumerate(second, start=1):
            cost = min(rows[-1][j] + 1, row[-1] + 1, rows[-1][j - 1] + (letter != other))
            if i > 1 < j and letter == second[j - 2] and first[i - 2] == other:
                cost = min(cost, rows[-2][j - 2] + 1)
            row.append(cost)
        rows.append(row)
    return rows[-1][-1]


def unknown(word: str, known: Iterable[str]) -> str:
    """`unknown; did you mean ...?`, or the list of what is known."""
    known = list(known)
    guess = closest_word(word, known)
    if guess is not None:
        return f"unknown; did you mean {guess}?"
    return f"unknown; expected {'one of ' + ', '.join(known) if known else 'nothing here'}"


class Unfit(ValueError):
    """A value is not what was expected; `value`, where only a part of it is meant, and `at`, where
    this is."""

    def __init__(
        self, expected: str, value: object = None, at: str = "", also: tuple[Unfit, ...] = ()
    ):
        super().__init__(expected)
        self.expected, self.value, self.at, self.also = expected, value, at, also


class Unmatched(Unfit):
    """A cell does not have the form of its column."""


def unfit(causes: list[Unfit]) -> Unfit:
    """Several at once."""
    return Unfit(causes[0].expected, causes[0].value, also=tuple(causes[1:]))


@dataclass(frozen=True)
class Misfit:
    """One thing that pydantic found wrong: where, its name for it (`missing`, `extra_forbidden`),
    the value, and what a check of ours raised."""

    loc: Loc
    kind: str
    value: object
    cause: Exception | None


def misfits(error: ValidationError) -> Iterator[Misfit]:
    """Everything that is wrong; several `Unfit` of one check one by one."""
    for one in error.errors(include_url=False):
        cause = one.get("ctx", {}).get("error")
        for part in (cause, *cause.also) if isinstance(cause, Unfit) else (cause,):
            yield Misfit(one["loc"], one["type"], one["input"], part)
