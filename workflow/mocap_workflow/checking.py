"""What pydantic finds wrong, in lines that a user can act on."""

from __future__ import annotations

from collections.abc import Iterator

from pydantic import ValidationError

Loc = tuple[int | str, ...]


class Unfit(ValueError):
    """A value is not what was expected; `value`, where only a part of it is meant, and `at`, where
    this is."""

    def __init__(
        self, expected: str, value: object = None, at: str = "", also: tuple[Unfit, ...] = ()
    ):
        super().__init__(expected)
        self.expected, self.value, self.at, self.also = expected, value, at, also


def unfit(found: list[Unfit]) -> Unfit:
    """Several at once."""
    return Unfit(found[0].expected, found[0].value, also=tuple(found[1:]))


def misfits(error: ValidationError) -> Iterator[tuple[Loc, Unfit | None]]:
    """Where something is wrong, and what was expected there; None where the type says it."""
    for one in error.errors(include_url=False, include_input=False):
        cause = one.get("ctx", {}).get("error")
        if isinstance(cause, Unfit):
            yield from ((one["loc"], part) for part in (cause, *cause.also))
        else:
            yield one["loc"], None


class Unmatched(Unfit):
    """A cell does not look as its column asks."""
