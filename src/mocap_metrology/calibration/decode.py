"""What the steps of a calibration are given: a recording, settings, what to compare with."""

from __future__ import annotations

import json
import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypedDict

import numpy as np

from mocap_metrology.common.errors import Refusal, UnknownUnit
from mocap_metrology.common.files import read_table, sha256
from mocap_metrology.io.read import read_recording
from mocap_metrology.io.units import Unit
from mocap_metrology.lighthouse.assess import reference
from mocap_metrology.lighthouse.assess.reference import Reference
from mocap_metrology.lighthouse.batch.problem import Priors
from mocap_metrology.lighthouse.calibrate.batch import Sensors
from mocap_metrology.lighthouse.calibrate.jansen import CalibrationSettings
from mocap_metrology.lighthouse.decode.chain import Cleaning, Decoded, decode
from mocap_metrology.lighthouse.export.world import read_points
from mocap_metrology.lighthouse.known_length import KnownLength, known_length
from mocap_metrology.lighthouse.records import Station, inertial_of
from mocap_metrology.settings import Lighthouse

log = logging.getLogger(__name__)


class Check(TypedDict):
    """Contents of check.json."""

    ok: bool
    why: str
    warnings: list[str]
    notes: list[str]


@dataclass(frozen=True)
class Entry:
    """Entries of a calibration, as in a row of the sheet; board: the name of the tracked
    object of a libsurvive recording; sha256: of the recording, where it is known."""

    calibration: str = ""
    path: str | None = None
    format: str = "gpio-dump"
    board: str | None = None
    twin: str | None = None
    sha256: str | None = None
    reference_labels_master: Sequence[str] = ()
    reference_labels_slave: Sequence[str] = ()
    reference_unit: Unit | None = None
    tracked_with: str | None = None
    known_length: str | None = None


def decoded(entry: Entry, files: Mapping[str, str], settings: Lighthouse) -> Decoded:
    """A recording, decoded; `files` are named dump, board and factory."""
    return decode(
        files["dump"],
        entry.format,
        str(entry.board) if entry.format == "libsurvive-rec" else files["board"],
        files.get("factory"),
        sample_rate_hz=settings.sample_rate_hz,
        active_level=settings.active_level,
        cleaning=Cleaning(
            gate_rad=1e-3 * settings.gate_mrad,
            gate_mad=settings.gate_mad,
            half_window=settings.still_half_window,
            n_sigma=settings.still_n_sigma,
        ),
    )


def calibration_settings(settings: Lighthouse) -> CalibrationSettings:
    """`CalibrationSettings` of the section lighthouse."""
    lasers = settings.lasers_mm
    return CalibrationSettings(
        estimators=settings.estimators,
        optics=settings.optics,
        simplex_optics=settings.simplex_optics,
        reconstruction=settings.reconstruction,
        lm_interpolation=settings.lm_interpolation,
        lm_weights=settings.lm_weights,
        start_distance_m=settings.start_distance_m,
        lasers_m=None if lasers is None else 1e-3 * np.reshape(lasers, (2, 2, 3)),
        variant=settings.variant,
        pnp_method=settings.pnp_method,
        priors=priors_of(settings),
    )


def sensors_of(
    settings: Lighthouse,
    stations: Sequence[Station],
    inertial: str | None,
    lengths: tuple[KnownLength, ...] = (),
) -> Sensors:
    """What a calibration uses besides hits, by the settings; inertial: path of inertial.parquet."""
    series = ups = None
    if settings.inertial and inertial is not None:
        series = inertial_of(read_table(inertial)[0])
    if settings.gravity:
        unknown = np.full(3, np.nan)
        ups = np.array([unknown if one.gravity is None else one.gravity for one in stations])
    return Sensors(series, ups, lengths)


def lengths_of(entry: Entry, points: str | None, n_diodes: int) -> tuple[KnownLength, ...]:
    """The length that a row states; points: file of those in the room, if it names one. Raises
    `Refusal` for one that cannot be used."""
    if not entry.known_length:
        return ()
    places = None if points is None else read_points(points)
    return (known_length(entry.known_length, n_diodes, places),)


def priors_of(settings: Lighthouse) -> Priors:
    """`Priors` of the section lighthouse."""
    return Priors(
        time_zero_us=settings.time_zero_sd_us,
        phase_mrad=settings.phase_sd_mrad,
        laser_depth_mm=settings.laser_depth_sd_mm,
        board_scale=settings.board_scale_sd,
        board_position_mm=settings.board_position_sd_mm,
    )


def checked(entry: Entry, files: Mapping[str, str], settings: Lighthouse) -> tuple[Check, Decoded]:
    """Contents of check.json, and the decoded recording; raises `Refusal` for one that cannot be
    used, and for such points in the room, where `files` has these."""
    if entry.sha256 and (found := sha256(str(entry.path))) != entry.sha256:
        name = Path(str(entry.path)).name
        raise Refusal(f"{name}: SHA-256 is {found}; expected {entry.sha256}")
    if "points" in files:
        read_points(files["points"])
    recording = decoded(entry, files, settings)
    if "points" in files or not str(entry.known_length).startswith("points"):
        lengths_of(entry, files.get("points"), len(recording.board))
    warnings = [
        f"{station.role}: no factory values ({station.why}); expected errors of centimetres"
        for station in recording.stations
        if station.factory is None
    ]
    return {"ok": True, "why": "", "warnings": warnings, "notes": recording.notes}, recording


def reference_of(entry: Entry, path: str | None, mount: str | None) -> Reference | None:
    """The reference of a row: a pose file, or markers on both housings in a C3D file."""
    if path is None:
        return None
    if not path.lower().endswith(".c3d"):
        return reference.pose_reference(path)
    master, slave = entry.reference_labels_master, entry.reference_labels_slave
    known = reference.read_mount(str(mount))
    if not master and not slave:  # a twin's: M1 ... on the master, S1 ... on the slave
        master, slave = ([label for label in known if label.startswith(one)] for one in "MS")
    try:
        found = read_recording([path], [*master, *slave], unit=entry.reference_unit)
    except UnknownUnit as refusal:
        raise Refusal(f"{refusal} (column reference_unit of the sheet)") from None
    if found.unit_source == "assumed":
        log.warning("%s names no unit, so its coordinates are assumed to be in mm", Path(path).name)
    said = f"markers in {Path(path).name}"
    return reference.reference_from_markers(
        found.position_mm, found.labels, master, slave, known, said
    )


def truths_of(path: str | None) -> dict[str, Reference] | None:
    """What a twin was made with: between its housings, and between the origins of its optics."""
    if path is None:
        return None
    lasers = json.loads(Path(path).read_text(encoding="utf-8"))["lasers_m"]
    housing = reference.pose_reference(path)
    return {"housing": housing, "optical": reference.optical(housing, np.array(lasers))}
