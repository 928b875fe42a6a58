"""The step of a calibration whose row names a bar: two objects on it, tracked with the stations of
the calibration, and how wrong their distance is. The bar checks; nothing is fitted to it. A bar
that is hardly moved is judged too: errors of the stations and the diodes are there at rest."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from mocap_metrology.accuracy import take as of_take
from mocap_metrology.accuracy.bar import BarEntry, evaluate
from mocap_metrology.accuracy.bar_rows import bar_rows
from mocap_metrology.accuracy.findings import findings_of
from mocap_metrology.calibration.receiver import stated_errors
from mocap_metrology.calibration.sweeps import Entry, Paths, Recorded, decoded, recorded
from mocap_metrology.calibration.track import scene_before, stations_used
from mocap_metrology.common import files
from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.types import Row
from mocap_metrology.io.labels import pair_of
from mocap_metrology.lighthouse.assess.pose_file import PoseFile, is_network, read_pose_json
from mocap_metrology.lighthouse.decode.libsurvive import TrackedObject, tracked_objects
from mocap_metrology.lighthouse.track.bar import BarEnds, Object, heads
from mocap_metrology.lighthouse.track.receiver import STEP_S
from mocap_metrology.present.accuracy.bar import bar_document
from mocap_metrology.present.text.sentence import render
from mocap_metrology.settings import Bar as Limits
from mocap_metrology.settings import Lighthouse


def bar(
    entry: Entry,
    bar_row: BarEntry,
    inputs: Paths,
    settings: Lighthouse,
    limits: Limits,
    paths: Paths,
    other: Entry | None = None,
) -> Row:
    """bar.json and bar.csv of a row; a refusal is a result, with the reason in bar.json.

    given: paths named dump, factory (if any) and as `DECODED`, pose, tracked_with (if any); of
    `other`, a row whose object is the other end, the same after `other_`; paths: as `BAR`.
    Returns the contents of bar.json.
    """
    try:
        document, rows = _judged(entry, bar_row, inputs, settings, limits, other)
    except Refusal as refusal:
        document, rows = {"recording": entry.calibration, "refused": str(refusal)}, []
    files.write_csv(paths["bar_rows"], rows, () if rows else ("quantity", "class"))
    files.write_json(paths["bar"], document)
    return document


def _judged(
    entry: Entry,
    bar_row: BarEntry,
    inputs: Paths,
    settings: Lighthouse,
    limits: Limits,
    other: Entry | None,
) -> tuple[Row, list[Row]]:
    own_pose = read_pose_json(inputs["pose"])
    used = stations_used(entry, own_pose, inputs.get("tracked_with"))
    if not is_network(used):
        raise Refusal("bar: stations of the first generation; expected the second (V2)")
    ours, theirs = _by_labels(entry, inputs["dump"]), {}
    ends = {label: (entry, tracked) for label, tracked in ours.items()}
    if other is not None:
        theirs = _by_labels(other, inputs["other_dump"])
        ends |= {f"{other.calibration}:{k}": (other, v) for k, v in theirs.items()}
    file = Path(inputs["dump"]).name
    pair = pair_of(bar_row.bar, list(ends), file, "two objects of the recording")
    board = ours.get(_board(entry))
    if sum(ends[label][1] is board for label in pair) != 1:
        raise Refusal(
            f"bar is {bar_row.bar}; expected the board {_board(entry)} and another object"
        )
    first, objects = recorded(inputs), []
    for label in pair:
        row, tracked = ends[label]
        is_own, seen = tracked is board, first
        if row is not entry:
            if tracked is not theirs.get(_board(row)):
                raise Refusal(f"bar: {label} is not the board of calibration {row.calibration}")
            seen = _of_other_row(inputs, first)
        elif not is_own:
            read = decoded(replace(entry, board=tracked.name), inputs, settings)
            sensors = read.pulses.inertial if read.pulses else None
            origin: files.Metadata = {"host_s": read.host_s, "clocks": []}
            seen = Recorded(read.hits, read.stations, read.board, read.normals, origin, sensors)
        objects.append(_object(seen, first, tracked, used, is_own and used is own_pose, settings))
    return _document(entry.calibration, bar_row, pair, heads(*objects), used, limits)


def _board(entry: Entry) -> str:
    """What a bar calls the board of a row: the name of the object, or of its file."""
    name = str(entry.board)
    return name if entry.format == "libsurvive-rec" else Path(name).stem


def _by_labels(entry: Entry, dump: str) -> dict[str, TrackedObject]:
    """Objects of a recording by name and by serial number."""
    if entry.format != "libsurvive-rec":
        return {_board(entry): TrackedObject(_board(entry))}
    objects = tracked_objects(dump)
    return {one.name: one for one in objects} | {one.serial: one for one in objects if one.serial}


def _of_other_row(inputs: Paths, first: Recorded) -> Recorded:
    """The computer's times of two files are of one clock only where these are the same."""
    start = "other_"
    seen = recorded({k.removeprefix(start): v for k, v in inputs.items() if k.startswith(start)})
    same = seen.origin["sha256"] is not None and seen.origin["sha256"] == first.origin["sha256"]
    return seen if same else replace(seen, origin=seen.origin | {"host_s": None})


