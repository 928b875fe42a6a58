"""Pose of a receiver along a recording with stations that were calibrated before (J VIII).

The trajectory is that of estimator `batch`, with the slave's pose held: time zeros, laser depths
and the receiver's diodes are estimated within their priors. Each pose has three standard
deviations: by the noise of the hits, by the error of the calibration, and by all, errors of optics
and board included.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.linear import nearest_rotation
from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.batch.estimate import Joint, expect_determined
from mocap_metrology.lighthouse.batch.kernel import POSE, right_jacobians
from mocap_metrology.lighthouse.batch.problem import layout
from mocap_metrology.lighthouse.batch.recording import Recording
from mocap_metrology.lighthouse.batch.solve import Reduced, covariance_of, reduced
from mocap_metrology.lighthouse.batch.trajectory import KNOT_S, Trajectory, trajectory_of
from mocap_metrology.lighthouse.batch.view import pose_blocks, selected_inverse
from mocap_metrology.lighthouse.board import FEWEST_DIODES
from mocap_metrology.lighthouse.calibrate.fits import well_fitted
from mocap_metrology.lighthouse.calibrate.network import moments
from mocap_metrology.lighthouse.calibrate.scene import Pose, Scene, faced
from mocap_metrology.lighthouse.fit.board_pose import by_levenberg_marquardt, well_posed
from mocap_metrology.lighthouse.records import COVARIANCE_UNITS, ROLES, Hits, Measurements, Path
from mocap_metrology.lighthouse.rotation import exp, quaternions
from mocap_metrology.lighthouse.rotor import directions, rotor_parameters
from mocap_metrology.lighthouse.timing import CYCLE_S

STEP_S = 2 * CYCLE_S  # between poses: a turn of the rotors, 1/60 s
NEAR_S = KNOT_S / 2  # hits so near a moment are its own
FEWEST_HITS = 6  # of a trajectory
AXES_OF_POSE = ("x_mm", "y_mm", "z_mm", "rx_deg", "ry_deg", "rz_deg")
FEWEST_POINTS = 3
PARALLEL = 1e-6  # squared sine of the angle between two rays, below which they fix no point


def first_trajectory(
    hits: Hits, board: np.ndarray, rotors: np.ndarray, stations: Sequence[Pose]
) -> Trajectory | None:
    """Near that of the board; None where no pose of it is found.

    A diode that both stations see at one moment is at the point nearest to both rays; three such
    points give the pose without a mirrored one (Kabsch). Where one station alone sees four diodes,
    the pose is that of the smaller K_1. rotors (stations, 2, 13); stations: their poses in the
    frame of the first. Points are those of a station and of the two before it.
    """
    seen = [
        Measurements(measured.time_s, directions(measured.angles_rad, rotors[station]))
        for station, measured in enumerate(moments(hits, len(board), len(stations)))
    ]
    parts = []
    for j in range(1, len(seen)):
        for i in range(max(j - 2, 0), j):
            (R, t_m), (R_j, t_j) = stations[i], stations[j]
            both = triangulated([seen[i], seen[j]], board, R.T @ R_j, R.T @ (t_j - t_m))
            parts.append(both.seen_from(R, t_m))
    alone = ~np.isin(seen[0].time_s, np.concatenate([part.time_s for part in parts]))
    for measured, pose in zip(seen, stations, strict=True):
        rows = alone & (measured.seen.sum(axis=1) >= FEWEST_DIODES)
        if len(posed := well_posed(measured.take(rows), board)):
            by_one = by_levenberg_marquardt(posed, board, rotor_parameters())
            parts.append(by_one.seen_from(*pose))
    every = Path.joined(parts)
    if not len(every):
        return None
    begin, end = hits.time_s.min(), hits.time_s.max()
    return trajectory_of(every, begin, end)


def triangulated(
    seen: Sequence[Measurements], board: np.ndarray, R: np.ndarray, t_m: np.ndarray
) -> Path:
    """Poses at the moments at which both stations see three diodes that span a surface; seen: ideal
    angles of both at the same moments."""
    tangents = [np.moveaxis(np.tan(measured.angles_rad), 2, 0) for measured in seen]
    a, b = (np.stack([np.ones_like(tangent[0]), *tangent], -1) for tangent in tangents)
    b = b @ R.T
    aa, ab, bb = (np.einsum("ndi,ndi->nd", *pair) for pair in ((a, a), (a, b), (b, b)))
    with np.errstate(invalid="ignore", divide="ignore"):
        det = np.where(aa * bb - ab**2 > PARALLEL * aa * bb, aa * bb - ab**2, np.nan)
        far_a = (bb * (a @ t_m) - ab * (b @ t_m)) / det
        far_b = (ab * (a @ t_m) - aa * (b @ t_m)) / det
    points = (far_a[..., None] * a + t_m + far_b[..., None] * b) / 2
    known = np.isfinite(points).all(axis=2) & (far_a > 0) & (far_b > 0)
    shared = np.where(known[..., None], seen[0].angles_rad, np.nan)
    enough = known.sum(axis=1) >= FEWEST_POINTS
    wide = well_posed(Measurements(seen[0].time_s[enough], shared[enough]), board).time_s
    rows = np.flatnonzero(np.isin(seen[0].time_s, wide))
    R, t_m = _superposed(points[rows], known[rows], board)
    return Path(seen[0].time_s[rows], R, t_m, *3 * [np.zeros(rows.size)])


def _superposed(
    points: np.ndarray, known: np.ndarray, board: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """R (n, 3, 3), p (n, 3) that bring the board to the known of the points (n, diodes, 3)."""
    w = known / known.sum(axis=1, keepdims=True)
    points = np.where(known[..., None], points, 0.0)
    centre, board_centre = np.einsum("nd,ndi->ni", w, points), w @ board
    H = np.einsum("nd,ndi,ndj->nij", w, points - centre[:, None], board - board_centre[:, None])
    R = nearest_rotation(H)
    return R, centre - np.einsum("nij,nj->ni", R, board_centre)


@dataclass(frozen=True)
class Spread:
    """Standard deviations (n, 6) of position in m and left rotation vector in rad: by the noise of
    the hits; by the error of the slave's pose; by all, with the priors of optics and board."""

    noise: Floats
    calibration: Floats
    total: Floats
    by_slave: Floats  # (n, 6, 6): derivative by the slave's pose, or by those of all stations
    covariance: Floats  # (n, 6, 6) of all


