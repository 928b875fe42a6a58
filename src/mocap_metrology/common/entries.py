"""The file of twins and its entries: reading of values, and messages on wrong ones.

A number may be text (`1e-6` arrives from YAML as text); a key without a value counts as absent.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, TypeVar, get_args

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    TypeAdapter,
    ValidationError,
)
from pydantic.fields import FieldInfo
from pydantic.json_schema import JsonSchemaValue, SkipJsonSchema
from pydantic_core import CoreSchema, core_schema

from mocap_metrology.common.documents import load_yaml
from mocap_metrology.common.faults import Faults, Unfit, misfits, quoted, unknown

TwinsFile = dict[str, dict[str, Any]]  # its sections
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*")
ENTRY = ConfigDict(
    extra="forbid",
    use_attribute_docstrings=True,
    arbitrary_types_allowed=True,
    validate_by_alias=True,
    validate_by_name=True,  # in Python; in a file by its key alone
)
MADE: Any = SkipJsonSchema()  # type: ignore[type-arg]  # marks a field that is no key: what the reader states


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
            what = quoted(str(entries))
            faults.append(f"{path}, section {section}: {what}, expected names with settings")
            continue
        faults += [
            f'{path}, {section}, {quoted(str(name))}: expected a name of letters, digits, "_", "."'
            f' and "-", and a section of settings'
            for name, settings in entries.items()
            if not (NAME.fullmatch(str(name)) and isinstance(settings, dict))
        ]
    if faults:
        raise Faults(faults)
    return content


class Entry(BaseModel):
    """Keys with values. A pydantic dataclass with the configuration `ENTRY` is one, too."""

    model_config = ENTRY | ConfigDict(frozen=True)


def is_entry(kind: object) -> bool:
    """Whether the value of a key has keys itself."""
    return hasattr(kind, "__pydantic_fields__")


def entry_in(kind: object) -> type | None:
    """The entry among the types that a value may have."""
    return next((one for one in get_args(kind) or (kind,) if is_entry(one)), None)


def fields_by_key(kind: type) -> dict[str, FieldInfo]:
    """All fields of an entry by their keys, but for those that are `MADE`."""
    fields: dict[str, FieldInfo] = kind.__pydantic_fields__  # type: ignore[attr-defined]
    keys = {field.alias or name: field for name, field in fields.items()}
    return {key: field for key, field in keys.items() if MADE not in field.metadata}


@dataclass(frozen=True)
class Number:
    """Annotation of a number in a range, both ends included; `positive`: greater than zero."""

    low: float = 0.0
    high: float = math.inf
    positive: bool = False
    whole: bool = False

    @property
    def expected(self) -> str:
        """The message for the user."""
        words = "a whole number" if self.whole else "a number"
        if self.positive:
            return f"{words} > 0"
        low, high = (str(n) if isinstance(n, int) else f"{n:g}" for n in (self.low, self.high))
        if self.high < math.inf:
            return f"{words} from {low} to {high}"
        return f"{words} >= {low}" if self.low > -math.inf else words

    def read(self, value: object) -> float:
        """The value as a number, or `Unfit`."""
        try:
            number: Any = value if self.whole else float(value)  # type: ignore[arg-type]
        except (TypeError, ValueError, OverflowError):
            number = math.nan
        other = isinstance(value, bool) or (self.whole and not isinstance(value, int))
        if other or not self.low <= number <= self.high or abs(number) == math.inf:
            raise Unfit(self.expected, value)
        if self.positive and not number:
            raise Unfit(self.expected, value)
        return number

    def __get_pydantic_core_schema__(
        self, source: object, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_before_validator_function(self.read, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        low = {"exclusiveMinimum": 0.0} if self.positive else {"minimum": self.low}
        ends = {k: v for k, v in (low | {"maximum": self.high}).items() if math.isfinite(v)}
        return handler(schema) | ends


def Whole(low: int = 0, high: float = math.inf) -> Number:
    """Annotation of a whole number in a range."""
    return Number(low, high, whole=True)


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


def list_of(
    count: int | None, expected: str, kind: type = object, distinct: bool = False
) -> BeforeValidator:
    """A list of so many values of a kind."""

    def check(value: object) -> object:
        items = tuple(value) if isinstance(value, list | tuple) else None
        right = items is not None and all(isinstance(one, kind) for one in items)
        if items is None or not right or (count is not None and len(items) != count):
            raise Unfit(expected, value)
        if distinct and len(set(items)) < len(items):
            raise Unfit(expected, value)
        return items

    return BeforeValidator(check)


Text = Annotated[str, BeforeValidator(str)]
NonNegative = Annotated[float, Number()]
Positive = Annotated[float, Number(positive=True)]
AnyNumber = Annotated[float, Number(-math.inf)]


OfKind = TypeVar("OfKind")


def read_entry(kind: type[OfKind], mapping: object, where: str, **made: object) -> OfKind:
    """The entry; `Faults` names everything wrong, each line beginning with `where`. made: values of
    its fields that are no keys."""
    values = _without_empty(mapping)
    lines: list[str] = []
    if isinstance(values, Mapping):
        lines = [_unknown(where, key, kind) for key in values if key in made]
        values = {**values, **made}
    try:
        entry: OfKind = TypeAdapter(kind).validate_python(values, by_alias=True, by_name=False)
    except ValidationError as error:
        raise Faults([*lines, *_lines(error, kind, where)]) from None
    if lines:
        raise Faults(lines)
    return entry


def _without_empty(value: object) -> object:
    if isinstance(value, Mapping):
        return {str(k): _without_empty(v) for k, v in value.items() if v is not None}
    return value


def _unknown(at: str, key: str, of: type) -> str:
    return f"{at}: unknown key {key!r}, expected one of {', '.join(fields_by_key(of))}"


def _lines(error: ValidationError, kind: type, where: str) -> list[str]:
    lines: list[str] = []
    missing: dict[str, list[str]] = {}
    for one in misfits(error):
        of: type | None = kind
        at, between, key = where, ": ", ""
        for part in (part for part in one.loc if isinstance(part, str)):
            if key:
                of = entry_in(fields_by_key(of)[key].annotation) if of else None
                at, between = f"{at}{between}{key}", "."
            key = part
        cause = one.cause
        if one.kind == "missing" and of:
            missing.setdefault(at, []).append(key)
        elif one.kind in ("extra_forbidden", "unexpected_keyword_argument") and of:
            lines.append(_unknown(at, key, of))
        elif isinstance(cause, Unfit):
            what = f"{cause.value!r}, expected {cause.expected}"
            lines.append(f"{at}{between}{key}{cause.at}: {what}" if key else f"{at}: {what}")
        else:
            what = str(cause or f"{one.value!r}, expected keys with values")
            lines.append(f"{at}{between}{key}: {what}" if key else f"{at}: {what}")
    return lines + [f"{at}: {', '.join(keys)} is missing" for at, keys in missing.items()]
