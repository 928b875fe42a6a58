"""What the header of a text recording says, and what every header is read with."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from mocap_metrology.common.errors import Refusal
from mocap_metrology.io.c3d.labels import complete_labels
from mocap_metrology.io.c3d.units import KNOWN, MM

NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


@dataclass(frozen=True)
class Turned:
    """Where the orientation of a label stands: `columns` (from 0) of a quaternion x, y, z, w, of a
    matrix row by row, or of three angles in degrees about the body's own axes (`XYZ`, in this
    order), as `kind` says: `quaternion`, `matrix`, `XYZ` ..."""

    columns: tuple[int, ...]
    kind: str


@dataclass(frozen=True)
class Layout:
    """A text recording without its numbers.

    `columns`: places (from 0) of x, y, z of each label; `frame_column`, `time_column` (s) where
    there are such. `data_line` (from 1) and `data_offset` (bytes): where the numbers start.
    `declared`: name and value of the field that counts frames; `declared_too_few`: whether it is
    known to be below the number of rows at times. `frame_rate_hz` 0: not told.
    `ends_blank`: an empty line ends the numbers. `zero_is_gap`: x = y = z = 0 is no measurement;
    `zero_note`: what to say where there are such. `remarks`: what to say of a label, by its place,
    once it is chosen. `turned`: orientations of labels that are bodies, by their place.
    """

    path: Path
    format: str
    labels: tuple[str, ...]
    columns: tuple[tuple[int, int, int], ...]
    frame_rate_hz: float
    units: str
    mm_per_unit: float
    delimiter: str
    data_line: int
    data_offset: int
    n_columns: int
    frame_column: int | None = None
    time_column: int | None = None
    declared: tuple[str, int] | None = None
    declared_too_few: bool = False
    ends_blank: bool = False
    zero_is_gap: bool = False
    zero_note: str = ""
    notes: tuple[str, ...] = ()
    remarks: Mapping[int, str] = field(default_factory=dict)
    turned: Mapping[int, Turned] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Name of the file without its folder."""
        return self.path.name


def number(text: str) -> float | None:
    """A finite decimal number, with a point or a comma; None for anything else."""
    text = text.strip().strip('"')
    if "." not in text:
        text = text.replace(",", ".", 1)
    return float(text) if NUMBER.fullmatch(text) else None


def rate(text: str) -> float:
    """Frame rate in Hz, 0 where the text tells none."""
    found = number(text)
    return found if found is not None and found > 0 else 0.0


def count(text: str, name: str, file: str) -> int:
    """A whole number of the header's field `name`."""
    found = number(text)
    if found is None or found < 0 or found != int(found):
        raise Refusal(f"{file}: {name} is {text.strip()[:40]!r}, expected a whole number")
    return int(found)


def unit(texts: Sequence[str], name: str, file: str) -> tuple[str, float, tuple[str, ...]]:
    """Unit as written, mm in it, and remarks; `name` says where it stands."""
    given = list(dict.fromkeys(text.strip() for text in texts if text.strip()))
    if not given:
        return "mm", 1.0, (f"units_assumed: {name} is missing or empty, mm is assumed",)
    for text in given:
        if text.lower() not in MM:
            raise Refusal(f"{file}: {name} is {text[:40]!r}, expected one of {KNOWN}")
    if len({MM[text.lower()] for text in given}) > 1:
        raise Refusal(f"{file}: {name} differ ({', '.join(given)}), expected one unit")
    return given[0], MM[given[0].lower()], ()


def named(labels: Sequence[str]) -> tuple[str, ...]:
    """Labels stripped, and completed as those of C3D files are."""
    stripped = [label.strip() for label in labels]
    return complete_labels(stripped, len(stripped))


def triples(first: int, n: int) -> tuple[tuple[int, int, int], ...]:
    """Columns of `n` labels that follow each other from column `first`."""
    return tuple((i, i + 1, i + 2) for i in range(first, first + 3 * n, 3))
