"""The parameter section of a C3D file, and numbers as the three processors of C3D store them.

The section is walked record by record, nothing taken on trust. A record is: length of its name
(1 byte, negative = locked), group number (1 byte, negative = it is the group itself), name,
distance to the next record (2 bytes, counted from themselves, 0 = last), then for a parameter its
type, dimensions and values, and for both a description.
Layout after the C3D user guide (c3d.org), "The parameter section".
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import prod

import numpy as np
import numpy.typing as npt

from mocap_metrology.common.errors import Refusal

PROCESSORS = {84: "Intel", 85: "DEC", 86: "MIPS"}
BLOCK = 512  # bytes; C3D counts places in blocks from 1
SIZES = {-1: 1, 1: 1, 2: 2, 4: 4}  # bytes per element of text, byte, int16, float

Stored = np.int16 | np.uint32 | np.float32  # a word of the data section
Numbers = npt.NDArray[np.int64] | npt.NDArray[np.float64]


def byte_order(processor: int) -> str:
    """numpy's mark of the byte order: MIPS is big-endian, Intel and DEC are little-endian."""
    return ">" if processor == 86 else "<"


def raw_dtype(processor: int, is_float: bool) -> np.dtype[Stored]:
    """A stored word of the data section; DEC floats as uint32, for `ieee_from_dec`."""
    kind = "i2" if not is_float else "u4" if processor == 85 else "f4"
    return np.dtype(byte_order(processor) + kind)


def ieee_from_dec(stored: npt.NDArray[Stored]) -> npt.NDArray[np.float32]:
    """float32 values of DEC F_floating numbers that were read as little-endian uint32.

    F_floating stores its more significant 16-bit word first; its exponent bias is 128 with the
    mantissa in [0.5, 1), so the same bits as IEEE are 4 times too large. Two is taken off the
    exponent rather than dividing, because DEC's largest exponent would read as infinity.
    Below 2^-126 the result is zero.
    """
    bits = np.asarray(stored, dtype=np.uint32)
    swapped = (bits << np.uint32(16)) | (bits >> np.uint32(16))
    small = (swapped & np.uint32(0x7F800000)) < np.uint32(3 << 23)
    return np.where(small, np.uint32(0), swapped - np.uint32(2 << 23)).view(np.float32)


def floats(raw: bytes, processor: int) -> npt.NDArray[np.float32]:
    """float32 values of whole 4-byte words."""
    words = np.frombuffer(raw, raw_dtype(processor, is_float=True))
    return ieee_from_dec(words) if processor == 85 else words.astype(np.float32)


def int16s(raw: bytes, processor: int) -> npt.NDArray[np.int64]:
    """Signed 16-bit values, as int64."""
    return np.frombuffer(raw, byte_order(processor) + "i2").astype(np.int64)


def unsigned(value: int) -> int:
    """A signed 16-bit word read as unsigned."""
    return int(value) & 0xFFFF


@dataclass(frozen=True)
class Parameter:
    """One parameter: `kind` -1 text, 1 byte, 2 int16, 4 float; first dimension varies fastest."""

    kind: int
    dims: tuple[int, ...]
    raw: bytes
    processor: int

    def numbers(self) -> Numbers:
        """Values as float64 or int64 (int16 signed), flat; empty for text."""
        if self.kind == 4:
            return floats(self.raw, self.processor).astype(float)
        if self.kind == 2:
            return int16s(self.raw, self.processor)
        return np.frombuffer(self.raw if self.kind == 1 else b"", np.uint8).astype(np.int64)

    def texts(self) -> list[str]:
        """Strings of a text parameter, blanks around and NULs after them off; none for numbers."""
        if self.kind != -1:
            return []
        width = self.dims[0] if self.dims else 1
        if width == 0:
            return [""] * prod(self.dims[1:]) if len(self.dims) > 1 else []
        return [_text(self.raw[i : i + width]) for i in range(0, len(self.raw), width)]


def _text(raw: bytes) -> str:
    raw = raw.split(b"\0", 1)[0]
    try:
        return raw.decode("utf-8").strip()
    except UnicodeDecodeError:
        return raw.decode("latin-1").strip()


