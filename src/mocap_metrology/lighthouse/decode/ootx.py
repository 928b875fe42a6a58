"""Calibration of a base station (OOTX) out of the bits of its flashes, one a cycle; its frames.

A frame is a sync of 17 zeros and a one; the length of the payload, the payload padded to whole
words and its CRC32, in words of 16 bits with a stuffing one after each. Bytes go out with the
highest bit first; whole numbers and the checksum (zlib's polynomial, over the payload without its
padding) are little-endian, reals are float16. A payload of 33 bytes makes 358 bits, 2.98 s; it is
sent over and over. Layout as in the LighthouseRedox notes and the decoders of vive-diy-position-
sensor, libsurvive and the Crazyflie firmware. The accelerometer's x points to the station's right,
y up and z backwards.

Bits are indexed by their cycle, so that a missed flash is a hole and not a shift. A whole
frame without a hole is taken as it is. Else the repetitions vote, position by position, a hole for
nobody; what stays open is tried, likeliest first, at most `TRIES` readings against the CRC.
Random bits pass one reading with 2^-32, all with 2^-18; they would also have to agree with the
sync and the stuffing, name a known protocol, pad with zeros, and hold values that a station can
have. Nothing is accepted without the CRC.
"""

from __future__ import annotations

import heapq
import struct
import zlib
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.planes import check_within
from mocap_metrology.lighthouse.records import ROLES, Factory, Flashes, Station
from mocap_metrology.lighthouse.rotor import LIBSURVIVE, rotor_parameters
from mocap_metrology.lighthouse.timing import axis_of, data_of

TRIES = 1 << 14  # readings of voted bits that are tried against the CRC
MOST_OPEN = 24  # bits without any vote; with more, so few tries would be a lottery
IN_TURN = 0.65  # share of codes naming the rotor of their turn from which the turns are believed
FIXED_AGREE = 0.9  # least share of votes for sync, stuffing, length and padding
MODES = ("A", "b", "c")
SYNC = (0,) * 17 + (1,)
PROTOCOLS = {33: (6,), 31: (4, 5)}  # length of the payload: protocols that have it
GIB_LIMITS = {"gibphase": 7.0, "gibmag": 0.3}

# IEEE half floats and bytes of the payload, protocol 6; 4 and 5 end before the mode.
LAYOUT = struct.Struct("<HI2e2eBB2e3b2e2e")
# Columns: the accelerometer's axes x, y, z in the station's frame (x forward, y left, z up).
ACCEL_TO_STATION = np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


@dataclass(frozen=True)
class Payload:
    """What a frame may hold: protocols by length of the payload, how it is unpacked, raising
    `Refusal` for what no station sends, and its bytes that are the same in all frames."""

    protocols: Mapping[int, tuple[int, ...]]
    unpack: Callable[[bytes], Station]
    constant: Callable[[bytes], bytes]


def decode_station(flashes: Flashes) -> Station:
    """Calibration of the station whose flashes these are; without a frame of right checksum
    `factory` is None and `why` states the reason."""
    return station_of(bit_line(flashes), Station(ROLES[flashes.station]), FIRST)


def station_of(bits: np.ndarray, unknown: Station, payload: Payload) -> Station:
    """A station with the calibration out of its bits, or with the reason why there is none."""
    frames, syncs, why = whole_frames(bits, payload)
    if not frames:
        frames, why = voted_frame(bits, why, payload)
    if len({payload.constant(frame) for frame in frames}) > 1:
        frames, why = [], "complete frames with correct checksums contradict each other"
    if not frames:
        known = int((bits >= 0).sum())
        seen = f"{known} bits in {bits.size} cycles, {bits.size - known} missing, {syncs} syncs"
        if bits.size < (least := min(map(frame_bits, payload.protocols))):
            seen, why = f"{bits.size} bits", f"the recording shows less than one, of {least} bits"
        return replace(unknown, why=f"no calibration frame ({seen}): {why}")
    station = payload.unpack(Counter(frames).most_common(1)[0][0])
    return replace(station, role=unknown.role, frames_found=len(frames))


