"""Layout of a calibration frame (OOTX): payload <-> bits.

A frame is a sync of 17 zeros and a one; the length of the payload, the payload padded to whole
words and its CRC32, in words of 16 bits with a stuffing one after each. Bytes go out with the
highest bit first; whole numbers and the checksum (zlib's polynomial, over the payload without its
padding) are little-endian, reals are float16. A payload of 33 bytes makes 358 bits, 2.98 s; it is
sent over and over. Layout as in the LighthouseRedox notes and the decoders of vive-diy-position-
sensor, libsurvive and the Crazyflie firmware.

The accelerometer's x points to the station's right, y up and z backwards.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.records import Factory
from mocap_metrology.lighthouse.rotor import check

MODES = ("A", "b", "c")
SYNC = (0,) * 17 + (1,)
PROTOCOLS = {33: (6,), 31: (4, 5)}  # length of the payload: protocols that have it

# IEEE half floats and bytes of the payload, protocol 6; 4 and 5 end before the mode.
LAYOUT = struct.Struct("<HI2e2eBB2e3b2e2e")
# Columns: the accelerometer's axes x, y, z in the station's frame (x forward, y left, z up).
ACCEL_TO_STATION = np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


@dataclass(frozen=True)
class Payload:
    """Fields of a frame."""

    id: int
    protocol: int
    firmware: int
    hardware: int
    unlock: int
    mode: str | None
    faults: int
    accel: tuple[int, int, int]
    factory: Factory


def frame_bits(length: int = 33) -> int:
    """Bits of a frame with a payload of `length` bytes: 18 + 17 (3 + ceil(length / 2))."""
    return len(SYNC) + 17 * (3 + (length + 1) // 2)


def pack(payload: Payload) -> bytes:
    """The 33 bytes of a payload of protocol 6."""
    f = payload.factory
    head = LAYOUT.pack(
        payload.firmware << 6 | 6,
        payload.id,
        *f.phase,
        *f.tilt,
        payload.unlock,
        payload.hardware,
        *f.curve,
        *payload.accel,
        *f.gibphase,
        *f.gibmag,
    )
    return head + bytes([MODES.index(payload.mode), payload.faults])


def unpack(data: bytes) -> Payload:
    """Fields of a payload of 31 or 33 bytes.

    Raises `Refusal` where a value is none that a first-generation station can have.
    """
    v = LAYOUT.unpack(data[: LAYOUT.size])
    protocol = v[0] & 63
    if protocol not in PROTOCOLS[len(data)]:
        raise Refusal(f"protocol {protocol} of {len(data)} bytes; expected 6 of 33, 4 or 5 of 31")
    mode, faults = (data[31], data[32]) if len(data) == 33 else (None, 0)
    if mode is not None and mode >= len(MODES):
        raise Refusal(f"mode {mode}; expected 0, 1 or 2")
    pairs = [np.array(v[i : i + 2]) for i in (2, 4, 8, 13, 15)]
    factory = Factory(*pairs)
    _check_values(factory)
    return Payload(
        id=v[1],
        protocol=protocol,
        firmware=v[0] >> 6,
        hardware=v[7],
        unlock=v[6],
        mode=None if mode is None else MODES[mode],
        faults=faults,
        accel=v[10:13],
        factory=factory,
    )


def _check_values(factory: Factory) -> None:
    check(factory)
    for name, limit in (("gibphase", 7.0), ("gibmag", 0.3)):
        values = getattr(factory, name)
        if not (np.abs(values) <= limit).all():
            raise Refusal(f"{name} is {values.tolist()}; expected within +-{limit}")


def up_of(accel: tuple[int, int, int]) -> np.ndarray | None:
    """Unit vector upwards in the station's frame from its accelerometer; None where it is zero."""
    v = ACCEL_TO_STATION @ np.asarray(accel, dtype=np.float64)
    length = np.linalg.norm(v)
    return v / length if length else None


def accel_of(up: np.ndarray) -> tuple[int, int, int]:
    """The accelerometer's three numbers, largest +-127, for the way up in the station's frame."""
    v = ACCEL_TO_STATION.T @ np.asarray(up, dtype=np.float64)
    return tuple(int(n) for n in np.round(127 * v / np.abs(v).max()))


def encode_frame(
    factory: Factory,
    id: int,
    mode: str,
    gravity_int8: tuple[int, int, int] = (0, 127, 0),
    firmware: int = 436,
    hardware: int = 9,
    unlock: int = 1,
    faults: int = 0,
) -> np.ndarray:
    """Bits of one frame, uint8 (358,), to be sent over and over; reals are rounded to float16.

    gravity_int8 are the accelerometer's x, y, z as in `accel_of`; mode is A, b or c.
    """
    values = Payload(id, 6, firmware, hardware, unlock, mode, faults, tuple(gravity_int8), factory)
    return frame_of(pack(values))


def frame_of(data: bytes) -> np.ndarray:
    """Bits of the frame around a payload."""
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
    if length % 2:
        fixed[-43:-35] = True  # padding: low half of the word before the checksum
    return fixed, value


def bytes_of(frame: np.ndarray, length: int) -> tuple[bytes, int]:
    """Payload and checksum of a frame; the payload's length is not read from it."""
    words = frame[len(SYNC) :].reshape(-1, 17)[:, :16].astype(np.uint8)
    body = np.packbits(words).tobytes()
    return body[2 : 2 + length], int.from_bytes(body[-4:], "little")
