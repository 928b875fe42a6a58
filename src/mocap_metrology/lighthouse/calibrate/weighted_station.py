"""Pose of the slave from its own angles of a board whose path is known (J V-B, Eq. 5 and 6), and
K_2 of J with this path uncertain, as it is.

J Eq. 6 assumes the board poses P_n to be exact; their errors, tenths of a degree in rotation, then
go into the slave's pose. Here the residuals e_n of a measurement have the covariance
sigma^2 (I + J_P H_n^-1 J_P^T): J_P is the derivative of the slave's angles by P_n, and
H_n = J^T J of the master's own angles is the information about P_n. By Woodbury's identity

    e^T W e = e^T e - (J_P^T e)^T (H_n + J_P^T J_P)^-1 (J_P^T e),

so what a shift or turn of the board within its uncertainty can explain does not count.

Two parts of a recording are held against each other so: a station that is bumped by millimetres
leaves a pose between both, with a residual like that of sound recordings; but what came before and
what came after then have poses of their own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.batch.parts import SPLITS
from mocap_metrology.lighthouse.calibrate.reconstruction import Optics
from mocap_metrology.lighthouse.calibrate.superpose import at_times, blocks_of, jackknife, nearest
from mocap_metrology.lighthouse.fit.levenberg_marquardt import (
    PoseProblem,
    damped_step,
    minimise,
    normal_equations,
    turn,
)
from mocap_metrology.lighthouse.fit.simplex import (
    BOARD,
    STATION,
    SimplexSettings,
    nelder_mead,
    seen_at,
)
from mocap_metrology.lighthouse.records import MASTER, SLAVE, Halves, Measurements, Path
from mocap_metrology.lighthouse.rotor import angles

STEPS, ROUNDS = 20, 5  # of one descent; of descents, each with its own outliers
LARGEST_DAMPING = 1e10  # of the diagonal; beyond, the descent ends
RIDGE = 1e-12  # rad^2/m^2, rad^2/rad^2
SMALLEST_STEP = 1e-8  # m, rad: far below the resolution of angles
OUTLIER = 25.0  # times the median cost a measurement: a mirrored pose, left out
# Of the plain residual by weighting it: lasers 15 mm off make 2, a last step that runs away 10.
RISE = 3.0

Pose = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Evidence:
    """Slave's measurements and the board poses of the master's path at their times.

    path: at the n times; angles (n, diodes, 2), NaN where unseen; information (n, 6, 6): H_n;
    rotors: of the slave.
    """

    path: Path
    angles: np.ndarray
    information: np.ndarray
    board: np.ndarray
    rotors: np.ndarray

    @property
    def seen(self) -> np.ndarray:
        """Diodes with both angles, (n, diodes)."""
        return np.isfinite(self.angles).all(axis=2)

    @cached_property
    def plain(self) -> PoseProblem:
        """P_n and M_t,n of J Eq. 6, flat: diodes in the master's frame, and the slave's angles."""
        points = np.einsum("nij,dj->ndi", self.path.R, self.board) + self.path.t_m[:, None]
        return PoseProblem(STATION, points[self.seen], self.angles[self.seen], self.rotors)


def seen_on_path(
    paths: tuple[Path, Path], optics: Optics, board: np.ndarray, order: int
) -> Evidence:
    """The slave's measurements that have the master's path on both sides, and the path then."""
    master, slave = optics.measurements
    then, inside = at_times(paths[MASTER], slave.time_s, order)
    return evidence(then, slave.take(inside), master, board, optics.rotors)


def evidence(
    path: Path,
    measured: Measurements,
    master: Measurements,
    board: np.ndarray,
    rotors: Sequence[np.ndarray],
) -> Evidence:
    """Evidence of a path at the times of `measured`; its information is that of the nearest of the
    master's measurements. rotors: of master and slave."""
    seen = master.angles_rad[nearest(path.time_s, master.time_s)]
    board = np.ascontiguousarray(board)
    known, *_ = board_equations(path.R, path.t_m, seen, board, rotors[MASTER])
    return Evidence(path, measured.angles_rad, known, board, rotors[SLAVE])


