"""The step of a calibration whose row names motion capture of its receiver: the tracked path, and
the places of the stations, against it. Motion capture checks; nothing of the calibration is fitted
to it."""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from mocap_metrology.calibration.pose import motion_capture
from mocap_metrology.calibration.sweeps import Entry, Paths, recorded
from mocap_metrology.calibration.track import scene_before, stations_used
from mocap_metrology.common import files
from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.types import Floats, Row
from mocap_metrology.io.units import Unit
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.assess.pose_file import pose_row, read_pose_json
from mocap_metrology.lighthouse.batch.kernel import POSE
from mocap_metrology.lighthouse.calibrate.scene import ESTIMATED, Scene
from mocap_metrology.lighthouse.records import COVARIANCE_UNITS
from mocap_metrology.lighthouse.track.markers import Markers, Tracked
from mocap_metrology.lighthouse.track.mocap import Match, match
from mocap_metrology.lighthouse.track.receiver import AXES_OF_POSE, Calibrated
from mocap_metrology.lighthouse.track.resection import Resected, resected
from mocap_metrology.present.text.sentence import render
from mocap_metrology.settings import Lighthouse

log = logging.getLogger(__name__)
BY_CHANCE = 0.01  # probability below which a station is not where the calibration has it


def receiver(
    entry: Entry,
    seen: str,
    labels: Sequence[str],
    inputs: Paths,
    settings: Lighthouse,
    output: str,
    unit: Unit | None = None,
) -> Row:
    """receiver.json of a row; a refusal is a result, with the reason in it.

    seen: a recording of markers on the receiver; labels: of these, empty for all; inputs: paths
    named as `DECODED`, track, pose, tracked_with (if any); unit: of the coordinates, where the file
    names none. Returns the contents of receiver.json.
    """
    try:
        read = motion_capture(seen, labels, unit, "receiver_unit")
        place_m = 1e-3 * np.asarray(read.position_mm, float)
        markers = Markers(read.labels, read.frame_rate_hz, place_m).cleaned()
        document = _judged(entry, markers, Path(seen).name, inputs, settings)
    except Refusal as refusal:
        document = {"recording": entry.calibration, "refused": str(refusal)}
    log.info("%s", document.get("sentence") or document["refused"])
    files.write_json(output, document)
    return document


def _judged(entry: Entry, seen: Markers, file: str, inputs: Paths, settings: Lighthouse) -> Row:
    columns, origin = files.read_table(inputs["track"])
    if not columns["time_s"].size:
        raise Refusal(f"receiver: the board is not tracked ({origin.get('reason', 'no hits')})")
    track = _tracked(columns)
    matched = match(track, seen)
    free, n = matched.free, len(seen.labels)
    common_s = float(matched.time_s.size * np.median(np.diff(track.time_s)))
    levers = zip(seen.labels, free.lever_m, matched.sd[2:-1].reshape(n, 3), strict=True)
    document: Row = {
        "recording": entry.calibration,
        "motion_capture": {"source": file, "labels": list(seen.labels), "rate_hz": seen.rate_hz},
        "not_rigid": seen.not_rigid,
        "common_s": common_s,
        "n_moments": int(matched.time_s.size),
        "clock": {
            "offset_s": free.offset_s,
            "offset_sd_s": float(matched.sd[0]),
            "rate_ppm": 1e6 * free.rate,
            "rate_sd_ppm": 1e6 * float(matched.sd[1]),
            "slip_ms": 1e3 * matched.slip_s,
            "slip_share": matched.slip_share,
        },
        "frame": pose_row(matched.alignment.A, matched.alignment.b_m),
        "lever_mm": {k: {"value": _mm(value), "sd": _mm(sd)} for k, value, sd in levers},
        "scale_ppm": 1e6 * (free.scale - 1),
        "scale_sd_ppm": 1e6 * float(matched.sd[-1]),
        "place_mm": _statistics(1e3 * np.linalg.norm(matched.place_m.mean(axis=1), axis=1)),
        "attitude_deg": None,
        "stated": _stated(columns, matched),
    }
    if matched.turn_rad is not None:
        turns = np.degrees(np.linalg.norm(matched.turn_rad, axis=1))
        document["attitude_deg"] = _statistics(turns)
    try:
        document["stations"] = _stations(*_scene(entry, inputs, settings), track, seen, matched)
    except Refusal as refusal:
        document |= {"stations": {}, "not_resected": str(refusal)}
    document["sentence"] = render("receiver.check", **document)
    return document


