"""Estimator `batch`: all hits of a recording at their own times, in one estimate.

J's method needs both angles of a diode at one moment, which it interpolates, and poses of both
stations at one moment, which it interpolates too; it names the missing correlation of both
stations' data as its limit (J VII). Here the board follows one continuous trajectory, and each hit
is compared with it when it happened (`lighthouse.batch`). It starts from board poses on which both
stations agree; `fits` and `turns` say what is begun anew or left out.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from mocap_metrology.lighthouse.batch import inertial, parts
from mocap_metrology.lighthouse.batch.estimate import Joint, determined
from mocap_metrology.lighthouse.batch.length import added, equation
from mocap_metrology.lighthouse.batch.problem import GROUPS, State
from mocap_metrology.lighthouse.batch.recording import Sensed
from mocap_metrology.lighthouse.batch.residuals import residual_rows
from mocap_metrology.lighthouse.batch.solve import reduced
from mocap_metrology.lighthouse.batch.trajectory import KNOT_S, Trajectory
from mocap_metrology.lighthouse.board import digest
from mocap_metrology.lighthouse.calibrate import fits
from mocap_metrology.lighthouse.calibrate.network import Start, placed, start, still_start
from mocap_metrology.lighthouse.calibrate.scene import NAME, Scene
from mocap_metrology.lighthouse.calibrate.variants import COVARIANCE_UNITS
from mocap_metrology.lighthouse.records import SLAVE, Measurements, Path, PoseEstimate


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
    """Poses of all stations but the first from all hits, and the joint estimate that they are from.
    still: median angles of a board that keeps its place; known: what `joint` returns, where it was
    called before. Raises `Refusal` where no start is found or the search does not converge."""
    began = time.perf_counter()
    found, note = known or joint(scene, still)
    one, stage = found.recordings[0], "final" if still is None else "static"
    with determined(scene.title):
        pieces = parts.pieces_of(found, one) if still is None else []
        residuals = residual_rows(found, scene.hits, scene.names)
        path = _path(one.trajectory, one.sweeps.hits.time_s)
        details = {**details_of(scene, found), "residuals": residuals}
        poses = []
        for k in range(1, len(scene.names)):
            pose = pose_of(scene, found, stage, details, k)
            pose = replace(
                pose,
                halves=parts.halves(found, k, pieces) if still is None else None,
                path=path,
                note=note,
            )
            poses.append(replace(pose, seconds=time.perf_counter() - began))
    return poses, found


def pose_of(
    scene: Scene, found: Joint, stage: str, details: Mapping[str, object], station: int = SLAVE
) -> PoseEstimate:
    """A station's pose out of a joint estimate of one recording or of several; details: of all
    stations, to which the share is added that the scale of the board has in the variance of the
    position of this one."""
    units = COVARIANCE_UNITS
    board = digest(scene.board)
    noise, shared = parts.shared_errors(found, scene.used_priors, units, board, station)
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
        details={**details, "scale_share": parts.scale_share(found, station)},
        station=scene.names[station],
    )


def _path(trajectory: Trajectory, time_s: np.ndarray) -> Path:
    """The trajectory at half the distance of its knots, where it is known; time_s: of the hits."""
    at = np.arange(time_s.min(), time_s.max(), KNOT_S / 2)
    at = at[trajectory.known(at)]
    R, t_m = trajectory.poses(at)
    none = np.full(at.size, np.nan)
    return Path(at, R, t_m, none, np.zeros(at.size, dtype=np.int64), none)


def details_of(scene: Scene, found: Joint) -> dict[str, object]:
    """Of a joint estimate: noise of a hit and of a sweep, offsets of the axes, depths between
    lasers, size of the errors of diodes' places that the recording does not contradict; rms
    residual over the noise of a hit by station, axis and diode; the sensors of the board; rms
    residual of hits as they are weighed; lost share of the weight of all hits on diodes that light
    can reach, at times at which the board's place is sought; misfit of pieces as in `Joint`;
    probabilities by chance that estimates are so far from their priors; `of_length`."""
    one, of, state = found.recordings[0], found.of, found.state
    depth = of.columns[:, 0, 1]
    place = of.group == GROUPS.index("place")
    residual = np.concatenate([part.residual for part in found.recordings])
    weight = np.concatenate([part.total_weight() for part in found.recordings])
    total = residual.size
    if len(found.recordings) == 1:
        used = np.isin(scene.hits.diode, np.unique(one.sweeps.hits.diode)) & placed(scene)
        if (normals := scene.sensors.normals) is not None:
            used &= ~fits.grazing(scene.hits, one.trajectory, state, normals)
        total = max(int(used.sum()), residual.size)
    return {
        "noise_hit_urad": 1e6 * one.noise.hit,
        "noise_sweep_urad": 1e6 * one.noise.sweep,
        "offset_urad": (1e6 * state.offsets).tolist(),
        "laser_depth_mm": (1e3 * state.values[depth]).tolist() if (depth >= 0).all() else None,
        "board_position_mm": 1e3 * float(found.believed[place].max()) if place.any() else None,
        "residual_ratios": parts.residual_ratios(one, scene.names),
        "inertial": _of_sensors(one.sensors, state),
        "steps": found.rounds,
        **({"cover_mm": (1e3 * state.cover).tolist()} if of.cover >= 0 else {}),
        "weighted_rms_urad": 1e6 * float(np.sqrt(weight @ residual**2 / weight.sum())),
        "weight_lost": 1 - float(weight.sum()) / total,
        "misfit": found.misfit,
        "prior_p": parts.prior_p(found),
        **parts.of_length(found),
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
    first: Joint | None = None,
) -> tuple[Joint, str]:
    """The joint estimate behind `solved`, and a note on what was left out; raises as that.
    near: where it starts, if that is known; first: what `fits.explored` returned from there."""
    with determined(scene.title):
        if still is None:
            near = near or start(scene)
            if scene.generation == 1 and first is None:
                near = fits.facing(scene, *near)
            found, note = fits.well_fitted(scene, *near, first)
        else:
            hits, trajectory, poses, note = still_start(scene, still)
            hits, trajectory, poses = fits.facing(scene, hits, trajectory, poses)
            found, _, why = fits.if_they_agree(
                scene, lambda own: fits.fitted(own, hits, trajectory, poses)
            )
            note = "; ".join(filter(None, (note, why)))
        found = found.sure(scene.title)
        if not scene.known_pose:
            found = replace(found, misfit=parts.misfit_of(found))
    return found, "; ".join(filter(None, (note, less_certain(found))))


def less_certain(found: Joint) -> str:
    """A note on known lengths to which the board's path at their moments, as where no hits show it,
    adds more than their own standard deviation."""
    notes = []
    for one in (one for one in found.recordings if one.lengths):
        part = reduced(one.sums(found.state, found.of), one.trajectory, one.noise)
        for seen in one.lengths:
            own = equation(seen, one.trajectory.control, found.state, found.of)
            times = np.sqrt(added(own, part, one.noise)[2] / own.variance)
            if times > 2:
                at = ", ".join(f"{p.time_s:g} s" for p in seen.known.places if p.station is None)
                why = f"{times:.0f} times less certain, as the place of the board is at {at}"
                notes.append(f"known_length is {why}")
    return "; ".join(notes)
