"""Which recordings of a group are made of subsets of the same cameras."""

from __future__ import annotations

from collections.abc import Sequence

from mocap_workflow.recordings import RecordingRow

Rows = Sequence[RecordingRow]


def takes(rows: Rows) -> list[list[str]]:
    """Recordings of one camera type, date and set of markers, where one has all cameras of another
    and more; those without such a partner are left out."""
    found: dict[tuple[str, str | None, tuple[str, ...]], list[RecordingRow]] = {}
    for row in rows:
        found.setdefault((row.camera_type, row.date, row.markers), []).append(row)
    nested = [[row.recording for row in take if _has_partner(row, take)] for take in found.values()]
    return [names for names in nested if names]


def _has_partner(row: RecordingRow, take: Rows) -> bool:
    own = frozenset(row.camera_ids)
    others = [frozenset(other.camera_ids) for other in take]
    return any(other and own and (own < other or other < own) for other in others)