def _object(
    seen: Recorded,
    first: Recorded,
    tracked: TrackedObject,
    used: PoseFile,
    is_own: bool,
    settings: Lighthouse,
) -> Object:
    """first: the board of the row, whose factory values the calibration has used."""
    known = {station.role: station.factory for station in first.stations}
    stations = [replace(s, factory=known.get(s.role) or s.factory) for s in seen.stations]
    scene, calibrated = scene_before(used, is_own, replace(seen, stations=stations), settings)
    host_s = seen.origin.get("host_s")
    return Object(
        scene, calibrated, (tracked.R, tracked.t_m), math.nan if host_s is None else host_s
    )


def _document(
    name: str,
    bar_row: BarEntry,
    pair: Sequence[str],
    bar_ends: BarEnds,
    used: PoseFile,
    limits: Limits,
) -> tuple[Row, list[Row]]:
    from scipy.spatial.transform import Rotation

    take = of_take.take_of(name, "", 1 / STEP_S, 1e3 * bar_ends.t_m, 0.0)
    of_take.check(take, " and ".join(pair), bar_row.length_mm, 0.0)
    way, least, said = of_take.way_mm(take), limits.least_path_mm, []
    if way < least:
        said = [render("bar.one_place", way=way, least=least, pair=pair)]
    quaternions = np.full((2, 4, bar_ends.time_s.size), math.nan)
    seen = take.known
    quaternions[:, :, seen] = [Rotation.from_matrix(R[seen]).as_quat().T for R in bar_ends.R]
    pose = bar_row.pose
    take = of_take.with_angles(take, quaternions, pose.quaternion if pose else None)
    judged = evaluate([take], bar_row.certificate, limits)
    findings = findings_of(judged, pose_u_deg=pose.u_deg if pose else 0.0)
    document: Row = {
        "recording": name,
        **bar_document(judged, findings, limits, pair, warnings=said),
    }
    clock = bar_ends.clock
    document["clock"] = {
        "rate_ppm": 1e6 * (clock.rate - 1),
        "rms_ns": 1e9 * clock.rms_s,
        "stations_apart_ns": 1e9 * clock.apart_s,
        "n_turns": clock.turns,
    }
    document["stations"] = {name: one["id"] for name, one in used["stations"].items()}
    document["stated"] = _stated(take.length_mm - judged.reference_mm, 1e3 * bar_ends.sd_m, bar_row)
    return document, bar_rows(judged)


def _stated(error_mm: np.ndarray, sd_mm: np.ndarray, bar_row: BarEntry) -> Row:
    """`stated_errors` of a distance, of its error that of the certificate included."""
    known = np.isfinite(error_mm) & np.isfinite(sd_mm)
    sizes = np.abs(error_mm[known]) / np.hypot(sd_mm[known], bar_row.length_u_mm or 0.0)
    return stated_errors(sd_mm[known], sizes)
