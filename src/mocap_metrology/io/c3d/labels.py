"""Labels of points: completing them, and finding the ones that were asked for."""

from __future__ import annotations

import re
from collections.abc import Sequence

from mocap_metrology.common.errors import Refusal


def complete_labels(labels: Sequence[str], n_points: int) -> tuple[str, ...]:
    """One label a point; a point without one is called `point_12`, counted from 1."""
    given = [*labels[:n_points], *[""] * (n_points - len(labels))]
    return tuple(label or f"point_{i}" for i, label in enumerate(given, start=1))


def in_words(labels: Sequence[str], most: int = 20) -> str:
    """Labels for a message, a long list cut short."""
    text = ", ".join(labels[:most])
    return text if len(labels) <= most else f"{text}, … and {len(labels) - most} more"


def find_points(labels: Sequence[str], markers: Sequence[str], file: str) -> list[int]:
    """Places (from 0) of the chosen `markers` among `labels`.

    A marker is a label, or its part after the subject's prefix (`C7` for `Matt:C7`) where that is
    one point only, or `LABEL#2` for the second point of that label.
    """
    if not markers:
        raise Refusal(f"{file}: no marker is chosen; there are: {in_words(labels)}")
    found = [_find(labels, marker.strip(), file) for marker in markers]
    for i, place in enumerate(found):
        if place in found[:i]:
            raise Refusal(f"{file}: marker {markers[i].strip()!r} is chosen twice")
    return found


def _find(labels: Sequence[str], marker: str, file: str) -> int:
    same = [i for i, label in enumerate(labels) if label == marker]
    if len(same) == 1:
        return same[0]
    if same:
        raise Refusal(
            f"{file}: {len(same)} points are labelled {marker!r}: choose one of them as"
            f" {', '.join(f'{marker}#{k}' for k in range(1, len(same) + 1))}"
        )
    if numbered := re.fullmatch(r"(.+)#([0-9]+)", marker):
        same = [i for i, label in enumerate(labels) if label == numbered[1]]
        if same and 1 <= int(numbered[2]) <= len(same):
            return same[int(numbered[2]) - 1]
        if same:
            raise Refusal(f"{file}: no {marker!r}: points labelled {numbered[1]!r}: {len(same)}")
    suffix = [i for i, label in enumerate(labels) if ":" in label and _bare(label) == marker]
    if len(suffix) == 1:
        return suffix[0]
    if suffix:
        several = in_words([labels[i] for i in suffix])
        raise Refusal(f"{file}: marker {marker!r} is one of several: choose from {several}")
    raise Refusal(f"{file}: no marker {marker!r}; there are: {in_words(labels)}")


def _bare(label: str) -> str:
    return label.split(":", 1)[1].strip()
