"""Configuration read into dataclasses whose fields say how: Annotated[type, reader(value, where)].

A reader returns the value or raises a `Refusal` that begins with `where`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import MISSING, fields
from functools import cache
from typing import Any, get_type_hints

from mocap_metrology.common.errors import Refusal

Reader = Callable[[Any, str], Any]


def read(kind: type, mapping: Any, where: str, **more: Any) -> Any:
    """An instance of a dataclass from its keys; a key without a value counts as absent.

    Raises `Refusal` for keys unknown or missing and values that their readers refuse.
    """
    given = {k: v for k, v in mapping_of(mapping, where).items() if v is not None}
    readers = _readers(kind)
    check_keys(given, readers, where)
    for one in fields(kind):
        if one.name in readers and one.default is MISSING and one.name not in given:
            raise Refusal(f"{where}: {one.name} is missing")
    values = {k: readers[k](v, f"{where}: {k}") for k, v in given.items()}
    return kind(**values, **more)


@cache
def _readers(kind: type) -> dict[str, Reader]:
    hints = get_type_hints(kind, include_extras=True)
    return {k: h.__metadata__[0] for k, h in hints.items() if hasattr(h, "__metadata__")}


def number_in(low: float, high: float) -> Reader:
    """Reader of a number in a range."""
    return lambda value, where: number(value, where, low, high)


def whole_in(low: int, high: int) -> Reader:
    """Reader of a whole number in a range."""
    return lambda value, where: whole(value, where, low, high)


def numbers_in(largest: float, count: int = 3) -> Reader:
    """Reader of a list of numbers, each within +-largest."""
    return lambda value, where: numbers(value, where, largest, count)


def one_of(*names: str) -> Reader:
    """Reader of one of these words."""

    def reader(value: Any, where: str) -> str:
        if value not in names:
            raise Refusal(f"{where}: {value!r}, expected one of {', '.join(names)}")
        return value

    return reader


def nested(kind: type) -> Reader:
    """Reader of a dataclass of its own."""
    return lambda value, where: read(kind, value, where)


def text(value: Any, where: str) -> str:
    """Anything, as text."""
    return str(value)


def mapping_of(value: Any, where: str) -> Mapping[str, Any]:
    """Keys with values."""
    if not isinstance(value, Mapping):
        raise Refusal(f"{where}: {value!r}, expected keys with values")
    return value


def check_keys(mapping: Mapping[str, Any], allowed: Iterable[str], where: str) -> None:
    """Refuse keys that nobody knows."""
    for key in mapping:
        if key not in allowed:
            raise Refusal(f"{where}: unknown key {key!r}, expected one of {', '.join(allowed)}")


def whole(value: Any, where: str, low: int, high: int) -> int:
    """A whole number in a range."""
    if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
        raise Refusal(f"{where}: {value!r}, expected a whole number from {low} to {high}")
    return value


def number(value: Any, where: str, low: float, high: float) -> float:
    """A number in a range; `1e-6` arrives from YAML as text and is one too."""
    try:
        found = math.nan if isinstance(value, bool) else float(value)
    except (TypeError, ValueError):
        found = math.nan
    if not low <= found <= high:
        raise Refusal(f"{where}: {value!r}, expected a number from {low:g} to {high:g}")
    return found


def numbers(value: Any, where: str, largest: float, count: int) -> tuple[float, ...]:
    """A list of so many numbers, each within +-largest."""
    if not isinstance(value, list | tuple) or len(value) != count:
        raise Refusal(f"{where}: {value!r}, expected a list of {count} numbers")
    return tuple(number(v, where, -largest, largest) for v in value)
