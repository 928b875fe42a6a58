"""Second generation: turns of the stations, and the hits of their two planes of light.

A station has one rotor. Its light carries its place in the turn, from which a receiver computes
when the turn began, but with 20 to 60 urad of noise: so a turn is timed by the line through many
begins and the swing about it, never by a single one. Turns of two stations slide through each
other.

Periods by channel: crazyflie-firmware, `pulse_processor_v2.c`; angles of the planes likewise, and
as in libsurvive's `survive_process_gen2.c`.

Calibration frames (OOTX), one bit a turn, are those of `ootx`, of a payload of 43 bytes: 443 bits,
8.2 to 8.9 s. A frame begins anywhere, so that 17.7 s hold a whole one for certain. Layout as in
libsurvive's `ootx_decoder.h` and the Crazyflie firmware; the accelerometer has the axes of the
first generation's.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.decode import ootx
from mocap_metrology.lighthouse.decode.clean import sweep_medians
from mocap_metrology.lighthouse.decode.comb import fit_clock
from mocap_metrology.lighthouse.decode.flashes import counts_of
from mocap_metrology.lighthouse.decode.wander import Delay, TurnClock, wander
from mocap_metrology.lighthouse.records import Factory, Hits, Inertial, Pulses, Station, is_new
from mocap_metrology.lighthouse.timing import TICKS_PER_S

PERIOD_TICKS = (
    *(959000, 957000, 953000, 949000, 947000, 943000, 941000, 939000),
    *(937000, 929000, 919000, 911000, 907000, 901000, 893000, 887000),
)
PERIOD_S = np.array(PERIOD_TICKS) / TICKS_PER_S  # of a turn, by channel index
PLANE_RAD = np.array([2, 4]) * np.pi / 3  # angle of the rotor where a plane is straight ahead
LARGEST_RAD = 1.2  # of an angle that a station can sweep with both planes
DOUBTFUL_RAD = 0.05 * np.pi  # of the rotor about half a turn, where either plane may sweep
NEAR_RAD = 0.35  # of the angles of a plane before and after: an object is no larger
FEWEST_BEGINS = 12  # of a station
LARGEST_PPM = 100.0  # of a period: eight recordings have -12 to 6
OUTLIER_S = 2e-6  # least deviation of a begin that is left out
DRIFT_S = 15e-6  # from turn to turn: half the difference of two periods
REPEATED = 0.25  # share of the pulses of a diode
FATES = ("no_sweep", "second_on_diode", "hit")
NO_SWEEP, SECOND, HIT = range(len(FATES))
LENGTH = 43
PROTOCOLS = {LENGTH: (8,)}
# Firmware and protocol, id; phase, tilt; unlock count, hardware; curve; accelerometer; gibphase,
# gibmag; channel, faults; ogeephase, ogeemag; unknown.
LAYOUT = struct.Struct("<HI2e2eBB2e3b2e2eBB2e2eH")
CHANNEL = 0x80  # plus the channel index
PHASE_LIMITS = {"gibphase": 7.0, "ogeephase": 7.0}


@dataclass(frozen=True)
class Light:
    """What a receiver tells of second-generation light, all by its clock."""

    begin_channel: np.ndarray  # int8, index 0 to 15, of each begin of a turn that was computed
    begin_s: np.ndarray
    begin_bit: np.ndarray  # int8, of the station's data; -1 unknown
    hit_channel: np.ndarray  # int8
    hit_diode: np.ndarray  # int16
    hit_s: np.ndarray
    n_diodes: int
    duration_s: float
    resolution_s: float
    notes: tuple[str, ...] = ()
    inertial: Inertial | None = None
    normals: np.ndarray | None = None  # (n_diodes, 3), unit vectors out of the diodes
    host_s: float = float("nan")  # time 0 by the clock of the computer


@dataclass(frozen=True)
class Turns:
    """Turns of a station: those with a begin, one each, rising."""

    channel: int
    clock: TurnClock
    turn: np.ndarray  # from 0, missed ones counted
    late: Delay  # off the clock
    bit: np.ndarray  # int8; -1 unknown

    def place(self, time_s: Floats) -> tuple[np.ndarray, Floats]:
        """Turn at these times, and angle of the rotor in it, rad.

        The rotor swings, so what it is late by is taken at the time, not at the begin of its turn:
        half a turn later it can be 0.1 us more.
        """
        passed = (time_s - self.clock.epoch_s) / self.clock.cycle_s
        turn = np.floor(passed).astype(np.int64)
        return turn, 2 * np.pi * (passed - turn - self.late(passed) / self.clock.cycle_s)


def find_turns(light: Light) -> tuple[list[Turns], list[str]]:
    """Turns of all stations by rising channel, and why light of a channel was ignored."""
    combs, notes = [], []
    for channel in np.unique(np.r_[light.begin_channel, light.hit_channel]):
        rows = np.flatnonzero(light.begin_channel == channel)
        rows = rows[np.argsort(light.begin_s[rows], kind="stable")]
        why, turns = "too few", None
        if rows.size >= FEWEST_BEGINS:
            why = f"not {1e3 * PERIOD_S[channel]:.3f} ms apart, as turns of such a station are"
            turns = _turns(channel, light.begin_s[rows], light.begin_bit[rows], light.resolution_s)
        if turns is not None:
            combs.append(turns)
        else:
            n = int((light.hit_channel == channel).sum())
            notes.append(f"channel {channel}: {rows.size} begins of turns, {why}; {n} hits ignored")
    return combs, notes


def _turns(channel: int, begin_s: Floats, bit: np.ndarray, resolution_s: float) -> Turns | None:
    """Turns of one station, begins being sorted; None where these are not of its period."""
    nominal = PERIOD_S[channel]
    turn = np.cumsum(np.round(np.diff(begin_s, prepend=begin_s[:1]) / nominal)).astype(np.int64)
    first = np.flatnonzero(np.diff(turn, prepend=-1))
    if first.size < FEWEST_BEGINS:
        return None
    clock, _ = fit_clock(turn[first], begin_s[first])
    residual = begin_s - clock.start(turn)
    used = np.flatnonzero(np.abs(residual) <= max(5 * clock.rms_s, OUTLIER_S))
    right = abs(clock.cycle_s / nominal - 1) <= 1e-6 * LARGEST_PPM
    if not right or used.size < max(FEWEST_BEGINS, turn.size // 2):
        return None
    # A receiver that tells a begin with each plane tells it twice.
    known, first, which = np.unique(turn[used], return_index=True, return_inverse=True)
    mean = np.bincount(which, residual[used]) / np.bincount(which)
    late, its = wander(known, mean, resolution_s)
    told = int(known[0]), int(known[-1])
    share = known.size / (1 + told[1] - told[0])
    of_turns = TurnClock(**vars(clock), **vars(its), told=told, share=share)
    return Turns(int(channel), of_turns, known, late, bit[used][first])


def find_turn_hits(light: Light, turns: list[Turns]) -> tuple[Hits, dict[str, list[int]]]:
    """Hits of all stations by time, and how many went where, a count for each diode.

    Report: `hit`, and what was dropped: `no_sweep` where no plane can be, beyond 1.2 rad or of a
    channel without turns; `second_on_diode` of two hits on a diode in a sweep, of which the one
    nearer to the median of the sweep remains.
    """
    fate = np.full(light.hit_s.size, NO_SWEEP, np.int8)
    station, plane = np.empty((2, fate.size), np.int8)
    turn, angle = np.empty(fate.size, np.int64), np.empty(fate.size)
    for index, one in enumerate(turns):
        rows = np.flatnonzero(light.hit_channel == one.channel)
        time_s = light.hit_s[rows]
        turn[rows], rotor = one.place(time_s)
        plane[rows], good = _plane(rotor, time_s)
        angle[rows] = rotor - PLANE_RAD[plane[rows]]
        rows = rows[good & (np.abs(angle[rows]) <= LARGEST_RAD)]
        station[rows], fate[rows] = index, HIT
    chosen = np.flatnonzero(fate == HIT)
    whole = (column[chosen] for column in (station, plane, turn, light.hit_diode))
    hits = Hits.of(*whole, time_s=light.hit_s[chosen], angle_rad=angle[chosen])
    off = np.abs(hits.angle_rad - sweep_medians(hits))
    order = np.lexsort((off, hits.diode, hits.axis, hits.station, hits.cycle))
    keys = (key[order] for key in (hits.cycle, hits.station, hits.axis, hits.diode))
    first = is_new(*keys)
    fate[chosen[order[~first]]] = SECOND
    hits = hits.take(np.sort(order[first]))
    order = np.argsort(hits.time_s, kind="stable")
    return hits.take(order), counts_of(FATES, fate, light.hit_diode, light.n_diodes)


def channels_by_period(pulses: Pulses) -> list[int]:
    """Channels whose period the pulses of a diode repeat with: what a dump without the data of the
    light still shows of second-generation stations; empty where none does.

    A moving diode is met up to `DRIFT_S` early or late in the next turn.
    """
    if not pulses.start_s.size:
        return []
    start = pulses.start_s[pulses.diode == np.argmax(np.bincount(pulses.diode))]
    next_turn = start + PERIOD_S[:, None]
    first, last = (np.searchsorted(start, next_turn + off) for off in (-DRIFT_S, DRIFT_S))
    again = (last > first).mean(axis=1)
    by_chance = start.size / max(pulses.duration_s, 1e-3) * 2 * DRIFT_S
    return np.flatnonzero(again > max(REPEATED, 5 * by_chance)).tolist()


def _plane(rotor: Floats, time_s: Floats) -> tuple[np.ndarray, np.ndarray]:
    """Plane of each hit, and whether it is known: about half a turn, where the fields of both
    planes overlap, it is the one whose other hits about that time are the nearer, or the one that
    has none where those of the other are far."""
    plane: np.ndarray = (rotor >= np.pi).astype(np.int8)
    doubtful = np.abs(rotor - np.pi) <= DOUBTFUL_RAD
    known = ~doubtful
    if not doubtful.any():
        return plane, known
    off = np.full((2, int(doubtful.sum())), NEAR_RAD)
    for k in (0, 1):
        sure = np.flatnonzero(known & (plane == k))
        if sure.size:
            sure = sure[np.argsort(time_s[sure])]
            usual = np.interp(time_s[doubtful], time_s[sure], rotor[sure])
            off[k] = np.abs(rotor[doubtful] - usual)
    plane[doubtful] = np.argmin(off, axis=0)
    known[doubtful] = off.min(axis=0) <= NEAR_RAD
    return plane, known


def decode_turns(turns: Turns) -> Station:
    """Calibration of the station whose turns these are, as `ootx.decode_station`."""
    bits = np.full(int(turns.turn[-1] - turns.turn[0]) + 1, -1, np.int8)
    bits[turns.turn - turns.turn[0]] = turns.bit
    payload = ootx.Payload(
        PROTOCOLS,
        partial(unpack, channel=turns.channel),
        lambda data: data[2:14] + data[16:20] + data[23:31] + data[33:41],
    )
    return ootx.station_of(bits, unknown_station(turns.channel), payload)


def unknown_station(channel: int, why: str = "") -> Station:
    """A station of which only the channel is known."""
    return Station(str(channel), why=why, generation=2, channel=channel)


def unpack(data: bytes, channel: int | None = None) -> Station:
    """Station of a payload of 43 bytes, which names its channel index. Raises `Refusal` where a
    value is none of a second-generation station, or the channel is another than the given one."""
    v = LAYOUT.unpack(data)
    if (v[0] & 63) not in PROTOCOLS[LENGTH]:
        raise Refusal(f"protocol {v[0] & 63} of {len(data)} bytes; expected 8 of {LENGTH}")
    named = v[17] - CHANNEL
    if not 0 <= named < 16 or channel not in (None, named):
        raise Refusal(f"channel {v[17]:#x} in a frame of channel {channel}")
    station = ootx.station_of_payload(
        v, str(named), (2, 4, 8, 13, 15, 19, 21), PHASE_LIMITS, generation=2
    )
    return replace(station, channel=named)


def encode_frame2(
    factory: Factory, id: int, channel: int, gravity_int8: tuple[int, int, int]
) -> np.ndarray:
    """Bits of one frame, uint8 (443,), as `ootx.encode_frame`."""
    # Firmware and protocol, hardware.
    first = ootx.values(factory, 300 << 6 | 8, id, 1, 14, gravity_int8)
    rest = CHANNEL + channel, 0, *factory.ogeephase, *factory.ogeemag, 0
    return ootx.frame_of(LAYOUT.pack(*first, *rest))
