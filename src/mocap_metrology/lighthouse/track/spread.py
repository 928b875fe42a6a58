"""Covariance of a receiver's poses along its trajectory, from what it is estimated with.

With the normal equations of `batch.solve`, control points x, and all else y = (p, q), p the slave's
pose and q time zeros, laser depths and the board,

    x = - A^-1 (g + C y),   dq/dp = - (S_qq + L)^-1 S_qp,

so with K = (I, dq/dp) the slave's pose moves the control points by -A^-1 C K dp. A pose at a moment
depends on four control points, whose blocks of A^-1 lie within its band.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.batch.estimate import Joint
from mocap_metrology.lighthouse.batch.inverse import pose_blocks, selected_inverse
from mocap_metrology.lighthouse.batch.kernel import POSE, right_jacobians
from mocap_metrology.lighthouse.batch.problem import layout
from mocap_metrology.lighthouse.batch.recording import Recording
from mocap_metrology.lighthouse.batch.solve import Reduced, covariance_of, reduced
from mocap_metrology.lighthouse.calibrate.scene import Scene
from mocap_metrology.lighthouse.rotation import exp


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
    found: Joint, scene: Scene, covariance: np.ndarray, own: bool, time_s: np.ndarray
) -> Spread:
    """Of the poses of one recording at these times.

    found: an estimate, the slave's pose among the unknowns or held; scene: that it is of;
    covariance (6, 6) of the slave's pose in m and rad, of more stations that of all poses; own: the
    pose comes from this very recording, so that errors of board and optics in both are the same.
    """
    one, state = found.recordings[0], found.state
    there = [column >= 0 for column in found.of.inertial]
    gravity = found.of.gravity >= 0
    n, board, priors = len(state.R), len(state.board), scene.used_priors
    of = layout(n, board, priors, inertial=there, gravity=gravity, more=scene.more)
    poses = len(covariance)
    free = np.full(of.size - found.of.size, np.inf)  # the slave's pose, where it was held
    working, believed = np.r_[free, found.working], np.r_[free, found.believed]
    parts = reduced(one.sums(state, of, of.inertial[0]), one.trajectory, one.noise)
    S, p, q = parts.S + one.by_lengths(state, of, parts)[0], slice(0, poses), slice(poses, None)
    M = np.linalg.inv(S[q, q] + np.diag(1 / working[q] ** 2))
    K = np.vstack([np.eye(poses), -M @ S[q, p]])
    every = np.zeros_like(S)
    if own:
        every = covariance_of(S, working, believed)
    else:
        every[q, q] = covariance_of(S[q, q], working[q], believed[q])
    every = every + K @ (covariance - every[p, p]) @ K.T
    of_noise = np.zeros_like(S)
    of_noise[q, q] = M @ S[q, q] @ M
    by_all, of_hits = _by_unknowns(one, parts, time_s)
    hits = np.einsum("naa->na", of_hits)

    def sd(by: Floats, of_y: Floats, more: Floats | float = 0.0) -> Floats:
        variance: Floats = ((by @ of_y) * by).sum(axis=2) + more
        return np.sqrt(np.maximum(variance, 0.0))

    by_slave = by_all @ K
    total = by_all @ every @ np.swapaxes(by_all, 1, 2) + of_hits
    return Spread(
        sd(by_all, of_noise, hits),
        sd(by_slave, covariance),
        np.sqrt(np.maximum(np.einsum("naa->na", total), 0.0)),
        by_slave,
        total,
    )


def _by_unknowns(one: Recording, parts: Reduced, time_s: np.ndarray) -> tuple[Floats, Floats]:
    """Derivatives (n, 6, G) of the poses by all but the trajectory, and their covariance
    (n, 6, 6) where that is known, in m and rad."""
    trajectory = one.trajectory
    first, weights = trajectory.basis(time_s)
    near = first[:, None] + np.arange(4)
    of_hits = np.zeros((time_s.size, POSE, POSE))
    pose_blocks(selected_inverse(parts.factor), first, weights, of_hits)
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
