"""Fits of `batch` to hits of the second generation, which are many, of fast hands, and some wrong.

A few steps show stretches of which the first poses are wrong: they begin anew from what is before
and after, for where the board is thought elsewhere its own hits look like reflections, and the
search hardly ends. Then reflections leave: hits of diodes that light cannot reach, or grazes, where
normals are known, and those far off where the board is. Knots of the trajectory 50 ms apart follow
no hand that shakes a controller (residuals of a real one 1.3 mrad, with knots 12.5 ms apart 0.05),
so they are halved while that makes the residuals smaller. All this, and which diodes are bad, is
found from as many turns as the trajectory needs; all of them count in the last fit.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy import ndimage

from mocap_metrology.common.hampel import MAD_TO_SIGMA
from mocap_metrology.lighthouse.batch.estimate import Joint
from mocap_metrology.lighthouse.batch.kernel import POSE
from mocap_metrology.lighthouse.batch.recording import Given, recording
from mocap_metrology.lighthouse.batch.trajectory import KNOT_S, Trajectory
from mocap_metrology.lighthouse.calibrate.fits import (
    bad_diodes,
    bounded,
    bridged,
    bridged_trajectory,
    fitted,
    grazing,
    if_they_agree,
    noted,
    poses_of,
    without_bad_diodes,
)
from mocap_metrology.lighthouse.calibrate.scene import Pose, Scene
from mocap_metrology.lighthouse.records import Hits

FINEST_S = 0.011  # between knots
FOLLOWED = 0.6, 0.7  # of the noise and of the mean square residual: finer knots follow no more
ENOUGH, MANY = 5, 40_000  # hits an unknown of the trajectory; in all: fewer are all used
FEWEST = 2.0  # likewise, of finer knots
ROUGH = 6  # steps to the first estimate, which shows reflections
COARSE_RAD, FINE_RAD = 1e-3, 3e-4  # from an angle by a first and by a better estimate
GATE = 8.0  # likewise, over the robust spread
LOST, LOST_RAD = 3.0, 3e-3  # median of a station at a time over that of all, and at least
TOGETHER_S = 0.1  # for what is usual of a station
RENEWALS = 3  # of bad diodes, at most
BAD_DIODE = 2.0  # its rms residual over the median of all; of good ones at most 1.5


def well_fitted(
    scene: Scene,
    hits: Hits,
    trajectory: Trajectory,
    poses: Sequence[Pose],
    first: Joint | None = None,
) -> tuple[Joint, str]:
    """The estimate from there, and a note on what was left out; first: what `explored` returns of
    stations of the first generation, where it was called before."""
    if scene.generation != 2:
        return without_bad_diodes(scene, hits, trajectory, poses, first)
    found, scene, why = if_they_agree(
        scene, lambda own: bridged(own, _first(own, hits, trajectory, poses))
    )
    found, out = _without_bad(scene, hits, found)
    finer = _followed(scene, hits, found)
    if finer is not found:  # where the board was not followed, good diodes can look bad
        found, out = _without_bad(scene, hits, finer)
    good = _gated(scene, hits, found, FINE_RAD, out)
    return fitted(scene, good, found.recordings[0].trajectory, near=found), noted(out, why)


def _without_bad(scene: Scene, hits: Hits, found: Joint) -> tuple[Joint, list[int]]:
    """An estimate without diodes that the others contradict, and these."""
    out: list[int] = []
    for _ in range(RENEWALS + 1):
        near = found.recordings[0].trajectory
        good = _gated(scene, _thinned(hits, near), found, FINE_RAD, out)
        found = fitted(scene, good, near, near=found, sized=True)
        worst = bad_diodes(found, BAD_DIODE)
        if not worst.size:
            break
        out += worst.tolist()
    return found, out


def _thinned(hits: Hits, trajectory: Trajectory) -> Hits:
    """Every so many turns of a station, so that `MANY` hits remain and `ENOUGH` for the trajectory:
    with fewer, the fastest stretches of a short recording would be lost."""
    each = math.ceil(len(hits) / max(ENOUGH * POSE * len(trajectory.control), MANY))
    return hits if each == 1 else hits.take(hits.cycle % each == 0)


def _first(scene: Scene, hits: Hits, trajectory: Trajectory, poses: Sequence[Pose]) -> Joint:
    """A first estimate, without what is far off."""
    bare = replace(scene, sensors=replace(scene.sensors, normals=None))
    few = _thinned(hits, trajectory)
    found = fitted(bare, few, trajectory, poses, sized=True, rounds=ROUGH)
    if (again := bridged_trajectory(found.recordings[0], True)) is not None:
        found = fitted(bare, few, again, poses_of(found), sized=True, rounds=ROUGH)
    good, trajectory = _gated(scene, few, found, COARSE_RAD), found.recordings[0].trajectory
    return fitted(scene, good, trajectory, poses_of(found), sized=True)


def _followed(scene: Scene, hits: Hits, found: Joint) -> Joint:
    """An estimate by knots that follow the board; itself where its own do. With all diodes: finer
    knots need many hits."""
    trajectory = found.recordings[0].trajectory
    while trajectory.knot_s > 2 * FINEST_S and not trajectory.still:
        trajectory = found.recordings[0].trajectory.halved()
        good = _gated(scene, _thinned(hits, trajectory), found, COARSE_RAD)
        if len(good) < FEWEST * POSE * len(trajectory.control):
            break
        then = fitted(scene, good, trajectory, near=found, sized=True)
        less = np.array(_left(then)) / _left(found)
        if not then.converged or (less > FOLLOWED).all():
            break
        found = then
    return found


def _left(found: Joint) -> tuple[float, float]:
    """Mean square residual in rad^2 for each hit that determines nothing: by the noise, which wrong
    hits do not touch, and of all, with stretches that are not followed."""
    one = found.recordings[0]
    time_s = one.sweeps.hits.time_s
    stretch = ((time_s - time_s.min()) / KNOT_S).astype(np.int64)
    square = bounded(one.residual, stretch) ** 2
    free = max(square.size - one.trajectory.control.size, 1)
    return one.noise.hit**2 + one.noise.sweep**2, float(square.sum()) / free


def _gated(
    scene: Scene, hits: Hits, found: Joint, least_rad: float, out: Sequence[int] = ()
) -> Hits:
    """Without hits of diodes that are out, and those that an estimate shows to be reflections:
    farther off than least_rad and `GATE` times what is usual, of all and of the station at that
    time, or on diodes that light cannot reach. Where most hits of a station are off, it is the
    board that is not there; by a better estimate, the station may see a reflection of it."""
    hits = hits.take(~np.isin(hits.diode, out)) if len(out) else hits
    one = recording(Given(hits, found.recordings[0].trajectory), found.state)
    off, own = np.abs(one.residual), one.sweeps.hits
    when = ((own.time_s - own.time_s.min()) / TOGETHER_S).astype(np.int64)
    shape = len(scene.names), when.max() + 1
    group = own.station * shape[1] + when
    of_group = ndimage.median(off, group, np.arange(shape[0] * shape[1]))
    usual = np.maximum(of_group[group], np.median(off))
    wrong = off > np.maximum(least_rad, GATE * MAD_TO_SIGMA * usual)
    if least_rad <= FINE_RAD:
        seen = np.bincount(group, minlength=of_group.size) > 0
        lost = (of_group > max(LOST * np.median(off), LOST_RAD)) & seen
        wrong |= _without_view(lost.reshape(shape), seen.reshape(shape)).ravel()[group]
    if (normals := scene.sensors.normals) is not None:
        wrong |= grazing(own, one.trajectory, found.state, normals)
    return one.sweeps.hits.take(~wrong)


def _without_view(lost: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Which stations tell nothing of the others at a time, (stations, times): those that are lost,
    and one that remains alone with these, as none tells which is right."""
    alone = lost.any(axis=0) & ((seen & ~lost).sum(axis=0) < 2)
    out: np.ndarray = lost | alone
    return out
