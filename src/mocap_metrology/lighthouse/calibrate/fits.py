"""Fits of `batch` that begin anew where stretches or diodes contradict the others.

A stretch of the trajectory can end in the mirrored minimum of a flat board; there the residual is
large, so such stretches are begun anew from what is before and after them. A diode that the others
contradict is left out and named.

Fits of `batch` to hits of the second generation, which are many, of fast hands, and some wrong.

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
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy import ndimage

from mocap_metrology.common.hampel import MAD_TO_SIGMA
from mocap_metrology.lighthouse.batch import inertial
from mocap_metrology.lighthouse.batch.estimate import ROUNDS, Joint, completed, estimate
from mocap_metrology.lighthouse.batch.kernel import POSE
from mocap_metrology.lighthouse.batch.parts import misfit_of, rms_by
from mocap_metrology.lighthouse.batch.problem import State
from mocap_metrology.lighthouse.batch.recording import BatchInput, Recording, recording
from mocap_metrology.lighthouse.batch.trajectory import KNOT_S, Trajectory, trajectory_through
from mocap_metrology.lighthouse.batch.view import LEAST_RAD
from mocap_metrology.lighthouse.board import FEWEST_DIODES
from mocap_metrology.lighthouse.calibrate.scene import Pose, Scene
from mocap_metrology.lighthouse.records import Hits

GRAZING_RAD = np.radians(75.0)  # of incidence: beyond it hits are off by twice as much, or wrong
RENEWALS = 3  # of stretches and of diodes, at most
BAD_STRETCH = 1.7  # of its rms residual over the median of all
LOST_STRETCH = 3.0  # likewise, after that
LARGEST_RAD = 1e-3  # of a hit's residual in the rms of a stretch
FAR_OFF = 6.0  # likewise, over the median of the stretch
MANY_DIODES = 8  # with fewer, one at a time is left out
BAD_DIODE = 3.0  # its rms residual over the median of all
FAR_DIODE = 8.0  # from its place, over the standard deviation of one coordinate
SHORTEST_S = 0.025  # of a stretch
FEWEST_HITS = 6  # of a stretch or diode that is judged
FINEST_S = 0.011  # between knots
FOLLOWED = 0.6, 0.7  # of the noise and of the mean square residual: finer knots follow no more
ENOUGH, MANY = 5, 40_000  # hits an unknown of the trajectory; in all: fewer are all used
FEWEST_OF_FINER = 2.0  # likewise, of finer knots
ROUGH = 6  # steps to the first estimate, which shows reflections
COARSE_RAD, FINE_RAD = 1e-3, 3e-4  # from an angle by a first and by a better estimate
GATE = 8.0  # likewise, over the robust spread
LOST, LOST_RAD = 3.0, 3e-3  # median of a station at a time over that of all, and at least
TOGETHER_S = 0.1  # for what is usual of a station
BAD_OF_MANY = 2.0  # its rms residual over the median of all; of good ones at most 1.5


def fitted(
    scene: Scene,
    hits: Hits,
    trajectory: Trajectory,
    poses: Sequence[Pose] = (),
    *,
    sized: bool = False,
    near: Joint | None = None,
    rounds: int = ROUNDS,
) -> Joint:
    """One estimate from there, whatever fits badly; sized, near, rounds: as in `estimate`."""
    R, t = zip(*poses_of(near) if near else poses, strict=True)
    its = scene.sensors
    inputs = [BatchInput(hits, trajectory, its.inertial, its.lengths, its.clocks)]
    how = scene.rotors, scene.board, scene.used_priors, scene.known_pose
    return estimate(inputs, R, t, *how, sized=sized, more=scene.more, near=near, rounds=rounds)


def explored(scene: Scene, hits: Hits, trajectory: Trajectory, poses: Sequence[Pose]) -> Joint:
    """The estimate by priors as they are, with its bias: `bridged`, and without diodes whose hits
    the others contradict."""
    for _ in range(RENEWALS + 1):
        joint = bridged(scene, fitted(scene, hits, trajectory, poses, sized=True), hits)
        worst = bad_diodes(joint)[:1]
        if not worst.size:
            break
        hits = hits.take(hits.diode != worst)
    return joint


def exclusion_note(out: Sequence[int], why: str) -> str:
    """Note of excluded diodes and of what else was done, or an empty text."""
    named = ", ".join(map(str, sorted(out)))
    note = f"diode {named} excluded: the others contradict it" if out else ""
    return "; ".join(filter(None, (note, why)))


def if_they_agree(scene: Scene, estimate_of: Callable[[Scene], Joint]) -> tuple[Joint, Scene, str]:
    """The estimate, what it is of, and why that is without the board's sensors where these
    contradict the light, or no estimate is found with them."""
    joint, why = None, ""
    try:
        joint = estimate_of(scene)
    except np.linalg.LinAlgError:
        if scene.sensors.inertial is None:
            raise
        why = "no estimate with them"
    if joint is not None:
        sensors = joint.recordings[0].sensors
        if sensors is None:
            return joint, scene, ""
        why = inertial.contradiction(joint.state.values, sensors.column, sensors.noise)
        if not joint.converged:
            why = f"no convergence in {joint.rounds} steps with them"
        if not why:
            return joint, scene, ""
    without = replace(scene, sensors=replace(scene.sensors, inertial=None))
    return estimate_of(without), without, f"gyroscope and accelerometer not used: {why}"


def refitted(scene: Scene, joint: Joint) -> Joint:
    """The estimate of a scene that differs little, from one of the same hits."""
    one = joint.recordings[0]
    then = fitted(scene, one.sweeps.hits, one.trajectory, poses_of(joint)).sure(scene.title)
    return replace(then, misfit=misfit_of(then))


def bad_diodes(joint: Joint, times: float = BAD_DIODE) -> np.ndarray:
    """Diodes that fit far worse than the others, and at least half as badly as the worst, which is
    the first: by their residual, so many `times` the median of all, or by how far from their place
    in the board file they would have to be. One where few would remain, none of four."""
    one = joint.recordings[0]
    z = rms_by(one.sweeps.hits.diode, (one.alone / one.noise.hit) ** 2, FEWEST_HITS)
    excess = z / (times * max(np.nanmedian(z), one.tau_rad / one.noise.hit))
    if joint.of.places >= 0:
        columns = slice(joint.of.places, joint.of.places + 3 * len(joint.state.board))
        moved = (joint.state.values[columns] / joint.of.sd[columns]).reshape(-1, 3)[: z.size]
        excess = np.fmax(excess, np.linalg.norm(moved, axis=1) / FAR_DIODE)
    excess = np.nan_to_num(excess)
    order = np.argsort(-excess, kind="stable")
    worst = order[excess[order] > max(1.0, 0.5 * excess.max())]
    n = np.unique(one.sweeps.hits.diode).size
    most = 0 if n <= FEWEST_DIODES else 1 if n - worst.size < MANY_DIODES else n
    return worst[:most]


def bridged(scene: Scene, joint: Joint, hits: Hits | None = None) -> Joint:
    """Stretches of an estimate that fit badly begin anew from their neighbours while that helps,
    and sweeps of those that remain far worse than others are left out; by priors as they are."""
    hits = joint.recordings[0].sweeps.hits if hits is None else hits
    few_wrong = scene.generation == 2
    for _ in range(RENEWALS):
        again = bridged_trajectory(joint.recordings[0], few_wrong)
        if again is None:
            break
        then = fitted(scene, hits, again, poses_of(joint), sized=True)
        if not then.converged or _misfit(then) >= _misfit(joint):
            break
        joint = then
    one = joint.recordings[0]
    sweep, squares = one.sweeps.sweep, np.minimum(one.alone**2, LARGEST_RAD**2)
    bad = _bad_stretches(one, few_wrong, LOST_STRETCH)[one.seen.who[:, 3]]
    bad &= rms_by(sweep, squares)[sweep] > LOST_STRETCH * max(np.median(squares) ** 0.5, LEAST_RAD)
    if not bad.any():
        return joint
    then = fitted(scene, one.sweeps.hits.take(~bad), one.trajectory, poses_of(joint), sized=True)
    return then if then.converged else joint


def poses_of(joint: Joint) -> list[Pose]:
    """Poses of all stations in the frame of the first."""
    return list(zip(joint.state.R, joint.state.t_m, strict=True))


def _misfit(joint: Joint) -> float:
    """Mean square residual in rad^2, of hits that fit by 1 mrad at most."""
    return float(np.mean(np.minimum(joint.recordings[0].residual ** 2, 1e-6)))


def _bad_stretches(one: Recording, few_wrong: bool, times: float) -> np.ndarray:
    """Which stretches between knots have an rms residual so many times the median of all; finer
    knots than `SHORTEST_S` are judged together. few_wrong: single hits may be wrong, but no whole
    sweeps."""
    each = max(round(SHORTEST_S / one.trajectory.knot_s), 1)
    stretch = one.seen.who[:, 3] // each
    sizes = bounded(one.alone, stretch) if few_wrong else np.minimum(np.abs(one.alone), LARGEST_RAD)
    rms = np.repeat(rms_by(stretch, sizes**2, FEWEST_HITS), each)
    with np.errstate(invalid="ignore"):
        bad: np.ndarray = rms > times * max(np.nanmedian(rms), LEAST_RAD)
    return bad


def bounded(off: np.ndarray, stretch: np.ndarray) -> np.ndarray:
    """Sizes of residuals, at most `LARGEST_RAD` and `FAR_OFF` times what is usual of their stretch,
    so that hits of which few are wrong make none bad."""
    usual = ndimage.median(np.abs(off), stretch, np.arange(stretch.max() + 1))[stretch]
    return np.minimum(np.abs(off), np.minimum(LARGEST_RAD, FAR_OFF * usual))


def bridged_trajectory(one: Recording, few_wrong: bool) -> Trajectory | None:
    """The trajectory through its good stretches only; None where all are good."""
    trajectory = one.trajectory
    stretch = one.seen.who[:, 3]
    bad = _bad_stretches(one, few_wrong, BAD_STRETCH)
    if not bad.any() or bad.all():
        return None
    bad = np.convolve(bad, np.ones(5))[2:-2] > 0  # a spline's error reaches to its neighbours
    middle = trajectory.begin_s + trajectory.knot_s * (np.arange(bad.size) + 0.5)
    good = ~bad & (np.bincount(stretch, minlength=bad.size)[: bad.size] > 0)
    if np.count_nonzero(good) < 2:
        return None
    at = middle[good]
    R, t = trajectory.poses(at)
    end = trajectory.begin_s + trajectory.knot_s * (len(trajectory.control) - 3)
    return trajectory_through(at, R, t, trajectory.begin_s, end, trajectory.knot_s)


def without_hidden_hits(
    scene: Scene, hits: Hits, trajectory: Trajectory, poses: Sequence[Pose]
) -> tuple[Hits, Trajectory, list[Pose]]:
    """Without hits of diodes that light cannot reach, or grazes, where their normals are known:
    those are reflections, or of an unknown cover. By a first estimate, and by one without most."""
    if (normals := scene.sensors.normals) is None:
        return hits, trajectory, list(poses)
    uncovered = replace(scene, sensors=replace(scene.sensors, normals=None))
    for _ in range(2):
        joint = fitted(uncovered, hits, trajectory, poses, sized=True)
        one, poses = joint.recordings[0], poses_of(joint)
        hits, trajectory = one.sweeps.hits, one.trajectory
        hits = hits.take(~grazing(hits, trajectory, joint.state, normals))
    return hits, trajectory, list(poses)


def grazing(hits: Hits, path: Trajectory, state: State, normals: np.ndarray) -> np.ndarray:
    """Whether light comes from beyond `GRAZING_RAD` of a diode's normal, where that is known."""
    R, p = path.poses(hits.time_s)
    normal = np.einsum("nij,nj->ni", R, normals[hits.diode])
    far = p + np.einsum("nij,nj->ni", R, state.board[hits.diode]) - state.t_m[hits.station]
    size = np.linalg.norm(far, axis=1) * np.linalg.norm(normal, axis=1)
    beyond = np.einsum("ni,ni->n", normal, far) > -np.cos(GRAZING_RAD) * size
    return beyond & (size > 0)


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

        def estimate_of(one: Scene) -> Joint:
            known = first if one is scene else None
            return completed(known or explored(one, hits, trajectory, poses))

        joint, _, why = if_they_agree(scene, estimate_of)
        out = np.setdiff1d(hits.diode, joint.recordings[0].sweeps.hits.diode).tolist()
        return joint, exclusion_note(out, why)
    scene = replace(scene, covered=False)
    joint, scene, why = if_they_agree(
        scene, lambda one: bridged(one, _first_estimate(one, hits, trajectory, poses))
    )
    joint, out = _without_bad(scene, hits, joint)
    finer = _followed(scene, hits, joint)
    if finer is not joint:  # where the board was not followed, good diodes can look bad
        joint, out = _without_bad(scene, hits, finer)
    good, scene = _gated(scene, hits, joint, FINE_RAD, out), replace(scene, covered=True)
    path, rounds = joint.recordings[0].trajectory, 2 * ROUNDS  # as the cover is new to the search
    return fitted(scene, good, path, near=joint, rounds=rounds), exclusion_note(out, why)


