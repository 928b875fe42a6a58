"""Both angles of every diode at one moment, out of sweeps that measure one at a time (J IV)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mocap_metrology.lighthouse.records import Hits
from mocap_metrology.lighthouse.timing import CYCLE_S

METHODS = ("full-interpolation", "dominant-axis", "pairs")
FEWEST_DIODES = 4
LONGEST_GAP_S = 6.5 * CYCLE_S  # one sweep of an axis (each 4 cycles) may be missing, not two
PAIR_GAP_S = 1.5 * CYCLE_S


@dataclass(frozen=True)
class Measurements:
    """M_t of J Eq. 2 at n moments, of one station.

    time_s (n,); angles_rad (n, diodes, 2): azimuth and elevation, NaN where either is missing.
    """

    time_s: np.ndarray
    angles_rad: np.ndarray

    def __len__(self) -> int:
        return int(self.time_s.size)

    @property
    def seen(self) -> np.ndarray:
        """Diodes with both angles, (n, diodes)."""
        return np.isfinite(self.angles_rad).all(axis=2)


@dataclass(frozen=True)
class _Sweeps:
    """All sweeps of one rotor: time (k, diodes) and angle (k, diodes) of hits, NaN if missing."""

    middle_s: np.ndarray  # (k,) mean time of the hits
    time_s: np.ndarray
    angle_rad: np.ndarray


def _sweeps(hits: Hits, station: int, axis: int, n_diodes: int) -> _Sweeps:
    own = hits.take((hits.station == station) & (hits.axis == axis))
    cycles, row = np.unique(own.cycle, return_inverse=True)
    time = np.full((cycles.size, n_diodes), np.nan)
    angle = np.full((cycles.size, n_diodes), np.nan)
    time[row, own.diode], angle[row, own.diode] = own.time_s, own.angle_rad
    counts = np.bincount(row, minlength=cycles.size)
    middle = np.bincount(row, own.time_s, minlength=cycles.size) / np.maximum(counts, 1)
    return _Sweeps(middle, time, angle)


def reconstruct(
    hits: Hits, station: int, n_diodes: int, method: str = "full-interpolation"
) -> Measurements:
    """Measurements of a station by one of the methods of J IV; those with four diodes or more.

    full-interpolation: at every sweep the other angle is interpolated linearly, diode by diode,
    between the sweeps before and after (J's choice); dominant-axis: the same, but only at sweeps of
    the angle that varies more; pairs: an azimuth sweep and the elevation sweep that follows it are
    taken as one moment, in the middle of both.
    """
    if method not in METHODS:
        raise ValueError(f"reconstruction is {method!r}; expected one of {', '.join(METHODS)}")
    sweeps = [_sweeps(hits, station, axis, n_diodes) for axis in (0, 1)]
    parts: list[Callable[[], tuple[np.ndarray, np.ndarray]]] = {
        "full-interpolation": lambda: [_interpolated(sweeps, axis) for axis in (0, 1)],
        "dominant-axis": lambda: [_interpolated(sweeps, _dominant(sweeps))],
        "pairs": lambda: [_pairs(sweeps)],
    }[method]()
    time = np.concatenate([part[0] for part in parts])
    angles = np.concatenate([part[1] for part in parts])
    angles[~np.isfinite(angles).all(axis=2)] = np.nan
    enough = np.isfinite(angles[:, :, 0]).sum(axis=1) >= FEWEST_DIODES
    order = np.flatnonzero(enough)[np.argsort(time[enough], kind="stable")]
    return Measurements(time[order], angles[order])


def _interpolated(sweeps: list[_Sweeps], axis: int) -> tuple[np.ndarray, np.ndarray]:
    """Measurements at the sweeps of `axis`, the other angle interpolated to each diode's time."""
    own, other = sweeps[axis], sweeps[1 - axis]
    angles = np.full((*own.angle_rad.shape, 2), np.nan)
    if other.middle_s.size < 2:
        return own.middle_s, angles
    after = np.searchsorted(other.middle_s, own.middle_s)
    inside = np.flatnonzero((after > 0) & (after < other.middle_s.size))
    a, b = after[inside] - 1, after[inside]
    inside, a, b = (
        part[other.middle_s[b] - other.middle_s[a] <= LONGEST_GAP_S] for part in (inside, a, b)
    )
    share = (own.time_s[inside] - other.time_s[a]) / (other.time_s[b] - other.time_s[a])
    step = other.angle_rad[b] - other.angle_rad[a]
    angles[inside, :, axis] = own.angle_rad[inside]
    angles[inside, :, 1 - axis] = other.angle_rad[a] + share * step
    return own.middle_s, angles


def _dominant(sweeps: list[_Sweeps]) -> int:
    """The axis whose angles varied more over the recording."""
    spread = [np.nanvar(np.nanmean(s.angle_rad, axis=1)) if len(s.middle_s) else 0 for s in sweeps]
    return int(spread[1] > spread[0])


def _pairs(sweeps: list[_Sweeps]) -> tuple[np.ndarray, np.ndarray]:
    """An azimuth sweep and the elevation sweep right after it, at the middle of both."""
    first, second = sweeps
    follower = np.searchsorted(second.middle_s, first.middle_s)
    known = np.flatnonzero(follower < second.middle_s.size)
    follower = follower[known]
    near = second.middle_s[follower] - first.middle_s[known] <= PAIR_GAP_S
    known, follower = known[near], follower[near]
    time = (first.middle_s[known] + second.middle_s[follower]) / 2
    return time, np.stack([first.angle_rad[known], second.angle_rad[follower]], axis=2)
