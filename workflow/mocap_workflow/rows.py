"""Rows of both sheets: every column with its type, its pattern and its help.

A row is made of the texts of its cells. Its attributes are named like the columns, but for
`paths` and `twin`, which are in column `path`, and `accept_truncated`, which is in `truncated`.
"""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar, Literal, TypeVar, get_origin

import pydantic
from pydantic.fields import FieldInfo

from mocap_metrology.common import sheets
from mocap_metrology.common.faults import (
    Faults,
    Unfit,
    Unmatched,
    misfits,
    quoted,
    shortened,
    unknown,
)
from mocap_metrology.common.paths import DRIVE, exists, is_file, of_windows
from mocap_workflow import remote

SIMULATE = "simulate:"


@dataclass(frozen=True)
class Cell:
    """The form of a cell that is filled in, in code and in words."""

    pattern: str
    expected: str


@dataclass(frozen=True)
class Needs:
    """A cell is filled in only where another one is; what: of that one, in words."""

    column: str
    what: str


MEASURED = "measured"  # annotation of a cell that is filled in of real recordings alone


@dataclass(frozen=True)
class Place:
    """The place of a row, and what its cells may name."""

    sheet: str
    number: int
    cells: Mapping[str, str]
    names: Collection[str]  # of all rows
    first: Mapping[str, int]  # row of the first occurrence of a name, upper and lower case alike
    twins: Collection[str]

    @property
    def is_simulated(self) -> bool:
        """Whether the row names a twin, existing or not."""
        return self.cells["path"].startswith(SIMULATE)


Info = pydantic.ValidationInfo[Place]


def beside(sheet: str, path: str) -> str:
    """`path` as seen from the working folder, relative ones being relative to the sheet."""
    return os.path.normpath(Path(sheet).parent / path)


def existing(path: str, info: Info, any_kind: bool = False) -> str:
    """The path beside the sheet, or in S3; refused if it is no file or one that Snakemake cannot
    name.

    `any_kind` leaves what is there but no file to the rule that reads it.
    """
    if remote.in_s3(path):
        return remote.checked(path)
    here = beside(info.context.sheet, path)
    if set("<>{}") & set(here):
        raise Unfit("a path without any of < > { }", path)
    if not exists(here):
        what = f"{shortened(here)} does not exist{_instead(info.context.sheet, path)}"
        raise Unfit(f"a file ({what})", path)
    if not (any_kind or is_file(here)):
        raise Unfit(f"a file ({shortened(here)} is not a file)", path)
    return here


def _instead(sheet: str, path: str) -> str:
    """What a path that is not there was probably meant to be, or nothing."""
    if hint := of_windows(path if DRIVE.match(path) else beside(sheet, path)):
        return f"; {hint}"
    parts = [part.strip() for part in path.split(",")]
    if len(parts) > 1 and all(exists(beside(sheet, part)) for part in parts):
        return '; separate files with ";"'
    return ""


def file_or_none(path: str | None, info: Info) -> str | None:
    return existing(path, info) if path else None


def _rotation(text: str | None) -> str | None:
    """Refuse what states no rotation of the second end of a bar in the first."""
    from mocap_metrology.accuracy.bar import BarEntry
    from mocap_metrology.common.errors import Refusal

    try:
        _ = BarEntry("", bar_pose=text).pose
    except Refusal as refusal:
        raise Unfit(str(refusal).partition("; expected ")[2]) from None
    return text


def with_point(text: str | None) -> str | None:
    """A number with a decimal point, as it may have a comma."""
    return text.replace(",", ".") if text else text


def _above_zero(length: float | None) -> float | None:
    if length == 0:
        raise Unfit("a number of mm > 0 or nothing")
    return length


def each_once(what: str) -> pydantic.AfterValidator:
    """For parts of a cell: none is empty and none occurs twice."""

    def check(parts: tuple[str, ...]) -> tuple[str, ...]:
        if "" in parts or len(set(parts)) < len(parts):
            raise Unfit(f"{what}, none empty, none repeated")
        return parts

    return pydantic.AfterValidator(check)


# Names become wildcards. If the end of one repeats 20 times, Snakemake assumes endless recursion.
NAME = Cell(
    r"(?=.{1,200}$)(?!.*?(.{1,10}?)\1{19}$)[A-Za-z0-9][A-Za-z0-9_.-]*",
    'a name of letters, digits, "_", "." and "-", 200 at most, that begins with a letter or digit '
    "and does not end in 20 repetitions",
)
Name = Annotated[str, NAME]
FileOrNothing = Annotated[str | None, pydantic.AfterValidator(file_or_none)]
Labels = Annotated[tuple[str, ...], each_once('labels separated by ";"')]
Unit = Annotated[Literal["mm", "m"] | None, Cell("mm|m", "mm, m or nothing")]
NUMBER = r"([0-9]+([.,][0-9]*)?|[.,][0-9]+)([eE][+-]?[0-9]+)?"
Millimetres = Annotated[
    float | None,
    Cell(NUMBER, "a number of mm or nothing"),
    pydantic.BeforeValidator(with_point),
]
OF_BAR = Needs("bar", "a bar")
Length = Annotated[Millimetres, OF_BAR, pydantic.AfterValidator(_above_zero)]
LengthError = Annotated[Millimetres, Needs("length_mm", "a length")]
BarPose = Annotated[str | None, OF_BAR, pydantic.AfterValidator(_rotation)]