def _without_bad(scene: Scene, hits: Hits, joint: Joint) -> tuple[Joint, list[int]]:
    """An estimate without diodes that the others contradict, and these."""
    out: list[int] = []
    for _ in range(RENEWALS + 1):
        near = joint.recordings[0].trajectory
        good = _gated(scene, _thinned(hits, near), joint, FINE_RAD, out)
        joint = fitted(scene, good, near, near=joint, sized=True)
        worst = bad_diodes(joint, BAD_OF_MANY)
        if not worst.size:
            break
        out += worst.tolist()
    return joint, out


def _thinned(hits: Hits, trajectory: Trajectory) -> Hits:
    """Every so many turns of a station, so that `MANY` hits remain and `ENOUGH` for the trajectory:
    with fewer, the fastest stretches of a short recording would be lost."""
    each = math.ceil(len(hits) / max(ENOUGH * POSE * len(trajectory.control), MANY))
    return hits if each == 1 else hits.take(hits.cycle % each == 0)


def _first_estimate(
    scene: Scene, hits: Hits, trajectory: Trajectory, poses: Sequence[Pose]
) -> Joint:
    """A first estimate, without what is far off."""
    bare = replace(scene, sensors=replace(scene.sensors, normals=None))
    few = _thinned(hits, trajectory)
    joint = fitted(bare, few, trajectory, poses, sized=True, rounds=ROUGH)
    if (again := bridged_trajectory(joint.recordings[0], True)) is not None:
        joint = fitted(bare, few, again, poses_of(joint), sized=True, rounds=ROUGH)
    good, trajectory = _gated(scene, few, joint, COARSE_RAD), joint.recordings[0].trajectory
    return fitted(scene, good, trajectory, poses_of(joint), sized=True)