class Parameters:
    """Parameters by group and name, in capitals."""

    def __init__(self, parameters: Mapping[tuple[str, str], Parameter]):
        self._found = parameters

    def __len__(self) -> int:
        return len(self._found)

    def get(self, group: str, name: str) -> Parameter | None:
        """The parameter, or None."""
        return self._found.get((group, name))

    def names(self, group: str) -> list[str]:
        """Names of the parameters of a group."""
        return [name for its_group, name in self._found if its_group == group]

    def numbers(self, group: str, name: str) -> Numbers:
        """Its values, or an empty array where it is absent."""
        parameter = self.get(group, name)
        return np.array([]) if parameter is None else parameter.numbers()

    def number(self, group: str, name: str) -> float | None:
        """Its first value where that is finite, else None."""
        values = self.numbers(group, name)
        return float(values[0]) if len(values) and np.isfinite(values[0]) else None

    def count(self, group: str, name: str) -> int | None:
        """Its first value as a count: integers unsigned, floats rounded."""
        value, parameter = self.number(group, name), self.get(group, name)
        if value is None or parameter is None:
            return None
        return int(value) & 0xFFFF if parameter.kind == 2 else round(value)

    def texts(self, group: str, name: str) -> list[str]:
        """Its strings, numbered continuations (LABELS, LABELS2, LABELS3, ...) joined."""
        parameter, number, texts = self.get(group, name), 2, []
        while parameter is not None:
            texts += parameter.texts()
            parameter, number = self.get(group, f"{name}{number}"), number + 1
        return texts


def read_parameters(section: bytes, processor: int, file: str) -> Parameters:
    """All parameters of a section, which starts with its own 4-byte header.

    Refuses a record, array or description that reaches past its record or the section.
    """
    groups: dict[int, str] = {}
    parameters: dict[tuple[int, str], Parameter] = {}
    at = 4
    while at + 2 <= len(section):
        length, number = (int(v) for v in np.frombuffer(section[at : at + 2], np.int8))
        if length == 0:
            break
        name, body, end, last = _record(section, at, abs(length), processor, file)
        if number < 0:
            _description(section, body, end, name, file)
            if groups.setdefault(-number, name) != name:
                both = f"{groups[-number]!r} and {name!r}"
                raise Refusal(f"{file}: damaged: the groups {both} have the number {-number}")
        elif number > 0:
            parameter = _parameter(section, body, end, name, processor, file)
            if parameters.setdefault((number, name), parameter) != parameter:
                raise Refusal(
                    f"{file}: damaged: parameter {name!r} stands twice in one group, with "
                    "different values; expected once"
                )
        else:
            raise Refusal(f"{file}: damaged: parameter {name!r} belongs to group 0")
        if last:
            break
        at = end
    used = [
        name
        for number, name in groups.items()
        if any(its_group == number for its_group, _ in parameters)
    ]
    for name in used:
        if used.count(name) > 1:
            raise Refusal(
                f"{file}: damaged: {used.count(name)} groups are named {name!r}; expected one"
            )
    named = {
        (groups[number], name): p for (number, name), p in parameters.items() if number in groups
    }
    return Parameters(named)


def _record(
    section: bytes, at: int, length: int, processor: int, file: str
) -> tuple[str, int, int, bool]:
    """Name, place of the body, place of the next record, and whether this is the last one."""
    pointer = at + 2 + length
    if pointer + 2 > len(section):
        raise Refusal(f"{file}: damaged: the parameter section ends inside a record")
    name = _text(section[at + 2 : pointer]).upper()
    distance = int.from_bytes(
        section[pointer : pointer + 2], "big" if byte_order(processor) == ">" else "little"
    )
    end = pointer + distance if distance else len(section)
    if end > len(section) or 0 < distance < 2:
        raise Refusal(f"{file}: damaged: parameter record {name!r} reaches past its section")
    return name, pointer + 2, end, distance == 0


def _description(section: bytes, at: int, end: int, name: str, file: str) -> None:
    """Check that the description at `at` ends inside its record."""
    if at + 1 > end or at + 1 + section[at] > end:
        raise Refusal(f"{file}: damaged: description of {name!r} reaches past its record")


def _parameter(
    section: bytes, at: int, end: int, name: str, processor: int, file: str
) -> Parameter:
    if at + 2 > end:
        raise Refusal(f"{file}: damaged: parameter {name!r} has no type")
    kind, n_dims = int(np.frombuffer(section[at : at + 1], np.int8)[0]), section[at + 1]
    if kind not in SIZES or n_dims > 7:
        raise Refusal(
            f"{file}: damaged: parameter {name!r} has type {kind} and {n_dims} dimensions,"
            " expected type -1, 1, 2 or 4 and at most 7"
        )
    start = at + 2 + n_dims
    dims = tuple(section[at + 2 : start])
    stop = start + prod(dims) * SIZES[kind]
    if start > end or stop > end:
        raise Refusal(
            f"{file}: damaged: values of {name!r} reach {stop - end} bytes past their record"
        )
    _description(section, stop, end, name, file)
    return Parameter(kind, dims, section[start:stop], processor)