def spread(
    joint: Joint, scene: Scene, covariance: np.ndarray, is_own: bool, time_s: np.ndarray
) -> Spread:
    """Standard deviations of the poses of one recording at these times.

    With the normal equations of `batch.solve`, control points x, and all else y = (p, q), p the
    slave's pose and q time zeros, laser depths and the board,
        x = - A^-1 (g + C y),   dq/dp = - (S_qq + L)^-1 S_qp,
    so with K = (I, dq/dp) the slave's pose moves the control points by -A^-1 C K dp. A pose at a
    moment depends on four control points, whose blocks of A^-1 lie within its band.

    joint: an estimate, the slave's pose among the unknowns or held; scene: that it is of;
    covariance (6, 6) of the slave's pose in m and rad, of more stations that of all poses; is_own:
    the pose comes from this recording, so that errors of board and optics are the same in both.
    """
    one, state = joint.recordings[0], joint.state
    there = [column >= 0 for column in joint.of.inertial]
    gravity = joint.of.gravity >= 0
    n, board, priors = len(state.R), len(state.board), scene.used_priors
    of = layout(n, board, priors, inertial=there, gravity=gravity, more=scene.more)
    poses = len(covariance)
    free = np.full(of.size - joint.of.size, np.inf)  # the slave's pose, where it was held
    working, believed = np.r_[free, joint.working], np.r_[free, joint.believed]
    parts = reduced(one.sums(state, of, of.inertial[0]), one.trajectory, one.noise)
    S, p, q = parts.S + one.by_lengths(state, of, parts)[0], slice(0, poses), slice(poses, None)
    M = np.linalg.inv(S[q, q] + np.diag(1 / working[q] ** 2))
    K = np.vstack([np.eye(poses), -M @ S[q, p]])
    every = np.zeros_like(S)
    if is_own:
        every = covariance_of(S, working, believed)
    else:
        every[q, q] = covariance_of(S[q, q], working[q], believed[q])
    every = every + K @ (covariance - every[p, p]) @ K.T
    of_noise = np.zeros_like(S)
    of_noise[q, q] = M @ S[q, q] @ M
    by_all, of_hits = _by_unknowns(one, parts, time_s)
    if (then := one.at_a_moment()) is not one:
        own = reduced(then.sums(state, of, of.inertial[0]), one.trajectory, one.noise)
        of_hits = _by_unknowns(one, own, time_s)[1]
    hits = np.einsum("naa->na", of_hits)

    def sd(by: Floats, of_y: Floats, more: Floats | float = 0.0) -> Floats:
        variance: Floats = ((by @ of_y) * by).sum(axis=2) + more
        return np.sqrt(np.maximum(variance, 0.0))

    by_slave = by_all @ K
    total = by_all @ every @ np.swapaxes(by_all, 1, 2) + of_hits
    of_total = np.sqrt(np.maximum(np.einsum("naa->na", total), 0.0))
    return Spread(sd(by_all, of_noise, hits), sd(by_slave, covariance), of_total, by_slave, total)