@njit
def board_equations(
    R: np.ndarray, t: np.ndarray, measured: np.ndarray, board: np.ndarray, rotors: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """For each of n board poses in a station's frame, by its shift and left rotation vector: J^T J
    (n, 6, 6), J^T e (n, 6) and e^T e (n,) of the angles measured (n, diodes, 2), NaN unseen."""
    n = R.shape[0]
    H, g, square = np.empty((n, 6, 6)), np.empty((n, 6)), np.empty(n)
    for i in range(n):
        seen = np.isfinite(measured[i, :, 0]) & np.isfinite(measured[i, :, 1])
        problem = PoseProblem(BOARD, board[seen], measured[i][seen], rotors)
        square[i] = normal_equations(R[i], t[i], problem, H[i], g[i])
    return H, g, square


@dataclass(frozen=True)
class Residuals:
    """e^T W e / angles (n,) in rad^2 of each measurement, its angles (n,), its part of the normal
    equations of the slave's pose, (n, 6, 6) and (n, 6), and J_P^T J_P (n, 6, 6); the path's
    information (n, 6, 6)."""

    cost: np.ndarray
    count: np.ndarray
    H: np.ndarray
    g: np.ndarray
    of_path: np.ndarray
    information: np.ndarray

    def limit(self) -> float:
        """Cost beyond which a measurement is an outlier."""
        return OUTLIER * float(np.median(self.cost[self.count > 0]))

    def rms_urad(self) -> float:
        """Root mean square of what the uncertainty of the path does not explain."""
        return 1e6 * float(np.sqrt(self.total(self.limit()) / self.count.sum()))

    def noise_gain(self) -> float:
        """Root of the median of trace(I + J_P H^-1 J_P^T) / angles, by how much the path's
        uncertainty raises the variance of residuals: e^T e is expected to be this times the noise
        of an angle."""
        known = self.information + RIDGE * np.eye(6)
        lent = np.trace(np.linalg.solve(known, self.of_path), axis1=1, axis2=2)
        gain = 1 + lent / np.maximum(self.count, 1)
        return float(np.sqrt(np.median(gain[self.count > 0])))

    def total(self, limit: float) -> float:
        """Sum of e^T W e in rad^2, outliers counted as if at the limit."""
        return float(np.sum(np.minimum(self.cost, limit) * self.count))


def residuals(R: np.ndarray, t: np.ndarray, data: Evidence, exact: bool = False) -> Residuals:
    """Residuals of a slave's pose R, t (m), without what the path's uncertainty explains; exact:
    as if there were none, as J has it.

    The slave's shift does the opposite of the board's, and its turn that of the board's turn about
    the slave: with b from the slave to the board J = -J_P T^T, T = [1 0; [b] 1]. With H = J_P^T J_P
    and A = H_n + H, what is left of H and of J_P^T e is H_n A^-1 H and H_n A^-1 J_P^T e.
    """
    arm, count = data.path.t_m - t, 2 * data.seen.sum(axis=1)
    of_board = np.ascontiguousarray(R.T @ data.path.R), arm @ R
    H, g, square = board_equations(*of_board, data.angles, data.board, data.rotors)
    axes = np.kron(np.eye(2), R)  # from those of the slave to those of the master
    H, g = axes @ H @ axes.T, g @ axes.T
    # The ridge is far below the information of a diode; it only makes a lost board pose soluble.
    known = data.information + RIDGE * np.eye(6)
    left, T = np.concatenate([H, g[..., None]], axis=2), np.tile(np.eye(6), (len(H), 1, 1))
    if not exact:
        solved = np.linalg.solve(known + H, left)
        left, square = known @ solved, square - np.einsum("ni,ni->n", g, solved[..., 6])
    T[:, 3:, :3] = rotation.cross(arm)
    H_L, g_L = T @ left[..., :6] @ np.swapaxes(T, 1, 2), -(T @ left[..., 6:])[..., 0]
    cost = square / np.maximum(count, 1)
    cost = np.where(np.isfinite(cost), cost, np.inf)
    return Residuals(cost, count, H_L, g_L, H, data.information)


def _descend(
    R: np.ndarray, t: np.ndarray, data: Evidence, limit: float
) -> tuple[np.ndarray, np.ndarray, Residuals]:
    """Levenberg-Marquardt on `Residuals.total`: a step is accepted only if it falls."""
    at, damping = residuals(R, t, data), 0.0
    for _ in range(STEPS):
        near = (at.count > 0) & (at.cost <= limit)
        step = damped_step(at.H[near].sum(axis=0), at.g[near].sum(axis=0), damping)
        if np.isfinite(step).all():
            R2, t2 = turn(step[3:], np.ascontiguousarray(R)), t + step[:3]
            then = residuals(R2, t2, data)
            small = np.abs(step).max() < SMALLEST_STEP
            if then.total(limit) <= at.total(limit):
                R, t, at, damping = R2, t2, then, damping / 10
                if small:
                    break
                continue
            if small:
                break
        damping = max(10 * damping, 1e-3)
        if damping > LARGEST_DAMPING:
            break
    return R, t, at


def by_gauss_newton(
    R: np.ndarray, t: np.ndarray, data: Evidence
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """Slave pose R, t (m) of the least weighted K_2, from a pose near it, never worse than that;
    and its covariance (6, 6) of t and the left rotation vector in m and rad, by a jackknife over
    blocks of time; None with fewer than three."""
    for _ in range(ROUNDS):
        limit = residuals(R, t, data).limit()
        R, t, at = _descend(R, t, data, limit)
        if at.limit() >= limit / 2:
            break
    near = (at.count > 0) & (at.cost <= at.limit())
    return R, t, jackknife_of_steps(data.path.time_s[near], at.H[near], at.g[near])


def jackknife_of_steps(time_s: np.ndarray, H: np.ndarray, g: np.ndarray) -> np.ndarray | None:
    """Covariance (6, 6) of t and the left rotation vector in m and rad, by a jackknife over blocks
    of time: each estimate without one is a single Gauss-Newton step from the minimum,
    -(H - H_b)^-1 (g - g_b). H (n, 6, 6), g (n, 6) at times (n,). None with fewer than three."""
    block = blocks_of(time_s)
    others = [block != b for b in np.unique(block)]
    if len(others) < 3:
        return None
    steps = [damped_step(H[rest].sum(axis=0), g[rest].sum(axis=0), 0.0) for rest in others]
    return jackknife(np.array(steps)) if np.isfinite(steps).all() else None


def halves(R: np.ndarray, t: np.ndarray, data: Evidence) -> Halves | None:
    """Poses of the slave from the measurements before and after each of `SPLITS`: the two that are
    farthest apart by m2; None where no part tells its uncertainty."""
    time = data.path.time_s
    both = []
    for split in SPLITS:
        early = time < time.min() + split * np.ptp(time)
        parts = []
        for half in (early, ~early):
            known, angles_rad = data.information[half], data.angles[half]
            part = replace(data, path=data.path.take(half), angles=angles_rad, information=known)
            parts.append(by_gauss_newton(R, t, part))
        (R_a, t_a, C_a), (R_b, t_b, C_b) = parts
        if C_a is not None and C_b is not None:
            d = np.r_[t_a - t_b, rotation.error(R_a, R_b)]
            m2 = float(d @ np.linalg.pinv(C_a + C_b, rcond=1e-12) @ d)
            both.append(Halves.of(d, m2))
    return max(both, key=lambda one: one.m2, default=None)


def by_nelder_mead(
    R: np.ndarray, t: np.ndarray, data: Evidence, settings: SimplexSettings
) -> tuple[np.ndarray, np.ndarray, float]:
    """J Eq. 5 from the first estimate (R, t): R, t (m), K_2 in rad^2."""
    x0 = np.r_[t, rotation.to_angles(R)]
    x, cost, _ = nelder_mead(x0, seen_at(*data.plain), settings)
    return rotation.from_angles(*x[3:]), x[:3], cost


def by_levenberg_marquardt(
    R: np.ndarray, t: np.ndarray, data: Evidence
) -> tuple[np.ndarray, np.ndarray, float]:
    """J Eq. 5 by Levenberg-Marquardt from (R, t): R, t (m), K_2 in rad^2."""
    return minimise(np.ascontiguousarray(R), t, data.plain)[:3]


def covariance(R: np.ndarray, t: np.ndarray, data: Evidence) -> np.ndarray | None:
    """`jackknife_of_steps` of K_2, which assumes the board's path to be exact, so that the inverse
    of its second derivative would promise too much."""
    plain = residuals(R, t, data, exact=True)
    return jackknife_of_steps(data.path.time_s, plain.H, plain.g)


def residual_rms(R: np.ndarray, t: np.ndarray, data: Evidence) -> float:
    """Root mean square of C - M in rad at a slave pose."""
    _, points, measured, rotors = data.plain
    local = np.ascontiguousarray((points - t) @ R)
    return float(np.sqrt(np.mean((angles(local, rotors) - measured) ** 2)))


def last_step(
    starts: list[Pose], data: Evidence, weights: str = "path"
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """From the start of the least cost: R, t (m), covariance (6, 6) in m and rad.

    The weighted K_2 is taken down from there. If that makes the plain residual rise by more than
    weights can, it has run away: then the least plain K_2 stays. weights `none` stops at that, too.
    """
    plain = min(starts, key=lambda pose: residual_rms(pose[0], pose[1], data))
    R, t, _ = by_levenberg_marquardt(*plain, data)
    if weights == "path":
        starts = [*starts, (R, t)]
        tried = [residuals(*start, data) for start in starts]
        limit = min(one.limit() for one in tried)
        best = min(range(len(starts)), key=lambda k: tried[k].total(limit))
        R2, t2, spread = by_gauss_newton(*starts[best], data)
        before = residual_rms(R, t, data)
        if residual_rms(R2, t2, data) <= RISE * before:
            return R2, t2, spread
    return R, t, covariance(R, t, data)
