"""Factory values from the system configuration that Bitcraze's tools write (YAML).

    type: lighthouse_system_configuration
    version: '1'
    systemType: 1
    calibs:
      0: {uid: 4255386550, sweeps: [{phase: ..., tilt: ..., curve: ..., gibmag: ..., gibphase: ...},
                                    {...}]}

[crazyflie-lib-python, cflib/localization/lighthouse_config_manager.py]. Station 0 is the one that
flashes first, so the master; sweep 0 is the azimuth; uid is the id that its flashes carry. A file
without systemType is of second-generation stations, as its own reader takes it. `geos`, poses in
the room by the Crazyflie itself, are left out.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.records import ROLES, Factory, Station
from mocap_metrology.lighthouse.rotor import check

TYPE = "lighthouse_system_configuration"
VERSIONS = ("1", "2")
FIRST_GENERATION = 1
NAMES = tuple(Factory.__dataclass_fields__)


def is_crazyflie(text: str) -> bool:
    """Whether a text is a system configuration of a Crazyflie."""
    return TYPE in text


def stations_of(text: str, name: str) -> list[Station]:
    """Stations with factory values, master first. Raises `Refusal` naming file and field."""
    import yaml

    try:
        given = yaml.safe_load(text)
    except yaml.YAMLError as error:
        reason = " ".join(str(error).split())
        raise Refusal(f"{name}: no YAML ({reason}); expected {TYPE}") from None
    if not isinstance(given, Mapping) or given.get("type") != TYPE:
        raise Refusal(f"{name}: no {TYPE}; expected its type, version, systemType and calibs")
    if str(given.get("version")) not in VERSIONS:
        raise Refusal(f"{name}: version is {given.get('version')!r}; expected 1")
    if given.get("systemType", 2) != FIRST_GENERATION:
        raise Refusal(
            f"{name}: systemType is {given.get('systemType')!r}, second-generation (V2) base"
            " stations; expected 1"
        )
    calibs = given.get("calibs")
    if not isinstance(calibs, Mapping) or not calibs:
        raise Refusal(f"{name}: no calibs in it; expected factory values of stations 0 and 1")
    unknown = sorted(str(key) for key in calibs if key not in (0, 1))
    if unknown:
        raise Refusal(
            f"{name}: calibs of station {', '.join(unknown)}; expected stations 0 and 1 only"
        )
    return [_station(key, calibs[key], f"{name}: calibs.{key}") for key in sorted(calibs)]


def _station(key: int, given: Any, where: str) -> Station:
    """One entry of `calibs`."""
    if not isinstance(given, Mapping):
        raise Refusal(f"{where} is {given!r}; expected uid and sweeps")
    uid, sweeps = given.get("uid"), given.get("sweeps")
    if type(uid) is not int or not 0 <= uid < 1 << 32:
        raise Refusal(f"{where}.uid is {uid!r}; expected a whole number of 32 bits")
    if not isinstance(sweeps, list) or len(sweeps) != 2:
        raise Refusal(f"{where}.sweeps: expected a list of two, azimuth and elevation")
    factory = Factory(**{value: _pair(sweeps, value, where) for value in NAMES})
    try:
        check(factory)
    except Refusal as refusal:
        raise Refusal(f"{where}: {refusal}") from None
    return Station(ROLES[key], id=uid or None, factory=factory)


def _pair(sweeps: list[Any], value: str, where: str) -> np.ndarray:
    """A value of both sweeps."""
    found = [sweep.get(value) if isinstance(sweep, Mapping) else None for sweep in sweeps]
    for axis, number in enumerate(found):
        fits = isinstance(number, int | float) and not isinstance(number, bool)
        if not fits or not np.isfinite(number):
            raise Refusal(f"{where}.sweeps[{axis}].{value} is {number!r}; expected a number")
    return np.array(found, dtype=np.float64)
