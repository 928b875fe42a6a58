"""Second-generation light, and gyroscope and accelerometer, in recordings of libsurvive.

    seconds object W channel sensor time half         a hit; half = 1 adds half a tick
    seconds object Y channel time bit gen             begin of a turn, as the receiver computes it
    seconds object B channel sensor time plane theta  what libsurvive made of W

time in ticks of 48 MHz of a 32-bit counter of the object; seconds those of the computer. Sensors
are numbered as the positions in CONFIG. Y lines come late and out of order. A counter can restart,
and single lines are off by 2^24 ticks: both are told by the seconds, which lag by milliseconds. A
counter that jumps by less is told by the begins of turns, which are a period apart.

    seconds object I mask time ax ay az gx gy gz ...

time in ticks of 48 MHz of a 32-bit counter, the one of the pulses; forces in g, at rest 1 upwards,
and rates in rad/s, in axes of the sensors. Where these are on the object is in its CONFIG:
controllers have `imu` with `plus_x`, `plus_z` and `position`, headsets `trackref_from_imu`, a
quaternion x, y, z, w and the position.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from itertools import chain

import numpy as np
from scipy import ndimage

from mocap_metrology.common.errors import UNREADABLE, Refusal
from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.decode.turns import PERIOD_S, Light
from mocap_metrology.lighthouse.records import Inertial
from mocap_metrology.lighthouse.rotation import of_quaternions
from mocap_metrology.lighthouse.timing import TICKS_PER_S

W, Y, B = range(3)
OPERATIONS = {b"W": W, b"Y": Y, b"B": B}
STRAY_S = 0.12  # between a line's time and those of others of its moment: 2^24 ticks are 0.35 s
FARTHEST_S = 2.0  # likewise from those of the whole recording, by drift and delay
MOMENT = 256  # lines
JUMP = 2e-3  # of a turn, 17 us, by which begins are off those before: clocks differ by 1e-5
FEW = 15  # begins, of which the median is taken
LENGTH_OF_NORMAL = 0.1  # deviation from 1 that is damage
WRAP = 1 << 32
G_M_S2 = 9.80665
LARGEST = np.r_[np.full(3, 64.0), np.full(3, 100.0)]  # g and rad/s; beyond it a row is damaged
FARTHEST_M = 0.5  # from the diodes' origin
UNIT = 0.01  # of the length of an axis or quaternion
NUMBER = rb"([-+]?\d{1,12}\.?\d{0,12}(?:[eE][-+]?\d{1,3})?)"


def sensor_rows(block: bytes, wanted: bytes) -> tuple[np.ndarray, int]:
    """Counter, force and rate (n, 7) of the lines of an object, and how many cannot be read."""
    if b" I " not in block:
        return np.zeros((0, 7)), 0
    begin = rb"^[\d.]+ +" + re.escape(wanted) + rb" +I"
    matches = re.findall(
        begin + rb" +\d{1,6} +(\d{1,10})" + 6 * (rb" +" + NUMBER) + rb"(?:\s|$)", block, re.M
    )
    n_lines = len(re.findall(begin + rb"(?=\s)", block, re.M))
    values = np.array(matches, dtype="S32").astype(np.float64).reshape(-1, 7)
    fits = (np.abs(values[:, 1:]) <= LARGEST).all(axis=1) & (values[:, 0] < WRAP)
    return values[fits], n_lines - int(fits.sum())


def unrolled(counter: np.ndarray, begin: int) -> np.ndarray:
    """Ticks since `begin` of a counter of 32 bit; each is within 44.7 s of the one before."""
    step = (np.diff(counter, prepend=begin) + WRAP // 2) % WRAP - WRAP // 2
    return np.cumsum(step)


def sensors_in(values: np.ndarray, config: Mapping[str, object], begin: int) -> Inertial | None:
    """The sensors in axes of the object, from where the counter of the pulses is `begin` on; None
    without rows, or where the object does not describe them."""
    placed = _sensor_pose(config)
    if placed is None or not len(values):
        return None
    R, place = placed
    time = unrolled(values[:, 0].astype(np.int64), begin) / TICKS_PER_S
    order = np.argsort(time, kind="stable")
    order = order[np.r_[True, np.diff(time[order]) > 0]]
    return Inertial(time[order], values[order, 4:] @ R.T, G_M_S2 * values[order, 1:4] @ R.T, place)


def _sensor_pose(config: Mapping[str, object]) -> tuple[np.ndarray, np.ndarray] | None:
    """Rotation of the sensors' axes into the object's, and their place in m."""
    try:
        if "trackref_from_imu" in config:
            both = np.array(config["trackref_from_imu"], dtype=np.float64)
            if both.shape != (7,) or abs(np.linalg.norm(both[:4]) - 1) > UNIT:
                return None
            R, place = of_quaternions(both[:4]), both[4:]
        else:
            sensor = config["imu"]
            x, z, place = (
                np.array(sensor[name], dtype=np.float64)  # type: ignore[index]
                for name in ("plus_x", "plus_z", "position")
            )
            off = np.array([np.linalg.norm(x) - 1, np.linalg.norm(z) - 1, x @ z])
            if (np.abs(off) > UNIT).any():
                return None
            y = np.cross(z, x)
            R = np.column_stack([np.cross(y, z), y, z])
            R /= np.linalg.norm(R, axis=0)
    except UNREADABLE:
        return None
    if place.shape != (3,) or not np.isfinite(place).all() or np.linalg.norm(place) > FARTHEST_M:
        return None
    return R, place


def light_rows(block: bytes, wanted: bytes) -> tuple[np.ndarray, int]:
    """Seconds, operation and four whole numbers (n, 6) of the lines of an object in their order,
    and how many cannot be read; B lines where the block has no W."""
    if b" Y " not in block and b" W " not in block:
        return np.zeros((0, 6)), 0
    hits = b"W" if b" W " in block else b"B"
    begin = rb"^(\d+\.?\d*) +" + re.escape(wanted) + rb" +([Y" + hits + rb"])"
    matches = re.findall(begin + 4 * rb" +(\d{1,10})" + rb"(?: +\S+)?\r*$", block, re.M)
    n_lines = len(re.findall(begin + rb"(?=\s)", block, re.M))
    words = b" ".join(chain.from_iterable(matches))
    for name, number in OPERATIONS.items():
        words = words.replace(name, b"%d" % number)
    values = np.fromstring(words, sep=" ").reshape(-1, 6)
    time = np.where(values[:, 1] == Y, values[:, 3], values[:, 4])
    fits = (values[:, 2] < PERIOD_S.size) & (time < WRAP)
    return values[fits], n_lines - int(fits.sum())


def light_of(
    values: Floats, sensors: Floats, config: Mapping[str, object], n_diodes: int, name: str
) -> Light:
    """Light on an object out of its `light_rows`, and its gyroscope and accelerometer out of its
    `sensor_rows`. Raises `Refusal` where there are no hits."""
    of_b = not (values[:, 1] == W).any()
    values = values[(values[:, 1] == Y) | (values[:, 1] == (B if of_b else W))]
    begins = values[:, 1] == Y
    counter = np.where(begins, values[:, 3], values[:, 4])
    ticks, valid, lag = _ticks(counter, values[:, 0])
    valid &= _of_one_count(ticks, valid & begins, values[:, 2])
    notes = []
    if not valid.all():
        notes.append(
            f"{int((~valid).sum())} of {valid.size} lines are of another count of the object's"
            " clock and are left out"
        )
    if of_b:
        notes.append("no W lines: hits are taken from B lines, without half ticks")
    known = valid & (begins | (values[:, 3] < n_diodes))
    if (strange := int((valid & ~known).sum())) > 0:
        notes.append(f"{strange} hits are on none of the {n_diodes} sensors and are left out")
    values, ticks, begins = values[known], ticks[known], begins[known]
    if begins.all():
        raise Refusal(f"{name}: no hits (W lines) of the object; expected second-generation light")
    zero = float(ticks.min())
    half = np.where(begins | of_b, 0.0, 0.5 * values[:, 5])
    time_s = (ticks - zero + half) / TICKS_PER_S
    hits = ~begins
    return Light(
        begin_channel=values[begins, 2].astype(np.int8),
        begin_s=time_s[begins],
        begin_bit=(values[begins, 4] > 0).astype(np.int8),
        hit_channel=values[hits, 2].astype(np.int8),
        hit_diode=values[hits, 3].astype(np.int16),
        hit_s=time_s[hits],
        n_diodes=n_diodes,
        duration_s=float(np.ptp(time_s)),
        resolution_s=(1.0 if of_b else 0.5) / TICKS_PER_S,
        notes=tuple(notes),
        inertial=sensors_in(sensors, config, int(zero) % WRAP),
        normals=normals_of(config, n_diodes),
        host_s=zero / TICKS_PER_S + lag,
    )


def _ticks(counter: Floats, host_s: Floats) -> tuple[Floats, np.ndarray, float]:
    """Ticks since the counter's zero nearest to host time 0; the lines that are to be trusted, of
    the most common difference between both times and near the others of their moment; and this
    difference."""
    period = WRAP / TICKS_PER_S
    lag = np.mod(host_s - counter / TICKS_PER_S, period)
    whole = np.sort(np.concatenate([lag, lag + period]))
    inside = np.searchsorted(whole, whole + STRAY_S) - np.arange(whole.size)
    first = int(np.argmax(inside))
    usual = float(np.median(whole[first : first + inside[first]]))
    off = np.mod(lag - usual + period / 2, period) - period / 2
    near = np.abs(off) <= FARTHEST_S
    local = np.flatnonzero(near)
    for some in np.array_split(local, max(1, local.size // MOMENT)):
        near[some] = np.abs(off[some] - np.median(off[some])) <= STRAY_S
    wraps = np.round((host_s - usual - counter / TICKS_PER_S) / period)
    return counter + WRAP * wraps, near, usual


def _of_one_count(ticks: Floats, begins: np.ndarray, channel: Floats) -> np.ndarray:
    """The longest part of the lines, in their order, between jumps of the counter: there begins of
    the turns of a station are no longer whole periods after those before."""
    ends = {0, ticks.size}
    for rows in (np.flatnonzero(begins & (channel == one)) for one in np.unique(channel[begins])):
        turns = np.diff(ticks[rows]) / (TICKS_PER_S * PERIOD_S[int(channel[rows[0]])])
        off = turns - np.round(turns)
        near = (np.round(turns) == 1) & (np.abs(off) < JUMP)
        if np.count_nonzero(near) <= FEW:
            continue
        phase = np.cumsum(off - np.round(turns) * off[near].mean())
        step = np.diff(ndimage.median_filter(phase, FEW, mode="nearest"))
        ends |= set(rows[2:][np.abs(step) > JUMP].tolist())
    at = np.sort(list(ends))
    k = int(np.argmax(np.diff(at)))
    return np.isin(np.arange(ticks.size), np.arange(at[k], at[k + 1]))


def normals_of(config: Mapping[str, object], n_diodes: int) -> np.ndarray | None:
    """Unit vectors along which the sensors look, where the object describes them."""
    try:
        normals = np.array(config["lighthouse_config"]["modelNormals"], np.float64)  # type: ignore
        length = np.linalg.norm(normals, axis=1, keepdims=True)
    except UNREADABLE:
        return None
    if normals.shape != (n_diodes, 3) or not (np.abs(length - 1) <= LENGTH_OF_NORMAL).all():
        return None
    return normals / length