def bit_line(flashes: Flashes) -> np.ndarray:
    """Bits by cycle from the first seen one, int8: 0, 1, or -1 for a hole.

    The two rotors take turns. A length misread by one step names the wrong rotor, so a code that
    is out of turn is a hole.
    """
    if not flashes.cycle.size:
        return np.empty(0, np.int8)
    cycle, code = flashes.cycle - flashes.cycle[0], flashes.code
    known = code >= 0
    in_turn: np.ndarray = axis_of(code) == (flashes.cycle & 1)
    share = in_turn[known].mean() if known.any() else 0.5
    if max(share, 1.0 - share) >= IN_TURN:
        known &= in_turn if share > 0.5 else ~in_turn
    bits = np.full(int(cycle[-1]) + 1, -1, np.int8)
    bits[cycle] = np.where(known, data_of(code), -1)
    return bits


def whole_frames(bits: np.ndarray, payload: Payload) -> tuple[list[bytes], int, str]:
    """Payloads of all frames without a hole, the number of syncs seen, and what failed first."""
    frames, reasons = [], []
    bits = np.concatenate([bits, np.full(len(SYNC), -1, np.int8)])
    windows = np.lib.stride_tricks.sliding_window_view(bits, len(SYNC))
    starts = np.flatnonzero((windows == SYNC).all(axis=1))
    for start in starts:
        try:
            frames.append(_read_frame(bits[start : -len(SYNC)], payload))
        except Refusal as refusal:
            reasons.append(str(refusal))
    return frames, len(starts), (reasons or ["no sync of 17 zeros and a one"])[0]


def _read_frame(bits: np.ndarray, payload: Payload) -> bytes:
    """Payload of the frame that begins with the first bit."""
    for length in payload.protocols:
        fixed, value = template(length)
        frame = bits[: frame_bits(length)]
        head = len(SYNC) + 16
        if frame.size < head or (frame[:head] != value[:head]).any():
            continue
        if frame.size < fixed.size:
            raise Refusal("the frame is cut off")
        if (frame < 0).any():
            raise Refusal(f"a frame has {int((frame < 0).sum())} missing bits")
        if (frame[fixed] != value[fixed]).any():
            raise Refusal("a stuffing bit is wrong")
        data, crc = bytes_of(frame, length)
        if zlib.crc32(data) != crc:
            raise Refusal("the checksum is wrong")
        payload.unpack(data)
        return data
    expected = " or ".join(map(str, payload.protocols))
    raise Refusal(f"the length of the payload is not {expected} bytes")


def voted_frame(bits: np.ndarray, why: str, payload: Payload) -> tuple[list[bytes], str]:
    """Payload read from all repetitions together, in a list that is empty without one."""
    for length in payload.protocols:
        fixed, value = template(length)
        ones, zeros = (
            np.bincount(np.arange(bits.size) % fixed.size, bits == bit, minlength=fixed.size)
            for bit in (1, 0)
        )
        start, agree = _frame_begin(ones, zeros, fixed, value)
        if agree < FIXED_AGREE:
            continue
        margin = np.roll(ones - zeros, -start)
        frame = _search(margin, fixed, value, length, payload)
        if frame is not None:
            return [frame], ""
        why = (
            f"{why}; no combination of the repetitions has a correct checksum; "
            f"{int((margin[~fixed] == 0).sum())} of {int((~fixed).sum())} bits remain undecided"
        )
    return [], why


def _frame_begin(
    ones: np.ndarray, zeros: np.ndarray, fixed: np.ndarray, value: np.ndarray
) -> tuple[int, float]:
    """Where the frame begins, and the share of votes that agree there."""
    sign = np.where(fixed, 2.0 * value - 1.0, 0.0)
    turned = np.add.outer(np.arange(fixed.size), np.arange(fixed.size)) % fixed.size
    agree, votes = (ones - zeros)[turned] @ sign, (ones + zeros)[turned] @ fixed
    start = int(np.argmax(agree))
    if votes[start] < fixed.sum() / 2:
        return start, 0.0
    return start, float(agree[start] / votes[start] + 1.0) / 2.0


