"""What is made of the models: tables of config/README.md, and JSON Schemas for editors.

PYTHONPATH=workflow python -m mocap_workflow.document     (make docs)
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from decimal import Decimal
from pathlib import Path
from typing import Any, get_origin

from pydantic.fields import FieldInfo
from pydantic.json_schema import JsonSchemaValue, models_json_schema

from mocap_metrology.accuracy.twin import BarTwin
from mocap_metrology.common.entries import Number, entry_in, fields_by_key, is_entry
from mocap_metrology.common.sections import choices_of, fields, limits, words_of
from mocap_metrology.lighthouse.simulate.network_twin import NetworkTwin
from mocap_metrology.lighthouse.simulate.twin import FactoryValues, LighthouseTwin
from mocap_metrology.noise.twins.take import TakeTwin
from mocap_metrology.noise.twins.twin import Twin
from mocap_metrology.settings import Settings
from mocap_workflow.calibrations import CalibrationRow
from mocap_workflow.recordings import RecordingRow
from mocap_workflow.rows import SheetRow

ROOT = Path(__file__).resolve().parents[2]
MANUAL = ROOT / "config/README.md"
SCHEMAS = ROOT / "workflow/schemas"
KEYS = ["| key | default | range | meaning |", "|---|---|---|---|"]
TWINS: dict[str, type] = {
    "keys of twins of recordings": Twin,
    "keys of subsets of a take": TakeTwin,
    "keys of bars": BarTwin,
    "keys of twins of calibrations": LighthouseTwin,
    "keys of twins of second-generation stations": NetworkTwin,
}


def help_of(field: FieldInfo) -> str:
    """The description of a setting in one line."""
    return " ".join((field.description or "").split())


def value_text(value: object) -> str:
    """A default as config.yaml writes it."""
    if isinstance(value, tuple):
        return f"[{', '.join(map(value_text, value))}]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        text = format(Decimal(repr(value)), "f")
        return text.removesuffix(".0")
    return str(value)


def range_text(field: FieldInfo) -> str:
    """What a setting may be, in few words."""
    words = words_of(field)
    if words and words.range:
        return words.range
    kind = field.annotation
    choices = ", ".join(f"`{choice}`" for choice in choices_of(kind))
    if choices:
        return f"of {choices}" if get_origin(kind) is tuple else choices
    if kind is bool:
        return "`true`, `false`"
    limit = limits(field).replace(" and ", ", ").removeprefix("from ")
    return f"whole, {limit}" if kind is int else limit


def settings_table() -> list[str]:
    """Every key of config.yaml."""
    lines = [*KEYS]
    for name, field in fields(Settings):
        default = "nothing" if field.default is None else f"`{value_text(field.default)}`"
        lines.append(f"| `{name}` | {default} | {range_text(field)} | {help_of(field)} |")
    return lines


def columns_table(kind: type[SheetRow]) -> list[str]:
    """Every column of a sheet."""
    rows = [f"| `{name}` | {help_of(field)} |" for name, field in kind.columns().items()]
    return ["| column | what it holds |", "|---|---|", *rows]


def _keys(kind: type, prefix: str) -> Iterator[str]:
    for key, field in fields_by_key(kind).items():
        name, inner = f"{prefix}{key}", entry_in(field.annotation)
        value = field.get_default(call_default_factory=True)
        default = "needed" if field.is_required() else f"`{value_text(value)}`"
        if value in (None, "", (), {}) or is_entry(type(value)):
            default = "none" if not is_entry(type(value)) else "as below"
        yield f"| `{name}` | {default} | {_limits(field)} | {help_of(field)} |"
        if inner is not None and name != "slave":  # which has the keys of the master
            yield from _keys(inner, f"{name}.")


def _limits(field: FieldInfo) -> str:
    for reader in field.metadata:
        if isinstance(reader, Number):
            words = reader.expected.removeprefix("a ").replace("from ", "")
            return words.replace("whole number", "whole,").removeprefix("number ")
    return ""


def blocks() -> dict[str, list[str]]:
    """Tables of the manual by the name of their place in it."""
    return {
        "settings": settings_table(),
        "columns of recordings.tsv": columns_table(RecordingRow),
        "columns of calibrations.tsv": columns_table(CalibrationRow),
        **{name: [*KEYS, *_keys(kind, "")] for name, kind in TWINS.items()},
    }


def manual(text: str) -> str:
    """The manual with these tables between `<!-- made: name -->` and `<!-- end -->`."""
    for name, lines in blocks().items():
        before, start, rest = text.partition(f"<!-- made: {name} -->\n")
        _, end, after = rest.partition("\n<!-- end -->")
        assert start and end, name
        text = "".join((before, start, "\n".join(lines), end, after))
    return text


def _plain(schema: Any) -> Any:
    """Without titles that repeat the name and defaults of sections, whose keys have theirs;
    descriptions in one line, tuples of like items and values that may be null in short form."""
    if isinstance(schema, list):
        return [_plain(one) for one in schema]
    if not isinstance(schema, dict):
        return " ".join(schema.split()) if isinstance(schema, str) else schema
    plain = {k: _plain(v) for k, v in schema.items() if not (k == "title" and isinstance(v, str))}
    if "$ref" in plain and isinstance(plain.get("default"), dict):
        del plain["default"]
    first, *others = plain.get("prefixItems", ()) or [None]
    if others and all(other == first for other in others):
        plain = {"items" if k == "prefixItems" else k: v for k, v in plain.items()}
        plain["items"] = first
    kind, *null = plain.get("anyOf", ()) or [{}]
    if null == [{"type": "null"}] and "type" in kind and "enum" not in kind:
        del plain["anyOf"]
        plain = kind | {"type": [kind["type"], "null"]} | plain
    return plain


def twins_schema() -> JsonSchemaValue:
    """The file of twins. A key may come from a default, so none is required."""
    kinds: list[Any] = [Twin, TakeTwin, BarTwin, LighthouseTwin, NetworkTwin, FactoryValues]
    refs, shared = models_json_schema([(kind, "validation") for kind in kinds])
    of = {kind: refs[kind, "validation"] for kind in kinds}
    for definition in shared["$defs"].values():
        definition.pop("required", None)
    for kind in (LighthouseTwin, NetworkTwin):
        properties = shared["$defs"][kind.__name__]["properties"]
        properties["like"] = {"type": "string", "description": "Twin whose keys are inherited."}
    factory = shared["$defs"]["StationTwin"]["properties"]["factory"]
    factory["anyOf"].append({"type": "string"})
    named = {"type": "object", "additionalProperties": {}}
    twin = {"anyOf": [of[kind] for kind in kinds[:-1]]}
    defaults = {"recording": of[Twin], "calibration": of[LighthouseTwin]}
    return {
        "type": "object",
        "properties": {
            "defaults": {"type": "object", "properties": defaults},
            "factories": named | {"additionalProperties": of[FactoryValues]},
            "setups": named
            | {"additionalProperties": {"anyOf": [of[LighthouseTwin], of[NetworkTwin]]}},
            "twins": named | {"additionalProperties": twin},
        },
        "required": ["twins"],
        "additionalProperties": False,
        "$defs": shared["$defs"],
    }


def schemas() -> dict[str, str]:
    """Files of workflow/schemas."""
    by_name = {"config": Settings.model_json_schema(), "twins": twins_schema()}
    start = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    plain = {name: _plain(start | schema) for name, schema in by_name.items()}
    return {
        f"{name}.schema.json": json.dumps(schema, ensure_ascii=False, indent=1) + "\n"
        for name, schema in plain.items()
    }


def main() -> None:
    """Write all of it."""
    MANUAL.write_text(manual(MANUAL.read_text(encoding="utf-8")), encoding="utf-8")
    SCHEMAS.mkdir(exist_ok=True)
    for name, text in schemas().items():
        (SCHEMAS / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
