"""What rules select from the rows of a sheet."""

from collections.abc import Callable
from typing import Any

import pytest
from mocap_workflow import selection
from mocap_workflow.calibrations import CalibrationRow
from mocap_workflow.recordings import RecordingRow
from mocap_workflow.selection import names

from mocap_metrology.lighthouse.simulate.twin import LighthouseTwin, MotionTwin


def recording(name: str, kind: str = "", count: int | None = None, **cells: Any) -> RecordingRow:
    given = {"recording": name, "camera_type": kind, "n_cameras": count, "group": "lab"}
    return RecordingRow.model_construct().model_copy(update={"twin": None} | given | cells)


def calibration(name: str, setup: str = "sim-1", **cells: Any) -> CalibrationRow:
    given = {"calibration": name, "setup": setup, "group": "lab", "twin": None}
    return CalibrationRow.model_construct().model_copy(update=given | cells)


def test_a_sheet_as_a_table_to_look_up_in() -> None:
    rows = {
        "a": recording("a"),
        "b": recording("b", twin="T", group="2"),
        "c": recording("c", bar="A-B"),
    }
    sheet = selection.Sheet(RecordingRow, rows)
    assert sheet.groups == ["lab", "2"]
    assert sheet.table.to_dict("list") == {
        "recording": ["a", "b", "c"],
        "group": ["lab", "2", "lab"],
        "source": ["measured", "twin", "measured"],
        "about": ["noise", "noise", "bar"],
    }
    assert sheet.pattern(source="measured", about="bar") == "c"
    nothing = selection.Sheet(RecordingRow, {})
    assert nothing.table.query("group == 'lab' and source == 'twin'").empty


PLACE = {"place": "door"}


def of(kind: str, count: int | None = None, **cells: Any) -> dict[str, Any]:
    return {"kind": kind, "count": count, **cells}


@pytest.mark.parametrize(
    ("select", "rows", "expected"),
    [(selection.having("place"), {"a": {"place": None}, "b": {"place": "door"}}, ["b"]),
     (selection.with_place, {"a": PLACE, "b": {"place": None}, "c": {"place": "wall"}}, ["a", "c"]),
     (selection.with_place, {"a": PLACE, "b": PLACE}, []),
     (selection.scaled, {"a": of("V", 2), "b": of("V", 3), "c": {}}, ["a", "b", "c"]),
     (selection.scaled, {"a": of("V", 2), "b": of("T", 3), "c": of("V")}, []),
     (selection.with_and_without_failing,
      {**{"few": of("Vantage", 9), "again": of("Vantage", 9)},
       **{"all": of("Vantage", 10), "other": of("T40", 10)}}, ["all", "few"]),
     (selection.with_and_without_failing, {"all": of("Vantage", 10)}, []),
     (selection.full_sets,
      {"twin": of("T40", 10, twin="T"), "real": of("T40", 10), "few": of("Bonita", 8)}, ["real"]),
     (selection.full_sets, {"few": of("T40", 8), "fewer": of("T40", 6)}, ["few"])],
)  # fmt: skip
def test_recordings(select: Callable, rows: dict[str, dict], expected: list[str]) -> None:
    assert names(select([recording(name, **cells) for name, cells in rows.items()])) == expected


def test_references_are_the_accepted_ones_each_once() -> None:
    rows = [recording(name, compare_with=other) for name, other in zip("abcd", "xyxx", strict=True)]
    rows += [recording("e", compare_with=None)]
    assert names(selection.references(rows, [recording("w"), recording("x")])) == ["x"]


def test_setups_of_two_recordings_or_more_are_joined_once() -> None:
    rows = [
        *(calibration("a", "hall"), calibration("b", "hall"), calibration("c", "room")),
        *(calibration("d", "room", twin="T"), calibration("e", "room", group="other")),
        calibration("f", "alone"),
    ]
    assert selection.setups(rows) == [("lab", "hall", "measured"), ("lab", "room", "twin")]


