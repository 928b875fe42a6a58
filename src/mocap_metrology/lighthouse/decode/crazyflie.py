"""Second-generation light as the lighthouse deck of a Crazyflie reports it: one pulse a frame.

`crazyflie-uart`, the bytes of the deck, 12 a frame [lighthouse-fpga, readme.md; crazyflie-firmware,
lighthouse_core.c], little-endian:

    0     sensor (2 bits), slow bit, channel (4 bits), channel unknown
    1-2   length of the pulse, 24 MHz
    3-5   time since the turn began, 6 MHz, 17 bits; 0 unknown
    6-8   word of the light, 17 bits
    9-11  begin of the pulse, 24 MHz, which wraps every 0.7 s

Twice a second all bytes of a frame are 0xFF. `crazyflie-log`, the log on an SD card [Bitcraze's
cfusdlog.py]: event `lhUartFrame` with `sensor`, `basestation` (2 is unknown), `offset` (24 MHz, 0
unknown), `timestampFPGA` (24 bits) and `timestamp2FPGA` (unrolled); or these columns as a CSV.

Of the pulses of a sweep one has the time since the turn began. Such a group is used where its
channel is one, that time is there once and no sensor twice; other pulses have no known station.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from mocap_metrology.common import spreadsheet
from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.types import Integers
from mocap_metrology.lighthouse.decode.angles_csv import check_whole, numbers_of
from mocap_metrology.lighthouse.decode.turns import PERIOD_S, Light

FRAME = 12
SYNC = b"\xff" * FRAME
RATE_HZ = 24_000_000
FEWEST = 4  # frames in step
MOST_WRAPS = 30  # 20 s without frames
COUNTER = 1 << 24
MOST_BACK_S = 1.0  # pulses may be a little out of order
GAP_TICKS = 10_000  # between sweeps
UNKNOWN = -1
SENSORS = 4
MAGIC, VERSIONS = 0xBC, (1, 2)
EVENT = "lhUartFrame"
NEEDED = ("sensor", "basestation", "offset")
STAMPS = ("timestamp2FPGA", "timestampFPGA")
UNKNOWN_STATION = 2  # in a log
MOST_BYTES = 1 << 30


def read_uart(path: str | Path) -> Light:
    """Light out of the bytes of a deck. Raises `Refusal` where there are no frames in them."""
    name, data = Path(path).name, _bytes(path)
    parts, at, lost = [], data.find(SYNC), 0
    while at >= 0:
        frames = np.frombuffer(data, np.uint8, (len(data) - at) // FRAME * FRAME, at)
        frames = frames.reshape(-1, FRAME)
        sync = (frames == 0xFF).all(axis=1)
        broken = np.flatnonzero(~sync & ((frames[:, 5] | frames[:, 8]) > 1))  # padding is not 0
        end = int(broken[0]) if broken.size else len(frames)
        if end < FEWEST and broken.size:  # the byte before was 0xFF too
            at = data.find(SYNC, at + 1)
            continue
        parts.append(frames[:end][~sync[:end]])
        lost += bool(broken.size)
        at = data.find(SYNC, at + FRAME * end) if broken.size else -1
    parts = [part.astype(np.int64) for part in parts if len(part)]
    if not parts:
        raise Refusal(
            f"{name}: no frames of 12 bytes after one of 0xFF; expected the bytes of a lighthouse"
            " deck with second-generation base stations"
        )
    notes = [f"{lost} times out of step with the frames"] if lost else []
    wide = np.concatenate(parts)
    first, offset = wide[:, 0], 4 * _number(wide, 3)
    channel = np.where(first >> 7, UNKNOWN, first >> 3 & 15)
    ends = np.cumsum([len(part) for part in parts])[:-1]
    stamp = _continuous(_number(wide, 9), channel, offset, ends)
    return _light(first & 3, channel, offset, stamp, first >> 2 & 1, notes, name)


def _number(frames: Integers, at: int) -> Integers:
    return frames[:, at] | frames[:, at + 1] << 8 | frames[:, at + 2] << 16


def _unrolled(stamp: Integers) -> Integers:
    """Ticks of a counter of 24 bits without gaps of half its range."""
    step = np.diff(stamp, prepend=stamp[:1]) + COUNTER // 2
    return stamp[:1] + np.cumsum(step % COUNTER - COUNTER // 2)


def _continuous(stamp: Integers, channel: Integers, offset: Integers, ends: Integers) -> Integers:
    """Ticks over pieces of unknown distance, `ends` being the first frames of all but the first:
    the counter may wrap in between, as often as fits the turns of the stations before best."""
    timed = (offset > 0) & (channel != UNKNOWN)
    pieces = [_unrolled(piece) for piece in np.split(stamp, ends)]
    for k, at in enumerate(ends):
        now = pieces[k + 1]
        now += COUNTER * -((now[0] - pieces[k][-1]) // COUNTER)
        so_far = np.concatenate(pieces[: k + 1])
        off = np.zeros(MOST_WRAPS)
        for one in range(PERIOD_S.size):
            before, after = (
                np.flatnonzero(timed[a:b] & (channel[a:b] == one))
                for a, b in ((0, at), (at, at + now.size))
            )
            if before.size and after.size:
                period = PERIOD_S[one] * RATE_HZ
                last = so_far[before[-1]] - offset[before[-1]]
                apart = (now[after] - offset[at + after])[:10] - last
                turns = (apart + COUNTER * np.arange(MOST_WRAPS)[:, None]) / period
                off += np.median(np.abs(turns - np.round(turns)), axis=1)
        now += COUNTER * int(np.argmin(off))
    return np.concatenate(pieces)


def read_log(path: str | Path) -> Light:
    """Light out of a log, or of a CSV with its columns. Raises `Refusal` for a file that is
    neither, or has no such event."""
    name, data = Path(path).name, _bytes(path)
    if data[:1] == bytes([MAGIC]):
        table = _events(data, name)
    else:
        expected = f"a log of the Crazyflie with event {EVENT}, or its columns as a CSV"
        table = numbers_of(spreadsheet.columns(path, expected), NEEDED + STAMPS, name)
    missing = [column for column in NEEDED if column not in table]
    stamps = [column for column in STAMPS if column in table]
    if missing or not stamps:
        raise Refusal(f"{name}: no {', '.join(missing or STAMPS[:1])}; expected {NEEDED + STAMPS}")
    if not table[stamps[0]].size:
        raise Refusal(f"{name}: no rows; expected one row per pulse")
    whole = ((column, 0, 1 << 53, "a count") for column in (*NEEDED[1:], stamps[0]))
    check_whole(table, [("sensor", 0, SENSORS - 1, "a count"), *whole], name)
    sensor, station, offset, stamp = (
        table[column].astype(np.int64) for column in (*NEEDED, stamps[0])
    )
    if stamps[0] == STAMPS[1]:
        stamp = _unrolled(stamp)
    back = np.diff(stamp, prepend=stamp[0]) / RATE_HZ
    if (at := int(np.argmin(back))) and back[at] < -MOST_BACK_S:
        raise Refusal(
            f"{name}: {stamps[0]} goes back by {-back[at]:.3g} s in pulse {at + 1}; expected one"
            " recording"
        )
    channel = np.where(station == UNKNOWN_STATION, UNKNOWN, station)
    return _light(sensor, channel, offset, stamp, np.full(stamp.size, -1), [], name)


def _bytes(path: str | Path) -> bytes:
    try:
        if Path(path).stat().st_size > MOST_BYTES:
            raise Refusal(f"{Path(path).name}: too long; expected at most {MOST_BYTES} bytes")
        return Path(path).read_bytes()
    except OSError as error:
        reason = error.strerror or error
        raise Refusal(f"{Path(path).name}: cannot be read ({reason}); expected a log") from None


def _events(data: bytes, name: str) -> Mapping[str, np.ndarray]:
    """Variables of the event in a binary log. Its records lie one after another: version 1 has
    milliseconds of 32 bits in each, version 2 microseconds of 64 bits."""
    damaged = f"{name}: the log of the Crazyflie is damaged; expected whole events and a checksum"
    try:
        version, n_events = struct.unpack_from("<HH", data, 1)
        if version not in VERSIONS:
            raise Refusal(f"{name}: version {version} of the log; expected 1 or 2")
        at, sizes, wanted, names, code = 5, {}, -1, [], ""
        for _ in range(n_events):
            (event,) = struct.unpack_from("<H", data, at)
            end = data.index(0, at + 2)
            called, (n,) = data[at + 2 : end].decode(), struct.unpack_from("<H", data, end + 1)
            variables, at = [], end + 3
            for _ in range(n):
                end = data.index(0, at)
                variables.append(data[at:end].decode())
                at = end + 1
            form = "<" + "".join(variable[-2] for variable in variables)
            sizes[event] = struct.calcsize(form)
            if called == EVENT:
                wanted, code, names = event, form, [v[:-3] for v in variables]
        head = 6 if version == 1 else 10
        rows = []
        while at < len(data) - 4:
            event = data[at] | data[at + 1] << 8
            if event == wanted:
                rows.append(at + head)
            at += head + sizes[event]
    except (struct.error, ValueError, KeyError, IndexError) as error:
        raise error if isinstance(error, Refusal) else Refusal(damaged) from None
    if at != len(data) - 4 or zlib.crc32(data[:-4]) != int.from_bytes(data[-4:], "little"):
        raise Refusal(damaged)
    if not rows:
        raise Refusal(f"{name}: no event {EVENT}; expected a log with the pulses of the deck")
    table = np.array([struct.unpack_from(code, data, row) for row in rows], dtype=np.float64)
    return dict(zip(names, table.T, strict=True))


def _light(
    sensor: Integers,
    channel: Integers,
    offset: Integers,
    stamp: Integers,
    bit: Integers,
    notes: list[str],
    name: str,
) -> Light:
    """Light of the groups that can be used; offset and stamp in ticks."""
    order = np.argsort(stamp, kind="stable")
    sensor, channel, offset, stamp, bit = (
        x[order] for x in (sensor, channel, offset, stamp - stamp.min(), bit)
    )
    group = np.cumsum(np.diff(stamp, prepend=stamp[:1]) >= GAP_TICKS)
    n = int(group[-1]) + 1
    highest, lowest = np.full(n, UNKNOWN), np.full(n, PERIOD_S.size)
    known = channel != UNKNOWN
    np.maximum.at(highest, group[known], channel[known])
    np.minimum.at(lowest, group[known], channel[known])
    one_offset = np.bincount(group, offset > 0, n) == 1
    pairs = np.unique(group * SENSORS + sensor)
    once = np.bincount(pairs // SENSORS, minlength=n) == np.bincount(group, minlength=n)
    inside = (lowest >= 0) & (highest < PERIOD_S.size)
    used = ((highest == lowest) & inside & one_offset & once)[group]
    timed = used & (offset > 0)
    if not timed.any():
        raise Refusal(f"{name}: no sweep with one channel and one time in the turn; expected some")
    if not used.all():
        notes = [
            *notes,
            f"{int((~used).sum())} of {used.size} pulses are of sweeps of no single station",
        ]
    return Light(
        begin_channel=highest[group][timed].astype(np.int8),
        begin_s=(stamp - offset)[timed] / RATE_HZ,
        begin_bit=bit[timed].astype(np.int8),
        hit_channel=highest[group][used].astype(np.int8),
        hit_diode=sensor[used].astype(np.int16),
        hit_s=stamp[used] / RATE_HZ,
        n_diodes=SENSORS,
        duration_s=float(np.ptp(stamp)) / RATE_HZ,
        resolution_s=1 / RATE_HZ,
        notes=tuple(notes),
    )
