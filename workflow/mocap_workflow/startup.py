"""What workflow/rules/common.smk does once: configuration and sheets, or every fault in them."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from mocap_metrology.accuracy.monitor_row import Row
from mocap_metrology.common.documents import load_json, load_yaml
from mocap_metrology.common.entries import TwinsFile
from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.faults import Faults
from mocap_metrology.common.paths import exists
from mocap_metrology.common.sheets import read as read_sheet
from mocap_metrology.io.labels import AUTO, pair_of
from mocap_metrology.io.read import missing_marker
from mocap_metrology.noise.twins.take import TakeTwin
from mocap_metrology.recording import monitor_sheet
from mocap_metrology.settings import Settings, checked
from mocap_workflow import remote, rows
from mocap_workflow.calibration_twins import CalibrationTwin, calibration_twin
from mocap_workflow.calibrations import CalibrationRow
from mocap_workflow.recording_twins import AnyTwin, recording_twin
from mocap_workflow.recordings import RecordingRow

OF_THE_SHELL = re.compile(r"[\s&;|<>()$`\"'\\]")


def located(value: str | None, root: Path) -> str | None:
    """A relative path of the configuration: in the working folder, else in the project's."""
    if value is None or exists(value) or not exists(root / value):
        return value
    return str(root / value)


def check_python(path: str) -> None:
    """Refuse a Python whose path Snakemake (9.27), which does not quote it, cannot start."""
    if sign := OF_THE_SHELL.search(path):
        expected = "a folder of the project without blanks and other signs of the shell"
        raise Faults([f"{path}: {sign[0]!r} in the path of Python; expected {expected}"])


def check_files(paths: Iterable[str | Path]) -> None:
    """Refuse files of the configuration that Snakemake would read with the last of two equal keys,
    or not to the end."""
    faults = []
    for path in paths:
        try:
            text = Path(path).read_text(encoding="utf-8")
            (load_json if text.lstrip().startswith("{") else load_yaml)(text)
        except OSError as error:
            faults.append(f"{path}: {error.strerror}; expected a configuration")
        except ValueError as error:
            faults.append(f"{path}: no readable YAML or JSON: {error}")
    if faults:
        raise Faults(faults)


def configuration(config: Mapping[str, object], root: Path) -> Settings:
    """The checked configuration; paths of its sheets as seen from the working folder."""
    settings = checked(config)
    sheets = ("recordings", "calibrations", "twins")
    beside = {key: located(getattr(settings, key), root) for key in sheets}
    if "pnp" in settings.lighthouse.estimators:
        from mocap_metrology.lighthouse.calibrate.pnp import opencv_is_missing

        if why := opencv_is_missing():
            raise Faults([f"config, key lighthouse.estimators: {why}"])
    return settings.model_copy(update=beside)


def sheets(
    config: Mapping[str, Any], twins: Collection[str]
) -> tuple[dict[str, RecordingRow], dict[str, CalibrationRow]]:
    """Recordings and calibrations by name; the faults of both sheets come together."""
    kinds = {"recordings": RecordingRow, "calibrations": CalibrationRow}
    by_sheet, faults = _all(lambda name: rows.load(kinds[name], config[name], twins), kinds)
    recordings = by_sheet.get("recordings", {})
    calibrations = by_sheet.get("calibrations", {})
    faults += _between_rows(calibrations)
    faults += _spelled_otherwise([*recordings.values(), *calibrations.values()])
    if faults:
        raise Faults(faults)
    return recordings, calibrations


def monitors(sheet: str | None) -> dict[str, list[Row]]:
    """Takes by monitored facility, in order of the rows of a sheet of recordings."""
    if sheet is None:
        return {}
    lines = read_sheet(sheet, list(RecordingRow.columns()), ["recording"])
    return monitor_sheet.monitors(sheet, lines)


def _all(read: Callable[[str], Any], names: Iterable[str]) -> tuple[dict[str, Any], list[str]]:
    """What is read of each of some names, and all faults."""
    values: dict[str, Any] = {}
    faults: list[str] = []
    for name in names:
        try:
            values[name] = read(name)
        except Faults as found:
            faults += found.lines
    return values, faults


def _once(faults: Iterable[str]) -> list[str]:
    """One line for what several twins inherit."""
    twins: dict[str, list[str]] = {}  # by what is wrong with them
    for line in faults:
        twin, _, what = line.partition(": ")
        twins.setdefault(what, []).append(twin)
    more = {what: f" and {len(of) - 1} more" * (len(of) > 1) for what, of in twins.items()}
    return [f"{of[0]}{more[what]}: {what}" for what, of in twins.items()]


def _wrong(kind: str, name: str, column: str, value: object, expected: str) -> str:
    return f'{kind}s, {kind} "{name}", column {column}: "{value}"; expected {expected}'


