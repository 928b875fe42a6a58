"""A length that was measured in the room as an equation of a joint estimate.

It is that between two places, or the size of a figure of several, as angles do not show scale: with
places p_i of mean c,

    L = sqrt(sum |p_i - c|^2),   dL = sum (p_i - c) / L dp_i,

which of two places is their distance over sqrt(2). With a, b the derivatives by trajectory and all
else, and in the notation of `batch.solve`, the trajectory leaves the derivative b - C' A^-1 a and
the variance sd^2 + a' A^-1 a. It is not moved itself.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.batch.kernel import POSE, right_jacobians
from mocap_metrology.lighthouse.batch.problem import Layout, State
from mocap_metrology.lighthouse.batch.trajectory import Trajectory
from mocap_metrology.lighthouse.known_length import KnownLength
from mocap_metrology.lighthouse.rotation import exp


@dataclass(frozen=True)
class LengthEquation:
    """Residual L - measured in m, variance, derivatives by trajectory (6 K,) and all else
    (unknowns,)."""

    residual: float
    variance: float
    by_trajectory: Floats
    by_others: Floats


@dataclass(frozen=True)
class LengthView:
    """A length with what the trajectory's knots fix about it: first control point, weights of four,
    and reference rotation of each place."""

    known: KnownLength
    first: np.ndarray
    basis: Floats
    turned: Floats

    @classmethod
    def of(cls, known: KnownLength, trajectory: Trajectory) -> LengthView:
        """A known length with the basis functions of the path at its times."""
        time_s = np.array([place.time_s for place in known.places])
        return cls(known, *trajectory.basis(time_s), trajectory.reference(time_s))


def equation(seen: LengthView, control: Floats, state: State, of: Layout) -> LengthEquation:
    """The equation of a known length at these values; control (K, 6): control points of the
    trajectory."""
    places = seen.known.places
    n, rows = len(places), seen.first[:, None] + np.arange(4)
    ends = np.einsum("ni,nij->nj", seen.basis, control[rows])
    J = right_jacobians(np.ascontiguousarray(ends[:, 3:]))
    R = seen.turned @ exp(ends[:, 3:])
    at, by = ends[:, :3].copy(), np.zeros((n, 3, of.size))
    by_pose = np.zeros((n, 3, POSE))
    for k, place in enumerate(places):
        if place.station is not None:
            at[k] = state.t_m[place.station]
            if (pose := int(of.columns[place.station, 0, 0])) >= 0:
                by[k, :, pose : pose + 3] = np.eye(3)
            continue
        q = state.board[place.diode]
        at[k] += R[k] @ q
        by_pose[k, :, :3] = np.eye(3)
        by_pose[k, :, 3:] = R[k] @ np.cross(np.eye(3), q).T @ J[k]
        if of.scale >= 0:
            by[k, :, of.scale] = R[k] @ q
        if of.places >= 0:
            by[k, :, of.places + 3 * place.diode + np.arange(3)] = R[k].T
    off = at - at.mean(axis=0)
    size = float(np.linalg.norm(off))
    u, x = off / size, np.zeros_like(control)
    np.add.at(x, rows, seen.basis[:, :, None] * np.einsum("ni,nia->na", u, by_pose)[:, None])
    variance = seen.known.sd_m**2
    return LengthEquation(size - seen.known.size_m, variance, x.ravel(), np.einsum("ni,nig", u, by))
