"""A sentence of the diagnosis."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

Severity = Literal["info", "warning"]


@dataclass(frozen=True)
class Sentence:
    """kind: event, periodic, resolution, filter, low_pass, warm_up, drift, outliers, gaps, filled,
    repeated, moving, misfit, level, tails; severity: info or warning; words: a sentence; numbers:
    those in it, units in their names."""

    kind: str
    severity: Severity
    series: tuple[str, ...]
    words: str
    numbers: Mapping[str, object] = field(default_factory=dict)


def severity(matters: bool) -> Severity:
    """`warning` of what matters."""
    return "warning" if matters else "info"
