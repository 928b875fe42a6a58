"""Calibration of a second-generation station (OOTX) out of the bits of its turns, one a turn.

Frames are those of `ootx`, with a payload of 43 bytes: 443 bits, 8.2 to 8.9 s. A frame begins
anywhere, so that 17.7 s hold a whole one for certain. Layout as in libsurvive's `ootx_decoder.h`
and the Crazyflie firmware; the accelerometer has the axes of the first generation's.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from functools import partial

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse import planes
from mocap_metrology.lighthouse.decode.ootx import (
    Payload,
    check_limits,
    frame_of,
    station_of,
    up_of,
)
from mocap_metrology.lighthouse.decode.turns import Turns
from mocap_metrology.lighthouse.records import Factory, Station

LENGTH = 43
PROTOCOLS = {LENGTH: (8,)}
# Firmware and protocol, id; phase, tilt; unlock count, hardware; curve; accelerometer; gibphase,
# gibmag; channel, faults; ogeephase, ogeemag; unknown.
LAYOUT = struct.Struct("<HI2e2eBB2e3b2e2eBB2e2eH")
CHANNEL = 0x80  # plus the channel index
PHASE_LIMITS = (("gibphase", 7.0), ("ogeephase", 7.0))


def decode_turns(turns: Turns) -> Station:
    """Calibration of the station whose turns these are.

    Without a frame of right checksum `factory` is None and `why` states the reason in one line.
    """
    bits = np.full(int(turns.turn[-1] - turns.turn[0]) + 1, -1, np.int8)
    bits[turns.turn - turns.turn[0]] = turns.bit
    payload = Payload(
        PROTOCOLS,
        partial(unpack, channel=turns.channel),
        lambda data: data[2:14] + data[16:20] + data[23:31] + data[33:41],
    )
    return station_of(bits, unknown_station(turns.channel), payload)


def unknown_station(channel: int, why: str = "") -> Station:
    """A station of which only the channel is known."""
    return Station(str(channel), why=why, generation=2, channel=channel)


def unpack(data: bytes, channel: int | None = None) -> Station:
    """Station of a payload of 43 bytes, which names its channel index.

    Raises `Refusal` where a value is none that a second-generation station can have, or the channel
    is another than the given one.
    """
    v = LAYOUT.unpack(data)
    if (v[0] & 63) not in PROTOCOLS[LENGTH]:
        raise Refusal(f"protocol {v[0] & 63} of {len(data)} bytes; expected 8 of {LENGTH}")
    named = v[17] - CHANNEL
    if not 0 <= named < 16 or channel not in (None, named):
        raise Refusal(f"channel {v[17]:#x} in a frame of channel {channel}")
    pairs = (np.array(v[i : i + 2]) for i in (2, 4, 8, 13, 15, 19, 21))
    factory = Factory(*pairs, generation=2)
    check_limits(factory, PHASE_LIMITS)
    planes.parameters(factory, full=True)
    return Station(
        str(named),
        id=v[1],
        factory=factory,
        gravity=up_of(v[10:13]),
        firmware=v[0] >> 6,
        hardware=v[7],
        generation=2,
        channel=named,
    )


def encode_frame2(
    factory: Factory, id: int, channel: int, gravity_int8: tuple[int, int, int]
) -> np.ndarray:
    """Bits of one frame, uint8 (443,), to be sent over and over; reals are rounded to float16.

    gravity_int8 are the accelerometer's x, y, z as in `ootx.accel_of`.
    """
    values: Mapping[str, np.ndarray] = vars(factory)
    data = LAYOUT.pack(
        300 << 6 | 8,  # firmware and protocol
        id,
        *values["phase"],
        *values["tilt"],
        1,
        14,  # hardware
        *values["curve"],
        *gravity_int8,
        *values["gibphase"],
        *values["gibmag"],
        CHANNEL + channel,
        0,
        *values["ogeephase"],
        *values["ogeemag"],
        0,
    )
    return frame_of(data)
