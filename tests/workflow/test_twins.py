"""Twins of the file of twins: what a change of one is seen by, and subsets of one take."""

from typing import Any

import pytest
from mocap_workflow.recordings import RecordingRow
from mocap_workflow.selection import on_its_date
from mocap_workflow.startup import missing_markers
from mocap_workflow.startup import recording_twins as used_twins
from running import faults_of

from mocap_metrology.common.faults import Faults

TAKE = {"camera_type": "T40", "cameras": 4, "layout_seed": 1, "centroid_px": 0.1}


def twins(**changes: Any) -> dict[str, Any]:
    entry = {"take": TAKE, "camera_ids": [4, 1], "seed": 1, "duration_s": 600} | changes
    defaults = {"recording": {"distance_line": "split", "yz_coherence": 0.0, "labels": ["a", "b"]}}
    return {"twins": {"hall": entry}, "defaults": defaults}


def rows(camera_ids: list[int]) -> dict[str, RecordingRow]:
    return {"r": RecordingRow.model_construct(twin="hall", camera_ids=tuple(camera_ids))}


def test_a_take_has_defaults_of_its_kind_and_the_shorter_duration() -> None:
    for duration, expected in ((9000.0, 600.0), (60.0, 60.0)):
        made = used_twins(rows([1, 4]), twins(), duration)["hall"]
        assert made.duration_s == expected and made.labels == ("a", "b")
    assert used_twins(rows([]), twins(), 60.0)


def test_a_twin_has_the_form_of_its_own_or_of_the_configuration() -> None:
    common: dict[str, Any] = {"coefficients": {"all": {}}, "seed": 1}
    for own, form in ((common, "continuous"), (common | {"form": "sampled"}, "sampled")):
        made = used_twins(rows([]), {"twins": {"hall": own}, "defaults": {}}, 60.0, "continuous")
        assert made["hall"].form == form
    wrong = {"twins": {"hall": common, "room": common}, "defaults": {"recording": {"form": "both"}}}
    both = {n: RecordingRow.model_construct(twin=n, camera_ids=()) for n in wrong["twins"]}
    for used, who in ((rows([]), "twin hall"), (both, "twin hall and 1 more")):
        assert faults_of(used_twins, used, wrong, 60.0) == [
            f"{who}: form: 'both', expected sampled or continuous"
        ]


def test_a_facility_over_dates_needs_dates() -> None:
    """The twin of a row is that of its date."""
    entry = {"coefficients": {"all": {"h_0": 1e-6}}, "seed": 1, "days": {}}
    document = {"twins": {"f": entry}, "defaults": {}}
    row = RecordingRow.model_construct(twin="f", camera_ids=(), date="2026-03-02T08:15")
    made = used_twins({"r": row}, document, 60.0)["f"]
    assert on_its_date(made, row).date == "2026-03-02T08:15"
    with pytest.raises(Faults, match='column date: ""; expected a date, as twin f has days'):
        used_twins({"r": row.model_copy(update={"date": None})}, document, 60.0)


def test_a_bar_without_markers_is_for_its_step_to_read() -> None:
    row = RecordingRow.model_construct(twin=None, bar="auto", markers=(), paths=("none.c3d",))
    missing_markers([row])


def test_a_bar_that_its_twin_is_not_is_a_line() -> None:
    document = {"twins": {"b": {"bar": {"length": 500}, "seed": 1}}, "defaults": {}}
    row = RecordingRow.model_construct(twin="b", camera_ids=(), date=None, bar="A-B")
    assert faults_of(used_twins, {"r": row}, document, 60.0) == [
        'recordings, recording "r", column bar: twin b: bar is "A-B"; expected auto, or two markers'
        ' of the file joined by "-": Wand1, Wand2'
    ]
    used_twins({"r": row.model_copy(update={"bar": "Wand2-Wand1"})}, document, 60.0)


def test_other_cameras_than_the_sheet_says_are_a_line() -> None:
    assert faults_of(used_twins, rows([1, 3]), twins(), 60.0) == [
        'recordings, recording "r", column camera_ids: "1;3"; expected those of its twin hall, 4;1'
    ]
    assert faults_of(used_twins, rows([1, 3]), twins(camera_ids=[1, 9]), 60.0) == [
        "twin hall: camera_ids: [1, 9], expected two or more different whole numbers from 1 to 4"
    ]
