"""Bias of a joint estimate by the curvature of its model, to second order of the noise.

An angle is no linear function of the board's pose. Where this is uncertain by degrees, as that of a
small board, the mean of the angles over its errors is not the angle of its mean, and no length of
recording removes what this does to the other unknowns. With u the pose that a hit depends on, C its
covariance, H the second derivative of the angle by it, J and V those of all unknowns and of the
noise, and L the information of the priors,

    bias = -(J' V^-1 J + L)^-1 J' V^-1 d,   d = trace(H C) / 2 of each hit

(Box 1971, J. R. Stat. Soc. B 33, 171). The curvature by the stations' poses is far smaller and left
out.

The prior of the trajectory biases as well. It makes every turn smaller, and with it all that scales
with the trajectory: distances of the stations, which angles do not show, and places of diodes. At
the estimate the hits pull at the trajectory by as much as this prior, -g. So the prior has moved
the other unknowns by what -g, of the hits, would: in the notation of `batch.solve`, C' A^-1 g is
added to what the hits pull.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.linalg import hadamard

from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.batch import kernel
from mocap_metrology.lighthouse.batch.kernel import POSE
from mocap_metrology.lighthouse.batch.problem import Layout, State
from mocap_metrology.lighthouse.batch.recording import Recording
from mocap_metrology.lighthouse.batch.solve import Reduced, by_bends, linearised, reduced
from mocap_metrology.lighthouse.batch.trajectory import Trajectory
from mocap_metrology.lighthouse.batch.view import View, pose_blocks, selected_inverse

SIGNS = hadamard(8)[:, 1 : 1 + POSE]
UNSURE_RAD = 0.3  # of a rotation, as beside a gap: beyond it the second order does not suffice


def bias_equations(one: Recording, state: State, of: Layout, factor: np.ndarray) -> Reduced:
    """Normal equations of a recording with d in place of its residuals: their solution y is the
    bias of the global unknowns, and `trajectory_step(y)` that of the control points; without that
    of their own prior, which is all that is known where no hits are.

    factor: of A, as in `Reduced`. Other data pull nothing. One C stands for the hits of a sweep; d
    is 0 where it is too large for the second order.
    """
    seen, trajectory, noise, weight = one.seen, one.trajectory, one.noise, one.weights()
    first = seen.sweeps.first[:-1]
    C = pose_blocks(selected_inverse(factor), seen.who[first, 3], seen.basis[first])
    size, axes = np.linalg.eigh(C)
    root = noise.hit * axes * np.sqrt(np.maximum(size, 0.0))[:, None]
    root[np.sum(root[:, 3:] ** 2, axis=(1, 2)) > UNSURE_RAD**2] = 0.0
    d = _curvature(seen, trajectory, state, one.residual + seen.sweeps.hits.angle_rad, root)
    flat = replace(trajectory, control=np.zeros_like(trajectory.control))  # its prior pulls nothing
    if (more := one.more(of)) is not None:
        more = more._replace(g=np.zeros_like(more.g), g_inner=np.zeros_like(more.g_inner))
    sums = linearised(seen, trajectory, state, d, weight.hit, of, more, weight.held)
    part = reduced(sums, flat, noise)
    return replace(part, h=part.h - by_bends(part, trajectory, noise))


def _curvature(
    seen: View, trajectory: Trajectory, state: State, angle: np.ndarray, root: np.ndarray
) -> Floats:
    """trace(H C) / 2 in rad of every hit, C = root root'; angle (n,): as estimated; root
    (sweeps, 6, 6).

    It is half the sum of the second differences of the angle along the columns of the root. Each
    hit has one along their sum with signs of its own; these are orthogonal over eight hits, in
    which mixed terms cancel.
    """
    n, near = angle.size, seen.who[:, 3, None] + np.arange(4)
    pose = np.einsum("ni,nia->na", seen.basis, trajectory.control[near])
    sweep, signs = seen.sweeps.sweep, SIGNS[np.arange(n) % len(SIGNS)]
    shift = sum(root[sweep, :, k] * signs[:, k, None] for k in range(POSE))
    who, only = seen.who.copy(), np.tile([1.0, 0.0, 0.0, 0.0], (n, 1))
    who[:, 3] = np.arange(n)  # a control point for each hit
    total = -angle
    for sign in (1, -1):
        control = np.vstack([pose + sign * shift, np.zeros((3, POSE))])
        total += kernel.predicted(kernel.Light(who, only, seen.turned), control, state) / 2
    return total