def _own_name(name: str, info: Info) -> str:
    """Upper and lower case are one name to some file systems."""
    first = info.context.first[name.casefold()]
    if first != info.context.number:
        raise Unfit(f"a name of its own (row {first} has it)")
    return name


def _twin(text: str, info: Info) -> str | None:
    """The twin that column path names, None where it names files."""
    if not text.startswith(SIMULATE):
        return None
    twin, known = text.removeprefix(SIMULATE).strip(), info.context.twins
    if twin not in known:
        raise Unfit(f"simulate: and a twin of the file of twins ({unknown(twin, known)})")
    return twin


OwnName = Annotated[str, NAME, pydantic.AfterValidator(_own_name)]
Twin = Annotated[str | None, pydantic.Field(alias="path"), pydantic.BeforeValidator(_twin)]


class SheetRow(pydantic.BaseModel):
    """A row of a sheet."""

    model_config = pydantic.ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)
    KIND: ClassVar[str]  # also the column that names the row

    twin: Twin

    @property
    def name(self) -> str:
        """What the recording or calibration is called."""
        return str(getattr(self, self.KIND))

    @pydantic.computed_field  # type: ignore[prop-decorator]
    @property
    def source(self) -> Literal["twin", "measured"]:
        """What its tables and figures are marked with."""
        return "twin" if self.twin else "measured"

    @pydantic.field_validator("*", mode="before")
    @classmethod
    def _of_cell(cls, text: str, info: Info) -> object:
        """An empty cell is the default; another one must match, and is split for a list."""
        field, place = cls.model_fields[str(info.field_name)], info.context
        if not (text or field.is_required()):
            return field.default
        if MEASURED in field.metadata and place.is_simulated:
            raise Unfit(f"nothing for a simulated {cls.KIND}")
        for one in field.metadata:
            if isinstance(one, Cell) and not re.fullmatch(one.pattern, text):
                raise Unmatched(one.expected)
            if isinstance(one, Needs) and not place.cells.get(one.column):
                raise Unfit(f"nothing without {one.what} in column {one.column}")
        return sheets.parts_of(text) if get_origin(field.annotation) is tuple else text

    @classmethod
    def columns(cls) -> dict[str, FieldInfo]:
        """Fields by column, in the order of the header; `twin` has no column of its own."""
        fields = cls.model_fields.items()
        return {field.alias or name: field for name, field in fields if name != "twin"}

    @classmethod
    def required(cls) -> list[str]:
        """Columns that must be there."""
        return [column for column, field in cls.columns().items() if field.is_required()]


OfSheet = TypeVar("OfSheet", bound=SheetRow)


def load(kind: type[OfSheet], path: str | None, twins: Collection[str]) -> dict[str, OfSheet]:
    """Rows by name, whatever their order in the sheet, so that no result depends on it; `Faults`
    names everything wrong."""
    if path is None:
        return {}
    columns = list(kind.columns())
    lines = sheets.read(path, columns, kind.required())
    names = [line.cells[kind.KIND] for line in lines]
    first = {
        name.casefold(): line.number
        for name, line in zip(reversed(names), reversed(lines), strict=True)
    }
    rows, faults = {}, []
    for name, line in zip(names, lines, strict=True):
        place = Place(path, line.number, line.cells, names, first, twins)
        try:
            rows[name] = kind.model_validate(line.cells, context=place)
        except pydantic.ValidationError as error:
            whose = f" ({kind.KIND} {quoted(name)})" if name else ""
            faults += _lines(error, columns, f"{path}, row {line.number}{whose}", line.cells)
    if faults:
        raise Faults(faults)
    return {name: rows[name] for name in sorted(rows, key=by_number)}


def by_number(name: str) -> tuple[list[str | int], str]:
    """Key that sorts `T40-2` before `T40-10`: names never differ in upper and lower case alone."""
    parts = re.split("([0-9]+)", name.casefold())
    return [int(part) if k % 2 else part for k, part in enumerate(parts)], name


def _lines(
    error: pydantic.ValidationError, columns: list[str], where: str, cells: Mapping[str, str]
) -> list[str]:
    """A line for each wrong cell: first of those that do not look as they should."""
    causes = ((str(one.loc[0]), one.cause) for one in misfits(error))
    unfit_cells = [(column, cause) for column, cause in causes if isinstance(cause, Unfit)]
    unfit_cells.sort(key=lambda one: (not isinstance(one[1], Unmatched), columns.index(one[0])))
    return [
        f"{where}, column {column}: {quoted(value)}; expected {unfit.expected}"
        for column, unfit in unfit_cells
        for value in [cells[column] if unfit.value is None else unfit.value]
    ]
