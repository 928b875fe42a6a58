"""Gyroscope and accelerometer in libsurvive recordings.

    seconds object I mask time ax ay az gx gy gz ...

time in ticks of 48 MHz of a 32-bit counter, the one of the pulses; forces in g, at rest 1 upwards,
and rates in rad/s, in axes of the sensors. Where these are on the object is in its CONFIG:
controllers have `imu` with `plus_x`, `plus_z` and `position`, headsets `trackref_from_imu`, a
quaternion x, y, z, w and the position.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from mocap_metrology.common.errors import UNREADABLE
from mocap_metrology.lighthouse.records import Inertial
from mocap_metrology.lighthouse.timing import TICKS_PER_S

WRAP = 1 << 32
G_M_S2 = 9.80665
LARGEST = np.r_[np.full(3, 64.0), np.full(3, 100.0)]  # g and rad/s; beyond it a row is damaged
FARTHEST_M = 0.5  # from the diodes' origin
UNIT = 0.01  # of the length of an axis or quaternion
NUMBER = rb"([-+]?\d{1,12}\.?\d{0,12}(?:[eE][-+]?\d{1,3})?)"


def rows(block: bytes, wanted: bytes) -> tuple[np.ndarray, int]:
    """Counter, force and rate (n, 7) of the lines of an object, and how many cannot be read."""
    if b" I " not in block:
        return np.zeros((0, 7)), 0
    begin = rb"^[\d.]+ +" + re.escape(wanted) + rb" +I"
    found = re.findall(
        begin + rb" +\d{1,6} +(\d{1,10})" + 6 * (rb" +" + NUMBER) + rb"(?:\s|$)", block, re.M
    )
    n_lines = len(re.findall(begin + rb"(?=\s)", block, re.M))
    values = np.array(found, dtype="S32").astype(np.float64).reshape(-1, 7)
    fits = (np.abs(values[:, 1:]) <= LARGEST).all(axis=1) & (values[:, 0] < WRAP)
    return values[fits], n_lines - int(fits.sum())


def unrolled(counter: np.ndarray, begin: int) -> np.ndarray:
    """Ticks since `begin` of a counter of 32 bit; each is within 44.7 s of the one before."""
    step = (np.diff(counter, prepend=begin) + WRAP // 2) % WRAP - WRAP // 2
    ticks: np.ndarray = np.cumsum(step)
    return ticks


def series(values: np.ndarray, config: Mapping[str, object], begin: int) -> Inertial | None:
    """The sensors in axes of the object, from where the counter of the pulses is `begin` on; None
    without rows, or where the object does not describe them."""
    placed = _place(config)
    if placed is None or not len(values):
        return None
    R, place = placed
    time = unrolled(values[:, 0].astype(np.int64), begin) / TICKS_PER_S
    order = np.argsort(time, kind="stable")
    order = order[np.r_[True, np.diff(time[order]) > 0]]
    return Inertial(time[order], values[order, 4:] @ R.T, G_M_S2 * values[order, 1:4] @ R.T, place)


def _place(config: Mapping[str, object]) -> tuple[np.ndarray, np.ndarray] | None:
    """Rotation of the sensors' axes into the object's, and their place in m."""
    from scipy.spatial.transform import Rotation

    try:
        if "trackref_from_imu" in config:
            both = np.array(config["trackref_from_imu"], dtype=np.float64)
            if both.shape != (7,) or abs(np.linalg.norm(both[:4]) - 1) > UNIT:
                return None
            R, place = Rotation.from_quat(both[:4]).as_matrix(), both[4:]
        else:
            own = config["imu"]
            x, z, place = (
                np.array(own[name], dtype=np.float64)  # type: ignore[index]
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
