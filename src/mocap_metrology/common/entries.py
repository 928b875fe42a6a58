"""The file of twins and its entries: reading of values, and messages on wrong ones.

A number may be text (`1e-6` arrives from YAML as text); a key without a value counts as absent.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar, TypeVar, get_args

import pydantic
from pydantic import BaseModel, BeforeValidator, ConfigDict, ValidationError, model_validator
from pydantic.fields import FieldInfo
from pydantic_core import CoreSchema, core_schema

from mocap_metrology.common.documents import load_yaml
from mocap_metrology.common.faults import Faults, Loc, Unfit, misfits, shown, unknown

TwinsFile = dict[str, dict[str, Any]]  # its sections
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*")


def load_twins(path: str | None) -> TwinsFile:
    """The file of twins: `twins` by name, `defaults` by kind, `setups` and `factories` by name.
    What they hold is for those who make them to judge."""
    sections = ("defaults", "factories", "setups", "twins")
    if path is None:
        return {section: {} for section in sections}
    try:
        content = load_yaml(Path(path).read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise Faults([f"{path}: no such file; expected the file of twins"]) from None
    except (OSError, UnicodeDecodeError) as error:
        raise Faults([f"{path}: {error}; expected the file of twins"]) from None
    except ValueError as error:
        raise Faults([f"{path}: no readable YAML: {error}"]) from None
    if not isinstance(content, dict) or not isinstance(content.get("twins"), dict):
        raise Faults([f"{path}: no section twins; expected twins: with a name for each"])
    faults = [
        f"{path}, section {key}: {unknown(key, sections)}" for key in content.keys() - {*sections}
    ]
    content = {section: content.get(section) or {} for section in sections}
    for section, entries in content.items():
        if not isinstance(entries, dict):
            what = shown(str(entries))
            faults.append(f"{path}, section {section}: {what}, expected names with settings")
            continue
        faults += [
            f'{path}, {section}, {shown(str(name))}: expected a name of letters, digits, "_", "."'
            f' and "-", and a section of settings'
            for name, settings in entries.items()
            if not (NAME.fullmatch(str(name)) and isinstance(settings, dict))
        ]
    if faults:
        raise Faults(faults)
    return content


class Entry(BaseModel):
    """Keys with values."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", use_attribute_docstrings=True, arbitrary_types_allowed=True
    )
    MISSING: ClassVar[str] = "{} is missing"
    BEFORE_KEY: ClassVar[str] = ": "  # between the name of this entry and a key of it

    @model_validator(mode="before")
    @classmethod
    def _without_empty(cls, values: object) -> object:
        if isinstance(values, Mapping):
            return {str(key): value for key, value in values.items() if value is not None}
        return values

    @classmethod
    def fields_by_key(cls) -> dict[str, FieldInfo]:
        """All fields by their keys."""
        return {field.alias or name: field for name, field in cls.model_fields.items()}