def _search(
    margin: np.ndarray, fixed: np.ndarray, value: np.ndarray, length: int, payload: Payload
) -> bytes | None:
    """First payload with the right checksum among the `TRIES` likeliest readings of voted bits.

    With equal error rates the odds of a bit are a power of its margin (ones less zeros), so the
    likeliest readings turn the bits whose margins add up to the least.
    """
    frame = np.where(fixed, value, margin > 0).astype(np.uint8)
    free = np.flatnonzero(~fixed)
    if np.count_nonzero(margin[free] == 0) > MOST_OPEN:
        return None
    free = free[np.argsort(np.abs(margin[free]), kind="stable")]
    columns = _columns(free, length)
    for flips in _by_cost(np.abs(margin[free]), columns, _syndrome(frame, length)):
        reading = frame.copy()
        reading[free[list(flips)]] ^= 1
        data, _ = bytes_of(reading, length)  # with the right checksum
        with suppress(Refusal):
            payload.unpack(data)
            return data
    return None


def _syndrome(frame: np.ndarray, length: int) -> int:
    data, crc = bytes_of(frame, length)
    return zlib.crc32(data) ^ crc


def _columns(free: np.ndarray, length: int) -> list[int]:
    """What turning each bit does to checksum ^ CRC32(payload); it is linear in the bits."""
    zero = frame_of(bytes(length))
    columns = []
    for position in free:
        turned = zero.copy()
        turned[position] ^= 1
        columns.append(_syndrome(turned, length))
    return columns


def _by_cost(cost: np.ndarray, columns: list[int], syndrome: int) -> Iterator[tuple[int, ...]]:
    """Sets of bits that make the syndrome zero, among the `TRIES` sets of least total cost.

    cost rises. Every set has one parent, got by moving its last bit down or dropping it, so a heap
    brings all sets in order of cost.
    """
    weights = [float(c) for c in cost]
    if syndrome == 0:
        yield ()
    heap: list[tuple[float, tuple[int, ...], int]] = [(weights[0], (0,), syndrome ^ columns[0])]
    for _ in range(TRIES):
        total, flips, left = heapq.heappop(heap)
        if left == 0:
            yield flips
        last, after = flips[-1], flips[-1] + 1
        if after == len(weights):
            continue
        turned = left ^ columns[after]
        heapq.heappush(heap, (total + weights[after], (*flips, after), turned))
        moved = (total + weights[after] - weights[last], (*flips[:-1], after))
        heapq.heappush(heap, (*moved, turned ^ columns[last]))


