"""Continuous trajectory of a board: cubic B-splines of position and rotation.

    p(t) = sum_i B_i(t) c_i,   R(t) = F(t) Exp(sum_i B_i(t) f_i)

with uniform knots, c_i in m, f_i rotation vectors in rad and F(t) a fixed smooth rotation near the
board's own, so that the rotation vectors stay small however far the board turns. F is scipy's
spline of rotations through medians of board poses.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mocap_metrology.lighthouse.records import Path
from mocap_metrology.lighthouse.rotation import exp, log

KNOT_S = 0.05  # 50 ms: follows 10 Hz, and a sweep of 8 ms is in two intervals at most
WINDOW_S = 0.1  # of the poses behind a node of F
FARTHEST_S = 0.25  # from a node: without a pose nearer, the trajectory is not known


def cubic(u: np.ndarray) -> np.ndarray:
    """Weights (n, 4) of the control points of an interval, u from 0 to 1 in it."""
    second, third = (3 * u**3 - 6 * u**2 + 4) / 6, (-3 * u**3 + 3 * u**2 + 3 * u + 1) / 6
    return np.column_stack([(1 - u) ** 3 / 6, second, third, u**3 / 6])


@dataclass(frozen=True)
class Trajectory:
    """Knots begin_s + i knot_s; control (K, 6): c_i and f_i; nodes of F: node_s (n,) and node_R
    (n, 3, 3), one for a board at rest, which has one control point, too."""

    begin_s: float
    knot_s: float
    control: np.ndarray
    node_s: np.ndarray
    node_R: np.ndarray

    @property
    def still(self) -> bool:
        return self.node_s.size == 1

    def moved(self, step: np.ndarray) -> Trajectory:
        """The path with its knots moved by a step (6 n,) in m and rad."""
        return replace(self, control=self.control + step.reshape(-1, 6))

    def seen_from(self, R: np.ndarray, t_m: np.ndarray) -> Trajectory:
        """The trajectory in a frame in which its own frame has the pose R, t."""
        control = np.column_stack([self.control[:, :3] @ R.T + t_m, self.control[:, 3:]])
        return replace(self, control=control, node_R=R @ self.node_R)

    def halved(self) -> Trajectory:
        """The same with knots at half the distance."""
        c = self.control
        control = np.empty((2 * len(c) - 3, 6))
        control[::2] = (c[:-1] + c[1:]) / 2
        control[1::2] = (c[:-2] + 6 * c[1:-1] + c[2:]) / 8
        return replace(self, knot_s=self.knot_s / 2, control=control)

    def basis(self, time_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """First control point (n,) at each time, and the weights (n, 4) of it and the next."""
        if self.still:
            weights = np.zeros((time_s.size, 4))
            weights[:, 0] = 1.0
            return np.zeros(time_s.size, np.int64), weights
        at = (time_s - self.begin_s) / self.knot_s
        first = np.clip(np.floor(at).astype(np.int64), 0, len(self.control) - 4)
        return first, cubic(at - first)

    def reference(self, time_s: np.ndarray) -> np.ndarray:
        """Rotations (n, 3, 3) by a spline through the nodes; knots turn the board from these."""
        from scipy.spatial.transform import Rotation, RotationSpline

        if self.still:
            return np.tile(self.node_R, (time_s.size, 1, 1))
        nodes = Rotation.from_matrix(self.node_R)
        inside = np.clip(time_s, self.node_s[0], self.node_s[-1])
        return RotationSpline(self.node_s, nodes)(inside).as_matrix()

    def poses(self, time_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """R (n, 3, 3) and p (n, 3) in m at these times."""
        first, weights = self.basis(time_s)
        pose = np.einsum("ni,nij->nj", weights, self.control[first[:, None] + np.arange(4)])
        return self.reference(time_s) @ exp(pose[:, 3:]), pose[:, :3]

    def known(self, time_s: np.ndarray) -> np.ndarray:
        """Whether poses lie near these times, bool (n,)."""
        if self.still:
            return np.ones(time_s.size, np.bool_)
        after = np.clip(np.searchsorted(self.node_s, time_s), 1, self.node_s.size - 1)
        near = np.minimum(
            np.abs(time_s - self.node_s[after - 1]), np.abs(time_s - self.node_s[after])
        )
        return near <= FARTHEST_S


def trajectory_of(path: Path, begin_s: float, end_s: float) -> Trajectory:
    """From begin_s to end_s, through the poses of a path, sorted or not; some may be wrong.

    A node is the pose of its window that is nearest to all others (least sum of angles), and the
    median position.
    """
    order = np.argsort(path.time_s, kind="stable")
    time, R, t = path.time_s[order], path.R[order], path.t_m[order]
    window = np.floor((time - time[0]) / WINDOW_S).astype(np.int64)
    first = np.flatnonzero(np.diff(window, prepend=-1))
    node_s, node_R, node_t = [], [], []
    for low, high in zip(first, np.append(first[1:], time.size), strict=True):
        nearby = R[low:high]
        trace = np.einsum("aij,bij->ab", nearby, nearby)
        angle = np.arccos(np.clip((trace - 1) / 2, -1, 1))
        node_R.append(nearby[angle.sum(axis=1).argmin()])
        node_s.append(np.mean(time[low:high]))
        node_t.append(np.median(t[low:high], axis=0))
    return trajectory_through(np.array(node_s), np.array(node_R), np.array(node_t), begin_s, end_s)


def trajectory_through(
    node_s: np.ndarray,
    node_R: np.ndarray,
    node_t_m: np.ndarray,
    begin_s: float,
    end_s: float,
    knot_s: float = KNOT_S,
) -> Trajectory:
    """Through nodes (n,), (n, 3, 3), (n, 3); straight between their positions.

    F has nodes at the ends, too, if these are near, at the rate of the nodes beside them: held
    there, it would have a kink at the first and at the last pose.
    """
    count = int(np.ceil((end_s - begin_s) / knot_s)) + 3
    at = begin_s + knot_s * (np.arange(count) - 1)
    control = np.zeros((count, 6))
    for axis in range(3):
        control[:, axis] = np.interp(at, node_s, node_t_m[:, axis])
    time, R = node_s, node_R
    for end, a, b in ((begin_s, 0, 1), (end_s, -1, -2)):
        beyond = (time[a] - end) * (1 if a == 0 else -1)
        if time.size > 1 and 0 < beyond <= FARTHEST_S:
            rate = log(R[a].T @ R[b]) / (time[b] - time[a])
            place = 0 if a == 0 else time.size
            R = np.insert(R, place, R[a] @ exp(rate * (end - time[a])), axis=0)
            time = np.insert(time, place, end)
    return Trajectory(begin_s, knot_s, control, time, R)


def at_rest(R: np.ndarray, t_m: np.ndarray) -> Trajectory:
    """A board that keeps the pose R, t."""
    control = np.zeros((4, 6))
    control[0, :3] = t_m
    return Trajectory(0.0, np.inf, control, np.zeros(1), R[None])
