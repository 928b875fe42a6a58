"""Which markers a recording is judged by where none are named."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from mocap_metrology.common.errors import Refusal, Unseen
from mocap_metrology.io.labels import in_words
from mocap_metrology.io.read import Kind, points_by_kind, read_recording
from mocap_metrology.noise.gaussian.two_markers import median_drift
from mocap_metrology.present.text.numbers import mm
from mocap_metrology.recording.clean import Entry

# What is judged, the first kind of which the file has points, and what to say of it
KINDS: dict[Kind, str] = {
    "marker": "",
    "unlabelled": "; no marker of the file has a label, so a trajectory may be of several",
    "body": "; they are rigid bodies, whose positions the software solved from several markers",
}
FEWEST_SEEN = 0.5  # share of frames a marker must be there in to be chosen
WANTED = 2  # with two there is a distance


def chosen(entry: Entry, limit_mm: float) -> tuple[list[str], str]:
    """Markers of a file, and why these."""
    (path,) = entry.paths
    points = points_by_kind(path, entry.accept_truncated, entry.column_names)
    for kind in (kind for kind in KINDS if kind in points):
        labels = [label for label in points[kind] if ";" not in label]  # which separates them
        found, why = choose(labels, lambda label: _movement(entry, label), limit_mm)
        if found:
            return found, why + KINDS[kind]
    every = in_words([label for labels in points.values() for label in labels], 60)
    if KINDS.keys() & points.keys():
        why = "no marker or body is seen in half of the frames; name markers of these"
    else:
        why = (
            "all its points were computed by a model, not measured; to use them all the same, name"
        )
    raise Refusal(f"{Path(path).name}: {why}: {every}")


def choose(
    labels: Sequence[str], movement: Callable[[str], float | None], limit_mm: float
) -> tuple[list[str], str]:
    """Markers to judge by, and why these.

    The first two in the file that are at rest: choosing the quietest would flatter the system.
    Where fewer do, the two that move least. movement: range in mm of a marker's one-second means,
    None if it is hardly visible or not measured; computed only until two are found.
    """
    ranges: dict[str, float] = {}
    for label in labels:
        moved = movement(label)
        if moved is not None:
            ranges[label] = moved
        still = [name for name, value in ranges.items() if value <= limit_mm]
        if len(still) == WANTED:
            return still, "the first two at rest"
    least = sorted(ranges, key=lambda name: ranges[name])[:WANTED]
    if least and all(ranges[name] <= limit_mm for name in least):
        return least, "all at rest"
    moves = ", ".join(f"{name} by {mm(ranges[name])}" for name in least)
    return least, f"those that move least, {moves}: no two are at rest"


def _movement(entry: Entry, label: str) -> float | None:
    """Range of a marker's one-second medians in mm; None if it is hardly seen, or has a coordinate
    that is zero throughout, which no marker has that is measured."""
    how = entry.frame_rate_hz, False, entry.accept_truncated, entry.unit, entry.column_names
    try:
        found = read_recording(entry.paths, [label], *how)
    except Unseen:
        return None
    position = found.position_mm[0]
    seen = np.isfinite(position).all(axis=0)
    known = position if seen.all() else position[:, seen]
    if seen.mean() < FEWEST_SEEN or not known.any(axis=1).all():
        return None
    ranges = [median_drift(axis.astype(float), found.frame_rate_hz).range for axis in position]
    return float(max(ranges)) if np.isfinite(ranges).all() else None
