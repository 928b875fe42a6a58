"""Twins of recordings out of the file of twins."""

from __future__ import annotations

from collections.abc import Mapping

from mocap_metrology.accuracy.twin import BarTwin
from mocap_metrology.common.entries import fields_by_key, read_entry
from mocap_metrology.noise.twins.take import TakeTwin
from mocap_metrology.noise.twins.twin import Twin

AnyTwin = Twin | TakeTwin | BarTwin


def recording_twin(
    entry: Mapping[str, object], name: str, defaults: Mapping[str, object] | None = None
) -> AnyTwin:
    """A twin from its entry in the file of twins; missing keys have their defaults."""
    kinds: dict[str, type[AnyTwin]] = {"take": TakeTwin, "bar": BarTwin}
    kind = next((of for key, of in kinds.items() if key in entry), Twin)
    keys = fields_by_key(kind)
    common = {k: v for k, v in (defaults or {}).items() if kind is Twin or k in keys}
    if kind is BarTwin:
        common.pop("duration_s", None)  # of recordings at rest
    return read_entry(kind, {**common, **entry}, f"twin {name}", name=name)


def twin_from_mapping(mapping: Mapping[str, object], name: str = "twin") -> Twin:
    """A twin drawn from noise coefficients, of its entry alone."""
    return read_entry(Twin, mapping, f"twin {name}", name=name)


def take_twin_from_mapping(mapping: Mapping[str, object], name: str = "twin") -> TakeTwin:
    """A subset of a take, of its entry alone."""
    return read_entry(TakeTwin, mapping, f"twin {name}", name=name)