class Read:
    """How a value is read that is annotated with it: `read` returns it, or raises `Unfit`."""

    def read(self, value: object) -> object:
        raise NotImplementedError

    @property
    def expected(self) -> str:
        """The message for the user."""
        raise NotImplementedError

    def limits(self) -> dict[str, float]:
        """What JSON Schema calls its range."""
        raise NotImplementedError

    def __get_pydantic_core_schema__(
        self, source: object, handler: pydantic.GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_before_validator_function(self.read, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: pydantic.GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return handler(schema) | self.limits()


@dataclass(frozen=True)
class Number(Read):
    """A number in a range, both ends included; `positive`: greater than zero."""

    low: float = 0.0
    high: float = math.inf
    positive: bool = False

    @property
    def expected(self) -> str:
        words = f"a number from {self.low:g} to {self.high:g}"
        words = words.replace(" from 0 to inf", " >= 0").replace(" from -inf to inf", "")
        return "a number > 0" if self.positive else words

    def read(self, value: object) -> float:
        try:
            found = math.nan if isinstance(value, bool) else float(value)  # type: ignore[arg-type]
        except (TypeError, ValueError, OverflowError):
            found = math.nan
        if not self.low <= found <= self.high or math.isinf(found) or (self.positive and not found):
            raise Unfit(self.expected, value)
        return found

    def limits(self) -> dict[str, float]:
        low = {"exclusiveMinimum": 0.0} if self.positive else {"minimum": self.low}
        return {k: v for k, v in (low | {"maximum": self.high}).items() if math.isfinite(v)}


@dataclass(frozen=True)
class Whole(Read):
    """A whole number in a range."""

    low: int = 0
    high: int | None = None

    @property
    def expected(self) -> str:
        to = f">= {self.low}" if self.high is None else f"from {self.low} to {self.high}"
        return f"a whole number {to}"

    def read(self, value: object) -> int:
        high = math.inf if self.high is None else self.high
        if not isinstance(value, int) or isinstance(value, bool) or not self.low <= value <= high:
            raise Unfit(self.expected, value)
        return value

    def limits(self) -> dict[str, float]:
        low: dict[str, float] = {"minimum": self.low}
        return low if self.high is None else low | {"maximum": self.high}


def one_of(choices: Iterable[str], expected: str = "") -> BeforeValidator:
    """One of these words."""
    known = tuple(choices)

    def check(value: object) -> object:
        if value not in known:
            raise Unfit(expected or f"one of {', '.join(known)}", value)
        return value

    return BeforeValidator(check, json_schema_input_type=str)


def some_of(known: Iterable[str]) -> BeforeValidator:
    """Some of these keys."""
    known = tuple(known)

    def check(value: object) -> object:
        for key in value if isinstance(value, Mapping) else ():
            if key not in known:
                raise ValueError(f"unknown key {key!r}, expected one of {', '.join(known)}")
        return value

    return BeforeValidator(check)


def list_of(count: int, expected: str) -> BeforeValidator:
    """A list of so many values."""

    def check(value: object) -> object:
        if not isinstance(value, list | tuple) or len(value) != count:
            raise Unfit(expected, value)
        return tuple(value)

    return BeforeValidator(check)


Text = Annotated[str, BeforeValidator(str)]
NonNegative = Annotated[float, Number()]
Positive = Annotated[float, Number(positive=True)]
AnyNumber = Annotated[float, Number(-math.inf)]


OfKind = TypeVar("OfKind", bound=Entry)


def read_entry(kind: type[OfKind], mapping: object, where: str) -> OfKind:
    """The entry; `Faults` names everything wrong, each line beginning with `where`."""
    try:
        return kind.model_validate(mapping)
    except ValidationError as error:
        raise Faults(_lines(error, kind, where)) from None


def _lines(error: ValidationError, kind: type[Entry], where: str) -> list[str]:
    lines: list[str] = []
    missing: dict[str, list[str]] = {}
    for one in misfits(error):
        at, between, key, of = _place(one.loc, kind, where)
        cause = one.cause
        if one.kind == "missing" and of:
            missing.setdefault(f"{at}: {of.MISSING}", []).append(key)
        elif one.kind == "extra_forbidden" and of:
            known = ", ".join(of.fields_by_key())
            lines.append(f"{at}: unknown key {key!r}, expected one of {known}")
        elif isinstance(cause, Unfit):
            what = f"{cause.value!r}, expected {cause.expected}"
            lines.append(f"{at}{between}{key}{cause.at}: {what}")
        else:
            what = str(cause or f"{one.value!r}, expected keys with values")
            lines.append(f"{at}{between}{key}: {what}")
    return lines + [line.format(", ".join(keys)) for line, keys in missing.items()]


def _place(loc: Loc, kind: type[Entry], where: str) -> tuple[str, str, str, type[Entry] | None]:
    """The entry that contains a key, with its place in words, the path between, and the key."""
    of: type[Entry] | None = kind
    between, key = "", ""
    for part in (part for part in loc if isinstance(part, str)):
        if key:
            of = entry_in(of.fields_by_key()[key].annotation) if of else None
            where, between = f"{where}{between}{key}", of.BEFORE_KEY if of else "."
        else:
            between = ": "
        key = part
    return where, between, key, of


def entry_in(kind: object) -> type[Entry] | None:
    """The entry among the types that a value may have."""
    for one in get_args(kind) or (kind,):
        if isinstance(one, type) and issubclass(one, Entry):
            return one
    return None
