"""Stations from files: this project's `stations.json`, the JSON that libsurvive stores, or the YAML
of a Crazyflie.

For recordings without a whole calibration frame, and for reading back what a stage has written.
The system configuration that Bitcraze's tools write is

    type: lighthouse_system_configuration
    version: '1'
    systemType: 1
    calibs:
      0: {uid: 4255386550, sweeps: [{phase: ..., tilt: ..., curve: ..., gibmag: ..., gibphase: ...},
                                    {...}]}

[crazyflie-lib-python, cflib/localization/lighthouse_config_manager.py]. Station 0 is the one that
flashes first, so the master; sweep 0 is the azimuth; uid is the id that its flashes carry. A file
without systemType is of second-generation stations, as its own reader assumes: then stations are
channel indices, sweeps planes, with ogeephase and ogeemag. `geos`, poses in the room,
{0: {origin: [x, y, z], rotation: [[...], [...], [...]]}, 1: ...}, are read by `crazyflie_geometry`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from mocap_metrology.common.documents import load_json, load_yaml, text_of
from mocap_metrology.common.errors import UNREADABLE, Refusal
from mocap_metrology.common.spreadsheet import number
from mocap_metrology.lighthouse.decode import libsurvive_solution
from mocap_metrology.lighthouse.records import ROLES, Factory, Station
from mocap_metrology.lighthouse.rotor import rotor_parameters

FACTORY_NAMES = ("phase", "tilt", "curve", "gibphase", "gibmag")
NAMES_OF = {1: FACTORY_NAMES, 2: (*FACTORY_NAMES, "ogeephase", "ogeemag")}  # by generation
CHANNELS = 16  # of generation 2
OPTIONAL = ("frames_found", "why", "firmware", "hardware")
CRAZYFLIE_TYPE = "lighthouse_system_configuration"
CRAZYFLIE_VERSIONS = ("1", "2")


def read_factory(path: str | Path) -> list[Station]:
    """Stations with factory calibration, master first; the kind of file is detected from its
    content. Raises `Refusal` where the file is neither, or holds no calibration."""
    name = Path(path).name
    text = text_of(path, "stations.json")
    if is_crazyflie(text):
        return _of_crazyflie(text, name)
    if '"lighthouse' in text:
        return _of_libsurvive(path, text)
    try:
        document = load_json(text)
    except UNREADABLE as error:
        raise Refusal(
            f"{name}: no JSON ({error}); expected stations.json, libsurvive's companion file"
            " or a Crazyflie's system configuration"
        ) from None
    every = stations_from_json(document, name)
    stations = [station for station in every if station.factory is not None]
    if not stations:
        raise Refusal(f"{name}: no station has factory values; expected phase, tilt, curve...")
    return stations


def _of_libsurvive(path: str | Path, text: str) -> list[Station]:
    """libsurvive's lighthouse 1 flashes first: it is the master; of generation 2 by channel."""
    stations, generation = [], 2 if libsurvive_solution.of_second_generation(text) else 1
    for solved in libsurvive_solution.read_solution(path, generation):
        if generation == 1 and solved.index > 1:
            continue
        _check(solved.factory, Path(path).name)
        uid = None if generation == 2 and solved.id == libsurvive_solution.CLIPPED_ID else solved.id
        role = str(solved.channel) if generation == 2 else ROLES[1 - solved.index]
        station = Station(role, id=uid, mode=solved.mode, factory=solved.factory)
        stations.append(replace(station, generation=generation, channel=solved.channel))
    return sorted(stations, key=lambda one: (one.channel or 0, one.role))


def stations_to_json(stations: Sequence[Station]) -> list[dict[str, object]]:
    """What `stations.json` holds: a list, master first; null for what is not known. Of generation 2
    in the given order, with generation, channel and seven factory values."""
    every = list(stations)
    if all(station.generation == 1 for station in every):
        every.sort(key=lambda station: ROLES.index(station.role))
    entries = []
    for station in every:
        entry: dict[str, object] = {"role": station.role}
        if station.generation == 2:
            entry |= {"generation": 2, "channel": station.channel}
        entry |= {"id": station.id, "mode": station.mode, "factory": None, "gravity": None}
        if (factory := station.factory) is not None:
            names = NAMES_OF[station.generation]
            entry["factory"] = {k: [float(v) for v in getattr(factory, k)] for k in names}
        if station.gravity is not None:
            entry["gravity"] = [float(v) for v in station.gravity]
        entry |= {name: getattr(station, name) for name in OPTIONAL}
        if (up := station.up_by_geometry) is not None:
            entry["up_by_geometry"] = up.tolist()
        entries.append(entry)
    return entries


