"""Estimator `batch`: all hits of a recording at their own times, in one estimate.

J's method needs both angles of a diode at one moment, which it interpolates, and poses of both
stations at one moment, which it interpolates too; it names the missing correlation of both
stations' data as its limit (J VII). Here the board follows one continuous trajectory, and each hit
is compared with it when it happened (`lighthouse.batch`). It starts from board poses on which both
stations agree; `fits` says what is begun anew or left out.

Residuals are stored by angle, time and diode, of each station and axis, estimated minus measured.
Noise leaves means near 0. A rotor that differs from its model leaves a curve against the angle, a
station that moved one against time, a displaced or slow diode a large rms of its own.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from mocap_metrology.lighthouse.batch import beforehand, inertial, parts
from mocap_metrology.lighthouse.batch.estimate import Joint, expect_determined
from mocap_metrology.lighthouse.batch.parts import rms_by
from mocap_metrology.lighthouse.batch.problem import GROUPS, State
from mocap_metrology.lighthouse.batch.recording import BatchInput, Recording, Sensed, recording
from mocap_metrology.lighthouse.batch.solve import reduced
from mocap_metrology.lighthouse.batch.trajectory import KNOT_S, Trajectory
from mocap_metrology.lighthouse.board import digest
from mocap_metrology.lighthouse.calibrate import fits
from mocap_metrology.lighthouse.calibrate.network import Start, placed, start, still_start
from mocap_metrology.lighthouse.calibrate.scene import NAME, Scene
from mocap_metrology.lighthouse.records import (
    AXES,
    COVARIANCE_UNITS,
    SLAVE,
    Hits,
    Measurements,
    Path,
    PoseEstimate,
)

BINS = 12  # of angle and of time
FEWEST_HITS = 6  # of a bin
DIGITS = 2  # of urad and deg
Rows = list[dict[str, object]]


def solved(
    scene: Scene,
    still: Sequence[Measurements] | None = None,
    known: tuple[Joint, str] | None = None,
) -> tuple[PoseEstimate, Joint]:
    """The slave's pose, as `all_solved`."""
    (pose, *_), solution = all_solved(scene, still, known)
    return pose, solution


def all_solved(
    scene: Scene,
    still: Sequence[Measurements] | None = None,
    known: tuple[Joint, str] | None = None,
) -> tuple[list[PoseEstimate], Joint]:
    """Poses of all stations but the first from all hits, and their joint estimate; still: median
    angles of a board that keeps its place; known: what `joint` returns, where it was called before.
    Raises `Refusal` where no start is found or the search does not converge."""
    began = time.perf_counter()
    solution, note = known or joint(scene, still)
    one, stage = solution.recordings[0], "final" if still is None else "static"
    with expect_determined(scene.title):
        solution, halves, left = parts.halves_of_all(solution)
        residuals = residual_rows(solution, scene.hits, scene.names)
        path = _path(one.trajectory, one.sweeps.hits.time_s)
        usable = {"": usable_hits(scene, solution)}
        details = {**details_of(scene, solution, usable), "residuals": residuals}
        details["misfit_left"] = left
        poses = []
        for k, (pair,) in enumerate(halves, start=1):
            pose = pose_of(scene, solution, stage, details, k)
            seconds = time.perf_counter() - began
            poses.append(replace(pose, halves=pair, path=path, note=note, seconds=seconds))
    return poses, solution


def pose_of(
    scene: Scene, solution: Joint, stage: str, details: Mapping[str, object], station: int = SLAVE
) -> PoseEstimate:
    """A station's pose out of a joint estimate; details: of all stations, to which the share of the
    scale of the board in the variance of its position is added."""
    units = COVARIANCE_UNITS
    board = digest(scene.board)
    noise, shared = parts.shared_errors(solution, scene.used_priors, units, board, station)
    residual = np.concatenate([one.residual for one in solution.recordings])
    return PoseEstimate(
        estimator=NAME,
        stage=stage,
        optics=scene.optics,
        R=solution.state.R[station],
        t_m=solution.state.t_m[station],
        frame="optical" if scene.lasers_m is None else "housing",
        covariance=solution.pose_covariance(station) * np.outer(units, units),
        covariance_noise=noise,
        shared=shared,
        residual_rms_urad=1e6 * float(np.sqrt(np.mean(residual**2))),
        n_angles=residual.size,
        details={**details, "scale_share": beforehand.scale_share(solution, station)},
        station=scene.names[station],
    )


def _path(trajectory: Trajectory, time_s: np.ndarray) -> Path:
    """The trajectory at half the distance of its knots, where it is known."""
    at = np.arange(time_s.min(), time_s.max(), KNOT_S / 2)
    at = at[trajectory.known(at)]
    R, t_m = trajectory.poses(at)
    none = np.full(at.size, np.nan)
    return Path(at, R, t_m, none, np.zeros(at.size, dtype=np.int64), none)


