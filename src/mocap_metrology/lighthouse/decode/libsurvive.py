"""Recordings of libsurvive (`.rec`, `.rec.gz`).

One event a line: `seconds object op fields`. Used are `C channel start length`, a pulse in ticks of
48 MHz whose 32-bit counter wraps every 89.5 s; `CONFIG`, the object's own description with the
photodiodes' positions and which channel each is on; and `I mask time`, gyroscope and accelerometer,
see `libsurvive_lines`. Light of second-generation stations is in lines of its own, likewise.
"""

from __future__ import annotations

import codecs
import gzip
import json
import re
import zlib
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from mocap_metrology.common.errors import UNREADABLE, Refusal
from mocap_metrology.lighthouse.board import check_board
from mocap_metrology.lighthouse.decode.libsurvive_lines import (
    WRAP,
    light_of,
    light_rows,
    normals_of,
    sensor_rows,
    sensors_in,
    unrolled,
)
from mocap_metrology.lighthouse.decode.turns import Light
from mocap_metrology.lighthouse.records import Pulses
from mocap_metrology.lighthouse.timing import CYCLE_TICKS, TICKS_PER_S

CHUNK = 1 << 22
FEW = 100  # lines of the other generation: damage
LONGEST_LINE = 1 << 26
CHANNELS = 1 << 12  # beyond this a channel is damage
MOST_PULSES = 10_000_000  # of one object: an hour; beyond it the memory of a computer may not do
MOST_OBJECTS = 1000  # beyond this the names are damage

RAW = re.compile(rb"^[\d.]+ (\S+) C (\d{1,10}) (\d{1,10}) (\d{1,10})\r*$", re.M)
CONFIG = re.compile(rb"^[-+.\de]+ +(\S+) +CONFIG +(.*)$", re.M)
SECOND_GENERATION = re.compile(rb"^[-+.\de]+ +(\S+) +[WB] +\d", re.M)
PROCESSED = re.compile(rb"^[-+.\de]+ +(\S+) +(?:A|S|[LR] [XY]) +-?\d", re.M)
EVENT = re.compile(rb"^[-+.\de]+ +\S+ +\S", re.M)
ANY_C = re.compile(rb"^[-+.\de]+ +\S+ +C(?=\s)", re.M)
MOST_UNREADABLE = 1_000_000  # lines, where fewer can be read
MOST_BYTES = 1 << 33  # unpacked: some hours
UNIT = 1e-2  # deviation of the axes of a head from right angles and unit length


@dataclass
class RecordingPass:
    """Results of one pass over a recording."""

    pulses: list[np.ndarray] = field(default_factory=list)  # channel, start, length of the object
    inertial: list[np.ndarray] = field(default_factory=list)  # `sensor_rows`
    light: list[np.ndarray] = field(default_factory=list)  # `light_rows`
    raw: Counter[bytes] = field(default_factory=Counter)  # C lines by object
    second: Counter[bytes] = field(default_factory=Counter)  # W and B lines by object
    configs: dict[str, bytes] = field(default_factory=dict)
    processed: bool = False
    events: int = 0  # lines
    n_pulses: int = 0  # of the object
    unreadable: int = 0  # lines
    cut: str = ""  # how the file ends too early


def read_libsurvive(path: str | Path, tracked_object: str) -> tuple[Pulses | Light, np.ndarray]:
    """Pulses of one tracked object, or light of second-generation stations on it, with its
    gyroscope, accelerometer and directions of its photodiodes where it describes them, and the
    positions of these in metres, (n, 3).

    tracked_object: its name in the recording, by order of enumeration, or its serial number. Diodes
    are numbered as in the object's description; its channelMap gives their channels. Of the second
    generation, a compressed file may end too early and is used to its last whole line.
    Raises `Refusal` for what is no such recording, has both generations or no raw pulses, or lacks
    the object.
    """
    name = Path(path).name
    tracked_object = tracked_object.encode("utf-8", "replace").decode()
    seen = _scan(path, tracked_object.encode())
    chosen = _object_name(seen, tracked_object)
    second = _check(seen, chosen, tracked_object, name)
    text = seen.configs[chosen]
    board, channels = _description(text, f"{name}, {tracked_object}")
    config, sensors = json.loads(text), np.concatenate(seen.inertial)
    read: Pulses | Light
    if second:
        read = light_of(np.concatenate(seen.light), sensors, config, len(board), name)
    else:
        pulses, begin = _pulses(np.concatenate(seen.pulses), channels, len(board), name)
        felt, normals = sensors_in(sensors, config, begin), normals_of(config, len(board))
        read = replace(pulses, inertial=felt, normals=normals)
    notes = list(read.notes)
    if seen.cut:
        notes.append(f"the file is cut off ({seen.cut}) and used to its last whole line")
    if seen.unreadable:
        notes.append(
            f"{seen.unreadable} lines cannot be read and are left out: damage, or messages of a"
            " program"
        )
    known = {name.encode() for name in seen.configs}
    stray = sum(n for name, n in seen.raw.items() if name not in known)
    if stray:
        notes.append(f"{stray} pulses are of objects without a CONFIG line and are left out")
    return replace(read, notes=tuple(notes)), board


