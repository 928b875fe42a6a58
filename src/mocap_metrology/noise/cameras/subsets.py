"""Which recordings of a group differ by added cameras."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Addition:
    """The cameras `added` make recording `larger` out of `smaller`."""

    smaller: str
    larger: str
    added: tuple[int | str, ...]


def additions(camera_ids: Mapping[str, Sequence[int | str]]) -> list[Addition]:
    """Every pair of recordings of which one has all cameras of the other and more, with none in
    between; camera_ids: ids by recording."""
    sets = {name: frozenset(ids) for name, ids in camera_ids.items()}
    found = []
    for smaller, few in sets.items():
        for larger, many in sets.items():
            if few and few < many and not any(few < s < many for s in sets.values()):
                added = tuple(i for i in camera_ids[larger] if i not in few)
                found.append(Addition(smaller, larger, added))
    found.sort(key=lambda a: (len(sets[a.smaller]), len(sets[a.larger])))
    return found
