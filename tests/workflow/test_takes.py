"""Which recordings of a sheet are subsets of one take."""

from __future__ import annotations

from mocap_workflow.recordings import RecordingRow
from mocap_workflow.selection import takes


def row(name: str, ids: str, kind: str = "T40", date: str | None = None) -> RecordingRow:
    return RecordingRow.model_construct(
        recording=name,
        camera_ids=tuple(map(int, ids)),
        camera_type=kind,
        date=date,
        markers=("a", "b"),
    )


def test_takes_are_nested_subsets_of_one_type_and_day() -> None:
    rows = [row("few", "12"), row("many", "123"), row("other", "45"), row("alien", "1234", "V5")]
    rows += [row("later", "1", date="2020-01-01"), row("later3", "123", date="2020-01-01")]
    rows += [row("alone", "12", date="2021-01-01"), row("unknown", "")]
    assert takes(rows) == [["few", "many"], ["later", "later3"]]
    assert takes(rows[2:5]) == []
