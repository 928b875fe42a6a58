"""The warning of markers that move."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from mocap_metrology.noise.motion.movement import Movement
from mocap_metrology.present.text.numbers import mm, with_unit

MOST_NAMED = 6


def movement_words(moving: Mapping[str, tuple[str, Movement]], within_s: float) -> list[str]:
    """One line that names every moving marker (`most_moving`) and describes the largest movement:
    `shifts by 2.05 mm along x at 312 s`; none without movement."""
    if not moving:
        return []
    label = max(moving, key=lambda name: moving[name][1].size_mm)
    axis, worst = moving[label]
    first, *others = moving
    size = f"by {mm(worst.size_mm)} along {axis}"
    movement = f"moves {size} within {with_unit(within_s, 's')}"
    if math.isfinite(worst.time_s):
        movement = f"shifts {size} at {with_unit(worst.time_s, 's')}"
    return [
        f"marker {first} seems to move{_and_others(others)}: {f'{label} ' if others else ''}"
        f"{movement}, which noise does not explain; the Allan variance assumes stationary markers"
    ]


def _and_others(names: Sequence[str]) -> str:
    """`, and so does B`; `, and so do B, C and D`; `, and so do 39 others`."""
    if len(names) > MOST_NAMED:
        return f", and so do {len(names)} others"
    if len(names) < 2:
        return "".join(f", and so does {name}" for name in names)
    return f", and so do {', '.join(names[:-1])} and {names[-1]}"
