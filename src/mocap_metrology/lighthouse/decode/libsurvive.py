"""Recordings of libsurvive (`.rec`, `.rec.gz`), and the solution it stores beside them (`.json`).

One event a line: `seconds object op fields`. Used are `C channel start length`, a pulse in ticks of
48 MHz whose 32-bit counter wraps every 89.5 s; `CONFIG`, the object's own description with the
photodiodes' positions and which channel each is on; and `I mask time`, gyroscope and accelerometer,
see `inertial`. Light of second-generation stations is in lines of its own, see `libsurvive2`.

libsurvive counts stations the other way round (its lighthouse 0 is the one whose flash comes
second) and looks along -Z with X to the right and Y up: x = -Z, y = -X, z = Y.
"""

from __future__ import annotations

import gzip
import json
import re
import zlib
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from io import BufferedReader
from pathlib import Path
from typing import Any

import numpy as np

from mocap_metrology.common.errors import UNREADABLE, Refusal
from mocap_metrology.lighthouse.board import check_board
from mocap_metrology.lighthouse.decode import inertial, libsurvive2
from mocap_metrology.lighthouse.decode.inertial import WRAP, unrolled
from mocap_metrology.lighthouse.decode.turns import PERIOD_S, Light
from mocap_metrology.lighthouse.records import Factory, Pulses
from mocap_metrology.lighthouse.timing import CYCLE_TICKS, TICKS_PER_S

CHUNK = 1 << 22
FEW = 100  # lines of the other generation: damage
LONGEST_LINE = 1 << 26
CHANNELS = 1 << 12  # beyond this a channel is damage
MOST_PULSES = 10_000_000  # of one object: an hour; beyond it the memory of a computer may not do
MOST_OBJECTS = 1000  # beyond this the names are damage
# Rows: x, y, z of this project in axes of libsurvive, X, Y, Z.
FROM_LIBSURVIVE = np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])

RAW = re.compile(rb"^[\d.]+ (\S+) C (\d{1,10}) (\d{1,10}) (\d{1,10})\r*$", re.M)
CONFIG = re.compile(rb"^[-+.\de]+ +(\S+) +CONFIG +(.*)$", re.M)
SECOND_GENERATION = re.compile(rb"^[-+.\de]+ +(\S+) +[WB] +\d", re.M)
PROCESSED = re.compile(rb"^[-+.\de]+ +(\S+) +(?:A|S|[LR] [XY]) +-?\d", re.M)
EVENT = re.compile(rb"^[-+.\de]+ +\S+ +\S", re.M)
ANY_C = re.compile(rb"^[-+.\de]+ +\S+ +C(?=\s)", re.M)
MOST_UNREADABLE = 1_000_000  # lines, where fewer can be read
MOST_BYTES = 1 << 33  # unpacked: some hours


