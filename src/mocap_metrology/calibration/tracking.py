"""track.parquet: the receiver along a recording, with its own calibration or an earlier one."""

from __future__ import annotations

import logging
from collections.abc import Sequence

import numpy as np

from mocap_metrology.calibration.decode import Entry
from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import Metadata, write_table
from mocap_metrology.lighthouse.assess.comparison import ids_of
from mocap_metrology.lighthouse.assess.pose_file import (
    PoseEntry,
    PoseFile,
    chosen_pose,
    kind_of,
    matrix_and_metres,
    read_pose_json,
)
from mocap_metrology.lighthouse.assess.reference import check_same_ids
from mocap_metrology.lighthouse.calibrate.batch import ESTIMATED, NAME, Scene, Sensors
from mocap_metrology.lighthouse.calibrate.jansen import Calibration, CalibrationSettings
from mocap_metrology.lighthouse.calibrate.variants import AUTO, COVARIANCE_UNITS, FALLBACK
from mocap_metrology.lighthouse.records import Factory, Hits
from mocap_metrology.lighthouse.track.receiver import Calibrated, Track, along, columns, track

log = logging.getLogger(__name__)


def write_track(
    path: str,
    entry: Entry,
    found: Calibration,
    own: PoseFile,
    earlier: str | None,
    recorded: tuple[Hits, np.ndarray, Sequence[Factory | None]],
    settings: CalibrationSettings,
    origin: Metadata,
    sensors: Sensors,
) -> None:
    """Track the board of a recording and write its poses; where that cannot be, no rows, and the
    reason in the metadata.

    own: pose.json of this recording, `found` its estimates; earlier: that of another, whose
    stations are used where the row names it; recorded: hits, board in m, factory values; sensors:
    data besides hits.
    """
    more: Metadata = {"still": found.still, "tracked_with": entry.tracked_with}
    tracked = None
    try:
        used = _used(entry, own, earlier)
        more["stations"] = used["stations"]
        tracked = _tracked(found, used, used is own, recorded, settings, sensors)
        more["note"] = tracked.note
        seen = tracked.hits.any(axis=1)
        log.info("receiver: %d of %d moments have a pose", seen.sum(), seen.size)
    except Refusal as refusal:
        more["reason"] = str(refusal)
        level = logging.WARNING if entry.tracked_with else logging.INFO
        log.log(level, "not tracked: %s", refusal)
    write_table(path, columns(tracked), origin | more)


def _used(entry: Entry, own: PoseFile, earlier: str | None) -> PoseFile:
    """pose.json to track with; refused if it is of other stations, or with swapped roles."""
    if entry.tracked_with is None:
        return own
    if earlier is None:
        raise Refusal(f"calibration {entry.tracked_with}, to track with, is refused itself")
    used = read_pose_json(earlier)
    check_same_ids(ids_of(used), ids_of(own), "the calibration to track with", "the recording")
    return used


def _tracked(
    found: Calibration,
    used: PoseFile,
    is_own: bool,
    recorded: tuple[Hits, np.ndarray, Sequence[Factory | None]],
    settings: CalibrationSettings,
    sensors: Sensors,
) -> Track:
    entry = chosen_pose(used)
    if entry is None:
        raise Refusal("no pose of the slave to track with")
    by_batch = is_own and entry["estimator"] == NAME
    known = _calibrated(entry, by_batch)
    if by_batch and entry["stage"] == "final":
        scene, joint = found.joints[entry["optics"]]
        return along(joint, scene, known, entry["note"])
    _, _, optics = kind_of(entry)
    hits, board, factories = recorded
    if optics == ESTIMATED and not is_own:
        raise Refusal("the rotors of these stations were estimated; expected factory values")
    if optics == "factory" and None in factories:
        raise Refusal("the recording has no factory values of both stations, as the pose has")
    housing = settings.lasers_m is not None
    if entry["frame"] != ("housing" if housing else "optical"):
        raise Refusal(
            f"the pose is of the {entry['frame']} frame; expected the frame that lasers_mm implies"
        )
    how = settings.lasers_m, _variant(used, settings), settings.priors
    return track(Scene(hits, board, optics, factories, *how, sensors=sensors), known)


def _calibrated(entry: PoseEntry, is_own: bool) -> Calibrated:
    R, t = matrix_and_metres(entry)
    given = entry["covariance"]
    covariance = np.full((6, 6), np.nan) if given is None else np.array(given)
    return Calibrated(R, t, covariance / np.outer(COVARIANCE_UNITS, COVARIANCE_UNITS), is_own)


def _variant(used: PoseFile, settings: CalibrationSettings) -> str:
    """How factory values enter: as they did in the calibration."""
    chosen = (str(way["variant"]) for way in used.get("variants", []) if way["chosen"])
    fixed = FALLBACK if settings.variant == AUTO else settings.variant
    return next(chosen, fixed)
