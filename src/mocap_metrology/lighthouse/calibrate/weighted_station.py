"""K_2 of J with the board's path uncertain, as it is.

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

from dataclasses import dataclass, replace

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.batch.parts import SPLITS
from mocap_metrology.lighthouse.calibrate.superpose import blocks_of, jackknife
from mocap_metrology.lighthouse.fit.levenberg_marquardt import damped_step, normal_equations, turn
from mocap_metrology.lighthouse.fit.simplex import BOARD
from mocap_metrology.lighthouse.records import Halves, Measurements, Path
from mocap_metrology.lighthouse.rotor import angle_gradient

ITERATIONS, ROUNDS = 20, 5  # of one descent; of descents, each with its own outliers
LARGEST_DAMPING = 1e10  # of the diagonal; beyond, the descent ends
RIDGE = 1e-12  # rad^2/m^2, rad^2/rad^2
SMALLEST_STEP = 1e-8  # m, rad: far below the resolution of angles
OUTLIER = 25.0  # times the median cost a measurement: a mirrored pose, left out


@dataclass(frozen=True)
class Evidence:
    """Slave's measurements and the board poses of the master's path at their times.

    path: at the n times; angles (n, diodes, 2), NaN where unseen; information (n, 6, 6): H_n.
    """

    path: Path
    angles: np.ndarray
    information: np.ndarray
    board: np.ndarray


def evidence(
    path: Path, own: Measurements, master: Measurements, board: np.ndarray, rotors: np.ndarray
) -> Evidence:
    """Evidence of a path at the times of `own`; its information is that of the nearest of the
    master's measurements, which has as many diodes as another. rotors: of the master."""
    nearest = np.searchsorted(master.time_s, path.time_s)
    nearest = np.clip(nearest, 1, len(master) - 1)
    earlier = path.time_s - master.time_s[nearest - 1] < master.time_s[nearest] - path.time_s
    seen = master.seen[nearest - earlier]
    board = np.ascontiguousarray(board)
    return Evidence(
        path, own.angles_rad, _information(path.R, path.t_m, seen, board, rotors), board
    )


@njit
def _information(
    R: np.ndarray, t: np.ndarray, seen: np.ndarray, board: np.ndarray, rotors: np.ndarray
) -> np.ndarray:
    n = R.shape[0]
    out, g = np.empty((n, 6, 6)), np.empty(6)
    nothing = np.zeros((board.shape[0], 2))
    for i in range(n):
        own = board[seen[i]]
        normal_equations(R[i], t[i], BOARD, own, nothing, rotors, out[i], g)
    return out


