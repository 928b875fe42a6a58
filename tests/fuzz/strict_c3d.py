"""A strict reader of C3D, after the format's user guide: whatever is not consistent is unreadable.

It shares nothing with the package, and is slow.
"""

import math
import struct
from collections.abc import Sequence
from contextlib import suppress
from itertools import pairwise
from typing import Any

import numpy as np

BLOCK = 512
ORDER = {84: "<", 85: "<", 86: ">"}
MM = {"mm": 1.0, "cm": 10.0, "m": 1000.0}
Values = dict[str, Any]


class Unreadable(Exception):
    """No file of its format, or one that contradicts itself."""


def need(fact: object) -> None:
    if not fact:
        raise Unreadable


def vax(word: int) -> float:
    """An F_floating number of DEC, read as a little-endian 32-bit word."""
    word = int(word)  # of numpy, its differences would wrap
    word = (word & 0xFFFF) << 16 | word >> 16
    exponent = word >> 23 & 0xFF
    size = math.ldexp(0.5 + (word & 0x7FFFFF) / 2**24, exponent - 128) if exponent > 2 else 0.0
    return -size if word >> 31 else size


class File:
    """The parts of a file that say where its values are."""

    def __init__(self, raw: bytes) -> None:
        self.raw = raw
        need(len(raw) > 2 * BLOCK and raw[1] == 0x50 and raw[0] >= 2)
        start = (raw[0] - 1) * BLOCK
        need(len(raw) >= start + 4 and raw[start + 3] in ORDER)
        self.processor = raw[start + 3]
        self.points, self.analog, self.first, self.last = self.words(2, 4)
        (self.block,), (self.per_channel,) = self.words(16, 1), self.words(18, 1)
        self.header_scale, self.header_rate = self.real(12), self.real(20)
        self.data = (self.block - 1) * BLOCK
        need(self.block >= 2 and start < self.data < len(raw))
        self.found = self._parameters(start + 4, self.data)

    def words(self, at: int, n: int) -> list[int]:
        need(at + 2 * n <= len(self.raw))
        return list(struct.unpack_from(f"{ORDER[self.processor]}{n}H", self.raw, at))

    def real(self, at: int) -> float:
        need(at + 4 <= len(self.raw))
        if self.processor == 85:
            return vax(struct.unpack_from("<I", self.raw, at)[0])
        return float(struct.unpack_from(f"{ORDER[self.processor]}f", self.raw, at)[0])

    def _parameters(self, at: int, end: int) -> dict[tuple[str, str], tuple[int, list[int], int]]:
        """Type, dimensions and place of the values of each parameter, by group and name."""
        groups, found = {}, {}
        while True:
            need(at + 2 <= end)
            length, number = struct.unpack_from("bb", self.raw, at)
            if length == 0:
                break
            pointer = at + 2 + abs(length)
            need(pointer + 2 <= end and number != 0)
            name = self.raw[at + 2 : pointer].decode("latin-1").strip().upper()
            after = pointer + self.words(pointer, 1)[0]
            last = after == pointer
            after = end if last else after
            need(pointer + 2 <= after <= end)
            place = pointer + 2
            if number < 0:
                need(groups.setdefault(-number, name) == name)
            else:
                kind, n = struct.unpack_from("bB", self.raw, place)
                need(kind in (-1, 1, 2, 4) and n <= 7)
                dims = list(self.raw[place + 2 : place + 2 + n])
                values = place + 2 + n
                place = values + math.prod(dims) * abs(kind)
                own = found.setdefault((number, name), (kind, dims, values))
                size = place - values
                need(own[:2] == (kind, dims))
                need(self.raw[own[2] : own[2] + size] == self.raw[values:place])
            need(place < after and place + 1 + self.raw[place] <= after)
            if last:
                break
            at = after
        used = [name for number, name in groups.items() if any(g == number for g, _ in found)]
        need(len(set(used)) == len(used))
        return {(groups[g], name): value for (g, name), value in found.items() if g in groups}

    def number(self, name: str, group: str = "POINT") -> float | None:
        kind, dims, at = self.found.get((group, name), (0, [], 0))
        if kind not in (1, 2, 4) or math.prod(dims) < 1:
            return None
        return {1: lambda: float(self.raw[at]), 2: lambda: float(self.words(at, 1)[0]),
                4: lambda: self.real(at)}[kind]()  # fmt: skip

    def texts(self, name: str) -> list[str]:
        kind, dims, at = self.found.get(("POINT", name), (0, [], 0))
        if kind != -1:
            return []
        width, n = (dims[0] if dims else 1), math.prod(dims[1:])
        cells = [self.raw[at + i * width : at + (i + 1) * width] for i in range(n)]
        return [cell.split(b"\0")[0].decode("latin-1").strip() for cell in cells]

    def trial(self) -> tuple[int, int] | None:
        """First and last frame."""
        ends = []
        for name in ("ACTUAL_START_FIELD", "ACTUAL_END_FIELD"):
            kind, dims, at = self.found.get(("TRIAL", name), (0, [], 0))
            if kind != 2 or dims != [2]:
                return None
            low, high = self.words(at, 2)
            ends.append(low + 65536 * high)
        return ends[0], ends[1]

    def _ends(self, used: int, stride: int) -> bool:
        """Whether frames of `stride` bytes end after `used` bytes: zeros follow, or nothing."""
        there, end = len(self.raw) - self.data, self.data + used
        if not used <= there <= used + BLOCK or not any(self.raw[end - stride : end]):
            return False
        return not any(self.raw[end:]) and (used < there or len(self.raw) % BLOCK > 0)

    def _by_size(self, there: int, stride: int, said: set[int]) -> int:
        """The count where those of 16 bits are at their limit: to the last frame with values."""
        n = there // stride
        while n and not any(self.raw[self.data + (n - 1) * stride : self.data + n * stride]):
            n -= 1
        need(len(said) == 1 and there <= n * stride + BLOCK)
        need(len(self.raw) % BLOCK == 0 or there == n * stride)
        return n

    def frames(self, stride: int) -> int:
        """The count on which all agree: the wide ones, 16-bit ones at their limit or wrapped."""
        trial, long_frames = self.trial(), self.number("LONG_FRAMES")
        kind = self.found.get(("POINT", "FRAMES"), (0,))[0]
        own = self.number("FRAMES")
        wide = [trial[1] - trial[0] + 1 if trial else None, long_frames]
        wide += [own] if kind == 4 else []
        narrow = [None if kind == 4 else own, (self.last - self.first + 1) % 65536]
        n = int(next((v for v in [*wide, *narrow] if v), 0))
        there = len(self.raw) - self.data
        if not any(wide) and n in (65535, 32767) and there > n * stride + BLOCK:
            return self._by_size(there, stride, {int(v) for v in narrow if v})
        limits = {n} if n < 65536 else {n % 65536, 65535, 32767}
        if any(v not in (None, n) for v in wide) or any(
            v not in (None, 0) and v not in limits for v in narrow
        ):  # where they differ, the data must show where they end, or one alone go with the size
            said = {int(v) for v in [*wide, *narrow] if v}
            fits = {v for v in said if v * stride <= there <= v * stride + BLOCK}
            shown = {v for v in said if self._ends(v * stride, stride)} or fits
            need(len(shown) == 1)
            n = shown.pop()
        need(n > 0)
        need(n * stride <= there <= n * stride + BLOCK)
        need(len(self.raw) % BLOCK == 0 or there == n * stride)
        return n

    def counts(self, size: int) -> tuple[int, int]:
        """Frames, and words of `size` bytes in each: header and ANALOG:USED agree on the analog
        samples, or only one of them goes with the file."""
        channels = self.number("USED", "ANALOG")
        said = {self.analog} | (
            {int(channels * self.per_channel)} if channels is not None else set()
        )
        found = []
        for analog in said:
            words = 4 * self.points + analog
            with suppress(Unreadable):
                found.append((self.frames(words * size), words))
        need(len(found) == 1)
        return found[0]


