"""Common parts of sections of settings: reading of values, and messages on wrong ones.

Values from `--config key='{inner: value}'` arrive as text, `results=2024` as a number, an empty
value as None. So every value is first converted to the type of its setting, then checked.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import NoneType, UnionType
from typing import Annotated, Literal, TypeGuard, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt
from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)
from pydantic.fields import FieldInfo

from mocap_metrology.common.faults import Loc, closest_word, misfits, quoted, unknown

WORDS = {"true": True, "yes": True, "on": True, "false": False, "no": False, "off": False}
UNITS = {"s": "seconds", "mm": "mm", "m": "m", "hz": "Hz", "mrad": "mrad"}
WHOLE = "whole"  # context in which every key must be there
ABSENT = object()


@dataclass(frozen=True)
class Words:
    """Description of a setting, beyond its type, for errors and the manual."""

    expected: str
    range: str = ""


class Section(BaseModel):
    """Settings by name."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", strict=True, allow_inf_nan=False, use_attribute_docstrings=True
    )

    @model_validator(mode="before")
    @classmethod
    def _every_key(cls, values: object, info: ValidationInfo[str | None]) -> object:
        if info.context == WHOLE and isinstance(values, Mapping):
            return dict.fromkeys(cls.model_fields, ABSENT) | dict(values)
        return values

    @field_validator("*", mode="before")
    @classmethod
    def _of_text(cls, value: object, info: ValidationInfo[str | None]) -> object:
        return coerced(value, cls.model_fields[str(info.field_name)].annotation)


def is_section(kind: object) -> TypeGuard[type[Section]]:
    """Whether a setting is a section of its own."""
    return isinstance(kind, type) and issubclass(kind, Section)


def fields(section: type[Section], prefix: str = "") -> Iterator[tuple[str, FieldInfo]]:
    """All settings that hold a value, by dotted name."""
    for key, field in section.model_fields.items():
        if is_section(field.annotation):
            yield from fields(field.annotation, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", field


@dataclass(frozen=True)
class Unique:
    """Check of a list: no value twice, and at least this one or so many."""

    always: str = ""
    least: int = 0

    def __call__(self, values: tuple[object, ...]) -> tuple[object, ...]:
        few = len(values) < self.least or (self.always and self.always not in values)
        if few or len(set(values)) < len(values):
            raise ValueError("too few, or one repeated")
        return values


def coerced(value: object, kind: object) -> object:
    """The value as the type of the setting where that is possible, else unchanged."""
    if isinstance(value, str):
        value = value.strip()
    if get_origin(kind) is Annotated:  # of the items of a list
        kind = get_args(kind)[0]
    if isinstance(kind, UnionType):
        if value in (None, "", "null"):
            return None
        (kind,) = (one for one in get_args(kind) if one is not NoneType)
    if get_origin(kind) is tuple:
        items = value.split(",") if isinstance(value, str) else value
        of = get_args(kind)[0]
        return tuple(coerced(i, of) for i in items) if isinstance(items, list | tuple) else value
    choices = get_args(kind) if get_origin(kind) is Literal else ()
    if choices and value is False and "off" in choices:
        return "off"  # YAML reads a bare off as false
    if kind is bool:
        return WORDS.get(value.casefold(), value) if isinstance(value, str) else value
    if kind is str or isinstance(next(iter(choices), None), str):
        return str(value) if isinstance(value, int) and not isinstance(value, bool) else value
    return value if is_section(kind) else _number(value, whole=kind is not float)


def _number(value: object, whole: bool) -> object:
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


def words_of(field: FieldInfo) -> Words | None:
    """Description of a setting."""
    return next((item for item in field.metadata if isinstance(item, Words)), None)


def choices_of(kind: object) -> tuple[str, ...]:
    """Values that a setting, or each of a list, may have; none where it is not one of a few."""
    inner = get_args(kind)[0] if get_origin(kind) is tuple else kind
    return tuple(map(str, get_args(inner))) if get_origin(inner) is Literal else ()


def or_list(choices: Sequence[object]) -> str:
    """`a, b or c`."""
    *most, last = map(str, choices)
    return f"{', '.join(most)} or {last}"


def limits(field: FieldInfo) -> str:
    """`from 0 to 4`, `> 0 and <= 1`, or nothing."""
    low: str | None = None
    words = []
    for limit in field.metadata:
        match limit:
            case Ge(ge=value):
                low = f"{value:.15g}"
                words.append(f">= {low}")
            case Gt(gt=value):
                words.append(f"> {value:.15g}")
            case Lt(lt=value):
                words.append(f"< {value:.15g}")
            case Le(le=value) if low is not None:
                words = [f"from {low} to {value:.15g}"]
            case Le(le=value):
                words.append(f"<= {value:.15g}")
    return " and ".join(words)


def expected(name: str, field: FieldInfo) -> str:
    """What a value of a setting should be, in words."""
    kind = field.annotation
    words = words_of(field)
    if words is not None:
        return words.expected
    for item in field.metadata:
        if isinstance(item, AfterValidator) and isinstance(item.func, Unique):
            choices = ", ".join(choices_of(kind))
            among = f", {item.func.always} among them" if item.func.always else ""
            return f"a list of {choices}, each at most once{among}"
    if kind is bool:
        return "true or false"
    if get_origin(kind) is Literal:
        return or_list(get_args(kind))
    unit = UNITS.get(name.rpartition("_")[2], "") if "_" in name else ""
    noun = "a whole number" if kind is int else f"a number of {unit}" if unit else "a number"
    return f"{noun} {limits(field)}"


def faults(
    error: ValidationError, section: type[Section], config: Mapping[str, object]
) -> list[str]:
    """A line for each wrong key, in the order of the settings; unknown ones come first."""
    places = dict(_fault(one.loc, section, config) for one in misfits(error))
    return [f"config, key {line}" for line in sorted(places, key=lambda line: places[line])]


def _fault(
    loc: Loc, section: type[Section], config: Mapping[str, object]
) -> tuple[str, tuple[int, ...]]:
    """The fault of a key, and its place among the settings."""
    name, of = "", section
    place: tuple[int, ...] = ()
    value: object = config
    for key in map(str, loc):
        name, known = f"{name}.{key}" if name else key, list(of.model_fields)
        if key not in known:
            return f"{name}: {_unknown_key(key, of, section)}", (*place, -1)
        place = (*place, known.index(key))
        is_there = isinstance(value, Mapping) and key in value
        value = value[key] if isinstance(value, Mapping) and is_there else None
        field = of.model_fields[key]
        if not is_section(field.annotation):
            what = quoted(value) if is_there else "missing"
            return f"{name}: {what}; expected {expected(key, field)}", place
        of = field.annotation
    keys = ", ".join(of.model_fields)
    return f"{name}: {quoted(value)}; expected a section with {keys}", place


def _unknown_key(key: str, of: type[Section], whole: type[Section]) -> str:
    if closest_word(key, of.model_fields) is None:
        inner = {name.rpartition(".")[2]: name for name, _ in fields(whole)}
        guess = closest_word(key, inner)
        if guess is not None:
            return f"unknown; did you mean {inner[guess]}?"
    return unknown(key, of.model_fields)