def _followed(scene: Scene, hits: Hits, joint: Joint) -> Joint:
    """An estimate by knots that follow the board; itself where its own do. With all diodes: finer
    knots need many hits."""
    trajectory = joint.recordings[0].trajectory
    while trajectory.knot_s > 2 * FINEST_S and not trajectory.still:
        trajectory = joint.recordings[0].trajectory.halved()
        good = _gated(scene, _thinned(hits, trajectory), joint, COARSE_RAD)
        if len(good) < FEWEST_OF_FINER * POSE * len(trajectory.control):
            break
        then = fitted(scene, good, trajectory, near=joint, sized=True)
        less = np.array(_free_residual(then)) / _free_residual(joint)
        if not then.converged or (less > FOLLOWED).all():
            break
        joint = then
    return joint


def _free_residual(joint: Joint) -> tuple[float, float]:
    """Mean square residual in rad^2 for each hit that determines nothing: by the noise, which wrong
    hits do not touch, and of all, with stretches that are not followed."""
    one = joint.recordings[0]
    time_s = one.sweeps.hits.time_s
    stretch = ((time_s - time_s.min()) / KNOT_S).astype(np.int64)
    square = bounded(one.residual, stretch) ** 2
    free = max(square.size - one.trajectory.control.size, 1)
    return one.noise.hit**2 + one.noise.sweep**2, float(square.sum()) / free


