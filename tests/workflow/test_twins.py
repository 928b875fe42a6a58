"""Twins as models of the workflow, and the dataclasses that they make."""

from __future__ import annotations

from dataclasses import MISSING, fields

import pytest
from mocap_workflow import calibration_twins, recording_twins

from mocap_metrology.common.entries import Entry
from mocap_metrology.noise.twins import take, twin

PAIRS: list[tuple[type[Entry], type]] = [
    (recording_twins.RecordingTwin, twin.Twin),
    (recording_twins.Outliers, twin.Outliers),
    (recording_twins.Crump, twin.Crump),
    (recording_twins.TakeOfCameras, take.Take),
    (recording_twins.SubsetTwin, take.TakeTwin),
]


@pytest.mark.parametrize(("model", "made"), PAIRS)
def test_defaults_are_those_of_the_package(model: type[Entry], made: type) -> None:
    own = {name: f for name, f in model.model_fields.items() if not f.is_required()}
    compared = 0
    for field in fields(made):
        if field.name not in own or field.default is MISSING or field.name == "start_mm":
            continue
        value = own[field.name].get_default(call_default_factory=True)
        expected = field.default
        if isinstance(value, Entry):
            value, expected = value.model_dump(), vars(expected)
        assert value == expected, field.name
        compared += 1
    assert compared


RECORDING = {"published": {"camera_type": "T40", "n_cameras": 10}, "seed": 1}
TAKE = {"camera_type": "T40", "cameras": 4, "layout_seed": 1, "centroid_px": 0.1}
SUBSET = {"take": TAKE, "camera_ids": [4, 1], "seed": 1}
STATION = {"id": 1, "mode": "A"}
CALIBRATION = {"seed": 1, "master": STATION, "motion": {"centre_m": [3, 1, 0]}}


@pytest.mark.parametrize(
    ("entry", "change"),
    [
        (RECORDING, {"seed": 2}),
        (RECORDING, {"without": ["q_c1"]}),
        (RECORDING, {"scale": 2}),
        (RECORDING, {"gaps": {"per_hour": 1, "mean_s": 1}}),
        (SUBSET, {"camera_ids": [4, 2]}),
        (SUBSET, {"take": TAKE | {"centroid_px": 0.2}}),
        (CALIBRATION, {"dropout": 0.1}),
        (CALIBRATION, {"master": STATION | {"factory": {"phase": [0.05, 0.0241]}}}),
        (CALIBRATION, {"master": STATION | {"factory": {"phase": [0.05, 0.02411]}}}),
    ],
)
def test_a_change_of_a_twin_is_seen_in_params(entry: dict, change: dict) -> None:
    """Snakemake compares the text of a dict; of an object of another class it compares nothing."""
    calibration = "motion" in entry
    read = calibration_twins.twin_from_mapping if calibration else recording_twins.recording_twin
    texts = set()
    for values in (entry, entry | change):
        found = read(values, "T")
        texts.add(repr({"T": found if calibration else found.made("T")}))
    assert len(texts) == 2