def _far(xyz: np.ndarray) -> np.ndarray:
    """Frames of a marker (n, 3) in mm that are one number three times, 20 mm and more from where it
    was else: how programs write that it was not seen."""
    alike = (xyz == xyz[:, :1]).all(axis=1)
    other = xyz[~alike & np.isfinite(xyz).all(axis=1)]
    if not len(other):
        return np.zeros(len(xyz), dtype=bool)
    outside = (xyz < other.min(axis=0) - 20) | (xyz > other.max(axis=0) + 20)
    return alike & outside.any(axis=1)


def read(raw: bytes, labels: Sequence[str]) -> Values:
    """Positions in mm (n_labels, 3, n_frames), NaN where invalid, frame rate, unit, first frame."""
    file = File(raw)
    used, scale = file.number("USED"), file.number("SCALE")
    need(used == file.points > 0)
    scale = file.header_scale if scale is None else scale
    need(math.isfinite(scale) and scale != 0 and (scale < 0) == (file.header_scale < 0))
    need(scale < 0 or math.isclose(scale, file.header_scale, rel_tol=1e-6))
    inside = file.data < (raw[0] - 1 + raw[(raw[0] - 1) * BLOCK + 2]) * BLOCK
    need((file.number("DATA_START") or (0 if inside else file.block)) == file.block)
    need(not file.number("USED", "ROTATION"))
    is_float = scale < 0
    n, words = file.counts(4 if is_float else 2)
    rate = file.number("RATE")
    known = [r for r in (rate, file.header_rate) if r is not None and math.isfinite(r) and r > 0]
    need(known and math.isclose(known[0], known[-1], rel_tol=1e-3))
    units = {text.lower() for text in file.texts("UNITS") if text}
    need(len(units) <= 1 and units <= set(MM))
    unit = MM[units.pop()] if units else None
    every = file.texts("LABELS")
    need(all(every.count(label) == 1 for label in labels))
    code = f"{ORDER[file.processor]}{'f4' if is_float else 'i2'}"
    if is_float and file.processor == 85:
        code = "<u4"
    table = np.frombuffer(raw, code, n * words, file.data).reshape(n, words)
    chosen = np.stack([table[:, 4 * k : 4 * k + 4] for k in map(every.index, labels)])
    need(max(map(every.index, labels)) < file.points)
    values = np.vectorize(vax)(chosen) if code == "<u4" else chosen.astype(float)
    xyz = values[..., :3]
    bad = (values[..., 3] < 0) | (xyz == 0).all(axis=2) | ~np.isfinite(xyz).all(axis=2)
    if not is_float:  # what lies beyond is stored as the limit
        bad |= ((xyz <= -32768) | (xyz >= 32767)).any(axis=2)
    xyz = np.where(bad[..., None], np.nan, xyz) * (unit or 1.0) * (1.0 if is_float else scale)
    for marker in xyz:
        marker[_far(marker)] = np.nan
    trial = file.trial()  # one that does not go with the data gives no number, either
    return {
        "position_mm": xyz.transpose(0, 2, 1),
        "rate": known[0],
        "unit_assumed": unit is None,
        "first": trial[0] if trial and trial[1] - trial[0] + 1 == n else file.first,
    }


def join(parts: Sequence[bytes], labels: Sequence[str]) -> Values:
    """Segments of one take in order, by the numbers of their first frames."""
    found = [read(part, labels) for part in parts]
    need(all(math.isclose(one["rate"], found[0]["rate"], rel_tol=2e-6) for one in found))
    pieces = [found[0]["position_mm"]]
    for one, other in pairwise(found):
        gap = other["first"] - one["first"] - one["position_mm"].shape[2]
        need(0 <= gap <= 10_000)
        pieces += [np.full((len(labels), 3, gap), np.nan), other["position_mm"]]
    assumed = any(one["unit_assumed"] for one in found)
    return found[0] | {"position_mm": np.concatenate(pieces, axis=2), "unit_assumed": assumed}