def test_the_example_is_the_half_circle_with_the_least_noise_or_the_first() -> None:
    twins = {
        name: LighthouseTwin.model_construct(
            motion=MotionTwin.model_construct(pattern=pattern), independent_urad=noise
        )
        for name, pattern, noise in (("line", "line", 0), ("noisy", "arc", 30), ("arc", "arc", 0))
    }
    rows = [calibration("real"), *(calibration(name, twin=name) for name in twins)]
    assert names(selection.half_circle(rows, twins)) == ["arc"]
    assert names(selection.half_circle(rows[:3], twins)) == ["noisy"]
    assert names(selection.half_circle(rows[:2], twins)) == ["real"]
    assert selection.half_circle([], twins) == []


def test_other_objects_of_one_recording() -> None:
    """Of libsurvive alone, whose recordings name them: two boards of a dump are two guesses."""
    same = {"path": "a.rec", "format": "libsurvive-rec", "twin": None}
    first, second = (calibration(name, **same, board=name) for name in ("HMD", "T20"))
    elsewhere = calibration("b", **same | {"path": "b.rec"}, board="T20")
    again = calibration("c", **same, board="HMD")
    twin = calibration("d", twin="a", path="a.rec", format="libsurvive-rec", board="T20")
    every = [first, second, elsewhere, again, twin]
    assert selection.beside(first, every) == [second]
    assert selection.beside(second, every) == [first, again]
    assert selection.beside(twin, every) == []
    dumps = [one.model_copy(update={"format": "gpio-dump"}) for one in (first, second)]
    assert selection.beside(dumps[0], dumps) == []


def dated(name: str, date: str | None = None, reference: str | None = None, **other: Any) -> Any:
    same = {"camera_ids": (1, 2), "markers": ("A", "B"), "date": date, "compare_with": reference}
    return recording(name, "T40", 2, **same | other)


def test_a_recording_is_compared_with_the_one_before_by_date_of_the_same_cameras() -> None:
    """Or with the one that is named, of any group; never with a subset of the same take, and a
    take of a monitor only with the one that is named."""
    rows = [
        dated("march", "2026-03-01"),
        dated("january", "2026-01-01"),
        dated("february", "2026-02-01T08:00:00"),
        dated("others", "2026-02-15", camera_ids=(1, 3)),
        dated("undated"),
    ]
    assert selection.pairs(rows, names(rows)) == [("march", "february"), ("february", "january")]
    assert selection.series_over_dates(rows) == [["january", "february", "march"]]
    assert selection.series_over_dates(rows[1:]) == []
    accepted = [name for name in names(rows) if name != "february"]
    assert selection.pairs(rows, accepted) == [("march", "january")]
    turned = dated("april", "2026-04-01", markers=("B", "A"), camera_ids=(2, 1))
    assert selection.pairs([*rows, turned], names([*rows, turned]))[-1] == ("april", "march")
    elsewhere = dated("door", "2026-04-01", place="door")
    assert len(selection.pairs([*rows, elsewhere], names([*rows, elsewhere]))) == 2
    rows = [dated("after", "2026-03-01", "before"), dated("today", None, "refused")]
    assert selection.pairs(rows, ["after", "today", "before"]) == [("after", "before")]
    rows = [dated("two", "2026-03-01"), dated("again", "2026-03-01")]
    assert selection.pairs(rows, ["two", "again"]) == []
    rows = [dated(f"take{k}", f"2026-03-0{k}", monitor="hall") for k in (1, 2, 3)]
    rows.append(dated("take4", "2026-03-04", "take1", monitor="hall"))
    assert selection.pairs(rows, names(rows)) == [("take4", "take1")]


def test_takes_are_nested_subsets_of_one_type_and_day() -> None:
    cells = [
        *(("few", (1, 2), "T40", None), ("many", (1, 2, 3), "T40", None)),
        *(("other", (4, 5), "T40", None), ("alien", (1, 2, 3, 4), "V5", None)),
        *(("later", (1,), "T40", "2020-01-01"), ("later3", (1, 2, 3), "T40", "2020-01-01")),
        *(("alone", (1, 2), "T40", "2021-01-01"), ("unknown", (), "T40", None)),
    ]
    rows = [
        dated(name, date, camera_ids=ids).model_copy(update={"camera_type": kind})
        for name, ids, kind, date in cells
    ]
    assert selection.takes(rows) == [["few", "many"], ["later", "later3"]]
    assert selection.takes(rows[2:5]) == []
