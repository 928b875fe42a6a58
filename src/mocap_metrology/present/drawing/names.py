"""Names of series: coordinates of numbered markers, or anything else."""

from __future__ import annotations

import re

COORDINATE = re.compile(r"([xyz])(\d+)")


def coordinate_of(name: str) -> tuple[str, int] | None:
    """("x", 1) of "x1"; None of a distance or any other name."""
    found = COORDINATE.fullmatch(name)
    return (found[1], int(found[2])) if found else None
