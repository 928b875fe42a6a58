"""Pose of the slave from its own angles of a board whose path is known (J V-B, Eq. 5 and 6), and
the last step of `paper-lm`, which weighs in that the path is not exactly known.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.calibrate.reconstruction import Optics
from mocap_metrology.lighthouse.calibrate.superpose import at_times, blocks_of
from mocap_metrology.lighthouse.calibrate.weighted_station import (
    Evidence,
    by_gauss_newton,
    jackknife_of_steps,
    residuals,
)
from mocap_metrology.lighthouse.fit.levenberg_marquardt import (
    ITERATIONS,
    Given,
    minimise,
    normal_equations,
)
from mocap_metrology.lighthouse.fit.simplex import (
    MATLAB,
    STATION,
    SimplexSettings,
    nelder_mead,
    seen_at,
)
from mocap_metrology.lighthouse.records import MASTER, SLAVE, Measurements, Path
from mocap_metrology.lighthouse.rotor import angles

# Of the plain residual by weighting it: lasers 15 mm off make 2, a last step that runs away 10.
RISE = 3.0

Pose = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Scene:
    """What K_2 sums over: diodes in the master's frame (m), the slave's angles (rad), times; and
    the slave's rotors."""

    points: np.ndarray  # (n, 3)
    angles: np.ndarray  # (n, 2)
    time_s: np.ndarray  # (n,)
    rotors: np.ndarray


def scene(path: Path, measurements: Measurements, board: np.ndarray, rotors: np.ndarray) -> Scene:
    """P_n and M_t,n of J Eq. 6, flat. `path`: the board in the master's frame at the times of
    `measurements` of the slave."""
    seen = measurements.seen
    points = np.einsum("nij,dj->ndi", path.R, board) + path.t_m[:, None]
    time = np.broadcast_to(path.time_s[:, None], seen.shape)
    return Scene(points[seen], measurements.angles_rad[seen], time[seen], rotors)


def by_nelder_mead(
    R: np.ndarray, t: np.ndarray, given: Scene, settings: SimplexSettings = MATLAB
) -> tuple[np.ndarray, np.ndarray, float]:
    """J Eq. 5 from the first estimate (R, t): R, t (m), K_2 in rad^2."""
    x0 = np.r_[t, rotation.to_angles(R)]
    seen = seen_at(STATION, given.points, given.angles, given.rotors)
    x, cost, _ = nelder_mead(x0, seen, settings)
    return rotation.from_angles(*x[3:]), x[:3], cost


def by_levenberg_marquardt(
    R: np.ndarray, t: np.ndarray, given: Scene
) -> tuple[np.ndarray, np.ndarray, float]:
    """J Eq. 5 by Levenberg-Marquardt from (R, t): R, t (m), K_2 in rad^2."""
    seen = Given(STATION, given.points, given.angles, given.rotors)
    return minimise(np.ascontiguousarray(R), t, seen, ITERATIONS)[:3]


def covariance(R: np.ndarray, t: np.ndarray, given: Scene) -> np.ndarray | None:
    """`jackknife_of_steps` of K_2, which assumes the board's path to be exact, so that the inverse
    of its second derivative would promise too much."""
    block, parts = blocks_of(given.time_s), []
    for own in (block == b for b in np.unique(block)):
        seen = Given(STATION, given.points[own], given.angles[own], given.rotors)
        parts.append((np.empty((6, 6)), np.empty(6)))
        normal_equations(np.ascontiguousarray(R), t, seen, *parts[-1])
    return jackknife_of_steps(parts)


def residual_rms(R: np.ndarray, t: np.ndarray, given: Scene) -> float:
    """Root mean square of C - M in rad at a slave pose."""
    points = np.ascontiguousarray((given.points - t) @ R)
    return float(np.sqrt(np.mean((angles(points, given.rotors) - given.angles) ** 2)))


def seen_on_path(paths: tuple[Path, Path], optics: Optics, order: int) -> tuple[Path, Measurements]:
    """The slave's measurements that have the master's path on both sides, and the path then."""
    own = optics.measurements[SLAVE]
    then, kept = at_times(paths[MASTER], own.time_s, order)
    return then, own.take(kept)


def last_step(
    starts: list[Pose], given: Scene, weighed: Evidence, weights: str = "path"
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """From the start of the least cost: R, t (m), covariance (6, 6) in m and rad.

    The weighted K_2 is taken down from there. If that makes the plain residual rise by more than
    weights can, it has run away: then the least plain K_2 stays. weights `none` stops at that, too.
    """
    plain = min(starts, key=lambda pose: residual_rms(pose[0], pose[1], given))
    R, t, _ = by_levenberg_marquardt(*plain, given)
    if weights == "path":
        starts = [*starts, (R, t)]
        found = [residuals(*start, weighed) for start in starts]
        limit = min(one.limit() for one in found)
        best = min(range(len(starts)), key=lambda k: found[k].total(limit))
        R2, t2, spread = by_gauss_newton(*starts[best], weighed)
        before = residual_rms(R, t, given)
        if residual_rms(R2, t2, given) <= RISE * before:
            return R2, t2, spread
    return R, t, covariance(R, t, given)
