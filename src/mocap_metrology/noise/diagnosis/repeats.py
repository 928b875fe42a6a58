"""What is not measured: frames that repeat the position before them, and distances within a solved
rigid body.

All three coordinates of a measured marker stay the same from one frame to the next only where the
steps of the file hide its noise, and then it also leaves such a place by a step or two. Where it
leaves by many steps of the file, a coordinate had the same value by chance with a probability of
about step / change, and three of them with far less.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mocap_metrology.noise.diagnosis.fills import Rule
from mocap_metrology.noise.diagnosis.filtering import middle
from mocap_metrology.noise.series import distance, pair_name, position

LEAST_CHANGES = 16  # of frames, to know what a marker does from one to the next
HIDDEN = 0.005  # quantile of the changes: files may have coarser steps than declared
BEYOND = 4.0  # times the share that chance makes of one coordinate
SOLVED = 0.01  # of the variance; of markers that are measured apart it is about 1
LIKELIEST = 1 / 8  # chance of a repeat, from which nothing is reported
MANY = 1e-3  # share of the frames that is reported


@dataclass(frozen=True)
class Repeats:
    """Repeated positions of one marker: share of the frames that repeat the one before; the longest
    such stretch, in frames; change_mm: what the marker does when it leaves one (median)."""

    label: str
    share: float
    longest: int
    change_mm: float


def repeats(
    label: str, position_mm: Sequence[npt.NDArray[np.floating]], step_mm: float
) -> Repeats | None:
    """Frames that repeat the one before, in x, y, z (n,) in mm, NaN in gaps; `step_mm`: resolution
    of the file, 0 where it is not known.

    None where there are no more repeats than chance and the steps of the file make.
    """
    same = np.logical_and.reduce([axis[1:] == axis[:-1] for axis in position_mm])
    count = int(same.sum())
    if not count:
        return None
    moved = ~same
    for axis in position_mm:
        moved &= np.isfinite(_changes(axis))
    if np.count_nonzero(moved) < LEAST_CHANGES:
        return None
    runs = np.flatnonzero(np.diff(np.concatenate([[0], same.view(np.int8), [0]]))).reshape(-1, 2)
    change, chance = _leaving(position_mm, runs, moved, step_mm)
    longest, share = int(np.ptp(runs, axis=1).max()), count / (same.size + 1)
    if chance > LIKELIEST:
        return None
    if share <= max(MANY, BEYOND * chance) and longest < Rule.run(chance):
        return None
    return Repeats(label, share, longest, change)


def _changes(axis: npt.NDArray[np.floating]) -> npt.NDArray[np.float64]:
    """(n - 1,) sizes, one axis at a time: of 90 hours all three would be a gigabyte."""
    steps = np.diff(axis.astype(np.float64))
    return np.abs(steps, out=steps)


def _leaving(
    position_mm: Sequence[npt.NDArray[np.floating]],
    runs: npt.NDArray[np.intp],
    moved: npt.NDArray[np.bool_],
    step_mm: float,
) -> tuple[float, float]:
    """What the coordinate that does most does after the `runs` (median, in mm), and the chance that
    all repeat their values, the product of theirs, by what each does before or after, the smaller
    of both. moved (n - 1,): which changes are of no run."""
    best, chance = (0.0, 1.0), 1.0
    for axis in position_mm:
        changes = _changes(axis)
        before = np.where(runs[:, 0] > 0, changes[runs[:, 0] - 1], np.nan)
        after = np.where(runs[:, 1] < changes.size, changes[runs[:, 1] % changes.size], np.nan)
        nearest = np.fmin(before, after)
        known, steps = nearest[np.isfinite(nearest)], changes[moved & (changes > 0)]
        change = float(np.median(known)) if known.size else 0.0
        if change > 0 and steps.size:
            step = max(step_mm, float(np.quantile(steps, HIDDEN)))
            jump = float(np.nanmedian(after)) if np.isfinite(after).any() else change
            best = min(best, (jump, min(step / change, 1.0)), key=lambda one: one[1])
            chance *= min(step / change, 1.0)
    return best[0], chance


def solved_pairs(
    coordinates: Mapping[str, np.ndarray], pairs: Sequence[tuple[int, int]]
) -> dict[str, float]:
    """Distances between markers of a rigid body that the software solved: name -> variance of the
    steps of the distance from frame to frame over that of the steps of both ends along it.

    Ends that are measured by themselves have independent noise, so the ratio is 1. Markers at rest
    only: a body that moves keeps its distances, however they are measured.
    """
    ratios = {}
    near = {name: middle(v) for name, v in coordinates.items() if not name.startswith("L")}
    for first, second in pairs:
        a, b = position(near, first), position(near, second)
        with np.errstate(invalid="ignore"):
            along = np.nanmean(b - a, axis=1) if np.isfinite(a + b).any() else np.zeros(3)
        size = float(np.linalg.norm(along))
        steps = np.diff(distance(a, b))
        if not size > 0 or np.isfinite(steps).sum() < LEAST_CHANGES:
            continue
        ends = sum(float(np.nanvar(np.diff(along @ one / size))) for one in (a, b))
        ratio = float(np.nanvar(steps)) / ends if ends > 0 else 1.0
        if ratio < SOLVED:
            ratios[pair_name((first, second), pairs)] = ratio
    return ratios