def _between_rows(rows: Mapping[str, CalibrationRow]) -> list[str]:
    """Rows that are tracked with a row that is tracked with another, and so might wait for each
    other; rows with a bar whose other end is before other stations."""
    faults = []
    for name, row in rows.items():
        if (other := row.tracked_with_row) and rows[other].tracked_with:
            expected = "a calibration whose own tracked_with is empty"
            faults.append(_wrong("calibration", name, "tracked_with", other, expected))
        if (other := row.bar_row) and rows[other].setup != row.setup:
            expected = f"a calibration of setup {row.setup}"
            faults.append(_wrong("calibration", name, "bar", row.bar, expected))
    return faults


def _spelled_otherwise(rows: Iterable[RecordingRow | CalibrationRow]) -> list[str]:
    """Rows whose group or setup differs from that of an earlier row in upper and lower case alone:
    to some file systems, their results would be the same files."""
    first: dict[tuple[str, str], tuple[str, RecordingRow | CalibrationRow]] = {}
    faults = []
    for row in rows:
        for column in ("group", "setup", "monitor"):
            value = getattr(row, column, None) or ""
            known, other = first.setdefault((column, value.casefold()), (value, row))
            if value != known:
                expected = f'"{known}" as of {other.KIND} "{other.name}", or another name'
                faults.append(_wrong(row.KIND, row.name, column, value, expected))
    return faults


def missing_markers(rows: Iterable[RecordingRow]) -> None:
    """Refuse rows that name a marker, or an end of a bar, which their file, where it can be read
    here, does not have."""
    told = 'recordings, recording "{}", column {}: {}'
    faults = []
    for row in rows:
        if row.twin or any(map(remote.in_s3, row.paths)):
            continue
        bar = None if row.bar == AUTO else row.bar
        for column, markers, pair in (("markers", row.markers, None), ("bar", (), bar)):
            if (markers or pair) and (
                why := missing_marker(row.paths, markers, row.column_names, pair)
            ):
                faults.append(told.format(row.name, column, why))
    if faults:
        raise Faults(faults)


def recording_twins(
    recordings: Mapping[str, RecordingRow],
    document: TwinsFile,
    duration_s: float,
    form: str = "sampled",
) -> dict[str, AnyTwin]:
    """Every twin that the sheet of recordings uses, defaults filled in and checked.

    The shorter `duration_s` holds, a twin's own or that of the configuration: a quick look at
    everything is quick. `form` is that of the twins that have none of their own.
    """
    common = {"duration_s": duration_s, "form": form}
    common |= document["defaults"].get("recording") or {}

    def read(name: str) -> AnyTwin:
        twin = recording_twin(document["twins"][name], name, common)
        return replace(twin, duration_s=min(twin.duration_s, duration_s))

    twins, faults = _all(read, _used(recordings))
    faults = _once(faults) or _unlike_twins(recordings, twins)
    if faults:
        raise Faults(faults)
    return twins


def _used(rows: Mapping[str, RecordingRow] | Mapping[str, CalibrationRow]) -> list[str]:
    return list(dict.fromkeys(row.twin for row in rows.values() if row.twin))


def _unlike_twins(rows: Mapping[str, RecordingRow], twins: Mapping[str, AnyTwin]) -> list[str]:
    """Rows that name other cameras than those their twin, a subset of a take, is made of; then rows
    without a date whose twin is of a facility over dates; then bars that their twin is not."""
    cameras, dates, bars = [], [], []
    for name, row in rows.items():
        twin = twins.get(row.twin or "")
        cameras_of_row = set(row.camera_ids)
        if isinstance(twin, TakeTwin) and cameras_of_row not in (set(), set(twin.camera_ids)):
            shown, allowed = (";".join(map(str, ids)) for ids in (row.camera_ids, twin.camera_ids))
            expected = f"those of its twin {row.twin}, {allowed}"
            cameras.append(_wrong("recording", name, "camera_ids", shown, expected))
        if not row.date and getattr(twin, "days", None):
            expected = f"a date, as twin {row.twin} has days"
            dates.append(_wrong("recording", name, "date", "", expected))
        if twin and row.bar and row.bar != AUTO:
            try:
                pair_of(row.bar, twin.labels, f"twin {row.twin}")
            except Refusal as refusal:
                bars.append(f'recordings, recording "{name}", column bar: {refusal}')
    return cameras + dates + bars


def calibration_twins(
    rows: Mapping[str, CalibrationRow], document: TwinsFile
) -> dict[str, CalibrationTwin]:
    """Every twin that the sheet of calibrations uses, merged with its setup's and the defaults, and
    checked."""
    twins, faults = _all(lambda name: calibration_twin(document, name), _used(rows))
    if faults:
        raise Faults(_once(faults))
    return twins
