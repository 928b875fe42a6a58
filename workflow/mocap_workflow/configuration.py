"""The configuration: config/config.yaml with what the command line lays over it.

Values from `--config key='{inner: value}'` arrive as text, `results=2024` as a number, an empty
value as None. So every value is first turned into what the schema asks for, then checked.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import jsonschema
import yaml

from mocap_workflow.faults import Faults, meant, shown, unknown

WORDS = {"true": True, "yes": True, "on": True, "false": False, "no": False, "off": False}


def load_schema(path: str | Path) -> dict[str, Any]:
    """A schema of workflow/schemas."""
    return yaml.safe_load(Path(path).read_text(encoding="utf-8"))


def checked(config: Mapping[str, Any], schema: Mapping[str, Any]) -> dict[str, Any]:
    """The configuration with every value of its schema's type; `Faults` names all wrong ones."""
    faults: list[str] = []
    result = _section(config, schema, "", faults)
    faults += [] if faults else _crossed(result)
    if faults:
        raise Faults(faults)
    result["results"] = os.path.normpath(result["results"])
    return result


def _crossed(result: Mapping[str, Any]) -> list[str]:
    """Limits of the verdict that leave no room for `usable`."""
    limits, faults = result.get("verdict", {}), []
    for key, good in limits.items():
        other = key.replace("good_", "usable_")
        if other != key and other in limits and good > limits[other]:
            most = f"verdict.{other} ({limits[other]:g})"
            faults.append(f"config, key verdict.{key}: {shown(good)}; expected at most {most}")
    return faults


def _section(
    values: Mapping[str, Any], schema: Mapping[str, Any], prefix: str, faults: list[str]
) -> dict[str, Any]:
    properties = schema["properties"]
    result: dict[str, Any] = {}
    faults += [
        f"config, key {prefix}{key}: {_unknown_key(str(key), prefix, schema)}"
        for key in values
        if key not in properties
    ]
    for key, inner in properties.items():
        where = f"config, key {prefix}{key}"
        if inner.get("type") == "object":
            keys = ", ".join(inner["properties"])
            if isinstance(values.get(key), Mapping):
                result[key] = _section(values[key], inner, f"{prefix}{key}.", faults)
            else:
                faults.append(f"{where}: {shown(values.get(key))}; expected a section with {keys}")
        elif key not in values:
            faults.append(f"{where}: missing; expected {inner['expected']}")
        else:
            result[key] = coerced(values[key], inner)
            if not fits(result[key], inner):
                faults.append(f"{where}: {shown(values[key])}; expected {inner['expected']}")
    return result


def _unknown_key(key: str, prefix: str, schema: Mapping[str, Any]) -> str:
    if not prefix and meant(key, schema["properties"]) is None:
        inner = {name.rpartition(".")[2]: name for name in leaves(schema)}
        guess = meant(key, inner)
        if guess is not None:
            return f"unknown; did you mean {inner[guess]}?"
    return unknown(key, schema["properties"])


def leaves(schema: Mapping[str, Any], prefix: str = "") -> Iterator[str]:
    """Dotted names of all keys that hold a value."""
    for key, inner in schema["properties"].items():
        if inner.get("type") == "object":
            yield from leaves(inner, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}"


def fits(value: Any, schema: Mapping[str, Any]) -> bool:
    """Whether the value keeps to its schema; infinite and not-a-number never do."""
    if isinstance(value, float) and not math.isfinite(value):
        return False
    return jsonschema.Draft202012Validator(schema).is_valid(value)


def coerced(value: Any, schema: Mapping[str, Any]) -> Any:
    """The value as the type its schema asks for where that is possible, else unchanged."""
    kinds = schema["type"] if isinstance(schema["type"], list) else [schema["type"]]
    if isinstance(value, str):
        value = value.strip()
    if value in (None, "", "null") and "null" in kinds:
        return None
    if "array" in kinds:
        items = value.split(",") if isinstance(value, str) else value
        if not isinstance(items, list):
            return value
        return [coerced(item, schema["items"]) for item in items]
    if "boolean" in kinds:
        return WORDS.get(value.casefold(), value) if isinstance(value, str) else value
    if "string" in kinds:
        return _text(value, schema)
    return _number(value, whole="integer" in kinds)


def _text(value: Any, schema: Mapping[str, Any]) -> Any:
    if value is False and "off" in schema.get("enum", ()):
        return "off"  # YAML reads a bare off as false
    return str(value) if isinstance(value, int) and not isinstance(value, bool) else value


def _number(value: Any, whole: bool) -> Any:
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        return value
    try:
        number = float(value)
    except (ValueError, OverflowError):
        return value
    if not whole:
        return number
    if isinstance(value, int):
        return value
    return int(number) if math.isfinite(number) and number.is_integer() else value
