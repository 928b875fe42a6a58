"""pose.json of a setup: all its recordings in one estimate (`joint: setup`)."""

from __future__ import annotations

import json
import logging
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from mocap_metrology.calibration.pose import calibration_settings, sensors_of
from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import read_table, versions, write_json
from mocap_metrology.common.types import Row
from mocap_metrology.lighthouse import records
from mocap_metrology.lighthouse.assess.pose_file import read_pose_json
from mocap_metrology.lighthouse.assess.reference import check_same_ids
from mocap_metrology.lighthouse.assess.summary import refused, summary
from mocap_metrology.lighthouse.board import read_board, read_normals
from mocap_metrology.lighthouse.calibrate.batch import ESTIMATED, Scene
from mocap_metrology.lighthouse.calibrate.jansen import Calibration
from mocap_metrology.lighthouse.calibrate.setup import Setup, by_setup
from mocap_metrology.lighthouse.calibrate.static import median_angles
from mocap_metrology.lighthouse.decode.factory_file import stations_from_json
from mocap_metrology.lighthouse.records import MASTER, SLAVE, Station
from mocap_metrology.present.text.calibration import pose_document
from mocap_metrology.settings import Lighthouse

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Member:
    """A recording of a setup: its name and files."""

    name: str
    sweeps: str
    stations: str
    board: str
    pose: str
    inertial: str | None = None


def write_setup(setup: str, members: Sequence[Member], settings: Lighthouse, output: str) -> Row:
    """One pose from all recordings of a setup, with what each says of the others."""
    stations: list[Station] = []
    tables = {one.name: read_table(one.sweeps) for one in members}
    try:
        stations = _stations(members)
        found = _together(members, {k: hits for k, (hits, _) in tables.items()}, stations, settings)
        clocks = [origin["resolution_s"] for _, origin in tables.values()]
        document = pose_document(
            summary(
                Calibration([found.pose], why=found.why, variants=found.variants),
                stations,
                resolution_s=max(clocks) if None not in clocks else None,
            )
        )
        document["predicted"] = {name: asdict(one) for name, one in found.predicted.items()}
    except Refusal as refusal:
        log.warning("%s: %s", setup, refusal)
        document = pose_document(refused(stations or _read(members[0]), str(refusal)))
    document["recordings"] = [one.name for one in members]
    document["origin"] = {
        "recording": setup,
        "lighthouse": settings.of_one(),
        "versions": versions("numpy", "scipy", "numba"),
    }
    log.info("%s", document["verdict"])
    write_json(output, document)
    return document


def _read(one: Member) -> list[Station]:
    return stations_from_json(json.loads(Path(one.stations).read_text(encoding="utf-8")))


def _stations(members: Sequence[Member]) -> list[Station]:
    """Both stations, with what any recording tells of them; refuses those of others."""
    every = [_read(one) for one in members]
    for one, own in zip(members[1:], every[1:], strict=True):
        theirs, first = ((both[MASTER].id, both[SLAVE].id) for both in (own, every[0]))
        check_same_ids(theirs, first, one.name, members[0].name)
    return [
        next((own[k] for own in every if own[k].factory is not None), every[0][k])
        for k in (MASTER, SLAVE)
    ]


def _together(
    members: Sequence[Member],
    tables: Mapping[str, Mapping[str, np.ndarray]],
    stations: Sequence[Station],
    settings: Lighthouse,
) -> Setup:
    board = read_board(members[0].board)
    for one in members[1:]:
        if not np.array_equal(read_board(one.board), board):
            raise Refusal(f"{one.name} has another board than {members[0].name}; expected the same")
    how = calibration_settings(settings)
    factories = [station.factory for station in stations]
    known = "factory" in how.optics and None not in factories
    optics = "factory" if known else ESTIMATED if ESTIMATED in how.optics else "ideal"
    scenes, still = {}, {}
    for one in members:
        hits = records.hits_of(tables[one.name])
        normals = read_normals(one.board)
        more = sensors_of(settings, stations, one.inertial, normals=normals)
        lasers = how.lasers_m, how.variant, how.priors
        scenes[one.name] = Scene(hits, board, optics, factories, *lasers, sensors=more)
        if read_pose_json(one.pose)["diagnostics"].get("still"):
            middle = (median_angles(hits, station, len(board)) for station in (MASTER, SLAVE))
            still[one.name] = next(middle), next(middle)
    return by_setup(scenes, still)