def stations_from_json(entries: object, name: str = "stations.json") -> list[Station]:
    """Stations from parsed JSON; the reverse of `stations_to_json`, which only needs the role."""
    if not isinstance(entries, list) or not all(isinstance(e, Mapping) for e in entries):
        raise Refusal(f"{name}: expected a list of stations, each with role, id, mode, factory")
    stations = [_station(entry, name) for entry in entries]
    roles = [station.role for station in stations]
    if len(set(roles)) < len(roles):
        raise Refusal(f"{name}: two stations have the same role; expected one master, one slave")
    return stations


def _station(entry: Mapping[str, Any], name: str) -> Station:
    role, id_, mode = entry.get("role"), entry.get("id"), entry.get("mode")
    generation, channel = entry.get("generation", 1), entry.get("channel")
    if generation not in NAMES_OF:
        raise Refusal(f"{name}: generation is {generation!r}; expected 1 or 2")
    if generation == 1 and role not in ROLES:
        raise Refusal(f"{name}: role is {role!r}; expected master or slave")
    if generation == 2 and not (type(channel) is int and 0 <= channel < CHANNELS):
        raise Refusal(f"{name}: channel is {channel!r}; expected a whole number from 0 to 15")
    role = str(role if generation == 1 else channel)
    if id_ is not None and not (type(id_) is int and 0 <= id_ < 1 << 32):
        raise Refusal(f"{name}, {role}: id is {id_!r}; expected a whole number of 32 bits or null")
    if mode not in (None, "A", "b", "c"):
        raise Refusal(f"{name}, {role}: mode is {mode!r}; expected A, b, c or null")
    factory, gravity = entry.get("factory"), entry.get("gravity")
    if factory is not None:
        if not isinstance(factory, Mapping):
            raise Refusal(
                f"{name}, {role}: factory is not an object; expected phase, tilt, curve..."
            )
        values: dict[str, Any] = {
            k: finite(factory.get(k), (2,), f"{name}, {role}: {k}") for k in NAMES_OF[generation]
        }
        factory = Factory(**values, generation=generation)
        _check(factory, f"{name}, {role}")
    if gravity is not None:
        gravity = finite(gravity, (3,), f"{name}, {role}: gravity")
    rest = {key: entry[key] for key in OPTIONAL if key in entry}
    if (up := entry.get("up_by_geometry")) is not None:
        rest["up_by_geometry"] = finite(up, (3,), f"{name}, {role}: up_by_geometry")
    if generation == 2:
        rest |= {"generation": 2, "channel": channel}
    return Station(role, id_, mode, factory, gravity, **rest)


def _check(factory: Factory, where: str) -> None:
    try:
        rotor_parameters(factory)
    except Refusal as refusal:
        raise Refusal(f"{where}: {refusal}") from None


def finite(value: object, shape: tuple[int, ...], where: str) -> np.ndarray:
    """Finite numbers of this shape; `Refusal` where the value is none."""
    try:
        numbers = np.array(value, dtype=np.float64)
    except UNREADABLE:
        numbers = np.empty(0)
    if numbers.shape != shape or not np.isfinite(numbers).all():
        size = " x ".join(map(str, shape))
        raise Refusal(f"{where} is {value!r}; expected {size} finite numbers")
    return numbers


def is_crazyflie(text: str) -> bool:
    return CRAZYFLIE_TYPE in text


def _crazyflie(text: str, name: str, generations: tuple[int, ...]) -> Mapping[str, Any]:
    """The system configuration of stations of these generations in a text."""
    try:
        document = load_yaml(text)
    except UNREADABLE as error:
        raise Refusal(f"{name}: no YAML ({error}); expected {CRAZYFLIE_TYPE}") from None
    if not isinstance(document, Mapping) or document.get("type") != CRAZYFLIE_TYPE:
        raise Refusal(
            f"{name}: no {CRAZYFLIE_TYPE}; expected its type, version, systemType and calibs"
        )
    if str(document.get("version")) not in CRAZYFLIE_VERSIONS:
        raise Refusal(f"{name}: version is {document.get('version')!r}; expected 1")
    if document.get("systemType", 2) not in generations:
        expected = " or ".join(map(str, generations))
        raise Refusal(
            f"{name}: systemType is {document.get('systemType')!r}, second-generation (V2) base"
            f" stations; expected {expected}"
        )
    return document


Geometry = tuple[int | None, np.ndarray, np.ndarray]  # id, None where unknown; R, t in m