def usable_hits(scene: Scene, solution: Joint) -> int:
    """Hits of a recording on diodes of its estimate that light can reach, at times at which the
    board's place is sought."""
    one = solution.recordings[0]
    used = np.isin(scene.hits.diode, np.unique(one.sweeps.hits.diode)) & placed(scene)
    if (normals := scene.sensors.normals) is not None:
        used &= ~fits.grazing(scene.hits, one.trajectory, solution.state, normals)
    return max(int(used.sum()), one.residual.size)


def details_of(scene: Scene, solution: Joint, usable: Mapping[str, int]) -> dict[str, object]:
    """Of a joint estimate: noise of a hit and of a sweep, offsets of the axes, depths between
    lasers, size of the errors of diodes' places that the recording does not contradict; rms
    residual over the noise of a hit by station, axis and diode; the sensors of the board; rms
    residual of hits as they are weighed; lost share of the weight of the `usable_hits` of each
    recording, by title, the largest, and that title; misfit of pieces as in `Joint`; probabilities
    by chance that estimates are so far from their priors; `hidden_optics`; `of_length`."""
    one, of, state = solution.recordings[0], solution.of, solution.state
    depth = of.columns[:, 0, 1]
    place = of.group == GROUPS.index("place")
    residual = np.concatenate([part.residual for part in solution.recordings])
    weights = [part.total_weight() for part in solution.recordings]
    weight = np.concatenate(weights)
    shares = [float(own.sum()) / n for own, n in zip(weights, usable.values(), strict=True)]
    kept, most_lost = min(zip(shares, usable, strict=True))
    return {
        "noise_hit_urad": 1e6 * one.noise.hit,
        "noise_sweep_urad": 1e6 * one.noise.sweep,
        "offset_urad": (1e6 * state.offsets).tolist(),
        "laser_depth_mm": (1e3 * state.values[depth]).tolist() if (depth >= 0).all() else None,
        "board_position_mm": 1e3 * float(solution.believed[place].max()) if place.any() else None,
        "residual_ratios": parts.residual_ratios(one, scene.names),
        "inertial": _of_sensors(one.sensors, state),
        "steps": solution.rounds,
        **({"cover_mm": (1e3 * state.cover).tolist()} if of.cover >= 0 else {}),
        "weighted_rms_urad": 1e6 * float(np.sqrt(weight @ residual**2 / weight.sum())),
        "weight_lost": 1 - kept,
        **({"weight_lost_in": most_lost} if most_lost else {}),
        "misfit": solution.misfit,
        "prior_p": beforehand.prior_p(solution),
        "hidden_optics_mrad": 1e3 * beforehand.hidden_optics(solution),
        **beforehand.of_length(solution),
    }


