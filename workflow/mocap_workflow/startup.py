"""What workflow/rules/common.smk does once: configuration and sheets, or every fault in them."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import Any

from mocap_workflow import files, rows
from mocap_workflow.calibrations import CalibrationRow
from mocap_workflow.faults import Faults
from mocap_workflow.recordings import RecordingRow
from mocap_workflow.settings import Settings, checked

Rows = dict[str, dict[str, Any]]


def configuration(config: Mapping[str, object], root: Path) -> Settings:
    """The checked configuration; paths of its sheets as seen from the working folder."""
    settings = checked(config)
    sheets = ("recordings", "calibrations", "twins")
    found = {key: files.found(getattr(settings, key), root) for key in sheets}
    if "pnp" in settings.lighthouse.estimators:
        from mocap_metrology.lighthouse.calibrate.pnp import opencv_is_missing

        if why := opencv_is_missing():
            raise Faults([f"config, key lighthouse.estimators: {why}"])
    return settings.model_copy(update=found)


def sheets(
    config: Mapping[str, Any], twins: Collection[str]
) -> tuple[dict[str, RecordingRow], dict[str, CalibrationRow]]:
    """Recordings and calibrations by name; the faults of both sheets come together."""
    faults: list[str] = []
    recordings: dict[str, RecordingRow] = {}
    calibrations: dict[str, CalibrationRow] = {}
    try:
        recordings = rows.load(RecordingRow, config["recordings"], twins)
    except Faults as found:
        faults += found.lines
    try:
        calibrations = rows.load(CalibrationRow, config["calibrations"], twins)
    except Faults as found:
        faults += found.lines
    if faults:
        raise Faults(faults)
    return recordings, calibrations


def recording_twins(
    recordings: Mapping[str, RecordingRow],
    twins: Mapping[str, Any],
    duration_s: float,
    form: str = "sampled",
) -> dict[str, dict[str, Any]]:
    """Settings of every twin that the sheet of recordings uses, defaults filled in and checked.

    The shorter `duration_s` holds, a twin's own or that of the configuration: a quick look at
    everything is quick. `form` is that of the twins that have none of their own.
    """
    from mocap_metrology.common.errors import Refusal
    from mocap_metrology.noise.twins import take_twin
    from mocap_metrology.noise.twins.twin import twin_from_mapping

    common = {"duration_s": duration_s, "form": form} | (twins["defaults"].get("recording") or {})
    settings, faults = {}, []
    for name in dict.fromkeys(row.twin for row in recordings.values() if row.twin):
        entry = twins["twins"][name]
        of_take = take_twin.is_take(entry)
        values = take_twin.with_defaults(entry, common) if of_take else common | entry
        try:
            read = take_twin.take_twin_from_mapping if of_take else twin_from_mapping
            values["duration_s"] = min(read(values, name).duration_s, duration_s)
        except Refusal as refusal:
            faults.append(str(refusal))
        settings[name] = values
    faults = faults or _other_cameras(recordings, settings)
    if faults:
        raise Faults(faults)
    return settings


def _other_cameras(rows: Mapping[str, RecordingRow], settings: Rows) -> list[str]:
    """Rows that name other cameras than those their twin, a subset of a take, is made of."""
    faults = []
    for name, row in rows.items():
        made_of = settings.get(row.twin or "", {}).get("camera_ids")
        if made_of and row.camera_ids and set(row.camera_ids) != set(made_of):
            shown, own = (";".join(map(str, ids)) for ids in (row.camera_ids, made_of))
            faults.append(
                f'recordings, recording "{name}", column camera_ids: "{shown}"; '
                f"expected those of its twin {row.twin}, {own}"
            )
    return faults


def calibration_twins(
    rows: Mapping[str, CalibrationRow], twins: Mapping[str, Any]
) -> dict[str, dict[str, Any]]:
    """Settings of every twin that the sheet of calibrations uses, merged with its setup's and the
    defaults, and checked."""
    from mocap_metrology.common.errors import Refusal
    from mocap_metrology.lighthouse.simulate.twin import twin_entry, twin_from_mapping

    document = dict(twins) | {"defaults": twins["defaults"].get("calibration") or {}}
    settings, faults = {}, []
    for name in dict.fromkeys(row.twin for row in rows.values() if row.twin):
        try:
            settings[name] = twin_entry(document, name)
            twin_from_mapping(settings[name], name)
        except Refusal as refusal:
            faults.append(str(refusal))
    if faults:
        raise Faults(faults)
    return settings


def any_of(names: Iterable[str]) -> str:
    """Regular expression of exactly these names; of nothing when there is none."""
    return "|".join(re.escape(name) for name in dict.fromkeys(names)) or "(?!)"