def _tracked(columns: Mapping[str, np.ndarray]) -> Tracked:
    t = 1e-3 * np.column_stack([columns[f"{axis}_mm"] for axis in "xyz"])
    q = np.column_stack([columns[name] for name in ("qx", "qy", "qz", "qw")])
    R = np.full((len(t), 3, 3), math.nan)
    known = np.isfinite(t).all(axis=1)
    R[known] = rotation.of_quaternions(q[known])
    sd = np.column_stack([columns[f"sd_noise_{axis}"] for axis in AXES_OF_POSE[:3]])
    return Tracked(np.asarray(columns["time_s"]), R, t, 1e-3 * np.sqrt(np.mean(sd**2, axis=1)))


def _scene(entry: Entry, inputs: Paths, settings: Lighthouse) -> tuple[Scene, Calibrated]:
    """The light on the receiver, and the stations as the row tracks with them."""
    read, pose = replace(recorded(inputs), inertial=None), read_pose_json(inputs["pose"])
    used = stations_used(entry, pose, inputs.get("tracked_with"))
    scene, known = scene_before(used, used is pose, read, settings)
    if scene.optics == ESTIMATED:
        raise Refusal("the rotors of these stations were estimated; expected factory values")
    return scene, known


def _stations(
    scene: Scene, known: Calibrated, track: Tracked, seen: Markers, matched: Match
) -> dict[str, Row]:
    """Errors of the stations by name: the pose by the calibration less that by motion capture, as
    seen from the reference; and each pose, that of the reference too, in the frame of motion
    capture."""
    placed = resected(scene, known, track, seen, matched.free)
    rows = {
        scene.names[k]: {
            "in_motion_capture": pose_row(*pose),
            "n_hits": hits,
            "residual_rms_urad": 1e6 * rms,
        }
        for k, pose, hits, rms in zip(
            placed.members, placed.poses, placed.hits, placed.rms_rad, strict=True
        )
    }
    for place, k in enumerate(placed.members[1:]):
        rows[scene.names[k]] |= _difference(known, k, placed, place)
    return rows


def _difference(known: Calibrated, k: int, placed: Resected, place: int) -> Row:
    from scipy.stats import chi2

    (R, t), (R_0, t_0) = known.poses[k], placed.relative[place]
    off = np.r_[t - t_0, rotation.error(R, R_0)] * COVARIANCE_UNITS
    its, there = (slice(POSE * at, POSE * (at + 1)) for at in (k - 1, place))
    before, seen = known.covariance[its, its], placed.covariance[there, there]
    both = (before + seen) * np.outer(COVARIANCE_UNITS, COVARIANCE_UNITS)
    row: Row = {"difference_mm": off[:3].tolist(), "difference_deg": off[3:].tolist()}
    parts = {"": both, "_resection": seen * np.outer(COVARIANCE_UNITS, COVARIANCE_UNITS)}
    for unit, axes in (("mm", slice(0, 3)), ("deg", slice(3, 6))):
        row[f"shift_{unit}"] = float(np.linalg.norm(off[axes]))
        for name, C in parts.items():
            row[f"sd{name}_{unit}"] = float(np.sqrt(np.trace(C[axes, axes])))
    if np.isfinite(both).all():
        p = float(chi2.sf(off @ np.linalg.solve(both, off), POSE))
        row |= {"p_value": p, "agrees": p >= BY_CHANCE}
    return row


def _stated(columns: Mapping[str, np.ndarray], matched: Match) -> Row:
    """`stated_errors` of a coordinate; what a motion of the whole path would explain is not in the
    errors."""
    at = np.searchsorted(columns["time_s"], matched.time_s)
    sd = np.column_stack([columns[f"sd_{axis}"][at] for axis in AXES_OF_POSE[:3]])
    error = 1e3 * matched.place_m.mean(axis=1) @ matched.alignment.A
    known = np.isfinite(sd).all(axis=1)
    return stated_errors(sd[known], (np.abs(error) / sd)[known])


def stated_errors(sd_mm: np.ndarray, sizes: np.ndarray) -> Row:
    """Median standard deviation by a track, and how often an error is within one and two; sizes: of
    errors over theirs."""
    if not sizes.size:
        return dict.fromkeys(("sd_mm", "within_1", "within_2"), math.nan)
    within = {f"within_{k}": float((sizes <= k).mean()) for k in (1, 2)}
    return {"sd_mm": float(np.median(sd_mm)), **within}


def _statistics(values: Floats) -> Row:
    p50, p95 = np.percentile(values, [50, 95]).tolist()
    rms = float(np.sqrt(np.mean(values**2)))
    return {"rms": rms, "p50": p50, "p95": p95, "max": float(values.max())}


def _mm(values: Floats) -> list[float]:
    return (1e3 * np.asarray(values)).tolist()