def _of_sensors(sensors: Sensed | None, state: State) -> dict[str, object] | None:
    """Gravity in the frame of the master, and what was estimated of gyroscope and accelerometer;
    noise: of means over 25 ms, with what the trajectory cannot follow. None without them."""
    if sensors is None:
        return None
    values = state.values[sensors.column : sensors.column + inertial.OWN]
    return {
        "gravity_m_s2": state.gravity.tolist(),
        "gyro_noise_rad_s": float(sensors.noise[0]),
        "accel_noise_m_s2": float(sensors.noise[1]),
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
    """The joint estimate, and a note on what was left out; raises as `all_solved`. near: where it
    starts; first: what `fits.explored` returned from there."""
    with expect_determined(scene.title):
        if still is None:
            near = near or start(scene)
            if scene.generation == 1 and first is None:
                near = fits.without_hidden_hits(scene, *near)
            solution, note = fits.well_fitted(scene, *near, first)
        else:
            hits, trajectory, poses, note = still_start(scene, still)
            hits, trajectory, poses = fits.without_hidden_hits(scene, hits, trajectory, poses)
            solution, _, why = fits.if_they_agree(
                scene, lambda one: fits.fitted(one, hits, trajectory, poses)
            )
            note = "; ".join(filter(None, (note, why)))
        solution = solution.sure(scene.title)
        if not scene.known_pose:
            solution = replace(solution, misfit=parts.misfit_of(solution))
    return solution, "; ".join(filter(None, (note, less_certain(solution))))


def less_certain(solution: Joint) -> str:
    """A note on known lengths to which the board's path at their moments, as where no hits show it,
    adds more than their own standard deviation."""
    notes = []
    for one in (one for one in solution.recordings if one.lengths):
        part = reduced(one.sums(solution.state, solution.of), one.trajectory, one.noise)
        for seen in one.lengths:
            *_, variance = one.seen_length(seen, solution.state, solution.of, part)
            times = np.sqrt(variance) / seen.known.sd_m
            if times > 2:
                at = ", ".join(f"{p.time_s:g} s" for p in seen.known.places if p.station is None)
                why = f"{times:.0f} times less certain, as the place of the board is at {at}"
                notes.append(f"known_length is {why}")
    return "; ".join(notes)


def residual_rows(solution: Joint, hits: Hits, names: Sequence[str]) -> dict[str, Rows]:
    """Binned residuals of the first recording; hits: of the recording, also of excluded diodes;
    names: of the stations.

    `against`, for each station and axis and for `angle_deg` (as estimated) and `time_s`: middles of
    bins of equal width `at`, means `mean_urad` of the residuals, offsets of sweeps included, and
    `sd_urad`, the standard deviation of the mean by noise; `by_diode`, for each station: `diode`,
    `rms_urad` of the residuals without the offsets of sweeps, `n`, and those `excluded`.
    """
    one = every = solution.recordings[0]
    known = hits.take(one.trajectory.known(hits.time_s))
    if len(known) != one.residual.size:  # with those of excluded diodes, along the same trajectory
        every = replace(
            recording(BatchInput(known, one.trajectory), solution.state), noise=one.noise
        )
    return {"against": _against(one, names), "by_diode": _by_diode(one, every, names)}


def _against(one: Recording, names: Sequence[str]) -> Rows:
    rows: Rows = []
    hits, of_hits = one.sweeps.hits, (one.residual, one.plain().hit, one.sweeps.sweep)
    # Bins of the measured angle would sort the hits of a board at rest by their residuals.
    scales = {"angle_deg": np.degrees(hits.angle_rad + one.residual), "time_s": hits.time_s}
    every = product(scales, enumerate(names), enumerate(AXES))
    for name, (station, role), (axis, label) in every:
        chosen = np.flatnonzero((hits.station == station) & (hits.axis == axis))
        if chosen.size:
            residual, weight, sweep = (values[chosen] for values in of_hits)
            at, mean, sd = binned_means(scales[name][chosen], residual, weight, sweep, one.noise)
            row: dict[str, object] = {"against": name, "station": role, "axis": label}
            row |= {"at": np.round(at, 3).tolist()}
            row |= {"mean_urad": np.round(1e6 * mean, DIGITS).tolist()}
            rows.append(row | {"sd_urad": np.round(1e6 * sd, DIGITS).tolist()})
    return rows


def binned_means(
    x: np.ndarray,
    residual: np.ndarray,
    weight: np.ndarray,
    sweep: np.ndarray,
    noise: tuple[float, float],
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Middles of `BINS` bins of equal width, means and their standard deviations, of the bins with
    `FEWEST_HITS` or more.

    x, residual, weight, sweep (n,) of hits; noise: standard deviations s of a hit and c of what the
    hits of a sweep share. With W = sum w, the mean is sum w r / W and its variance
    (s^2 sum w^2 + c^2 sum_sweeps (sum w)^2) / W^2.
    """
    edges = np.linspace(x.min(), x.max(), BINS + 1)
    in_bin = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, BINS - 1)
    total, square, sums = (
        np.bincount(in_bin, values, BINS) for values in (weight, weight**2, weight * residual)
    )
    n_sweeps = int(sweep.max()) + 1
    of_sweep = np.bincount(n_sweeps * in_bin + sweep, weight, n_sweeps * BINS)
    shared = np.sum(of_sweep.reshape(BINS, n_sweeps) ** 2, axis=1)
    many = np.bincount(in_bin, minlength=BINS) >= FEWEST_HITS
    hit, common = noise
    sd = np.sqrt(hit**2 * square[many] + common**2 * shared[many]) / total[many]
    return ((edges[:-1] + edges[1:]) / 2)[many], sums[many] / total[many], sd


def _by_diode(one: Recording, every: Recording, names: Sequence[str]) -> Rows:
    rows: Rows = []
    hits, square = every.sweeps.hits, every.alone**2
    for station, role in enumerate(names):
        of_station = hits.station == station
        rms = rms_by(hits.diode[of_station], square[of_station])
        count = np.bincount(hits.diode[of_station], minlength=rms.size)
        of_one = one.sweeps.hits.station == station
        used = np.bincount(one.sweeps.hits.diode[of_one], minlength=rms.size)
        seen = np.flatnonzero(count)
        rows.append(
            {
                "station": role,
                "diode": seen.tolist(),
                "rms_urad": np.round(1e6 * rms[seen], DIGITS).tolist(),
                "n": count[seen].tolist(),
                "excluded": seen[used[seen] == 0].tolist(),
            }
        )
    return rows
