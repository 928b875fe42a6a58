"""Pose of the slave from its own angles of a board whose path is known (J V-B, Eq. 5 and 6), and
the last step of `paper-lm`, which weighs in that the path is not exactly known.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.calibrate.reconstruction import Optics
from mocap_metrology.lighthouse.calibrate.superpose import at_times, blocks_of, jackknife
from mocap_metrology.lighthouse.calibrate.weighted_station import (
    Evidence,
    by_gauss_newton,
    residuals,
)
from mocap_metrology.lighthouse.fit.levenberg_marquardt import (
    ITERATIONS,
    damped_step,
    minimise,
    normal_equations,
)
from mocap_metrology.lighthouse.fit.simplex import MATLAB, STATION, SimplexSettings, search
from mocap_metrology.lighthouse.records import MASTER, SLAVE, Measurements, Path

# Of the plain residual by weighting it: lasers 15 mm off make 2, a last step that runs away 10.
RISE = 3.0

Pose = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Scene:
    """What K_2 sums over: diodes in the master's frame (m), the slave's angles (rad), times."""

    points: np.ndarray  # (n, 3)
    angles: np.ndarray  # (n, 2)
    time_s: np.ndarray  # (n,)


def scene(path: Path, measurements: Measurements, board: np.ndarray) -> Scene:
    """P_n and M_t,n of J Eq. 6, flat. `path`: the board in the master's frame at the times of
    `measurements` of the slave."""
    seen = measurements.seen
    points = np.einsum("nij,dj->ndi", path.R, board) + path.t_m[:, None]
    time = np.broadcast_to(path.time_s[:, None], seen.shape)
    return Scene(
        np.ascontiguousarray(points[seen]),
        np.ascontiguousarray(measurements.angles_rad[seen]),
        time[seen],
    )


def by_nelder_mead(
    R: np.ndarray,
    t: np.ndarray,
    given: Scene,
    rotors: np.ndarray,
    settings: SimplexSettings = MATLAB,
) -> tuple[np.ndarray, np.ndarray, float]:
    """J Eq. 5 from the first estimate (R, t): R, t (m), K_2 in rad^2."""
    x0 = np.r_[t, rotation.to_angles(R)]
    x, cost, _ = search(x0, STATION, given.points, given.angles, rotors, settings)
    return rotation.from_angles(*x[3:]), x[:3], cost


def by_levenberg_marquardt(
    R: np.ndarray, t: np.ndarray, given: Scene, rotors: np.ndarray
) -> tuple[np.ndarray, np.ndarray, float]:
    """J Eq. 5 by Levenberg-Marquardt from (R, t): R, t (m), K_2 in rad^2."""
    R, t, cost, _ = minimise(
        np.ascontiguousarray(R), t, STATION, given.points, given.angles, rotors, ITERATIONS
    )
    return R, t, cost


def covariance(R: np.ndarray, t: np.ndarray, given: Scene, rotors: np.ndarray) -> np.ndarray | None:
    """Covariance (6, 6) of t and the left rotation vector in m and rad, by a jackknife.

    K_2 assumes the board's path to be exact, so the inverse of its second derivative would promise
    too much. Blocks of time are left out one at a time; each estimate without one is a single
    Gauss-Newton step from the minimum, -(H - H_b)^-1 (g - g_b). None with fewer than three blocks.
    """
    block = blocks_of(given.time_s)
    count = int(block.max()) + 1
    if count < 3:
        return None
    Hs, gs = np.empty((count, 6, 6)), np.empty((count, 6))
    for b in range(count):
        own = block == b
        normal_equations(
            np.ascontiguousarray(R),
            t,
            STATION,
            np.ascontiguousarray(given.points[own]),
            np.ascontiguousarray(given.angles[own]),
            rotors,
            Hs[b],
            gs[b],
        )
    H, g = Hs.sum(axis=0), gs.sum(axis=0)
    steps = np.array([damped_step(H - Hs[b], g - gs[b], 0.0) for b in range(count)])
    return jackknife(steps) if np.isfinite(steps).all() else None


def residual_rms(R: np.ndarray, t: np.ndarray, given: Scene, rotors: np.ndarray) -> float:
    """Root mean square of C - M in rad at a slave pose."""
    from mocap_metrology.lighthouse.rotor import angles

    points = np.ascontiguousarray((given.points - t) @ R)
    return float(np.sqrt(np.mean((angles(points, rotors) - given.angles) ** 2)))


def seen_on_path(paths: tuple[Path, Path], optics: Optics, order: int) -> tuple[Path, Measurements]:
    """The slave's measurements that have the master's path on both sides, and the path then."""
    own = optics.measurements[SLAVE]
    then, kept = at_times(paths[MASTER], own.time_s, order)
    return then, own.take(kept)


def last_step(
    starts: list[Pose],
    given: Scene,
    weighed: Evidence,
    rotors: np.ndarray,
    weights: str = "path",
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """From the start of the least cost: R, t (m), covariance (6, 6) in m and rad.

    The weighted K_2 is taken down from there. If that makes the plain residual rise by more than
    weights can, it has run away: then the least plain K_2 stays. weights `none` stops at that, too.
    """
    plain = min(starts, key=lambda pose: residual_rms(pose[0], pose[1], given, rotors))
    R, t, _ = by_levenberg_marquardt(*plain, given, rotors)
    if weights == "path":
        starts = [*starts, (R, t)]
        found = [residuals(*start, weighed, rotors) for start in starts]
        limit = min(one.limit() for one in found)
        best = min(range(len(starts)), key=lambda k: found[k].total(limit))
        R2, t2, spread = by_gauss_newton(*starts[best], weighed, rotors)
        before = residual_rms(R, t, given, rotors)
        if residual_rms(R2, t2, given, rotors) <= RISE * before:
            return R2, t2, spread
    return R, t, covariance(R, t, given, rotors)
