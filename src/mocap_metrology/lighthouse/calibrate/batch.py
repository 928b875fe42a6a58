"""Estimator `batch`: all hits of a recording at their own times, in one estimate.

J's method needs both angles of a diode at one moment, which it interpolates, and poses of both
stations at one moment, which it interpolates too; it names the missing correlation of both
stations' data as its limit (J VII). Here the board follows one continuous trajectory, and each hit
is compared with it when it happened (`lighthouse.batch`). It starts from board poses on which both
stations agree.

A stretch of the trajectory can end in the mirrored minimum of a flat board; there the residual is
large, so such stretches are begun anew from what is before and after them. A diode that the others
contradict is left out and named.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from mocap_metrology.lighthouse.batch import inertial
from mocap_metrology.lighthouse.batch.estimate import Joint, determined, estimate
from mocap_metrology.lighthouse.batch.parts import (
    halves,
    misfit_of,
    pieces_of,
    prior_p,
    residual_ratios,
    rms_by,
    scale_share,
    shared_errors,
)
from mocap_metrology.lighthouse.batch.problem import GROUPS, State
from mocap_metrology.lighthouse.batch.recording import Given, Recording, Sensed
from mocap_metrology.lighthouse.batch.residuals import residual_rows
from mocap_metrology.lighthouse.batch.trajectory import KNOT_S, Trajectory, through
from mocap_metrology.lighthouse.board import FEWEST_DIODES, digest
from mocap_metrology.lighthouse.calibrate.network import Start, start, still_start
from mocap_metrology.lighthouse.calibrate.scene import ESTIMATED, NAME, Pose, Scene, Sensors
from mocap_metrology.lighthouse.calibrate.variants import COVARIANCE_UNITS
from mocap_metrology.lighthouse.records import SLAVE, Hits, Measurements, Path, PoseEstimate

GRAZING_RAD = np.radians(75.0)  # of incidence: beyond it hits are off by twice as much, or wrong
RENEWALS = 3  # of stretches and of diodes, at most
BAD_STRETCH = 1.7  # of its rms residual over the median of all
LOST_STRETCH = 3.0  # likewise, after that
LARGEST_RAD = 1e-3  # of a hit's residual in the rms of a stretch: single wrong hits make none bad
MANY_DIODES = 8  # with fewer, one at a time is left out
BAD_DIODE = 3.0  # likewise
FAR_DIODE = 8.0  # from its place, over the standard deviation of one coordinate
FEWEST_HITS = 6  # of a stretch or diode that is judged

__all__ = ["ESTIMATED", "NAME", "Scene", "Sensors", "by_batch", "joint", "solved", "start"]


def by_batch(scene: Scene, still: Sequence[Measurements] | None = None) -> PoseEstimate:
    """The slave's pose from all hits. still: median angles of a board that keeps its place.

    Raises `Refusal` where no start is found or the search does not converge.
    """
    return solved(scene, still)[0]


def solved(
    scene: Scene,
    still: Sequence[Measurements] | None = None,
    known: tuple[Joint, str] | None = None,
) -> tuple[PoseEstimate, Joint]:
    """The slave's pose, as `all_solved`."""
    (pose, *_), found = all_solved(scene, still, known)
    return pose, found


def all_solved(
    scene: Scene,
    still: Sequence[Measurements] | None = None,
    known: tuple[Joint, str] | None = None,
) -> tuple[list[PoseEstimate], Joint]:
    """Poses of all stations but the first, and the joint estimate that they are from; raises as
    `by_batch`. known: what `joint` returns, where it was called before."""
    began = time.perf_counter()
    found, note = known or joint(scene, still)
    one, stage = found.recordings[0], "final" if still is None else "static"
    with determined(scene.title):
        pieces = pieces_of(found, one) if still is None else []
        residuals = residual_rows(found, scene.hits, scene.names)
        path = _path(one.trajectory, one.sweeps.hits.time_s)
        poses = []
        for k in range(1, len(scene.names)):
            pose = pose_of(scene, found, stage, k)
            pose = replace(
                pose,
                details={**(pose.details or {}), "residuals": residuals},
                halves=halves(found, k, pieces) if still is None else None,
                path=path,
                note=note,
            )
            poses.append(replace(pose, seconds=time.perf_counter() - began))
    return poses, found