def _by_unknowns(one: Recording, parts: Reduced, time_s: np.ndarray) -> tuple[Floats, Floats]:
    """Derivatives (n, 6, G) of the poses by all but the trajectory, and their covariance
    (n, 6, 6) where that is known, in m and rad."""
    trajectory = one.trajectory
    first, weights = trajectory.basis(time_s)
    near = first[:, None] + np.arange(4)
    of_hits = pose_blocks(selected_inverse(parts.factor), first, weights)
    rows = parts.A_C.reshape(-1, POSE, parts.A_C.shape[1])
    by = np.zeros((time_s.size, *rows.shape[1:]))
    for i in range(4):
        by -= weights[:, i, None, None] * rows[near[:, i]]
    turn = np.einsum("ni,nia->na", weights, trajectory.control[near, 3:])
    J = trajectory.reference(time_s) @ exp(turn) @ right_jacobians(turn)
    by[:, 3:] = J @ by[:, 3:]
    of_hits[:, 3:] = J @ of_hits[:, 3:]
    of_hits[:, :, 3:] = of_hits[:, :, 3:] @ np.swapaxes(J, 1, 2)
    return by, one.noise.hit**2 * of_hits


@dataclass(frozen=True)
class Calibrated:
    """Pose R, t (m) of the slave in the master's frame, its covariance (6, 6) in m and rad (0 where
    none is known), and whether it comes from the recording that is tracked; of more stations
    R (n - 1, 3, 3), t (n - 1, 3), and the covariance of all, 6 (n - 1) square."""

    R: np.ndarray
    t_m: np.ndarray
    covariance: np.ndarray
    is_own: bool

    @property
    def poses(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Poses (R, t in m) of all stations in the frame of the first."""
        others = zip(self.R.reshape(-1, 3, 3), self.t_m.reshape(-1, 3), strict=True)
        return [(np.eye(3), np.zeros(3)), *others]


@dataclass(frozen=True)
class Track:
    """Poses at n moments `STEP_S` apart, in the master's frame; NaN where no hit is near.

    R (n, 3, 3), t_m (n, 3); hits (n, stations): of each within `NEAR_S`; residual_rad (n,):
    their rms beyond what their sweeps share; sd: of the poses; note: what was left out; names: of
    the stations.
    """

    time_s: Floats
    R: Floats
    t_m: Floats
    hits: np.ndarray
    residual_rad: Floats
    sd: Spread
    note: str
    names: Sequence[str] = ROLES


def track(scene: Scene, known: Calibrated, time_s: Floats | None = None) -> Track:
    """Poses of the board of `scene` along its recording, or at times within it, with stations as
    `known`. Raises `Refusal` where no pose of it can be found."""
    scene, hits = replace(scene, known_pose=True), scene.hits
    rotors = scene.rotors
    trajectory = None
    if len(hits) >= FEWEST_HITS:
        trajectory = first_trajectory(hits, scene.board, rotors, known.poses)
    if trajectory is None:
        raise Refusal(
            "receiver: expected moments at which both stations see three of its diodes, or one four"
        )
    hits = hits.take(trajectory.known(hits.time_s))
    R, t_m = trajectory.poses(hits.time_s)
    from_station = t_m - np.array([t for _, t in known.poses])[hits.station]
    scene, why = faced(scene, [(R, from_station, hits.diode)])
    with expect_determined("receiver"):
        joint, note = well_fitted(scene, hits, trajectory, known.poses)
    note = "; ".join(filter(None, (why, note)))
    return poses_along(joint.sure("receiver"), scene, known, note, time_s)


def poses_along(
    joint: Joint, scene: Scene, known: Calibrated, note: str, time_s: Floats | None = None
) -> Track:
    """Poses of an estimate from the hits of `scene`, the slave's pose among its unknowns or not."""
    one, own_s = joint.recordings[0], scene.hits.time_s
    if time_s is None:
        time_s = own_s.min() + STEP_S * np.arange(int(np.ptp(own_s) / STEP_S) + 1)
    hits = one.sweeps.hits
    count, residual = _hits_near(time_s, hits, one.alone, len(scene.names))
    with expect_determined("receiver"):
        sd = spread(joint, scene, known.covariance, known.is_own, time_s)
    R, t = one.trajectory.poses(time_s)
    unseen = count.sum(axis=1) == 0
    for values in (R, t, residual, sd.noise, sd.calibration, sd.total, sd.by_slave):
        values[unseen] = np.nan
    return Track(time_s, R, t, count, residual, sd, note, scene.names)


def columns(tracked: Track | None) -> dict[str, np.ndarray]:
    """track.parquet: one row a moment; no rows without a track."""
    if tracked is None:
        nothing = np.zeros((0, 6))
        sd = Spread(nothing, nothing, nothing, *2 * [np.zeros((0, 6, 6))])
        R, count = np.zeros((0, 3, 3)), np.zeros((0, 2), np.int32)
        tracked = Track(nothing[:, 0], R, nothing[:, :3], count, nothing[:, 0], sd, "")
    q, seen = np.full((tracked.time_s.size, 4), np.nan), tracked.hits.any(axis=1)
    if seen.any():
        q[seen] = quaternions(tracked.R[seen])
    parts = {"time_s": tracked.time_s}
    parts |= dict(zip(("x_mm", "y_mm", "z_mm"), 1e3 * tracked.t_m.T, strict=True))
    parts |= dict(zip(("qx", "qy", "qz", "qw"), q.T, strict=True))
    hits = (f"n_hits_{name}" for name in tracked.names)
    parts |= dict(zip(hits, tracked.hits.T, strict=True))
    parts["residual_urad"] = 1e6 * tracked.residual_rad
    kinds = {"noise": tracked.sd.noise, "calibration": tracked.sd.calibration, "": tracked.sd.total}
    for kind, values in kinds.items():
        names = (f"sd_{kind}_{axis}".replace("__", "_") for axis in AXES_OF_POSE)
        parts |= dict(zip(names, (values * COVARIANCE_UNITS).T, strict=True))
    by = tracked.sd.by_slave[:, :3]
    by = by.reshape(len(by), 3, by.shape[2] // POSE, POSE)
    parts["gain_mm_per_mm"] = np.sqrt((by[..., :3] ** 2).sum(axis=(1, 2, 3)) / 3)
    per_rad = np.sqrt((by[..., 3:] ** 2).sum(axis=(1, 2, 3)) / 3)
    parts["gain_mm_per_deg"] = 1e3 * np.radians(per_rad)
    return parts


def _hits_near(time_s: Floats, hits: Hits, off: Floats, n: int) -> tuple[np.ndarray, Floats]:
    """Hits (times, n) of each station within `NEAR_S` of each time, and rms of their residuals."""
    order = np.argsort(hits.time_s, kind="stable")
    ends = np.searchsorted(hits.time_s[order], [time_s - NEAR_S, time_s + NEAR_S])
    of = [hits.station[order] == k for k in range(n)]
    sums = [np.cumsum(np.r_[0.0, values]) for values in (*of, off[order] ** 2)]
    *counts, squares = (total[ends[1]] - total[ends[0]] for total in sums)
    with np.errstate(invalid="ignore"):
        rms = np.sqrt(np.maximum(squares, 0.0) / np.sum(counts, axis=0))
    return np.stack(counts, axis=1).astype(np.int32), rms