@dataclass
class Seen:
    """Results of one pass over a recording."""

    pulses: list[np.ndarray] = field(default_factory=list)  # channel, start, length of the object
    inertial: list[np.ndarray] = field(default_factory=list)  # rows of `inertial.rows`
    light: list[np.ndarray] = field(default_factory=list)  # rows of `libsurvive2.rows`
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
    gyroscope and accelerometer where it describes them, and the positions of its photodiodes in
    metres, (n, 3).

    tracked_object: its name in the recording, by order of enumeration, or its serial number. Diodes
    are numbered as in the object's description; its channelMap gives their channels. Of the second
    generation, a compressed file may end too early and is used to its last whole line.
    Raises `Refusal` for what is no such recording, has both generations or no raw pulses, or lacks
    the object.
    """
    name = Path(path).name
    seen = _scan(path, tracked_object.encode())
    own = _named(seen, tracked_object)
    second = _check(seen, own, tracked_object, name)
    text = seen.configs[own]
    board, channels = _description(text, f"{name}, {tracked_object}")
    config, sensors = json.loads(text), np.concatenate(seen.inertial)
    read: Pulses | Light
    if second:
        read = libsurvive2.light_of(np.concatenate(seen.light), sensors, config, len(board), name)
    else:
        pulses, begin = _pulses(np.concatenate(seen.pulses), channels, len(board), name)
        read = replace(pulses, inertial=inertial.series(sensors, config, begin))
    notes = list(read.notes)
    if seen.cut:
        notes.append(f"the file is cut off ({seen.cut}) and used to its last whole line")
    if seen.unreadable:
        notes.append(
            f"{seen.unreadable} lines cannot be read and are left out: the file is damaged"
        )
    known = {name.encode() for name in seen.configs}
    stray = sum(n for name, n in seen.raw.items() if name not in known)
    if stray:
        notes.append(f"{stray} pulses are of objects without a CONFIG line and are left out")
    return replace(read, notes=tuple(notes)), board


def _named(seen: Seen, wanted: str) -> str:
    """Name in the recording of the object of that name, or else of that serial number."""
    if wanted in seen.configs or wanted.encode() in seen.raw | seen.second:
        return wanted
    for name, text in seen.configs.items():
        with suppress(*UNREADABLE):
            if json.loads(text).get("device_serial_number") == wanted:
                return name
    return wanted


def _scan(path: str | Path, wanted: bytes) -> Seen:
    seen, file = Seen(), Path(path).name
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
            wanted = _named(seen, wanted.decode()).encode()
        if b" C " in block:
            _add_raw(seen, block, wanted)
        seen.second.update(Counter(SECOND_GENERATION.findall(block)))
        for rows, n_damaged in (
            inertial.rows(block, wanted),
            libsurvive2.rows(block, wanted),
        ):
            (seen.inertial if rows.shape[1] == 7 else seen.light).append(rows)
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


def _add_raw(seen: Seen, block: bytes, wanted: bytes) -> None:
    """Store the pulses of the wanted object, count those of all."""
    lines = [line for line in block.split(b"\n") if b" C " in line]
    found = RAW.findall(b"\n".join(lines))
    seen.raw.update(Counter(row[0] for row in found))
    seen.unreadable += len(ANY_C.findall(b"\n".join(lines))) - len(found)
    mine = [list(map(int, row[1:])) for row in found if row[0] == wanted]
    seen.pulses.append(np.array(mine, np.int64).reshape(-1, 3))
    seen.n_pulses += len(mine)


def blocks(path: str | Path, seen: Seen) -> Iterator[bytes]:
    """The text in pieces of whole lines without empty ones; a last line without end was cut off,
    and is left out. The caller is told where the file ends too early."""
    name, rest, size = Path(path).name, b"", 0
    try:
        with _opened(path) as stream:
            while piece := stream.read1(CHUNK):
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


@contextmanager
def _opened(path: str | Path) -> Iterator[BufferedReader | gzip.GzipFile]:
    """The file, unpacked where its first bytes are those of gzip, whatever its name."""
    with Path(path).open("rb") as raw:
        packed = raw.read(2) == b"\x1f\x8b"
        raw.seek(0)
        if packed:
            with gzip.open(raw) as stream:
                yield stream
        else:
            yield raw


def _check(seen: Seen, own: str, wanted: str, name: str) -> bool:
    """Whether the light is of second-generation stations; refuses a recording without raw pulses
    and description of the object. own: its name, wanted: as the user names it."""
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
    if own.encode() not in there:
        objects = ", ".join(sorted(name.decode("utf-8", "replace") for name in there))
        raise Refusal(f"{name}: no pulses of an object {wanted!r}; expected one of {objects}")
    if own not in seen.configs:
        raise Refusal(f"{name}: no CONFIG line of {own}; expected its geometry there")
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


@dataclass(frozen=True)
class SolvedStation:
    """A station in libsurvive's own solution; pose from station to world, in libsurvive's axes,
    None where it has none."""

    index: int
    id: int
    mode: str | None  # of generation 1
    factory: Factory
    pose: tuple[np.ndarray, np.ndarray] | None
    channel: int | None = None  # of generation 2


BLOCK = re.compile(r'"lighthouse(\d+)"\s*:\s*\{([^{}]*)\}')
ENTRY = re.compile(r'"(\w+)"\s*:\s*(?:"([^"]*)"|\[([^][]*)\])')
MODES = "Abc"  # by number
FACTORY_KEYS = {
    "phase": "fcalphase",
    "tilt": "fcaltilt",
    "curve": "fcalcurve",
    "gibphase": "fcalgibpha",
    "gibmag": "fcalgibmag",
}
FACTORY2_KEYS = {**FACTORY_KEYS, "ogeephase": "fcalogeephase", "ogeemag": "fcalogeemag"}
SECOND_NAMED = re.compile(r'"(?:configed-)?lighthouse-gen"\s*:\s*"2"')
CLIPPED_ID = 0x7FFFFFFF  # of larger ones, by some versions of libsurvive


def read_solution(path: str | Path, generation: int = 1) -> list[SolvedStation]:
    """Stations in the configuration that libsurvive writes beside a recording.

    It is a list of `"key":"value"` and of blocks, not quite JSON. Ids are unsigned, which the file
    prints with a sign. Stations without a factory calibration (OOTXSet 0) are left out.
    Raises `Refusal` where there is no station of the generation in it.
    """
    name = Path(path).name
    text = solution_text(path)
    if (second := of_second_generation(text)) != (generation == 2):
        words = ["first-generation", "second-generation (V2)"]
        raise Refusal(f"{name}: of {words[second]} stations; expected {words[not second]} ones")
    try:
        found = [_solved(int(i), block, generation) for i, block in BLOCK.findall(text)]
    except UNREADABLE as error:
        raise Refusal(
            f"{name}: a lighthouse block has a missing or invalid entry ({error}); expected id, "
            "mode, pose, fcal*"
        ) from None
    stations = [station for station in found if station is not None]
    if not stations:
        raise Refusal(f"{name}: no calibrated station; expected blocks lighthouse0, lighthouse1")
    return stations


def solution_text(path: str | Path) -> str:
    """Text of such a configuration."""
    try:
        return Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise Refusal(
            f"{Path(path).name}: cannot be read ({error}); expected libsurvive's JSON"
        ) from None


def of_second_generation(text: str) -> bool:
    """Whether a configuration is of second-generation stations: it says so, or has values that the
    first does not transmit, which are zeros there."""
    ogee = re.findall(r'"fcalogee\w*"\s*:\s*\[([^][]*)\]', text)
    return bool(SECOND_NAMED.search(text)) or any(re.search("[1-9]", values) for values in ogee)


def _solved(index: int, block: str, generation: int) -> SolvedStation | None:
    from scipy.spatial.transform import Rotation

    entries = {key: listed or single for key, single, listed in ENTRY.findall(block)}
    if entries.get("OOTXSet", "1") == "0":
        return None

    def numbers(key: str, count: int) -> np.ndarray:
        values = np.array([float(v.strip(' "')) for v in entries[key].split(",")])
        if values.size != count or not np.isfinite(values).all():
            raise ValueError(f"{key} is {entries[key]}")
        return values

    keys = FACTORY_KEYS if generation == 1 else FACTORY2_KEYS
    calibration: dict[str, Any] = {name: numbers(key, 2) for name, key in keys.items()}
    mode, pose = int(entries["mode"]), None
    if entries.get("PositionSet", "1") != "0":
        values = numbers("pose", 7)
        pose = Rotation.from_quat(values[3:], scalar_first=True).as_matrix(), values[:3]
    if generation == 2 and not 0 <= mode < PERIOD_S.size:
        raise ValueError(f"mode is {mode}")
    return SolvedStation(
        index=index,
        id=int(entries["id"]) % WRAP,
        mode=MODES[mode] if generation == 1 and 0 <= mode < 3 else None,
        factory=Factory(**calibration, generation=generation),
        pose=pose,
        channel=mode if generation == 2 else None,
    )


def solution_pose(stations: list[SolvedStation]) -> tuple[np.ndarray, np.ndarray]:
    """Pose of the slave in the master's frame, R (3, 3) and t in metres, in this project's axes.

    The master is libsurvive's lighthouse 1. With station-to-world poses R_i, t_i and the change of
    axes C: R = C R_1^T R_0 C^T, t = C R_1^T (t_0 - t_1).
    """
    by_index = {station.index: station.pose for station in stations}
    slave, master = by_index.get(0), by_index.get(1)
    if slave is None or master is None:
        raise Refusal(
            "libsurvive's solution: expected poses of the two stations lighthouse0 and lighthouse1"
        )
    C, to_master = FROM_LIBSURVIVE, master[0].T
    return C @ to_master @ slave[0] @ C.T, C @ to_master @ (slave[1] - master[1])