def pose_of(scene: Scene, found: Joint, stage: str, station: int = SLAVE) -> PoseEstimate:
    """A station's pose out of a joint estimate of one recording or of several."""
    units = COVARIANCE_UNITS
    board = digest(scene.board)
    noise, shared = shared_errors(found, scene.used_priors, units, board, station)
    residual = np.concatenate([one.residual for one in found.recordings])
    return PoseEstimate(
        estimator=NAME,
        stage=stage,
        optics=scene.optics,
        R=found.state.R[station],
        t_m=found.state.t_m[station],
        frame="optical" if scene.lasers_m is None else "housing",
        covariance=found.pose_covariance(station) * np.outer(units, units),
        covariance_noise=noise,
        shared=shared,
        residual_rms_urad=1e6 * float(np.sqrt(np.mean(residual**2))),
        n_angles=residual.size,
        details=_details(found, scene.names) | _weighed(scene, found, station),
        station=scene.names[station],
    )


def _path(trajectory: Trajectory, time_s: np.ndarray) -> Path:
    """The trajectory at half the distance of its knots, where it is known; time_s: of the hits."""
    at = np.arange(time_s.min(), time_s.max(), KNOT_S / 2)
    at = at[trajectory.known(at)]
    R, t_m = trajectory.poses(at)
    none = np.full(at.size, np.nan)
    return Path(at, R, t_m, none, np.zeros(at.size, dtype=np.int64), none)


def _details(found: Joint, names: Sequence[str]) -> dict[str, object]:
    """Noise in urad, of a hit and of a sweep; offsets of the axes in urad, depths between lasers in
    mm, size of the errors of diodes' places that the recording does not contradict in mm; rms
    residual over the noise of a hit by station, axis and diode; and the sensors of the board."""
    one, of, state = found.recordings[0], found.of, found.state
    depth = of.columns[:, 0, 1]
    place = of.group == GROUPS.index("place")
    return {
        "noise_hit_urad": 1e6 * one.noise.hit,
        "noise_sweep_urad": 1e6 * one.noise.sweep,
        "offset_urad": (1e6 * state.offsets).tolist(),
        "laser_depth_mm": (1e3 * state.values[depth]).tolist() if (depth >= 0).all() else None,
        "board_position_mm": 1e3 * float(found.believed[place].max()) if place.any() else None,
        "residual_ratios": residual_ratios(one, names),
        "inertial": _of_sensors(one.sensors, state),
        "steps": found.rounds,
        **({"cover_mm": (1e3 * state.cover).tolist()} if of.cover >= 0 else {}),
    }


def _weighed(scene: Scene, found: Joint, station: int) -> dict[str, object]:
    """rms residual in urad of hits as they are weighed; share of the weight of all hits that is
    lost; misfit of pieces as in `Joint`; probability by chance that estimates are so far from their
    priors; and the share that the scale of the board has in the variance of the position."""
    residual = np.concatenate([one.residual for one in found.recordings])
    weight = np.concatenate([one.total_weight() for one in found.recordings])
    total = residual.size
    if len(found.recordings) == 1:
        used = np.unique(found.recordings[0].sweeps.hits.diode)
        total = int(np.isin(scene.hits.diode, used).sum())
    return {
        "weighted_rms_urad": 1e6 * float(np.sqrt(weight @ residual**2 / weight.sum())),
        "weight_lost": 1 - float(weight.sum()) / total,
        "misfit": found.misfit,
        "prior_p": prior_p(found),
        "scale_share": scale_share(found, station),
    }


def _of_sensors(own: Sensed | None, state: State) -> dict[str, object] | None:
    """Gravity in the frame of the master, and what was estimated of gyroscope and accelerometer;
    noise: of means over 25 ms, with what the trajectory cannot follow. None without them."""
    if own is None:
        return None
    values = state.values[own.column : own.column + inertial.OWN]
    return {
        "gravity_m_s2": state.gravity.tolist(),
        "gyro_noise_rad_s": float(own.noise[0]),
        "accel_noise_m_s2": float(own.noise[1]),
        "gyro_bias_rad_s": values[inertial.BIAS_W].tolist(),
        "accel_bias_m_s2": values[inertial.BIAS_F].tolist(),
        "accel_scale": 1 + float(values[inertial.SCALE][0]),
        "turn_deg": np.degrees(values[inertial.TURN]).tolist(),
        "place_mm": (1e3 * values[inertial.PLACE]).tolist(),
        "delay_ms": 1e3 * float(values[inertial.DELAY][0]),
    }


