"""Files of a calibration: dump -> pulses, stations, sweeps -> board poses, pose of the slave.
`given` and `files` are paths by name."""

from __future__ import annotations

import json
import logging
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from mocap_metrology.calibration.decode import (
    Entry,
    calibration_settings,
    lengths_of,
    reference_of,
    sensors_of,
    truths_of,
)
from mocap_metrology.calibration.exports import frame_of, write_exports
from mocap_metrology.calibration.tracking import write_track
from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import (
    read_table,
    sha256,
    versions,
    write_csv,
    write_json,
    write_table,
)
from mocap_metrology.common.parallel import Over, in_turn
from mocap_metrology.common.types import Row
from mocap_metrology.lighthouse import records
from mocap_metrology.lighthouse.assess.summary import refused, summary
from mocap_metrology.lighthouse.board import read_board
from mocap_metrology.lighthouse.calibrate.jansen import Calibration, calibrate
from mocap_metrology.lighthouse.decode.chain import Decoded, dropped_share
from mocap_metrology.lighthouse.decode.factory_file import stations_from_json, stations_to_json
from mocap_metrology.present.text.calibration import pose_document, reason
from mocap_metrology.settings import Lighthouse

log = logging.getLogger(__name__)
Paths = Mapping[str, str]


def write_decoded(entry: Entry, found: Decoded, settings: Lighthouse, files: Paths) -> None:
    """Pulses, gyroscope and accelerometer, stations, clean hits, and the board; `files` are named
    pulses, inertial, stations, sweeps, board."""
    origin = {
        "recording": entry.calibration,
        "source": entry.twin or Path(str(entry.path)).name,  # wherever the file was
        "twin": entry.twin,
        "sha256": None if entry.twin else sha256(str(entry.path)),
        "lighthouse": settings.of_one(),
        "duration_s": found.duration_s,
        "resolution_s": found.pulses.resolution_s if found.pulses else None,
        "notes": found.notes,
        "clocks": [vars(clock) for clock in found.clocks],
        "versions": versions("numpy", "numba", "pyarrow"),
    }
    table: Mapping[str, np.ndarray | Sequence[object]] = {
        name: [] for name in ("start_s", "length_us", "diode")
    }
    if found.pulses is not None:
        table = records.pulse_columns(found.pulses)
    write_table(files["pulses"], table, origin, records.PULSES_CODED)
    sensors = found.pulses.inertial if found.pulses else None
    write_table(files["inertial"], records.inertial_columns(sensors), origin, records.PLACES)
    origin |= {"counts_by_diode": found.report, "dropped": dropped_share(found.report)}
    write_table(files["sweeps"], records.sweep_columns(found.hits), origin, records.SWEEPS_CODED)
    write_board(files["board"], found.board)
    write_json(files["stations"], stations_to_json(found.stations))
    for station in found.stations:
        log.info("%s: id %s, mode %s, %s", station.role, station.id, station.mode, station.why)
    log.info("%d hits; dropped %s; %s", len(found.hits), origin["dropped"], found.notes)


def write_poses(
    entry: Entry, settings: Lighthouse, given: Paths, files: Paths, over: Over = in_turn
) -> Row:
    """sweeps.parquet, stations.json -> poses.parquet, pose.json, track.parquet: board poses, pose
    of the slave, and the board tracked with it; and the files of other programs.

    `given` are named sweeps, stations, board, and, where there are any, inertial, reference, mount,
    truth, earlier, tracked_with, points; `files` pose, poses, track and as `FORMATS`; over: as in
    `calibrate`. Returns the contents of pose.json.
    """
    hits, origin = read_table(given["sweeps"])
    stations = stations_from_json(json.loads(Path(given["stations"]).read_text(encoding="utf-8")))
    factories = [station.factory for station in stations]
    found, board, placed = Calibration(), read_board(given["board"]), None
    recorded, how = (records.hits_of(hits), board, factories), calibration_settings(settings)
    lengths = lengths_of(entry, given.get("points"), len(board))
    sensors = sensors_of(settings, stations, given.get("inertial"), lengths)
    try:
        found = calibrate(*recorded, how, log.info, over, sensors)
        result = summary(
            found,
            stations,
            duration_s=origin["duration_s"],
            resolution_s=origin["resolution_s"],
            notes=origin["notes"],
            reference=reference_of(entry, given.get("reference"), given.get("mount")),
            truths=truths_of(given.get("truth")),
            earlier=given.get("earlier"),
        )
        if (index := result.document["chosen"]) is not None:
            pose, points = found.estimates[index], given.get("points")
            placed = frame_of(found, pose, stations, board, settings.world, points)
    except Refusal as refusal:
        log.warning("%s", refusal)
        result = refused(stations, str(refusal))
    document = pose_document(result)
    verdict = {"word": result.verdict.word, "reason": reason(result.verdict)}
    log.info("%s", verdict)
    same = ("recording", "source", "twin", "sha256", "duration_s")
    origin = {key: origin[key] for key in same} | {"lighthouse": settings.of_one()}
    origin["versions"] = versions("numpy", "scipy", "numba")
    write_table(files["poses"], records.pose_columns(found.paths), origin)
    earlier = given.get("tracked_with")
    write_track(
        files["track"], entry, found, result.document, earlier, recorded, how, origin, sensors
    )
    world = write_exports(origin, verdict, stations, placed, how.lasers_m, files)
    document |= {"world": world, "origin": origin}
    write_json(files["pose"], document)
    return document


def write_board(path: str, board: np.ndarray) -> None:
    """A board as a CSV file x_m,y_m,z_m in diode order."""
    write_csv(path, [dict(zip(("x_m", "y_m", "z_m"), place, strict=True)) for place in board])
