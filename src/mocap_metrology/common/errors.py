"""The exceptions that a user is meant to read."""

from __future__ import annotations

import errno
from collections.abc import Sequence
from pathlib import Path
from typing import TypeGuard
from unicodedata import category

LONGEST = 2000  # letters of a message
# What numbers out of damaged JSON or YAML raise: also beyond all floats, or nested a thousand deep
UNREADABLE = (ValueError, KeyError, TypeError, AttributeError, OverflowError, RecursionError)


def printable(text: str) -> str:
    """Text for a terminal: a letter that controls it, or has no form of its own, as its code.
    Spaces of any width stay."""
    return "".join(c if c.isprintable() or category(c) == "Zs" else ascii(c)[1:-1] for c in text)


def is_full(error: BaseException) -> TypeGuard[OSError]:
    """Whether a disk, or the user's share of it, has no room left."""
    return isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT)


def one_line(message: object) -> str:
    """A message as one line of printable letters, a very long one without its middle."""
    text = printable(" ".join(str(message).split()))
    if len(text) <= LONGEST:
        return text
    return f"{text[: LONGEST // 2]} [...] {text[-LONGEST // 2 :]}"


class Refusal(ValueError):
    """Input that cannot be used. The message is one line: what, where, what was expected."""

    def __init__(self, message: str):
        super().__init__(one_line(message))


class Damaged(Refusal):
    """A file of results, at `path`, that is not as it was written."""

    def __init__(self, path: str | Path, what: str):
        self.path, self.what = Path(path), what
        super().__init__(f"{path} is damaged: {what}; delete it and run again to make it anew")


class Missing(Refusal):
    """A file of results that an earlier step wrote, and that is gone."""

    def __init__(self, path: str | Path):
        why = "it was deleted, or was damaged and another job removed it"
        super().__init__(f"{path} is missing: {why}; run again to make it anew")


class Truncated(Refusal):
    """A file that ends early, of which what is there could be used."""


class UnknownUnit(Refusal):
    """A file whose unit of length is missing or implausible until the user states it."""


class Unseen(Refusal):
    """Markers that are seen in no frame of an otherwise good file."""

    def __init__(self, text: str, labels: Sequence[str]) -> None:
        super().__init__(text)
        self.labels = labels
