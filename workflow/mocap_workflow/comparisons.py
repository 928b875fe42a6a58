"""Which recordings of a group are held against which, by what the sheet says of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

Rows = Sequence[Mapping[str, Any]]


def pairs(rows: Rows, accepted: Iterable[str]) -> list[tuple[str, str]]:
    """(recording, reference): the one named by `compare_with`, else the one before by date, of the
    same cameras and markers. Recordings of one moment are subsets of one take, and not compared."""
    known, found = set(accepted), []
    for row in rows:
        reference = row["compare_with"]
        if reference is None and row["date"]:
            earlier = [r for r in _alike(rows, row) if r["date"] < row["date"]]
            reference = max(earlier, key=lambda r: r["date"])["recording"] if earlier else None
        if reference in known:
            found.append((row["recording"], reference))
    return found


def series_over_dates(rows: Rows) -> list[list[str]]:
    """Recordings of the same cameras and markers on three days or more, in order of date."""
    found: list[list[str]] = []
    for row in rows:
        own = sorted(_alike(rows, row), key=lambda r: r["date"])
        names = [r["recording"] for r in own]
        if row["date"] and len({r["date"][:10] for r in own}) >= 3 and names not in found:
            found.append(names)
    return found


def _alike(rows: Rows, row: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Dated rows of the same cameras and markers, the row itself included."""
    same = ("camera_type", "n_cameras", "camera_ids", "markers")
    return [r for r in rows if r["date"] and all(r[key] == row[key] for key in same)]
