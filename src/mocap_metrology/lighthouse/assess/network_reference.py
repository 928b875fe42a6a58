"""True poses of any number of stations, as another system measured them, and which are compared.

A file may be a pose.json of any number of stations of this project, the system configuration of a
Crazyflie (systemType 2), the configuration of libsurvive, or JSON

    {"stations": {"3": {"id": 123, "R": [[...], ...], "t_m": [...]}, "11": ...}}

of poses in one frame, whatever it is; `quaternion_xyzw` and `translation_mm` likewise, `id` where
it is known. Stations are those of the recording with the same id, or channel where an id is
unknown.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mocap_metrology.common.documents import text_of
from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.assess import pose_file
from mocap_metrology.lighthouse.assess.reference import (
    LONGEST_M,
    Reference,
    is_libsurvive,
    of_json,
    rotation_in,
    station_id,
    translation_in,
)
from mocap_metrology.lighthouse.decode.factory_file import (
    CHANNELS,
    crazyflie_geometry,
    is_crazyflie,
)
from mocap_metrology.lighthouse.decode.libsurvive_solution import (
    CLIPPED_ID,
    FROM_LIBSURVIVE,
    read_solution,
)
from mocap_metrology.lighthouse.records import Station


@dataclass(frozen=True)
class Placed:
    """A station with its pose R (3, 3), t (3,) in m in the frame of the file."""

    channel: int
    id: int | None
    R: np.ndarray
    t_m: np.ndarray


@dataclass(frozen=True)
class NetworkReference:
    """source: where it comes from, in words."""

    stations: tuple[Placed, ...]
    source: str

    def seen_from(
        self, reference: str, stations: Sequence[Station]
    ) -> tuple[dict[str, Reference], str]:
        """Poses of stations by name in the frame of the one named `reference`, and which of them
        the file lacks, in words. Raises `Refusal` where a channel is of another station there."""
        placed = {one.role: self._of(one) for one in stations}
        lacks = [name for name, one in placed.items() if one is None]
        note = f"The reference has no pose of station {', '.join(lacks)}." if lacks else ""
        first = placed.get(reference)
        if first is None:
            return {}, note
        R_0, t_0 = first.R.T, first.t_m
        others = {k: one for k, one in placed.items() if one is not None and k != reference}
        source = self.source
        return {
            k: Reference(R_0 @ one.R, R_0 @ (one.t_m - t_0), (first.id, one.id), source)
            for k, one in others.items()
        }, note

    def _of(self, station: Station) -> Placed | None:
        same = [one for one in self.stations if one.id == station.id is not None]
        same += [one for one in self.stations if one.channel == station.channel]
        if same and None not in (same[0].id, station.id) and same[0].id != station.id:
            raise Refusal(
                f"{self.source}: its station {same[0].channel} is {same[0].id}, that of the"
                f" recording is {station.id}; expected poses of the same stations"
            )
        return same[0] if same else None


def network_reference(path: str | Path) -> NetworkReference:
    """Raises `Refusal` for a missing or impossible entry, and where there are not two stations."""
    name = Path(path).name
    text = text_of(path, "a pose file")
    if is_crazyflie(text):
        geometry = crazyflie_geometry(text, name, 2)
        every = [
            Placed(k, uid, rotation_in({"R": R}, f"{name}: geos.{k}.rotation"), t)
            for k, (uid, R, t) in geometry.items()
        ]
    elif is_libsurvive(text):
        every = []
        for one in read_solution(path, 2):
            if one.pose is not None and one.channel is not None:
                uid, (R, t) = None if one.id == CLIPPED_ID else one.id, one.pose
                every.append(Placed(one.channel, uid, R @ FROM_LIBSURVIVE.T, t))
    else:
        every = _of_json(path, text)
    if len(every) < 2:
        raise Refusal(f"{name}: poses of {len(every)} stations; expected two or more")
    apart = max(float(np.linalg.norm(one.t_m - every[0].t_m)) for one in every)
    if apart > LONGEST_M:
        raise Refusal(
            f"{name}: stations are {apart:g} m apart; expected up to {LONGEST_M:g} m (is the unit"
            " right?)"
        )
    return NetworkReference(tuple(every), f"pose file {name}")


def _of_json(path: str | Path, text: str) -> list[Placed]:
    name = Path(path).name
    document = of_json(text, name)
    stations = document.get("stations") if isinstance(document, Mapping) else None
    channels = {str(k) for k in range(CHANNELS)}
    if not isinstance(stations, Mapping) or not stations or not stations.keys() <= channels:
        raise Refusal(
            f'{name}: expected stations of the second generation by channel, {{"stations": {{"3":'
            ' {"id": ..., "R": ..., "t_m": ...}, ...}}'
        )
    if "poses" in document:
        return _of_pose_json(path)
    placed = []
    for channel, entry in stations.items():
        where = f"{name}: station {channel}"
        if not isinstance(entry, Mapping):
            raise Refusal(f"{where} is {entry!r}; expected R and t_m")
        R, t = rotation_in(entry, where), translation_in(entry, where)
        placed.append(Placed(int(channel), station_id(entry, where), R, t))
    return placed


def _of_pose_json(path: str | Path) -> list[Placed]:
    """The chosen poses, and that of the reference."""
    document = pose_file.read_pose_json(path)
    channel = str(document["reference"])
    first = Placed(int(channel), document["stations"][channel]["id"], np.eye(3), np.zeros(3))
    chosen = {name: pose_file.chosen_pose(one) for name, one in pose_file.pairs(document).items()}
    return [first] + [
        Placed(int(name), document["stations"][name]["id"], *pose_file.matrix_and_metres(entry))
        for name, entry in chosen.items()
        if entry is not None
    ]
