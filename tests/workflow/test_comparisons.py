"""Which recordings are held against which."""

from __future__ import annotations

from typing import Any

from mocap_workflow import selection
from mocap_workflow.recordings import RecordingRow


def row(
    name: str, date: str | None = None, reference: str | None = None, **other: Any
) -> RecordingRow:
    same = {"camera_type": "T40", "n_cameras": 2, "camera_ids": (1, 2), "markers": ("A", "B")}
    own = {"recording": name, "date": date, "compare_with": reference}
    return RecordingRow.model_construct(**same | own | other)


def test_the_one_before_by_date_of_the_same_cameras() -> None:
    rows = [
        row("march", "2026-03-01"),
        row("january", "2026-01-01"),
        row("february", "2026-02-01T08:00:00"),
        row("others", "2026-02-15", camera_ids=(1, 3)),
        row("undated"),
    ]
    names = [r.recording for r in rows]
    assert selection.pairs(rows, names) == [("march", "february"), ("february", "january")]
    assert selection.series_over_dates(rows) == [["january", "february", "march"]]
    assert selection.series_over_dates(rows[1:]) == []


def test_a_named_reference_of_any_group_if_it_was_accepted() -> None:
    rows = [row("after", "2026-03-01", "before"), row("today", None, "refused")]
    assert selection.pairs(rows, ["after", "today", "before"]) == [("after", "before")]


def test_subsets_of_one_take_are_not_compared() -> None:
    rows = [row("two", "2026-03-01"), row("again", "2026-03-01")]
    assert selection.pairs(rows, ["two", "again"]) == []
