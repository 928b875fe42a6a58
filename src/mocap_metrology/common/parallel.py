"""How a function is applied to each of several series: one after another, or at once."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Protocol, TypeVar

T = TypeVar("T")
R = TypeVar("R")


class MapFunction(Protocol):
    """The results of a function of each of some items, in their order."""

    def __call__(self, function: Callable[[T], R], items: Iterable[T], /) -> Iterable[R]: ...


def in_turn(function: Callable[[T], R], items: Iterable[T], /) -> Iterable[R]:
    """One after another."""
    return map(function, items)
