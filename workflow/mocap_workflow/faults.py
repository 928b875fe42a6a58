"""Wrong input is said in full and in lines a user can act on, never as a traceback."""

from __future__ import annotations

import difflib
import sys
from collections.abc import Iterable
from typing import NoReturn


class Faults(Exception):
    """Everything wrong with an input, one line each."""

    def __init__(self, lines: Iterable[str]):
        self.lines = [" ".join(str(line).split()) for line in lines]
        super().__init__("\n".join(self.lines))


def stop(faults: Faults) -> NoReturn:
    """Print the lines on standard error and leave with status 1."""
    sys.exit("\n".join(faults.lines))


def shown(value: object, most: int = 80) -> str:
    """A value as the message shows it: text quoted, nothing called nothing, long things cut."""
    if value is None or value == "":
        return "nothing"
    if isinstance(value, bool):
        return "yes" if value else "no"
    text = f'"{value}"' if isinstance(value, str) else str(value)
    return text if len(text) <= most else f"{text[: most - 5]}[...]"


def meant(word: str, known: Iterable[str]) -> str | None:
    """The known word that `word` was probably meant to be."""
    folded = {str(name).casefold(): name for name in known}
    close = difflib.get_close_matches(str(word).strip().casefold(), list(folded), n=1, cutoff=0.6)
    return folded[close[0]] if close else None


def unknown(word: str, known: Iterable[str]) -> str:
    """`unknown; did you mean ...?`, or the list of what is known."""
    known = list(known)
    guess = meant(word, known)
    if guess is not None:
        return f"unknown; did you mean {guess}?"
    return f"unknown; expected {'one of ' + ', '.join(known) if known else 'nothing here'}"
