"""Errors that the hits of a diode share from one direction, in light of the second generation.

What cover, housing and active area of a diode do to an angle depends on the direction of the light,
not on time: residuals of a moved controller (23 diodes, 2 to 3 m) covary by (34 urad)^2 within
0.5 deg of direction, (28)^2 at 2 deg, (18)^2 at 8 deg and not at all beyond 16 deg, whether hits
are 0.03 or 6 s apart; their white noise is 24 urad. Of n hits of a diode, of the white noise s, in
a cell of directions whose error has the variance tau^2, each has the variance s^2 + tau^2, and the
mean of all has s^2 / n + tau^2: all are worth as much as

    n share,   share = (s^2 + tau^2) / (s^2 + n tau^2)

independent ones. tau is what means of cells of one diode, station and plane differ by; a board that
shows its diodes from one direction shows no such difference, as the diodes' places explain it, and
has that of other boards.
"""

from __future__ import annotations

import numpy as np

from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.batch.kernel import POSE
from mocap_metrology.lighthouse.batch.problem import State
from mocap_metrology.lighthouse.batch.trajectory import Trajectory
from mocap_metrology.lighthouse.batch.view import View
from mocap_metrology.lighthouse.rotation import exp

CELL = 0.2  # of the direction, a unit vector in the board's axes: 11 deg
PER_AXIS = 12  # cells
USUAL_RAD, AS_MANY_AS = 25e-6, 2.0  # tau of two boards, 16 and 36 urad; and what that counts for
FEWEST_HITS = 4.0  # of a cell whose mean counts


def shares(
    seen: View,
    trajectory: Trajectory,
    state: State,
    alone: Floats,
    weight: Floats,
    hit_rad: float,
) -> tuple[Floats, float, float]:
    """Share of each hit; tau, and the noise of a hit with it, in rad.

    alone, weight: residual beyond its sweep's offset in rad, robust weight; hit_rad: noise of a
    hit.
    """
    who = seen.who
    own = np.einsum("ni,nia->na", seen.basis, trajectory.control[who[:, 3, None] + np.arange(4)])
    far = state.t_m[who[:, 0]] - own[:, :3]
    turn = seen.turned @ exp(own[:, 3:])
    way = np.einsum("nji,nj->ni", turn, far / np.linalg.norm(far, axis=1, keepdims=True))
    diode = (2 * who[:, 0] + who[:, 1]) * len(state.board) + who[:, 2]
    place = np.floor(way / CELL).astype(np.int64) + PER_AXIS // 2
    numbers = ((diode * PER_AXIS + place[:, 0]) * PER_AXIS + place[:, 1]) * PER_AXIS + place[:, 2]
    number, cell = np.unique(numbers, return_inverse=True)
    n = np.bincount(cell, weight).astype(np.float64)
    views = 2 * len(state.R) * who.shape[0] / (seen.sweeps.first.size - 1)
    mean = np.bincount(cell, weight * alone) / n
    within = float(weight @ (alone - mean[cell]) ** 2) / max(float(np.sum(n - 1)), 1.0)
    tau2 = _variance(number // PER_AXIS**3, n, mean, within, views)
    white = hit_rad**2 * min(within * float(n.sum()) / float(weight @ alone**2), 1.0)
    share = np.asarray((white + tau2) / (white + n * tau2), np.float64)
    return share[cell], float(np.sqrt(tau2)), float(np.sqrt(white + tau2))


def _variance(diode: np.ndarray, n: Floats, mean: Floats, within: float, views: float) -> float:
    """tau^2 in rad^2. diode, n, mean (cells,): what a cell is of, hits and their mean; within:
    variance of hits of a cell; views: hits of a moment, six of which the board's pose explains."""
    used = n >= FEWEST_HITS
    _, group = np.unique(diode[used], return_inverse=True)
    count = np.bincount(group)
    centre = np.bincount(group, mean[used]) / count
    several = (count > 1)[group]
    freedom = float(count.sum() - count.size)
    apart = (mean[used] - centre[group]) ** 2 - within / n[used] * (1 - 1 / count[group])
    total = float(np.sum(apart[several])) * views / max(views - POSE, 1.0)
    prior = AS_MANY_AS * USUAL_RAD**2
    return max(total + prior, 0.0) / (freedom + AS_MANY_AS)
