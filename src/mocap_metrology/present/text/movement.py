"""The warning of markers that move."""

from __future__ import annotations

from collections.abc import Mapping

from mocap_metrology.noise.motion.movement import Movement
from mocap_metrology.present.text.sentence import render

MOST_NAMED = 6


def movement_words(moving: Mapping[str, tuple[str, Movement]], within_s: float) -> list[str]:
    """One line that names every moving marker (`most_moving`) and describes the largest movement:
    `shifts by 2.05 mm along x at 312 s`; none without movement."""
    if not moving:
        return []
    label = max(moving, key=lambda name: moving[name][1].size_mm)
    axis, worst = moving[label]
    size = {"size_mm": worst.size_mm, "time_s": worst.time_s, "axis": axis, "label": label}
    named = {"names": list(moving), "most": MOST_NAMED, "within_s": within_s}
    return [render("moving.line", **named, **size)]
