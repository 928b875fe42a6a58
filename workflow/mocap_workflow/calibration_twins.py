"""Twins of calibrations out of the file of twins: what each inherits."""

from __future__ import annotations

from collections.abc import Mapping

from mocap_metrology.common.entries import TwinsFile, read_entry
from mocap_metrology.common.faults import Faults
from mocap_metrology.lighthouse.simulate.network_twin import NetworkTwin
from mocap_metrology.lighthouse.simulate.twin import LighthouseTwin

CalibrationTwin = LighthouseTwin | NetworkTwin


def calibration_twin(document: TwinsFile, name: str) -> CalibrationTwin:
    """A twin of the file of twins, with the keys it inherits from other entries; one with a number
    of `stations`, by itself or by them, is of the second generation."""
    entry = _entry(document, name)
    kind: type[CalibrationTwin] = NetworkTwin if "stations" in entry else LighthouseTwin
    return read_entry(kind, entry, f"twin {name}")


def twin_from_mapping(mapping: Mapping[str, object], name: str = "twin") -> LighthouseTwin:
    """A twin of its keys; setups and defaults are merged before."""
    return read_entry(LighthouseTwin, mapping, f"twin {name}")


def _entry(document: TwinsFile, name: str) -> dict[str, object]:
    """All keys of a twin: its own win over those of the twin that it is `like`, these over its
    setup's, and these over the defaults, which are of the first generation; nested keys one by one.
    A `factory` may name an entry of `factories`."""
    where = f"twin {name}"
    entries, setups = document["twins"], document.get("setups", {})
    factories = document.get("factories", {})
    entry = dict(entries[name])
    if "like" in entry:
        like = entry.pop("like")
        if not isinstance(like, str) or like not in entries or "like" in entries[like]:
            raise Faults([f"{where}: like: {like!r}, expected a twin without a key like"])
        entry = _merged(entries[like], entry)
    setup = entry.get("setup")
    if setup is not None and not (isinstance(setup, str) and setup in setups):
        raise Faults([f"{where}: setup: {setup!r}, expected one of {', '.join(setups)}"])
    of_setup = setups[setup] if setup is not None else {}
    if "stations" in {**of_setup, **entry}:  # the defaults are of the first generation
        return _merged(of_setup, entry)
    defaults = document.get("defaults", {}).get("calibration") or {}
    entry = _merged(_merged(defaults, of_setup), entry)
    for role in ("master", "slave"):
        station = entry.get(role)
        if isinstance(station, Mapping) and isinstance(station.get("factory"), str):
            named = station["factory"]
            if named not in factories:
                known = ", ".join(factories)
                raise Faults([f"{where}: {role}.factory: {named!r}, expected one of {known}"])
            entry[role] = {**station, "factory": factories[named]}
    return entry


def _merged(low: Mapping[str, object], high: Mapping[str, object]) -> dict[str, object]:
    both = {**low, **high}
    for key, value in high.items():
        under = low.get(key)
        if isinstance(value, Mapping) and isinstance(under, Mapping):
            both[key] = {**under, **value}
    return both