def frame_bits(length: int) -> int:
    """Bits of a frame with a payload of `length` bytes: 18 + 17 (3 + ceil(length / 2))."""
    return len(SYNC) + 17 * (3 + (length + 1) // 2)


def unpack(data: bytes) -> Station:
    """Station of a payload of 31 or 33 bytes; its role is not in there. Raises `Refusal` where a
    value is none that a first-generation station can have."""
    v = LAYOUT.unpack(data[: LAYOUT.size])
    protocol = v[0] & 63
    if protocol not in PROTOCOLS[len(data)]:
        raise Refusal(f"protocol {protocol} of {len(data)} bytes; expected 6 of 33, 4 or 5 of 31")
    mode = data[31] if len(data) == 33 else None
    if mode is not None and mode >= len(MODES):
        raise Refusal(f"mode {mode}; expected 0, 1 or 2")
    station = station_of_payload(v, "", (2, 4, 8, 13, 15), GIB_LIMITS, generation=1)
    return replace(station, mode=None if mode is None else MODES[mode])


def station_of_payload(
    v: tuple[Any, ...],
    role: str,
    pairs: Sequence[int],
    limits: Mapping[str, float],
    generation: int,
) -> Station:
    """A station by the values of its payload, which begins alike in both generations; pairs: where
    those of its factory calibration are. Raises `Refusal` for values that no station has."""
    planes = (np.array(v[i : i + 2]) for i in pairs)
    factory = Factory(*planes, generation=generation)
    rotor_parameters(factory, variant=LIBSURVIVE)
    check_within(factory, limits, "")
    up = up_of(v[10:13])
    known = {"generation": generation, "firmware": v[0] >> 6, "hardware": v[7]}
    return Station(role, id=v[1], factory=factory, gravity=up, **known)


FIRST = Payload(PROTOCOLS, unpack, lambda data: data[2:14] + data[16:20] + data[23:31])


def up_of(accel: tuple[int, int, int]) -> np.ndarray | None:
    """Unit vector upwards in the station's frame from its accelerometer; None where it is zero."""
    v = ACCEL_TO_STATION @ np.asarray(accel, dtype=np.float64)
    length = np.linalg.norm(v)
    return v / length if length else None


def accel_of(up: np.ndarray) -> tuple[int, int, int]:
    """The accelerometer's three numbers, largest +-127, for the way up in the station's frame."""
    v = ACCEL_TO_STATION.T @ np.asarray(up, dtype=np.float64)
    x, y, z = (int(n) for n in np.round(127 * v / np.abs(v).max()))
    return x, y, z


def encode_frame(
    factory: Factory,
    id: int,
    mode: str,
    gravity_int8: tuple[int, int, int] = (0, 127, 0),
    firmware: int = 436,
    hardware: int = 9,
    unlock: int = 1,
) -> np.ndarray:
    """Bits of one frame, uint8 (358,), to be sent over and over; reals are rounded to float16.

    gravity_int8 are the accelerometer's x, y, z as in `accel_of`; mode is A, b or c.
    """
    data = LAYOUT.pack(*values(factory, firmware << 6 | 6, id, unlock, hardware, gravity_int8))
    return frame_of(data + bytes([MODES.index(mode), 0]))


def values(
    factory: Factory, first: int, id: int, unlock: int, hardware: int, gravity: Sequence[int]
) -> Iterator[float]:
    """Those with which the payloads of both generations begin."""
    yield from (first, id, *factory.phase, *factory.tilt, unlock, hardware, *factory.curve)
    yield from (*gravity, *factory.gibphase, *factory.gibmag)


def frame_of(data: bytes) -> np.ndarray:
    """Bits of an OOTX frame: preamble, length, payload, CRC-32; a one after each 16 bits."""
    padded = data + bytes(len(data) % 2)
    body = struct.pack("<H", len(data)) + padded + struct.pack("<I", zlib.crc32(data))
    words = np.unpackbits(np.frombuffer(body, np.uint8)).reshape(-1, 16)
    stuffed = np.column_stack([words, np.ones(len(words), np.uint8)])
    return np.concatenate([np.array(SYNC, np.uint8), stuffed.ravel()])


def template(length: int) -> tuple[np.ndarray, np.ndarray]:
    """Which bits of a frame are known beforehand, and a frame that has them."""
    value = frame_of(bytes(length))
    fixed = np.zeros(value.size, bool)
    fixed[: len(SYNC) + 16] = True  # and the length
    fixed[len(SYNC) + 16 :: 17] = True  # stuffing
    fixed[-43:-35] = True  # padding of an odd length: low half of the word before the checksum
    return fixed, value


def bytes_of(frame: np.ndarray, length: int) -> tuple[bytes, int]:
    """Payload and checksum of a frame; the payload's length is not read from it."""
    words = frame[len(SYNC) :].reshape(-1, 17)[:, :16].astype(np.uint8)
    body = np.packbits(words).tobytes()
    return body[2 : 2 + length], int.from_bytes(body[-4:], "little")
