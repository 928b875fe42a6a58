"""Both angles of every diode at one moment, out of sweeps that measure one at a time (J IV); and
these as an optics sees them: ideal, or with factory values.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mocap_metrology.lighthouse.board import FEWEST_DIODES
from mocap_metrology.lighthouse.calibrate.superpose import lagrange
from mocap_metrology.lighthouse.records import Hits, Measurements
from mocap_metrology.lighthouse.timing import CYCLE_S

METHODS = ("full-interpolation", "dominant-axis", "pairs")
LONGEST_GAP_S = 8.5 * CYCLE_S  # one sweep of an axis (each 4 cycles) may be missing, not two
PAIR_GAP_S = 1.5 * CYCLE_S


@dataclass(frozen=True)
class _Sweeps:
    """All sweeps of one rotor: time (k, diodes) and angle (k, diodes) of hits, NaN if missing."""

    middle_s: np.ndarray  # (k,) mean time of the hits
    time_s: np.ndarray
    angle_rad: np.ndarray


def _sweeps(hits: Hits, station: int, axis: int, n_diodes: int) -> _Sweeps:
    of_axis = hits.take((hits.station == station) & (hits.axis == axis))
    cycles, row = np.unique(of_axis.cycle, return_inverse=True)
    time = np.full((cycles.size, n_diodes), np.nan)
    angle = np.full((cycles.size, n_diodes), np.nan)
    time[row, of_axis.diode], angle[row, of_axis.diode] = of_axis.time_s, of_axis.angle_rad
    counts = np.bincount(row, minlength=cycles.size)
    middle = np.bincount(row, of_axis.time_s, minlength=cycles.size) / np.maximum(counts, 1)
    return _Sweeps(middle, time, angle)


def reconstruct(
    hits: Hits, station: int, n_diodes: int, method: str = "full-interpolation", order: int = 1
) -> Measurements:
    """Measurements of a station by one of the methods of J IV; those with four diodes or more.

    full-interpolation: at every sweep the other angle is interpolated linearly, diode by diode,
    between the sweeps before and after (J's choice); dominant-axis: the same, but only at sweeps of
    the angle that varies more; pairs: an azimuth sweep and the elevation sweep that follows it are
    taken as one moment, in the middle of both. order 3 interpolates by the cubic through the two
    sweeps on either side, diode by diode where all four saw it, and takes both angles of all diodes
    at the middle of the sweep: within it the board moves on, which in the end turns its poses.
    """
    sweeps = [_sweeps(hits, station, axis, n_diodes) for axis in (0, 1)]
    if method == "pairs":
        parts = [_pairs(sweeps)]
    else:
        axes: tuple[int, ...] = (0, 1)
        if method == "dominant-axis":
            mean = [np.nanmean(s.angle_rad, axis=1) if len(s.middle_s) else 0.0 for s in sweeps]
            axes = (int(np.nanvar(mean[1]) > np.nanvar(mean[0])),)
        parts = [_interpolated(sweeps, axis, order) for axis in axes]
    time = np.concatenate([part[0] for part in parts])
    angles = np.concatenate([part[1] for part in parts])
    angles[~np.isfinite(angles).all(axis=2)] = np.nan
    enough = np.isfinite(angles[:, :, 0]).sum(axis=1) >= FEWEST_DIODES
    rows = np.flatnonzero(enough)[np.argsort(time[enough], kind="stable")]
    return Measurements(time[rows], angles[rows])


def _interpolated(sweeps: list[_Sweeps], axis: int, order: int) -> tuple[np.ndarray, np.ndarray]:
    """Measurements at the sweeps of `axis`, the other angle interpolated to each diode's time."""
    sweep, other = sweeps[axis], sweeps[1 - axis]
    if order == 3 and sweep.middle_s.size > 2:
        sweep = _at_middle(sweep)
    angles = np.full((*sweep.angle_rad.shape, 2), np.nan)
    count = other.middle_s.size
    if count < 2:
        return sweep.middle_s, angles
    after = np.searchsorted(other.middle_s, sweep.middle_s)
    inside = np.flatnonzero((after > 0) & (after < count))
    near = other.middle_s[after[inside]] - other.middle_s[after[inside] - 1] <= LONGEST_GAP_S
    inside = inside[near]
    a, b = after[inside] - 1, after[inside]
    time = sweep.time_s[inside]
    values = _polynomial(other, np.stack([a, b]), time)
    if order == 3:
        four = np.clip(np.stack([a - 1, a, b, b + 1]), 0, count - 1)
        whole = (a > 0) & (b < count - 1)
        whole &= np.ptp(other.middle_s[four], axis=0) <= 3 * LONGEST_GAP_S
        cubic = _polynomial(other, four[:, whole], time[whole])
        values[whole] = np.where(np.isfinite(cubic), cubic, values[whole])
    angles[inside, :, axis] = sweep.angle_rad[inside]
    angles[inside, :, 1 - axis] = values
    return sweep.middle_s, angles


def _at_middle(sweeps: _Sweeps) -> _Sweeps:
    """The angles moved to the middle of their sweep, by the rate of each diode between the sweeps
    before and after, or where these lack it by the median rate of the others."""
    angle, time = sweeps.angle_rad, sweeps.time_s
    rate = np.full_like(angle, np.nan)
    rate[1:-1] = (angle[2:] - angle[:-2]) / (time[2:] - time[:-2])
    rate[0], rate[-1] = rate[1], rate[-2]
    known = np.isfinite(rate).any(axis=1)
    common = np.zeros(len(rate))
    common[known] = np.nanmedian(rate[known], axis=1)
    rate = np.where(np.isfinite(rate), rate, common[:, None])
    middle = np.where(np.isfinite(time), sweeps.middle_s[:, None], np.nan)
    return _Sweeps(sweeps.middle_s, middle, angle + rate * (middle - time))


def _polynomial(sweeps: _Sweeps, nodes: np.ndarray, time_s: np.ndarray) -> np.ndarray:
    """Angles (n, diodes) at `time_s` of the polynomial through the sweeps `nodes` (k, n)."""
    return (lagrange(sweeps.time_s[nodes], time_s) * sweeps.angle_rad[nodes]).sum(axis=0)


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


@dataclass(frozen=True)
class Optics:
    """Measurements of all stations as an optics sees them, and the rotors that go with these."""

    name: str
    measurements: tuple[Measurements, ...]
    rotors: tuple[np.ndarray, ...]
    frame: str  # optical, or housing where the lasers' places are named
