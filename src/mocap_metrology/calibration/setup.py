"""pose.json of a setup: all its recordings in one estimate (`joint: setup`)."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace

import numpy as np

from mocap_metrology.calibration.sweeps import Recorded, recorded
from mocap_metrology.calibration.track import calibration_settings, sensors_of
from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import versions, write_json
from mocap_metrology.common.types import Row
from mocap_metrology.lighthouse.assess.pose_file import read_pose_json
from mocap_metrology.lighthouse.assess.reference import check_same_ids
from mocap_metrology.lighthouse.assess.summary import refused, summary
from mocap_metrology.lighthouse.calibrate.jansen import Calibration
from mocap_metrology.lighthouse.calibrate.scene import Scene, optics_for
from mocap_metrology.lighthouse.calibrate.setup import by_setup
from mocap_metrology.lighthouse.calibrate.static import median_angles
from mocap_metrology.lighthouse.records import MASTER, ROLES, SLAVE, Hits, Measurements, Station
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
    """Poses from all recordings of a setup, with what each says of the others."""
    stations: list[Station] = []
    every = {one.name: recorded({k: v for k, v in vars(one).items() if v}) for one in members}
    try:
        stations, places = same_stations({name: item.stations for name, item in every.items()})
        hits = {}
        for name, item in every.items():  # their stations as places in the list of all
            place = np.array(places[name], item.hits.station.dtype)
            hits[name] = replace(item.hits, station=place[item.hits.station])
        files = {name: item.origin["sha256"] for name, item in every.items()}
        _check_once(hits, files)
        scenes, still = _scenes(members, every, hits, stations, settings)
        seen = [(files[name], item.board.tobytes()) for name, item in scenes.items() if files[name]]
        # Two objects of equal boards in one recording: every row is of an object of its own.
        objects = {name: name for name in scenes} if len(set(seen)) < len(seen) else None
        solution = by_setup(scenes, still, objects)
        clocks = [item.origin["resolution_s"] for item in every.values()]
        calibration = Calibration(
            solution.poses, why=solution.why, variants=solution.variants, network=solution.network
        )
        resolution = max(clocks) if None not in clocks else None
        document = pose_document(summary(calibration, stations, resolution_s=resolution))
        said = {
            station: {name: asdict(one) for name, one in item.items()}
            for station, item in solution.predicted.items()
        }
        document["predicted"] = said if solution.network else said[ROLES[SLAVE]]
    except Refusal as refusal:
        log.warning("%s: %s", setup, refusal)
        document = pose_document(refused(stations or every[members[0].name].stations, str(refusal)))
    document["recordings"] = [one.name for one in members]
    document["origin"] = {
        "recording": setup,
        "lighthouse": settings.of_one(),
        "versions": versions("numpy", "scipy", "numba"),
    }
    log.info("%s", document["verdict"])
    write_json(output, document)
    return document


def _check_once(hits: Mapping[str, Hits], files: Mapping[str, str | None]) -> None:
    """Refuse hits that two rows share, which would count twice; files: SHA-256 by name."""
    seen: dict[tuple[str | None, bytes], str] = {}
    for name, member_hits in hits.items():
        other = seen.setdefault((files[name], member_hits.time_s.tobytes()), name)
        if files[name] and other != name:
            raise Refusal(
                f"{other} and {name} are of one object in one recording; expected one row"
            )


def _scenes(
    members: Sequence[Member],
    every: Mapping[str, Recorded],
    hits: Mapping[str, Hits],
    stations: Sequence[Station],
    settings: Lighthouse,
) -> tuple[dict[str, Scene], dict[str, list[Measurements]]]:
    how = calibration_settings(settings)
    factories = [station.factory for station in stations]
    optics = optics_for(how.optics, factories)
    generation, names = stations[0].generation, [station.role for station in stations]
    scenes, still = {}, {}
    for one in members:
        member_hits, read = hits[one.name], every[one.name]
        board, clocks = read.board, dict(zip(read.names, read.clocks, strict=False))
        more = sensors_of(settings, replace(read, stations=stations))
        more = replace(more, clocks=tuple(map(clocks.get, names)))
        lasers = how.lasers_m if generation == 1 else None
        known = member_hits, board, optics, factories, lasers, how.variant, how.priors
        scenes[one.name] = Scene(*known, sensors=more, generation=generation, names=names)
        if read_pose_json(one.pose)["diagnostics"].get("still"):
            still[one.name] = [
                median_angles(member_hits, k, len(board)) for k in range(len(stations))
            ]
    return scenes, still


def same_stations(
    every: Mapping[str, Sequence[Station]],
) -> tuple[list[Station], dict[str, list[int]]]:
    """Stations of all recordings, with what any recording tells of them, and the places in this
    list of those of each: by id, by channel where that is unknown.

    Of the first generation master and slave. Of the second by rising channel, that of the first
    recording that has the station. Raises `Refusal` where the recordings are of other stations or
    of both generations, or where a channel is of two stations.
    """
    if len({one.generation for listed in every.values() for one in listed}) > 1:
        raise Refusal("recordings of stations of both generations; expected those of one")
    first, *others = every
    if every[first][0].generation == 1:
        for name in others:
            theirs, its = (
                (listed[MASTER].id, listed[SLAVE].id) for listed in (every[name], every[first])
            )
            check_same_ids(theirs, its, name, first)
        both = [_best_known([listed[k] for listed in every.values()]) for k in (MASTER, SLAVE)]
        return both, {name: [MASTER, SLAVE] for name in every}
    groups = sorted(_of_channels(every), key=lambda same: same[0][1].channel or 0)
    places = {
        name: [
            next(k for k, same in enumerate(groups) if any(one is other for _, other in same))
            for one in listed
        ]
        for name, listed in every.items()
    }
    for name, of_one in places.items():
        if len(set(of_one)) < len(of_one):
            raise Refusal(f"{name}: two of its stations are one in the other recordings")
    return [_best_known([one for _, one in same]) for same in groups], places


def _of_channels(every: Mapping[str, Sequence[Station]]) -> list[list[tuple[str, Station]]]:
    """Stations of the second generation as each recording tells them, with its name, those that
    are one together; the first of these names it."""
    groups: list[list[tuple[str, Station]]] = []
    told = [(name, one) for name, group in every.items() for one in group]
    for name, one in sorted(told, key=lambda pair: pair[1].id is None):
        same = [group for group in groups if group[0][1].id == one.id]
        if one.id is None:
            same = [group for group in groups if one.channel in {o.channel for _, o in group}]
        if len(same) > 1:
            ids = " and ".join(str(group[0][1].id) for group in same)
            raise Refusal(f"{name}: station {one.role} has no id, and {ids} have that channel")
        if same:
            same[0].append((name, one))
            continue
        for (where, other), *_ in groups:
            if other.channel == one.channel:
                raise Refusal(
                    f"station {one.role} is {one.id} in {name} and {other.id} in {where};"
                    " expected one station a channel"
                )
        groups.append([(name, one)])
    return groups


def _best_known(told: Sequence[Station]) -> Station:
    """A station as one recording tells it, with factory values if any does, named as by the first;
    its id, too, where another one tells it."""
    best = next((one for one in told if one.factory is not None), told[0])
    uid = next((one.id for one in told if one.id is not None), None)
    return replace(best, role=told[0].role, channel=told[0].channel, id=best.id or uid)