@njit
def _blocks(
    R: np.ndarray,
    t: np.ndarray,
    board_R: np.ndarray,
    board_t: np.ndarray,
    board: np.ndarray,
    measured: np.ndarray,
    rotors: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """For each measurement: J^T J (n, 12, 12) and J^T e (n, 12) by the slave's pose, then the
    board's (shift, left rotation vector); e^T e (n,); angles (n,)."""
    n, d = measured.shape[0], board.shape[0]
    H, g, square = np.zeros((n, 12, 12)), np.zeros((n, 12)), np.zeros(n)
    count = np.zeros(n)
    row, D = np.empty(12), np.empty(3)
    arm, far = np.empty(3), np.empty(3)
    for i in range(n):
        for j in range(d):
            if not (np.isfinite(measured[i, j, 0]) and np.isfinite(measured[i, j, 1])):
                continue
            for k in range(3):
                arm[k] = (
                    board_R[i, k, 0] * board[j, 0]
                    + board_R[i, k, 1] * board[j, 1]
                    + board_R[i, k, 2] * board[j, 2]
                )
                far[k] = arm[k] + board_t[i, k] - t[k]
            x = R[0, 0] * far[0] + R[1, 0] * far[1] + R[2, 0] * far[2]
            y = R[0, 1] * far[0] + R[1, 1] * far[1] + R[2, 1] * far[2]
            z = R[0, 2] * far[0] + R[1, 2] * far[1] + R[2, 2] * far[2]
            for axis in range(2):
                theta, dx, dy, dz = angle_gradient(axis, x, y, z, rotors[axis])
                e = theta - measured[i, j, axis]
                for k in range(3):
                    D[k] = R[k, 0] * dx + R[k, 1] * dy + R[k, 2] * dz
                    row[6 + k] = D[k]
                for k in range(3):
                    p, q = (k + 1) % 3, (k + 2) % 3
                    row[3 + k] = -(far[p] * D[q] - far[q] * D[p])
                    row[9 + k] = arm[p] * D[q] - arm[q] * D[p]
                square[i] += e * e
                count[i] += 1.0
                for k in range(3, 12):
                    g[i, k] += row[k] * e
                    for m in range(3, k + 1):
                        H[i, k, m] += row[k] * row[m]
        for k in range(3, 12):
            for m in range(3, k):
                H[i, m, k] = H[i, k, m]
        for k in range(3):  # the slave's shift does the opposite of the board's
            g[i, k] = -g[i, 6 + k]
            for m in range(3, 12):
                H[i, k, m] = H[i, m, k] = -H[i, 6 + k, m]
            for m in range(3):
                H[i, k, m] = H[i, 6 + k, 6 + m]
    return H, g, square, count


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
        """Root mean square of what the path's uncertainty does not explain."""
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


def residuals(R: np.ndarray, t: np.ndarray, given: Evidence, rotors: np.ndarray) -> Residuals:
    """Residuals of a slave's pose R, t (m), without what the path's uncertainty explains."""
    H, g, square, count = _blocks(
        np.ascontiguousarray(R), t, given.path.R, given.path.t_m, given.board, given.angles, rotors
    )
    # The ridge is far below the information of a diode; it only makes a lost board pose soluble.
    A = given.information + H[:, 6:, 6:] + RIDGE * np.eye(6)
    right = np.concatenate([H[:, 6:, :6], g[:, 6:, None]], axis=2)
    solved = np.linalg.solve(A, right)
    cross = H[:, :6, 6:]
    H_L = H[:, :6, :6] - cross @ solved[:, :, :6]
    g_L = g[:, :6] - (cross @ solved[:, :, 6:])[:, :, 0]
    cost = (square - np.einsum("ni,ni->n", g[:, 6:], solved[:, :, 6])) / np.maximum(count, 1)
    cost = np.where(np.isfinite(cost), cost, np.inf)
    return Residuals(cost, count, H_L, g_L, H[:, 6:, 6:], given.information)


def _descend(
    R: np.ndarray, t: np.ndarray, given: Evidence, rotors: np.ndarray, limit: float
) -> tuple[np.ndarray, np.ndarray, Residuals]:
    """Levenberg-Marquardt on `Residuals.total`: a step is accepted only if it falls."""
    at, damping = residuals(R, t, given, rotors), 0.0
    for _ in range(ITERATIONS):
        kept = (at.count > 0) & (at.cost <= limit)
        step = damped_step(at.H[kept].sum(axis=0), at.g[kept].sum(axis=0), damping)
        if np.isfinite(step).all():
            R2, t2 = turn(step[3:], np.ascontiguousarray(R)), t + step[:3]
            then = residuals(R2, t2, given, rotors)
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
    R: np.ndarray, t: np.ndarray, given: Evidence, rotors: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """Slave pose R, t (m) of the least weighted K_2, from a pose near it; and its covariance.

    rotors: of the slave. Steps are damped and accepted only if the weighted K_2 falls, so what
    comes out is never worse than the start. Covariance (6, 6) of t and the left rotation vector in
    m and rad, by a jackknife over blocks of time; None with fewer than three blocks.
    """
    for _ in range(ROUNDS):
        limit = residuals(R, t, given, rotors).limit()
        R, t, at = _descend(R, t, given, rotors, limit)
        if at.limit() >= limit / 2:
            break
    kept = (at.count > 0) & (at.cost <= at.limit())
    block = blocks_of(given.path.time_s[kept])
    count = int(block.max()) + 1
    if count < 3:
        return R, t, None
    H, g = at.H[kept], at.g[kept]
    whole = H.sum(axis=0), g.sum(axis=0)
    steps = np.array(
        [
            damped_step(
                whole[0] - H[block == b].sum(axis=0), whole[1] - g[block == b].sum(axis=0), 0.0
            )
            for b in range(count)
        ]
    )
    return R, t, jackknife(steps) if np.isfinite(steps).all() else None


def warm_up() -> None:
    """Compile the kernels."""
    from mocap_metrology.lighthouse.board import flat_board
    from mocap_metrology.lighthouse.rotor import angles, rotor_parameters

    board, rotors, t = flat_board(), rotor_parameters(), np.array([3.0, 0, 0])
    given = Measurements(np.zeros(1), angles(board + t, rotors)[None])
    zero = np.zeros(1)
    path = Path(zero, np.eye(3)[None], t[None], zero, zero, zero)
    _information(path.R, path.t_m, given.seen, board, rotors)
    _blocks(np.eye(3), np.zeros(3), path.R, path.t_m, board, given.angles_rad, rotors)


def halves(R: np.ndarray, t: np.ndarray, given: Evidence, rotors: np.ndarray) -> Halves | None:
    """Poses of the slave from the measurements before and after each of `SPLITS`, both from near
    the pose R, t (m) of all: the two that are farthest apart by m2; None where no part tells its
    uncertainty. rotors: of the slave."""
    time = given.path.time_s
    found = []
    for split in SPLITS:
        early = time < time.min() + split * np.ptp(time)
        parts = [by_gauss_newton(R, t, _part(given, own), rotors) for own in (early, ~early)]
        told = [(R, t, spread) for R, t, spread in parts if spread is not None]
        if len(told) == 2:
            found.append(_apart(*told))
    return max(found, key=lambda one: one.m2, default=None)


def _part(given: Evidence, own: np.ndarray) -> Evidence:
    return replace(
        given,
        path=given.path.take(own),
        angles=given.angles[own],
        information=given.information[own],
    )


def _apart(
    a: tuple[np.ndarray, np.ndarray, np.ndarray], b: tuple[np.ndarray, np.ndarray, np.ndarray]
) -> Halves:
    d = np.r_[a[1] - b[1], rotation.error(a[0], b[0])]
    m2 = float(d @ np.linalg.pinv(a[2] + b[2], rcond=1e-12) @ d)
    return Halves(1e3 * float(np.linalg.norm(d[:3])), float(np.degrees(np.linalg.norm(d[3:]))), m2)
