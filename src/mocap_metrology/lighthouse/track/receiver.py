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
from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.batch.estimate import Joint, determined
from mocap_metrology.lighthouse.batch.kernel import POSE
from mocap_metrology.lighthouse.batch.trajectory import KNOT_S
from mocap_metrology.lighthouse.calibrate.batch import Scene
from mocap_metrology.lighthouse.calibrate.turns import well_fitted
from mocap_metrology.lighthouse.calibrate.variants import COVARIANCE_UNITS
from mocap_metrology.lighthouse.records import ROLES, Hits
from mocap_metrology.lighthouse.timing import CYCLE_S
from mocap_metrology.lighthouse.track import start
from mocap_metrology.lighthouse.track.spread import Spread, spread

STEP_S = 2 * CYCLE_S  # between poses: a turn of the rotors, 1/60 s
NEAR_S = KNOT_S / 2  # hits so near a moment are its own
FEWEST_HITS = 6  # of a trajectory
AXES_OF_POSE = ("x_mm", "y_mm", "z_mm", "rx_deg", "ry_deg", "rz_deg")


@dataclass(frozen=True)
class Calibrated:
    """Pose R, t (m) of the slave in the master's frame, its covariance (6, 6) in m and rad (0 where
    none is known), and whether it comes from the recording that is tracked; of more stations
    R (n - 1, 3, 3), t (n - 1, 3), and the covariance of all, 6 (n - 1) square."""

    R: np.ndarray
    t_m: np.ndarray
    covariance: np.ndarray
    own: bool

    @property
    def poses(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Of all stations, the reference first."""
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
    `known`.

    Raises `Refusal` where no pose of it can be found.
    """
    scene, hits = replace(scene, known_pose=True), scene.hits
    rotors = scene.rotors
    trajectory = None
    if len(hits) >= FEWEST_HITS:
        trajectory = start.trajectory(hits, scene.board, rotors, known.poses)
    if trajectory is None:
        raise Refusal(
            "receiver: expected moments at which both stations see three of its diodes, or one four"
        )
    hits = hits.take(trajectory.known(hits.time_s))
    with determined("receiver"):
        found, note = well_fitted(scene, hits, trajectory, known.poses)
    return along(found.sure("receiver"), scene, known, note, time_s)


def along(
    found: Joint, scene: Scene, known: Calibrated, note: str, time_s: Floats | None = None
) -> Track:
    """Poses of an estimate from the hits of `scene`, the slave's pose among its unknowns or not."""
    one, own_s = found.recordings[0], scene.hits.time_s
    if time_s is None:
        time_s = own_s.min() + STEP_S * np.arange(int(np.ptp(own_s) / STEP_S) + 1)
    hits = one.sweeps.hits
    count, residual = _near(time_s, hits, one.alone, len(scene.names))
    with determined("receiver"):
        sd = spread(found, scene, known.covariance, known.own, time_s)
    R, t = one.trajectory.poses(time_s)
    unseen = count.sum(axis=1) == 0
    for values in (R, t, residual, sd.noise, sd.calibration, sd.total, sd.by_slave):
        values[unseen] = np.nan
    return Track(time_s, R, t, count, residual, sd, note, scene.names)


def columns(found: Track | None) -> dict[str, np.ndarray]:
    """track.parquet: one row a moment; no rows without a track."""
    from scipy.spatial.transform import Rotation

    if found is None:
        nothing = np.zeros((0, 6))
        sd = Spread(nothing, nothing, nothing, *2 * [np.zeros((0, 6, 6))])
        R, count = np.zeros((0, 3, 3)), np.zeros((0, 2), np.int32)
        found = Track(nothing[:, 0], R, nothing[:, :3], count, nothing[:, 0], sd, "")
    q, seen = np.full((found.time_s.size, 4), np.nan), found.hits.any(axis=1)
    if seen.any():
        q[seen] = Rotation.from_matrix(found.R[seen]).as_quat(canonical=True)
    parts = {"time_s": found.time_s}
    parts |= dict(zip(("x_mm", "y_mm", "z_mm"), 1e3 * found.t_m.T, strict=True))
    parts |= dict(zip(("qx", "qy", "qz", "qw"), q.T, strict=True))
    hits = (f"n_hits_{name}" for name in found.names)
    parts |= dict(zip(hits, found.hits.T, strict=True))
    parts["residual_urad"] = 1e6 * found.residual_rad
    kinds = {"noise": found.sd.noise, "calibration": found.sd.calibration, "": found.sd.total}
    for kind, values in kinds.items():
        names = (f"sd_{kind}_{axis}".replace("__", "_") for axis in AXES_OF_POSE)
        parts |= dict(zip(names, (values * COVARIANCE_UNITS).T, strict=True))
    by = found.sd.by_slave[:, :3]
    by = by.reshape(len(by), 3, by.shape[2] // POSE, POSE)
    parts["gain_mm_per_mm"] = np.sqrt((by[..., :3] ** 2).sum(axis=(1, 2, 3)) / 3)
    per_rad = np.sqrt((by[..., 3:] ** 2).sum(axis=(1, 2, 3)) / 3)
    parts["gain_mm_per_deg"] = 1e3 * np.radians(per_rad)
    return parts


def _near(time_s: Floats, hits: Hits, off: Floats, n: int) -> tuple[np.ndarray, Floats]:
    """Hits (times, n) of each station within `NEAR_S` of each time, and rms of their residuals."""
    order = np.argsort(hits.time_s, kind="stable")
    ends = np.searchsorted(hits.time_s[order], [time_s - NEAR_S, time_s + NEAR_S])
    of = [hits.station[order] == k for k in range(n)]
    sums = [np.cumsum(np.r_[0.0, own]) for own in (*of, off[order] ** 2)]
    *counts, squares = (own[ends[1]] - own[ends[0]] for own in sums)
    with np.errstate(invalid="ignore"):
        rms = np.sqrt(np.maximum(squares, 0.0) / np.sum(counts, axis=0))
    return np.stack(counts, axis=1).astype(np.int32), rms
