"""Two paths of one board brought together: common times, then Kabsch (J VI-C to VI-E)."""

from __future__ import annotations

import numpy as np

from mocap_metrology.common.linear import nearest_rotation
from mocap_metrology.lighthouse.records import Path
from mocap_metrology.lighthouse.rotation import log
from mocap_metrology.lighthouse.timing import CYCLE_S

LONGEST_GAP_S = 12.5 * CYCLE_S  # between the two poses a third is interpolated from
BLOCKS = 20  # of the jackknife


def at_times(path: Path, time_s: np.ndarray, order: int = 1) -> tuple[Path, np.ndarray]:
    """The path at other times, and which of `time_s` have poses near enough on both sides.

    order 1: positions and the remaining K_1 linearly (J VI-C), rotations along the shortest turn;
    order 3: positions, and rotation vectors from the pose before, by the cubic through the two
    poses on either side, where they are near enough. Times outside the path, or in a gap of more
    than three sweep periods, are excluded. Returns the path at the other times, and the mask (n,).
    """
    if len(path) < 2:
        return path.take(np.zeros(0, dtype=int)), np.zeros(time_s.size, dtype=bool)
    after = np.clip(np.searchsorted(path.time_s, time_s, side="right"), 1, len(path) - 1)
    before = after - 1
    span = path.time_s[after] - path.time_s[before]
    inside = (time_s >= path.time_s[before]) & (time_s <= path.time_s[after])
    near = inside & (span <= LONGEST_GAP_S)
    if not near.any():
        return path.take(np.zeros(0, dtype=int)), near
    a, b, time = before[near], after[near], time_s[near]
    share = (time - path.time_s[a]) / span[near]
    R, t = _interpolated(path, np.stack([a, b]), time)
    if order == 3:
        four = np.clip(np.stack([a - 1, a, b, b + 1]), 0, len(path) - 1)
        whole = (a > 0) & (b < len(path) - 1)
        whole &= np.ptp(path.time_s[four], axis=0) <= 2 * LONGEST_GAP_S
        R[whole], t[whole] = _interpolated(path, four[:, whole], time[whole])
    epsilon = path.epsilon[a] + share * (path.epsilon[b] - path.epsilon[a])
    n_angles = np.minimum(path.n_angles[a], path.n_angles[b])
    return Path(time, R, t, epsilon, n_angles, path.ambiguity[a]), near


def nearest(time_s: np.ndarray, other_s: np.ndarray) -> np.ndarray:
    """Index of the nearest of `other_s`, which rise, to each time."""
    after = np.clip(np.searchsorted(other_s, time_s), 1, other_s.size - 1)
    return after - (time_s - other_s[after - 1] < other_s[after] - time_s)


def lagrange(nodes: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Weights (k, ...) of the polynomial through k nodes (k, ...), at (...)."""
    weights = np.ones_like(nodes)
    for i in range(len(nodes)):
        for j in range(len(nodes)):
            if i != j:
                weights[i] *= (at - nodes[j]) / (nodes[i] - nodes[j])
    return weights


def _interpolated(
    path: Path, nodes: np.ndarray, time_s: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """R (n, 3, 3) and t (n, 3) of the polynomial through the poses `nodes` (k, n)."""
    from scipy.spatial.transform import Rotation

    weights = lagrange(path.time_s[nodes], time_s)
    t = np.einsum("kn,kni->ni", weights, path.t_m[nodes])
    middle = (len(nodes) - 1) // 2
    first = Rotation.from_matrix(path.R[nodes[middle]])
    turn = np.zeros_like(t)
    for k in (k for k in range(len(nodes)) if k != middle):
        relative = first.inv() * Rotation.from_matrix(path.R[nodes[k]])
        turn += weights[k][:, None] * relative.as_rotvec()
    return (first * Rotation.from_rotvec(turn)).as_matrix(), t


def kabsch(
    moved: np.ndarray, fixed: np.ndarray, weight: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """R, t of the least weighted sum of |fixed - (R moved + t)|^2 [Kabsch 1976].

    moved, fixed (n, 3); weight (n,), default 1. The centroids are brought together, then R = V U^T
    of the singular value decomposition of the weighted covariance, never a reflection. As J VI-D
    has it; scipy's `Rotation.align_vectors` is equal to 4e-15, takes three times as long, which
    `geometric` and the jackknife would feel, and warns of the straight paths that boards go.
    """
    w = np.ones(len(moved)) if weight is None else weight
    w = w / w.sum()
    a, b = w @ moved, w @ fixed
    R = nearest_rotation(((moved - a) * w[:, None]).T @ (fixed - b)).T
    return R, b - R @ a


def jackknife(values: np.ndarray) -> np.ndarray:
    """Covariance of an estimate from its values with one of B blocks left out, (B, k) -> (k, k).

    (B - 1)/B sum (v_b - mean)(v_b - mean)^T: blocks of time, as neighbouring poses err together.
    """
    d = values - values.mean(axis=0)
    return (len(values) - 1) / len(values) * d.T @ d


def blocks_of(time_s: np.ndarray) -> np.ndarray:
    """Block of each time: equal stretches of the recording, numbered without gaps."""
    span = np.ptp(time_s) if time_s.size else 0.0
    if span == 0:
        return np.zeros(time_s.size, dtype=int)
    block = np.minimum(((time_s - time_s.min()) / span * BLOCKS).astype(int), BLOCKS - 1)
    return np.unique(block, return_inverse=True)[1]


def superpose(
    slave: np.ndarray, master: np.ndarray, weight: np.ndarray, time_s: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """Slave pose R, t (m) from positions of both paths at the same times, and its covariance (6, 6)
    of t and the left rotation vector in m and rad, by a jackknife over blocks of time; None with
    fewer than three."""
    R, t = kabsch(slave, master, weight)
    block = blocks_of(time_s)
    count = int(block.max()) + 1
    if count < 3:
        return R, t, None
    without = []
    for b in range(count):
        rest = block != b
        Rb, tb = kabsch(slave[rest], master[rest], weight[rest])
        without.append(np.r_[tb - t, log(Rb @ R.T)])
    return R, t, jackknife(np.array(without))
