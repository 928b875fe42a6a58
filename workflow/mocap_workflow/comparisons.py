"""Which recordings of a group are held against which, by what the sheet says of them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from operator import attrgetter

from mocap_workflow.recordings import RecordingRow

Rows = Sequence[RecordingRow]


def pairs(rows: Rows, accepted: Iterable[str]) -> list[tuple[str, str]]:
    """(recording, reference): the one named by `compare_with`, else the one before by date, of the
    same cameras and markers. Recordings of one moment are subsets of one take, and not compared."""
    known, found = set(accepted), []
    for row in rows:
        reference = row.compare_with
        if reference is None and row.date:
            earlier = [r for r in _dated_alike(rows, row) if _date(r) < row.date]
            reference = max(earlier, key=_date).recording if earlier else None
        if reference in known:
            found.append((row.recording, reference))
    return found


def series_over_dates(rows: Rows) -> list[list[str]]:
    """Recordings of the same cameras and markers on three days or more, in order of date."""
    found: list[list[str]] = []
    for row in rows:
        own = sorted(_dated_alike(rows, row), key=_date)
        names = [r.recording for r in own]
        if row.date and len({_date(r)[:10] for r in own}) >= 3 and names not in found:
            found.append(names)
    return found


def _date(row: RecordingRow) -> str:
    return row.date or ""


def _dated_alike(rows: Rows, row: RecordingRow) -> list[RecordingRow]:
    """Dated rows of the same cameras and markers, the row itself included."""
    same = attrgetter("camera_type", "n_cameras", "camera_ids", "markers")
    return [r for r in rows if r.date and same(r) == same(row)]