def _object_name(seen: RecordingPass, wanted: str) -> str:
    """Name in the recording of the object of that name, or else of that serial number."""
    if wanted in seen.configs or wanted.encode() in seen.raw | seen.second:
        return wanted
    for name, text in seen.configs.items():
        with suppress(*UNREADABLE):
            if json.loads(text).get("device_serial_number") == wanted:
                return name
    return wanted


def _scan(path: str | Path, wanted: bytes) -> RecordingPass:
    seen, file = RecordingPass(), Path(path).name
    for block in blocks(path, seen):
        n_events = len(EVENT.findall(block))
        seen.events += n_events
        seen.unreadable += block.count(b"\n") + bool(block) - n_events
        if seen.unreadable > max(MOST_UNREADABLE, seen.events):
            raise Refusal(
                f"{file}: {seen.unreadable} of its first {seen.unreadable + seen.events} lines do "
                "not read `seconds object event ...`; expected a libsurvive recording"
            )
        if b" CONFIG " in block:
            for name, text in CONFIG.findall(block):
                seen.configs.setdefault(name.decode("utf-8", "replace"), text)
            wanted = _object_name(seen, wanted.decode()).encode()
        if b" C " in block:
            lines = b"\n".join(line for line in block.split(b"\n") if b" C " in line)
            raw = RAW.findall(lines)
            seen.raw.update(Counter(row[0] for row in raw))
            seen.unreadable += len(ANY_C.findall(lines)) - len(raw)
            mine = [list(map(int, row[1:])) for row in raw if row[0] == wanted]
            seen.pulses.append(np.array(mine, np.int64).reshape(-1, 3))
            seen.n_pulses += len(mine)
        seen.second.update(Counter(SECOND_GENERATION.findall(block)))
        for parts, rows in ((seen.inertial, sensor_rows), (seen.light, light_rows)):
            block_rows, n_damaged = rows(block, wanted)
            parts.append(block_rows)
            seen.unreadable += n_damaged
        n_pulses = seen.n_pulses + seen.second[wanted]
        n_objects = max(len(seen.raw), len(seen.second), len(seen.configs))
        if n_pulses > MOST_PULSES or n_objects > MOST_OBJECTS:
            raise Refusal(
                f"{file}: too long: {n_pulses} pulses of {wanted.decode()} and"
                f" {n_objects} objects in the first part; expected at most {MOST_PULSES} of"
                f" {MOST_OBJECTS}"
            )
        if not seen.raw:
            seen.processed |= PROCESSED.search(block) is not None
    return seen


def blocks(path: str | Path, seen: RecordingPass) -> Iterator[bytes]:
    """The text in pieces of whole lines without empty ones; a last line without end was cut off,
    and is left out. The caller is told where the file ends too early."""
    name, rest, size = Path(path).name, b"", 0
    try:
        with Path(path).open("rb") as raw:
            packed = raw.peek(2).startswith(b"\x1f\x8b")  # whatever its name
            stream = gzip.GzipFile(fileobj=raw) if packed else raw
            while piece := stream.read1(CHUNK):
                if not size:
                    if piece[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE):
                        raise Refusal(f"{name}: is UTF-16 text; expected UTF-8: save it as UTF-8")
                    piece = piece.removeprefix(codecs.BOM_UTF8)
                size += len(piece)
                if len(rest) > LONGEST_LINE:
                    raise Refusal(f"{name}: no lines; expected a libsurvive recording")
                if size > MOST_BYTES:
                    raise Refusal(f"{name}: too long; expected at most {MOST_BYTES} bytes of text")
                head, line_end, tail = piece.rpartition(b"\n")
                if line_end:
                    text = (rest + head).replace(b"\r\n", b"\n")
                    yield re.sub(rb"\n{2,}", b"\n", text).strip(b"\r\n")
                    rest = tail
                else:
                    rest += piece
    except EOFError as error:
        seen.cut = str(error)
    except (gzip.BadGzipFile, zlib.error) as error:
        raise Refusal(
            f"{name}: its gzip stream is damaged ({error}); expected a complete file"
        ) from None
    except OSError as error:
        reason = error.strerror or error
        raise Refusal(f"{name}: cannot be read ({reason}); expected a recording") from None