def joint(
    scene: Scene,
    still: Sequence[Measurements] | None = None,
    near: Start | None = None,
) -> tuple[Joint, str]:
    """The joint estimate behind `by_batch`, and a note on what was left out; raises as that.
    near: where it starts, if that is known."""
    with determined(scene.title):
        if still is None:
            found, note = without_bad_diodes(scene, *facing(scene, *(near or start(scene))))
        else:
            hits, trajectory, poses, note = still_start(scene, still)
            hits, trajectory, poses = facing(scene, hits, trajectory, poses)
            found, _, why = _if_they_agree(scene, lambda own: fitted(own, hits, trajectory, poses))
            note = "; ".join(filter(None, (note, why)))
        found = found.sure(scene.title)
        if not scene.known_pose:
            found = replace(found, misfit=misfit_of(found))
    return found, note


def facing(scene: Scene, hits: Hits, trajectory: Trajectory, poses: list[Pose]) -> Start:
    """Without hits of diodes that light cannot reach, or grazes, where their normals are known:
    those are reflections, or of an unknown cover. By a first estimate."""
    if (normals := scene.sensors.normals) is None:
        return hits, trajectory, poses
    uncovered = replace(scene, sensors=replace(scene.sensors, normals=None))
    found = fitted(uncovered, hits, trajectory, poses, sized=True)
    one, state = found.recordings[0], found.state
    own = one.sweeps.hits
    R, p = one.trajectory.poses(own.time_s)
    normal = np.einsum("nij,nj->ni", R, normals[own.diode])
    far = p + np.einsum("nij,nj->ni", R, state.board[own.diode]) - state.t_m[own.station]
    size = np.linalg.norm(far, axis=1) * np.linalg.norm(normal, axis=1)
    grazing = np.einsum("ni,ni->n", normal, far) > -np.cos(GRAZING_RAD) * size
    kept = own.take(~grazing | ~(size > 0))
    return kept, one.trajectory, poses_of(found)


def fitted(
    scene: Scene,
    hits: Hits,
    trajectory: Trajectory,
    poses: Sequence[Pose],
    *,
    sized: bool = False,
) -> Joint:
    """One estimate from there, whatever fits badly; sized: as in `estimate`."""
    R, t = zip(*poses, strict=True)
    given = [Given(hits, trajectory, scene.sensors.inertial, scene.sensors.lengths)]
    how = scene.used_priors, scene.known_pose
    return estimate(given, R, t, scene.rotors, scene.board, *how, sized=sized, more=scene.more)


def without_bad_diodes(
    scene: Scene, hits: Hits, trajectory: Trajectory, poses: Sequence[Pose]
) -> tuple[Joint, str]:
    """The estimate without diodes whose hits the others contradict, and a note of these."""
    out: list[int] = []
    found, scene, why = _if_they_agree(scene, lambda own: renewed(own, hits, trajectory, poses))
    for _ in range(RENEWALS):
        worst = _bad_diodes(found)
        if not worst.size or np.unique(hits.diode).size <= FEWEST_DIODES:
            break
        if scene.generation == 2:  # hits are many, so not from the start again
            one = found.recordings[0]
            hits = one.sweeps.hits
            if np.unique(hits.diode).size - worst.size < MANY_DIODES:
                worst = worst[:1]
            hits = hits.take(~np.isin(hits.diode, worst))
            found = fitted(scene, hits, one.trajectory, poses_of(found))
        else:
            worst = worst[:1]
            hits = hits.take(hits.diode != worst)
            found = renewed(scene, hits, trajectory, poses)
        out += worst.tolist()
    named = ", ".join(map(str, sorted(out)))
    note = f"diode {named} excluded: the others contradict it" if out else ""
    return found, "; ".join(filter(None, (note, why)))


def _if_they_agree(scene: Scene, estimate_of: Callable[[Scene], Joint]) -> tuple[Joint, Scene, str]:
    """The estimate, what it is of, and why that is without the board's sensors where these
    contradict the light."""
    found = estimate_of(scene)
    own = found.recordings[0].sensors
    if own is None:
        return found, scene, ""
    why = inertial.contradiction(found.state.values, own.column, own.noise)
    if not found.converged:
        why = f"no convergence in {found.rounds} steps with them"
    if not why:
        return found, scene, ""
    without = replace(scene, sensors=replace(scene.sensors, inertial=None))
    return estimate_of(without), without, f"gyroscope and accelerometer not used: {why}"