def _gated(
    scene: Scene, hits: Hits, joint: Joint, least_rad: float, out: Sequence[int] = ()
) -> Hits:
    """Without hits of diodes that are out, and those that an estimate shows to be reflections:
    farther off than least_rad and `GATE` times what is usual, of all and of the station at that
    time, or on diodes that light cannot reach. Where most hits of a station are off, it is the
    board that is not there; by a better estimate, the station may see a reflection of it."""
    hits = hits.take(~np.isin(hits.diode, out)) if len(out) else hits
    one = recording(BatchInput(hits, joint.recordings[0].trajectory), joint.state)
    off, its_hits = np.abs(one.residual), one.sweeps.hits
    when = ((its_hits.time_s - its_hits.time_s.min()) / TOGETHER_S).astype(np.int64)
    shape = len(scene.names), when.max() + 1
    group = its_hits.station * shape[1] + when
    of_group = ndimage.median(off, group, np.arange(shape[0] * shape[1]))
    usual = np.maximum(of_group[group], np.median(off))
    wrong = off > np.maximum(least_rad, GATE * MAD_TO_SIGMA * usual)
    if least_rad <= FINE_RAD:
        seen = (np.bincount(group, minlength=of_group.size) > 0).reshape(shape)
        lost = (of_group > max(LOST * np.median(off), LOST_RAD)).reshape(shape) & seen
        # One that remains alone with lost ones tells nothing either: none tells which is right.
        alone = lost.any(axis=0) & ((seen & ~lost).sum(axis=0) < 2)
        wrong |= (lost | alone).ravel()[group]
    if (normals := scene.sensors.normals) is not None:
        wrong |= grazing(its_hits, one.trajectory, joint.state, normals)
    return one.sweeps.hits.take(~wrong)
