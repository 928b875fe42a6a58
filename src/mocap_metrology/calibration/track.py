"""The board of a recording, tracked with its own stations or with those of another calibration."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from mocap_metrology.calibration.sweeps import Entry, Recorded
from mocap_metrology.common import files
from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import Metadata
from mocap_metrology.lighthouse.assess import pose_file, reference
from mocap_metrology.lighthouse.assess.comparison import ids_of
from mocap_metrology.lighthouse.batch.problem import Priors
from mocap_metrology.lighthouse.calibrate.jansen import Calibration, CalibrationSettings
from mocap_metrology.lighthouse.calibrate.scene import ESTIMATED, NAME, Scene, Sensors
from mocap_metrology.lighthouse.calibrate.variants import AUTO, FALLBACK
from mocap_metrology.lighthouse.records import COVARIANCE_UNITS
from mocap_metrology.lighthouse.track import receiver
from mocap_metrology.settings import Lighthouse

log = logging.getLogger(__name__)


def calibration_settings(settings: Lighthouse) -> CalibrationSettings:
    """Settings of the estimators, lasers in m, from those of the configuration."""
    known = {k: v for k, v in settings if k in CalibrationSettings.__dataclass_fields__}
    if settings.lasers_mm is not None:
        known["lasers_m"] = 1e-3 * np.reshape(settings.lasers_mm, (2, 2, 3))
    priors = Priors(
        time_zero_us=settings.time_zero_sd_us,
        phase_mrad=settings.phase_sd_mrad,
        laser_depth_mm=settings.laser_depth_sd_mm,
        board_scale=settings.board_scale_sd,
        board_position_mm=settings.board_position_sd_mm,
    )
    return CalibrationSettings(**known, priors=priors)


def sensors_of(settings: Lighthouse, read: Recorded) -> Sensors:
    """What a calibration uses besides hits, by the settings."""
    ups = None
    if settings.gravity:
        unknown = np.full(3, np.nan)
        ups = np.array([unknown if one.gravity is None else one.gravity for one in read.stations])
    inertial = read.inertial if settings.inertial else None
    return Sensors(inertial, ups, read.lengths, read.normals, read.clocks)


def write_track(
    path: str,
    entry: Entry,
    calibration: Calibration,
    pose: pose_file.PoseFile,
    earlier: str | None,
    read: Recorded,
    settings: Lighthouse,
    origin: Metadata,
) -> None:
    """Track the board of a recording and write its poses; where that cannot be, no rows, and the
    reason in the metadata.

    pose: pose.json of this recording, `calibration` its estimates; earlier: that of another, whose
    stations are used where the row names it.
    """
    more: Metadata = {"still": calibration.still, "tracked_with": entry.tracked_with}
    tracked = None
    try:
        used = stations_used(entry, pose, earlier)
        more["stations"] = used["stations"]
        if pose_file.is_network(used):
            more["reference"] = used["reference"]
        placed = _placed(used)
        entry_used = next(iter(placed.values()))
        kind = entry_used["estimator"], entry_used["stage"]
        if used is pose and kind == (NAME, "final"):
            scene, joint = calibration.joints[entry_used["optics"]]
            stations = _calibrated(used, placed, True)
            tracked = receiver.poses_along(joint, scene, stations, entry_used["note"])
        else:
            tracked = receiver.track(*scene_before(used, used is pose, read, settings))
        more["note"] = tracked.note
        seen = tracked.hits.any(axis=1)
        log.info("receiver: %d of %d moments have a pose", seen.sum(), seen.size)
    except Refusal as refusal:
        more["reason"] = str(refusal)
        level = logging.WARNING if entry.tracked_with else logging.INFO
        log.log(level, "not tracked: %s", refusal)
    files.write_table(path, receiver.columns(tracked), origin | more)


def stations_used(
    entry: Entry, pose: pose_file.PoseFile, earlier: str | None
) -> pose_file.PoseFile:
    """pose.json to track with; refused if it is of other stations, or with swapped roles."""
    if entry.tracked_with is None:
        return pose
    if earlier is None:
        raise Refusal(f"calibration {entry.tracked_with}, to track with, is refused itself")
    used = pose_file.read_pose_json(earlier)
    if pose_file.is_network(used) != pose_file.is_network(pose):
        raise Refusal("the calibration to track with is of stations of the other generation")
    if pose_file.is_network(used):
        for name in used["stations"].keys() & pose["stations"].keys():
            first, second = (one["stations"][name]["id"] for one in (used, pose))
            if None not in (first, second) and first != second:
                raise Refusal(
                    f"the calibration to track with: its station {name} is {first}, that of the"
                    f" recording is {second}"
                )
        return used
    reference.check_same_ids(
        ids_of(used), ids_of(pose), "the calibration to track with", "the recording"
    )
    return used


def _placed(used: pose_file.PoseFile) -> dict[str, pose_file.PoseEntry]:
    """The chosen pose of each station that has one."""
    entries = {name: pose_file.chosen_pose(one) for name, one in pose_file.pairs(used).items()}
    placed = {name: entry for name, entry in entries.items() if entry is not None}
    if not placed:
        raise Refusal("no pose of the slave to track with")
    return placed


def scene_before(
    used: pose_file.PoseFile, is_own: bool, read: Recorded, settings: Lighthouse
) -> tuple[Scene, receiver.Calibrated]:
    """What `receiver.track` needs for an object before the stations of a pose.json; is_own: which
    comes from the same hits."""
    how, placed = calibration_settings(settings), _placed(used)
    entry = next(iter(placed.values()))
    by_batch = is_own and entry["estimator"] == NAME
    _, _, optics = pose_file.kind_of(entry)
    names = read.names
    if optics == ESTIMATED and not is_own:
        raise Refusal("the rotors of these stations were estimated; expected factory values")
    housing = how.lasers_m is not None
    if entry["frame"] != ("housing" if housing else "optical"):
        raise Refusal(
            f"the pose is of the {entry['frame']} frame; expected the frame that lasers_mm implies"
        )
    fixed = FALLBACK if how.variant == AUTO else how.variant
    variants = (str(way["variant"]) for way in used.get("variants", []) if way["chosen"])
    known = how.lasers_m, next(variants, fixed), how.priors
    hits, board, factories = read.seen
    scene = Scene(hits, board, optics, factories, *known, sensors=sensors_of(settings, read))
    if pose_file.is_network(used):
        reference = str(used["reference"])
        scene = replace(scene, names=names, generation=2)
        if reference not in names:
            raise Refusal(f"the recording has no light of station {reference}, the reference")
        placed = {name: pose for name, pose in placed.items() if name in names}
        scene = scene.of([names.index(name) for name in (reference, *placed)])
    if optics == "factory" and None in scene.factories:
        raise Refusal("the recording has no factory values of both stations, as the pose has")
    return scene, _calibrated(used, placed, by_batch)


def _calibrated(
    used: pose_file.PoseFile, placed: Mapping[str, pose_file.PoseEntry], is_own: bool
) -> receiver.Calibrated:
    """What is known of these stations."""
    R, t = zip(*map(pose_file.matrix_and_metres, placed.values()), strict=True)
    if not pose_file.is_network(used):
        stated = next(iter(placed.values()))["covariance"]
        covariance = np.full((6, 6), np.nan) if stated is None else np.array(stated)
    else:
        order = used["covariance_joint_stations"]
        at = np.concatenate([6 * order.index(name) + np.arange(6) for name in placed])
        joint = used["covariance_joint"]
        every = np.full((6 * len(order),) * 2, np.nan) if joint is None else np.array(joint)
        covariance = every[np.ix_(at, at)]
    units = np.tile(COVARIANCE_UNITS, len(placed))
    covariance = covariance / np.outer(units, units)
    return receiver.Calibrated(np.squeeze(R), np.squeeze(t), covariance, is_own)