def _check(seen: RecordingPass, chosen: str, wanted: str, name: str) -> bool:
    """Whether the light is of second-generation stations; refuses a recording without raw pulses
    and description of the object. chosen: its name, wanted: as the user names it."""
    n_first, n_second = sum(seen.raw.values()), sum(seen.second.values())
    if min(n_first, n_second) > FEW:
        raise Refusal(
            f"{name}: light of both generations of base stations ({n_first} C lines of the first,"
            f" {n_second} W or B lines of the second); expected one: their angles are measured"
            " from different zeros"
        )
    second = n_second > n_first
    if seen.cut and not second:
        raise Refusal(f"{name}: its gzip stream is damaged ({seen.cut}); expected a complete file")
    if not seen.events:
        raise Refusal(f"{name}: no line reads `seconds object event ...`; expected libsurvive's")
    there = seen.second if second else seen.raw
    if not there:
        only = "only processed angles (A, L, R or S lines)" if seen.processed else "no light"
        raise Refusal(
            f"{name}: {only}; expected raw pulses (C lines, or W and Y lines): record with a"
            " libsurvive that writes them"
        )
    if chosen.encode() not in there:
        objects = ", ".join(sorted(name.decode("utf-8", "replace") for name in there))
        raise Refusal(f"{name}: no pulses of an object {wanted!r}; expected one of {objects}")
    if chosen not in seen.configs:
        raise Refusal(f"{name}: no CONFIG line of {chosen}; expected its geometry there")
    return second


def _description(text: bytes, where: str) -> tuple[np.ndarray, np.ndarray]:
    """Positions of the diodes in metres, and the channel of each."""
    try:
        lights = json.loads(text)["lighthouse_config"]
        board = np.array(lights["modelPoints"], dtype=np.float64)
        channels = np.array(lights.get("channelMap", range(len(board))), dtype=np.int64)
    except UNREADABLE:
        raise Refusal(
            f"{where}: its CONFIG is unreadable; expected JSON with lighthouse_config.modelPoints"
        ) from None
    inside = ((channels >= 0) & (channels < CHANNELS - 1)).all()
    if channels.shape != (len(board),) or len(set(channels.tolist())) != len(board) or not inside:
        raise Refusal(
            f"{where}: channelMap does not name one channel for each of {len(board)} diodes"
        )
    return check_board(board, where), channels


def _pulses(
    values: np.ndarray, channels: np.ndarray, n_diodes: int, name: str
) -> tuple[Pulses, int]:
    """Pulses by time, from the counter unrolled from line to line, lines being a little out of
    order; and the counter at their begin."""
    notes = []
    diode_of = np.full(CHANNELS, -1, np.int16)
    diode_of[channels] = np.arange(n_diodes)
    diode = diode_of[np.minimum(values[:, 0], CHANNELS - 1)]
    diode[values[:, 2] > CYCLE_TICKS] = -1
    ticks = unrolled(values[:, 1], int(values[0, 1]))
    known = diode >= 0
    if not known.all():
        notes.append(
            f"{int((~known).sum())} pulses ignored: on no channel of the channelMap, or "
            "without an end"
        )
    order = np.flatnonzero(known)[np.argsort(ticks[known], kind="stable")]
    if not order.size:
        raise Refusal(f"{name}: no pulse on a channel of the channelMap")
    start, length = ticks[order] - ticks[order[0]], values[order, 2]
    begin = int(values[0, 1] + ticks[order[0]]) % WRAP
    pulses = Pulses(
        start_s=start / TICKS_PER_S,
        length_s=length / TICKS_PER_S,
        diode=diode[order],
        n_diodes=n_diodes,
        duration_s=float((start + length).max() / TICKS_PER_S),
        resolution_s=1.0 / TICKS_PER_S,
        notes=tuple(notes),
    )
    return pulses, begin


@dataclass(frozen=True, eq=False)
class TrackedObject:
    """An object: its name in the recording, by order of enumeration, and serial number; R (3, 3)
    and t_m (3,): its head, whose pose other programs give, in the frame of its diodes."""

    name: str
    serial: str | None = None
    R: np.ndarray = field(default_factory=lambda: np.eye(3))
    t_m: np.ndarray = field(default_factory=lambda: np.zeros(3))


def tracked_objects(path: str | Path) -> list[TrackedObject]:
    """The objects of a recording; those without a head have it in the frame of their diodes. Raises
    `Refusal` for a description that cannot be read."""
    texts: dict[str, bytes] = {}
    for block in blocks(path, RecordingPass()):
        for name, text in CONFIG.findall(block):
            texts.setdefault(name.decode("utf-8", "replace"), text)
    return [_described(name, text, Path(path).name) for name, text in texts.items()]


def _described(name: str, text: bytes, file: str) -> TrackedObject:
    try:
        config = json.loads(text)
        told, head = config.get("device_serial_number"), config.get("head")
        serial = told if isinstance(told, str) else None
        if head is None:
            return TrackedObject(name, serial)
        x, z, t = (np.array(head[k], np.float64) for k in ("plus_x", "plus_z", "position"))
        R = np.column_stack([x, np.cross(z, x), z])
        if t.shape == (3,) and np.abs(R.T @ R - np.eye(3)).max() <= UNIT:
            left, _, right = np.linalg.svd(R)
            return TrackedObject(name, serial, left @ right, t)
    except UNREADABLE:
        pass
    what = "with a head of position, and plus_x and plus_z of unit length and at right angles"
    raise Refusal(f"{file}, {name}: its CONFIG is unreadable; expected JSON {what}")
