"""The exceptions that a user is meant to read."""

from __future__ import annotations

from pathlib import Path


class Refusal(ValueError):
    """Input that cannot be used. The message is one line: what, where, what was expected."""

    def __init__(self, message: str):
        super().__init__(" ".join(str(message).split()))


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
    """A file whose unit of length is not told, or not believed, until the user states it."""


class Unseen(Refusal):
    """A marker that is seen in no frame of an otherwise good file."""