def refitted(scene: Scene, found: Joint) -> Joint:
    """The estimate of a scene that differs little, from one of the same hits."""
    one = found.recordings[0]
    then = fitted(scene, one.sweeps.hits, one.trajectory, poses_of(found)).sure(scene.title)
    return replace(then, misfit=misfit_of(then))


def _bad_diodes(found: Joint) -> np.ndarray:
    """Diodes that fit far worse than the others, and at least half as badly as the worst, which is
    the first: by their residual, or by how far from their place in the board file they would have
    to be."""
    one = found.recordings[0]
    z = rms_by(one.sweeps.hits.diode, (one.alone / one.noise.hit) ** 2, FEWEST_HITS)
    excess = z / (BAD_DIODE * np.nanmedian(z))
    if found.of.places >= 0:
        own = slice(found.of.places, found.of.places + 3 * len(found.state.board))
        moved = (found.state.values[own] / found.of.sd[own]).reshape(-1, 3)[: z.size]
        excess = np.fmax(excess, np.linalg.norm(moved, axis=1) / FAR_DIODE)
    excess = np.nan_to_num(excess)
    order = np.argsort(-excess, kind="stable")
    return order[excess[order] > max(1.0, 0.5 * excess.max())]


def renewed(
    scene: Scene,
    hits: Hits,
    trajectory: Trajectory,
    poses: Sequence[Pose],
    *,
    sized: bool = False,
) -> Joint:
    """The estimate; stretches that fit badly begin anew from their neighbours while that helps, and
    sweeps of those that remain far worse than others are left out, where they are so themselves."""
    found = fitted(scene, hits, trajectory, poses, sized=sized)
    for _ in range(RENEWALS):
        again = _bridged(found.recordings[0])
        if again is None:
            break
        then = fitted(scene, hits, again, poses_of(found), sized=sized)
        if not then.converged or _misfit(then) >= _misfit(found):
            break
        found = then
    one = found.recordings[0]
    bad = _bad_stretches(one, LOST_STRETCH)[one.seen.who[:, 3]]
    sweep, squares = one.sweeps.sweep, np.minimum(one.alone**2, LARGEST_RAD**2)
    bad &= rms_by(sweep, squares)[sweep] > LOST_STRETCH * np.sqrt(np.median(squares))
    if not bad.any():
        return found
    then = fitted(scene, one.sweeps.hits.take(~bad), one.trajectory, poses_of(found), sized=sized)
    return then if then.converged else found


def poses_of(found: Joint) -> list[Pose]:
    """Of all stations, in the frame of the first."""
    return list(zip(found.state.R, found.state.t_m, strict=True))


def _misfit(found: Joint) -> float:
    """Mean square residual in rad^2, of hits that fit by 1 mrad at most."""
    return float(np.mean(np.minimum(found.recordings[0].residual ** 2, 1e-6)))


def _bad_stretches(one: Recording, times: float) -> np.ndarray:
    """Which stretches between knots have an rms residual so many times the median of all."""
    rms = rms_by(one.seen.who[:, 3], np.minimum(one.alone**2, LARGEST_RAD**2), FEWEST_HITS)
    with np.errstate(invalid="ignore"):
        bad: np.ndarray = rms > times * np.nanmedian(rms)
    return bad


def _bridged(one: Recording) -> Trajectory | None:
    """The trajectory through its good stretches only; None where all are good."""
    trajectory = one.trajectory
    stretch = one.seen.who[:, 3]
    bad = _bad_stretches(one, BAD_STRETCH)
    if not bad.any() or bad.all():
        return None
    bad = np.convolve(bad, np.ones(5))[2:-2] > 0  # a spline's error reaches to its neighbours
    middle = trajectory.begin_s + trajectory.knot_s * (np.arange(bad.size) + 0.5)
    good = ~bad & (np.bincount(stretch, minlength=bad.size) > 0)
    if np.count_nonzero(good) < 2:
        return None
    at = middle[good]
    R, t = trajectory.poses(at)
    end = trajectory.begin_s + trajectory.knot_s * (len(trajectory.control) - 3)
    return through(at, R, t, trajectory.begin_s, end, trajectory.knot_s)
