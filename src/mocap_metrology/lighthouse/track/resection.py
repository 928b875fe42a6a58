"""Poses of stations in the frame of motion capture, from where it saw the receiver and the hits.

Diode d at the time of a hit is at m + Q (d - l): m the place of the markers by motion capture, Q
the tracked attitude in its frame, l the place of the markers on the board. Of the calibration only
Q is used, over the few centimetres from the markers to a diode. The poses of all stations are
unknown, and in common l (as far as the alignment leaves it open), a turn of Q and the offset of the
clocks. Residuals of neighbouring hits are alike (motion, diodes, motion capture), so that their
noise is scaled by what a jackknife over `BLOCKS` of the time shows of it.

Q is of the board as tracked with stations that may be wrong. So the board is tracked again with the
poses that were found, until they keep their place: each time a third of their error is left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.hampel import MAD_TO_SIGMA
from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.batch.estimate import expect_determined
from mocap_metrology.lighthouse.batch.kernel import POSE
from mocap_metrology.lighthouse.batch.solve import solved
from mocap_metrology.lighthouse.calibrate.scene import Pose, Scene
from mocap_metrology.lighthouse.calibrate.superpose import jackknife
from mocap_metrology.lighthouse.records import Hits
from mocap_metrology.lighthouse.rotation import error, exp
from mocap_metrology.lighthouse.rotor import angles
from mocap_metrology.lighthouse.track.markers import Alignment, Markers, Tracked
from mocap_metrology.lighthouse.track.mocap import BLOCKS, match
from mocap_metrology.lighthouse.track.receiver import Calibrated, Track, track

MOST_HITS = 20_000  # of a station
FEWEST_HITS, FEWEST_BLOCKS = 50, 4  # hits in a block, blocks that have them
NEAR_STEPS = 1.6  # between two moments of the track
TURN_SD_RAD, LEVER_SD_M, OFFSET_SD_S = np.radians(0.5), 5e-2, 1e-3  # of what is common
COMMON = 7  # lever, turn, offset
HUBER, GROSS = 2.0, 8.0
DIFFERENCE_M = 1e-6  # of a numerical derivative
ROUNDS, SMALL = 30, 1e-3
AGAIN, SETTLED = 5, 0.25  # times that the board is tracked; step over its standard deviation


@dataclass(frozen=True)
class Resected:
    """Poses R, t (m) of some stations of a scene, `members`, in the frame of motion capture, the
    reference first; covariance 6 (n - 1) square of those of all others in its frame, m and rad; of
    each the hits used, and the rms of their residuals in rad."""

    members: list[int]
    poses: list[Pose]
    covariance: Floats
    hits: list[int]
    rms_rad: list[float]

    @property
    def relative(self) -> list[Pose]:
        """Poses of the stations but the reference, in its frame."""
        (R_0, t_0), *others = self.poses
        return [(R_0.T @ R, R_0.T @ (t - t_0)) for R, t in others]


@dataclass(frozen=True)
class _Light:
    """Hits of one station: place and velocity (n, 3) of the markers by motion capture, Q (n, 3, 3),
    diode and angle."""

    place_m: Floats
    velocity: Floats
    Q: Floats
    diode_m: Floats
    axis: np.ndarray
    angle_rad: Floats
    block: np.ndarray


def resected(
    scene: Scene, known: Calibrated, tracked: Tracked, seen: Markers, alignment: Alignment
) -> Resected:
    """Poses that do not depend on those of the calibration, `known`, with which `tracked` was found
    and aligned. Raises `Refusal` as `resect` and `track`."""
    with expect_determined("receiver"):
        placed = resect(scene, known.poses, tracked, seen, alignment)
    if len(placed.members) < len(known.poses):
        scene = scene.of(placed.members)
    for _ in range(AGAIN):
        R, t = (np.stack(parts) for parts in zip(*placed.relative, strict=True))
        none = np.zeros_like(placed.covariance)
        now = Calibrated(np.squeeze(R), np.squeeze(t), none, False)
        ours = as_tracked(track(scene, now))
        with expect_determined("receiver"):
            then = resect(scene, now.poses, ours, seen, match(ours, seen).free)
        if len(then.members) < len(placed.members):
            break  # as good as before
        moved = _pose_steps(placed.relative, then.relative)
        placed = replace(then, members=placed.members)
        if np.abs(moved / np.sqrt(np.diag(placed.covariance))).max() < SETTLED:
            break
    return placed


def resect(
    scene: Scene, stations: list[Pose], track: Tracked, seen: Markers, known: Alignment
) -> Resected:
    """Without stations that have fewer than `FEWEST_HITS` in `FEWEST_BLOCKS` while motion capture
    saw the receiver.

    stations: their poses in the frame of the first, from which the search starts; track, known: of
    the board of the scene, and what brings it to motion capture. Raises `Refusal` where the
    reference or all others have fewer.
    """
    every = [_light(scene, k, track, seen, known) for k in range(len(stations))]
    counts = [np.bincount(one.block, minlength=BLOCKS) for one in every]
    members = [k for k, one in enumerate(counts) if (one >= FEWEST_HITS).sum() >= FEWEST_BLOCKS]
    if members[:1] != [0] or len(members) < 2:
        raise Refusal(
            f"motion capture saw the receiver at too few hits of station {scene.names[0]} or of"
            f" all others; expected {FEWEST_HITS} in each of {FEWEST_BLOCKS} tenths of the time"
        )
    light = [every[k] for k in members]
    start = [(known.A @ R, known.A @ t + known.b_m) for R, t in (stations[k] for k in members)]
    rotors, fit = scene.rotors[members], _Fit(start, np.zeros(COMMON))
    for _ in range(ROUNDS):
        normals = [_normal(one, k, fit, rotors[k]) for k, one in enumerate(light)]
        H = np.sum([one[0] for one in normals], axis=0)
        g = np.sum([one[1] for one in normals], axis=0)
        M, pull = H.sum(axis=0) + fit.prior, g.sum(axis=0) + fit.prior @ fit.at
        step = solved(M, -pull)
        fit = fit.moved(step)
        if np.sqrt(step @ M @ step / step.size) < SMALL:
            break
    others = [fit.moved(solved(M - H[b], g[b] - pull)) for b in range(BLOCKS)]
    covariance = _covariance(fit, others, H.sum(axis=0), M)
    hits, rms = [one.angle_rad.size for one in light], [one[2] for one in normals]
    return Resected(members, fit.poses, covariance, hits, rms)


@dataclass(frozen=True)
class _Fit:
    """Present values: poses, and what is common: lever in m, turn in rad, offset in s."""

    poses: list[Pose]
    common: Floats

    @property
    def at(self) -> Floats:
        return np.r_[np.zeros(POSE * len(self.poses)), self.common]

    @property
    def prior(self) -> Floats:
        """Information of the prior of all unknowns; the poses of stations have none."""
        sd = np.repeat([LEVER_SD_M, TURN_SD_RAD, OFFSET_SD_S], [3, 3, 1])
        return np.diag(np.r_[np.zeros(POSE * len(self.poses)), sd**-2])

    def moved(self, step: Floats) -> _Fit:
        steps = step[: POSE * len(self.poses)].reshape(-1, POSE)
        poses = [(exp(s[3:]) @ R, t + s[:3]) for s, (R, t) in zip(steps, self.poses, strict=True)]
        return _Fit(poses, self.common + step[-COMMON:])


def as_tracked(result: Track) -> Tracked:
    """A track with the standard deviation of its places, as motion capture is matched with it."""
    noise = np.sqrt(np.mean(result.sd.noise[:, :3] ** 2, axis=1))
    return Tracked(result.time_s, result.R, result.t_m, noise)


def _light(scene: Scene, k: int, track: Tracked, seen: Markers, known: Alignment) -> _Light:
    """Hits of a station where track and motion capture know the board; of many hits some."""
    from scipy.spatial.transform import Rotation, Slerp

    hits: Hits = scene.hits.take(scene.hits.station == k)
    hits = hits.take(np.arange(0, len(hits), max(len(hits) // MOST_HITS, 1)))
    tracked = np.flatnonzero(np.isfinite(track.t_m).all(axis=1))
    at = track.time_s[tracked]
    after = np.clip(np.searchsorted(at, hits.time_s), 1, at.size - 1)
    step = float(np.median(np.diff(track.time_s)))
    place, velocity = seen.at(known.time(hits.time_s))
    used = (hits.time_s >= at[after - 1]) & (hits.time_s <= at[after])
    used &= (at[after] - at[after - 1] <= NEAR_STEPS * step) & np.isfinite(place).all(axis=(1, 2))
    hits = hits.take(used)
    turns = Slerp(at, Rotation.from_matrix(track.R[tracked]))
    Q = known.A @ turns(hits.time_s).as_matrix()
    share = (hits.time_s - track.time_s[0]) / max(float(np.ptp(track.time_s)), 1e-9)
    block = np.clip((BLOCKS * share).astype(int), 0, BLOCKS - 1)
    arm = scene.board[hits.diode] - known.lever_m.mean(axis=0)
    mean = place[used].mean(axis=1), velocity[used].mean(axis=1)
    return _Light(*mean, Q, arm, hits.axis, hits.angle_rad, block)


def _normal(light: _Light, k: int, fit: _Fit, rotors: Floats) -> tuple[Floats, Floats, float]:
    """Normal equations H (blocks, u, u), g (blocks, u) of a station's hits, over the variance of
    their residuals; and the rms of these."""
    (R, t), n = fit.poses[k], len(fit.poses)
    lever, turn, offset = fit.common[:3], fit.common[3:6], fit.common[6]
    arm = light.diode_m @ exp(turn).T - lever
    far = light.place_m + offset * light.velocity + np.einsum("nij,nj->ni", light.Q, arm) - t
    point = np.ascontiguousarray(far @ R)
    rows = np.arange(len(point)), light.axis
    r = angles(point, rotors)[rows] - light.angle_rad
    down = np.empty_like(point)  # of the angle by the point in the station's frame
    for i in range(3):
        d = DIFFERENCE_M * np.eye(3)[i]
        down[:, i] = (angles(point + d, rotors)[rows] - angles(point - d, rotors)[rows]) / (
            2 * DIFFERENCE_M
        )
    down = down @ R.T  # in the frame of motion capture
    J = np.zeros((len(point), POSE * n + COMMON))
    J[:, POSE * k : POSE * k + 3] = -down
    J[:, POSE * k + 3 : POSE * k + 6] = np.cross(down, far)
    body = np.einsum("nij,ni->nj", light.Q, down)
    J[:, -7:-4], J[:, -4:-1] = -body, np.cross(light.diode_m, body)
    J[:, -1] = np.einsum("ni,ni->n", down, light.velocity)
    sigma = max(MAD_TO_SIGMA * float(np.median(np.abs(r))), 1e-9)
    size = np.abs(r) / sigma
    w = np.where(size < GROSS, 1 / np.maximum(size / HUBER, 1.0), 0.0)
    rms = float(np.sqrt(w @ r**2 / w.sum()))
    H, g = np.zeros((BLOCKS, J.shape[1], J.shape[1])), np.zeros((BLOCKS, J.shape[1]))
    for b in range(BLOCKS):
        at = light.block == b
        weighed = J[at] * w[at, None] / rms**2
        H[b], g[b] = weighed.T @ J[at], weighed.T @ r[at]
    return H, g, rms


def _covariance(fit: _Fit, others: list[_Fit], H: Floats, M: Floats) -> Floats:
    """Covariance of the poses in the frame of the reference: that of the noise, scaled to the mean
    of the jackknife where this is larger, plus that of the priors."""
    inverse = np.linalg.inv(M)
    size = POSE * len(fit.poses)
    steps = np.array([_pose_steps(fit.poses, other.poses) for other in others])
    noise = inverse @ H @ inverse
    more = np.trace(np.linalg.solve(noise[:size, :size], jackknife(steps))) / size
    every = max(float(more), 1.0) * noise + inverse @ fit.prior @ inverse
    D = relative_by_poses(fit.poses)
    return D @ every[:size, :size] @ D.T


def relative_by_poses(poses: Sequence[Pose]) -> Floats:
    """Derivatives (6 (n - 1), 6 n) of the poses in the frame of the first, by steps t and left
    rotation vectors of all."""
    (R_0, t_0), *others = poses
    D = np.zeros((POSE * len(others), POSE * len(poses)))
    for k, (_, t) in enumerate(others, start=1):
        rows = D[POSE * (k - 1) : POSE * k]
        arm = np.cross(np.eye(3), t - t_0)  # d(R_0' far) = R_0' (far x turn)
        rows[:3, POSE * k : POSE * k + 3], rows[:3, :3] = R_0.T, -R_0.T
        rows[:3, 3:6] = R_0.T @ arm
        rows[3:, POSE * k + 3 : POSE * k + 6], rows[3:, 3:6] = R_0.T, -R_0.T
    return D


def _pose_steps(a: Sequence[Pose], b: Sequence[Pose]) -> Floats:
    """Steps from poses to others."""
    pairs = zip(a, b, strict=True)
    return np.concatenate([np.r_[t_b - t_a, error(R_b, R_a)] for (R_a, t_a), (R_b, t_b) in pairs])