def crazyflie_geometry(text: str, name: str, generation: int) -> dict[int, Geometry]:
    """Poses of the stations in the room by key: 0 the master and 1 the slave, which must be there,
    or channels. Raises `Refusal` naming file and field; whether R is a rotation is not checked."""
    document = _crazyflie(text, name, (generation,))
    geos, keys = document.get("geos"), [*range(len(ROLES))]
    if generation == 2:
        keys = sorted(set(geos) & set(range(CHANNELS))) if isinstance(geos, Mapping) else []
    return {key: _geometry(document, key, name) for key in keys}


def _geometry(document: Mapping[str, Any], key: int, name: str) -> Geometry:
    geos, calibs = document.get("geos"), document.get("calibs")
    geo = geos.get(key) if isinstance(geos, Mapping) else None
    if not isinstance(geo, Mapping):
        raise Refusal(f"{name}: no geos.{key}; expected origin and rotation of two stations")
    t = finite(geo.get("origin"), (3,), f"{name}: geos.{key}.origin")
    R = finite(geo.get("rotation"), (3, 3), f"{name}: geos.{key}.rotation")
    calib = calibs.get(key) if isinstance(calibs, Mapping) else None
    uid = calib.get("uid") if isinstance(calib, Mapping) else None
    return (uid or None) if type(uid) is int else None, R, t


def _of_crazyflie(text: str, name: str) -> list[Station]:
    """Stations with factory values, by rising key: master first. Raises `Refusal` naming file and
    field."""
    document = _crazyflie(text, name, (1, 2))
    generation, calibs = document.get("systemType", 2), document.get("calibs")
    most = len(ROLES) if generation == 1 else CHANNELS
    if not isinstance(calibs, Mapping) or not calibs:
        raise Refusal(f"{name}: no calibs; expected factory values of stations 0 and 1")
    unknown = sorted(str(key) for key in calibs if key not in range(most))
    if unknown:
        raise Refusal(
            f"{name}: calibs of station {', '.join(unknown)}; expected stations 0 to {most - 1}"
            " only"
        )
    stations = {
        int(key): _crazyflie_station(key, calibs[key], f"{name}: calibs.{key}", generation)
        for key in sorted(calibs)
    }
    ups = _ups(document.get("geos"))
    if generation == 2 or len(ups) == len(ROLES):
        stations = {k: replace(one, up_by_geometry=ups.get(k)) for k, one in stations.items()}
    return list(stations.values())


def _ups(geos: object) -> dict[int, np.ndarray]:
    """Ways up in the frames of the stations, by key, where a pose is given."""
    ups = {}
    for key, geo in geos.items() if isinstance(geos, Mapping) else ():
        with suppress(*UNREADABLE):
            R = np.array(geo["rotation"], dtype=np.float64)
            if R.shape == (3, 3) and np.allclose(R @ R.T, np.eye(3), atol=1e-3):
                ups[key] = R[2]
    return ups


def _crazyflie_station(key: int, entry: object, where: str, generation: int) -> Station:
    """One entry of `calibs`."""
    if not isinstance(entry, Mapping):
        raise Refusal(f"{where} is {entry!r}; expected uid and sweeps")
    uid, sweeps = entry.get("uid"), entry.get("sweeps")
    if type(uid) is not int or not 0 <= uid < 1 << 32:
        raise Refusal(f"{where}.uid is {uid!r}; expected a whole number of 32 bits")
    if not isinstance(sweeps, list) or len(sweeps) != 2:
        two = "azimuth and elevation" if generation == 1 else "one a plane"
        raise Refusal(f"{where}.sweeps: expected a list of two, {two}")
    values: dict[str, Any] = {value: _pair(sweeps, value, where) for value in NAMES_OF[generation]}
    factory = Factory(**values, generation=generation)
    _check(factory, where)
    if generation == 2:
        return Station(str(key), uid or None, factory=factory, generation=2, channel=key)
    return Station(ROLES[key], id=uid or None, factory=factory)


def _pair(sweeps: list[object], value: str, where: str) -> np.ndarray:
    values = [_value(sweep.get(value)) if isinstance(sweep, Mapping) else None for sweep in sweeps]
    for axis, one in enumerate(values):
        whole = isinstance(one, int) and not isinstance(one, bool)
        if not whole and not (isinstance(one, float) and np.isfinite(one)):
            raise Refusal(f"{where}.sweeps[{axis}].{value} is {one!r}; expected a number")
    return finite(values, (2,), f"{where}.sweeps.{value}")


def _value(cell: object) -> object:
    """A number, also one of YAML 1.2 that PyYAML leaves as text: -.5, 1e-3."""
    with suppress(ValueError):
        return number(cell) if isinstance(cell, str) else cell
    return cell
