"""Values of an entry of the configuration, checked; a wrong one is refused in one line.

`where` names the entry and the key, as in `twin T40-10: seed`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from mocap_metrology.common.errors import Refusal

Point = tuple[float, float, float]


def section(value: Any, where: str) -> Mapping[str, Any]:
    """A mapping."""
    if not isinstance(value, Mapping):
        raise Refusal(f"{where}: {value!r}, expected keys with values")
    return value


def check_keys(mapping: Mapping[str, Any], allowed: Any, where: str) -> None:
    """Refuse a key that is not among `allowed`."""
    for key in mapping:
        if key not in allowed:
            raise Refusal(f"{where}: unknown key {key!r}, expected one of {', '.join(allowed)}")


def whole(value: Any, where: str, low: int = 0) -> int:
    """A whole number >= `low`."""
    if not isinstance(value, int) or isinstance(value, bool) or value < low:
        raise Refusal(f"{where}: {value!r}, expected a whole number >= {low}")
    return value


def number(
    value: Any, where: str, low: float = 0.0, high: float = math.inf, positive: bool = False
) -> float:
    """A number of the configuration; `1e-6` arrives from YAML as text and is one too."""
    expected = "a number > 0" if positive else f"a number from {low:g} to {high:g}"
    expected = expected.replace(" from 0 to inf", " >= 0").replace(" from -inf to inf", "")
    try:
        found = math.nan if isinstance(value, bool) else float(value)
    except (TypeError, ValueError):
        found = math.nan
    if not low <= found <= high or math.isinf(found) or (positive and found == 0):
        raise Refusal(f"{where}: {value!r}, expected {expected}")
    return found


def point(value: Any, where: str) -> Point:
    """Three coordinates."""
    if not isinstance(value, list) or len(value) != 3:
        raise Refusal(f"{where}: {value!r}, expected three numbers [x, y, z]")
    x, y, z = (number(v, where, -math.inf) for v in value)
    return x, y, z


def two_labels(value: Any, where: str) -> tuple[str, str]:
    """Names of two markers."""
    named = isinstance(value, list) and all(isinstance(label, str) for label in value)
    if not named or len(value) != 2 or value[0] == value[1]:
        raise Refusal(f"{where}: {value!r}, expected two names [first, second]")
    return value[0], value[1]


def drifts(value: Any, labels: tuple[str, str], where: str) -> dict[str, Point]:
    """Velocities of some of the markers."""
    found = section(value, where)
    check_keys(found, labels, where)
    return {label: point(v, f"{where}.{label}") for label, v in found.items()}
