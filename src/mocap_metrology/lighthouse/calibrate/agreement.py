"""Which of the two minima of each board pose is right, decided by both stations together.

A flat board, the smaller the more, looks nearly the same with its normal mirrored at the line of
sight, and K_1 of one station can prefer either pose. But R = R_master R_slave^T is one rotation for
the whole recording: of the four pairs of minima at a moment the right one gives it, while mirrored
ones give another at each place and turn of the board. So

1.  pairs of some moments are hypotheses of R, and moments vote for them; the rotation that Kabsch
    finds from positions, which are nearly those of both minima, is one more;
2.  for the hypotheses with most votes minima are chosen, and the slave's angles of the master's
    path (`weighted_station`) decide which of them explains the recording, or K_1 where several do;
3.  with it, minima are chosen for good: by agreement of both stations, K_1, and continuity along
    the path (Viterbi), until none changes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.calibrate.reconstruction import Optics
from mocap_metrology.lighthouse.calibrate.superpose import at_times, kabsch, nearest
from mocap_metrology.lighthouse.calibrate.weighted_station import (
    Pose,
    board_equations,
    by_gauss_newton,
    evidence,
    residuals,
)
from mocap_metrology.lighthouse.fit.board_pose import both_minima
from mocap_metrology.lighthouse.records import Measurements, Path
from mocap_metrology.lighthouse.rotation import log, mean
from mocap_metrology.lighthouse.timing import CYCLE_S

PAIR_S = 2.5 * CYCLE_S  # between measurements of both stations that are one moment
FARTHEST_M = 20.0  # no station is seen from farther
LEAST_NOISE_RAD = 20e-6  # of an angle: no rotor is steadier
FLOOR_RAD = np.radians(1.5)  # of a rotation: optics, and what the board turns between stations
RATE_RAD_S = 3.0  # a board turns no faster, as a rule
CLEAR = 0.95  # of the poses of a board that needs no second station
CAP = 20.0  # of a squared distance over its variance: beyond it a pose is wrong
IMPOSSIBLE = 1e6  # cost of a pose behind the station, or too far
VOTERS, PROPOSERS, HYPOTHESES = 150, 40, 6  # moments, moments, rotations, at most
ALIKE_RAD = np.radians(12.0)  # hypotheses nearer than this are one
EQUAL = 1.3  # costs of hypotheses that K_1 decides, as of a board that hardly turns
TRIED, ROUNDS = 150, 4  # measurements a hypothesis is tried on


@dataclass(frozen=True)
class Minima:
    """Both minima of the board poses of one station.

    paths: that of lower K_1 first; excess (2, n): K_1 less the lower one, over the variance of an
    angle, capped; spread (2, n, 3, 3): covariance of the rotations, rad^2.
    """

    measurements: Measurements
    paths: tuple[Path, Path]
    excess: np.ndarray
    spread: np.ndarray
    board: np.ndarray
    rotors: np.ndarray

    @property
    def R(self) -> np.ndarray:
        return np.stack([path.R for path in self.paths])

    @property
    def clear(self) -> bool:
        """Whether K_1 distinguishes the minima in nearly all poses."""
        alone = np.isinf(self.paths[0].ambiguity) | (self.excess[1] >= CAP)
        return bool(alone.mean() > CLEAR)

    def chosen(self, which: np.ndarray) -> Path:
        """The path through these minima, (n,) of 0 and 1. Its ambiguity is K_1 of the other minimum
        over that of the chosen one, below 1 where K_1 alone would have been wrong."""
        first, second = self.paths
        rows = np.arange(which.size)
        both = {
            k: np.stack([getattr(first, k), getattr(second, k)]) for k in ("R", "t_m", "epsilon")
        }
        taken = {k: v[which, rows] for k, v in both.items()}
        ambiguity = np.where(which == 1, 1 / np.maximum(first.ambiguity, 1), first.ambiguity)
        return Path(first.time_s, **taken, n_angles=first.n_angles, ambiguity=ambiguity)


def minima(measurements: Measurements, board: np.ndarray, rotors: np.ndarray) -> Minima:
    """Both minima of every board pose of a station, and how well each is known."""
    paths = both_minima(measurements, board, rotors)
    freedom = np.maximum(paths[0].n_angles - 6, 1)
    variance = max(float(np.median(paths[0].epsilon / freedom)), LEAST_NOISE_RAD**2)
    excess = np.stack([(p.epsilon - paths[0].epsilon) / variance for p in paths])
    excess = np.where(np.isfinite(excess), np.minimum(excess, CAP), IMPOSSIBLE)
    prior = np.diag(np.r_[np.full(3, 1 / 100.0**2), np.full(3, 1 / np.pi**2)])
    spread, angles = np.empty((2, len(measurements), 3, 3)), measurements.angles_rad
    for k, path in enumerate(paths):
        with np.errstate(over="ignore", invalid="ignore"):
            far = ~(np.linalg.norm(path.t_m, axis=1) < FARTHEST_M) | ~(path.t_m[:, 0] > 0)
        H, *_ = board_equations(path.R, path.t_m, angles, np.ascontiguousarray(board), rotors)
        H[far | ~np.isfinite(H).all(axis=(1, 2))] = 0.0
        information = H / variance + prior
        try:
            spread[k] = np.linalg.inv(information)[:, 3:, 3:]
        except np.linalg.LinAlgError:  # of a board that reflections place in a station
            spread[k] = np.linalg.pinv(information, hermitian=True)[:, 3:, 3:]
        excess[k, far] = IMPOSSIBLE
    return Minima(measurements, paths, excess, spread, board, rotors)


def _nearest(time_s: np.ndarray, other_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Index of the nearest of `other_s` to each time, and whether it is the same moment."""
    near = nearest(time_s, other_s)
    return near, np.abs(other_s[near] - time_s) <= PAIR_S


def _distance(turn: np.ndarray, spread: np.ndarray) -> np.ndarray:
    """Squared length of rotations (..., 3, 3) over their covariance, capped; (...)."""
    shape = turn.shape[:-2]
    v = log(turn.reshape(-1, 3, 3)).reshape(*shape, 3)
    S = spread + FLOOR_RAD**2 * np.eye(3)
    return np.minimum(np.einsum("...i,...i->...", v, np.linalg.solve(S, v[..., None])[..., 0]), CAP)


def _disagreement(first: Minima, other: Minima, R: np.ndarray) -> np.ndarray:
    """For each measurement of `first` and each of its minima the least cost over those of `other`
    at the same moment, (2, n); R: rotation of the frame of `other` in that of `first`."""
    near, same = _nearest(first.paths[0].time_s, other.paths[0].time_s)
    cost = np.zeros((2, near.size))
    theirs = R @ other.R[:, near[same]]
    spread = R @ other.spread[:, near[same]] @ R.T
    turn = np.einsum("anij,bnkj->abnik", first.R[:, same], theirs)
    apart = _distance(turn, first.spread[:, None, same] + spread[None])
    cost[:, same] = (apart + np.minimum(other.excess, CAP)[None, :, near[same]]).min(axis=1)
    return cost


def _smooth(minima_of: Minima, cost: np.ndarray) -> np.ndarray:
    """The minima (n,) of least total cost (2, n) and jumps along the path, by Viterbi."""
    R = minima_of.R
    turn = np.einsum("anij,bnkj->abnik", R[:, 1:], R[:, :-1])
    moved = np.square(RATE_RAD_S * np.diff(minima_of.paths[0].time_s))
    spread = (
        minima_of.spread[:, None, 1:]
        + minima_of.spread[None, :, :-1]
        + moved[:, None, None] * np.eye(3)
    )
    jump = _distance(turn, spread)
    return _viterbi(np.ascontiguousarray(cost), np.ascontiguousarray(jump))


@njit
def _viterbi(cost: np.ndarray, jump: np.ndarray) -> np.ndarray:
    """States (n,) of least sum of cost (2, n) and jump (to, from, n - 1)."""
    n = cost.shape[1]
    total, back = cost[:, 0].copy(), np.empty((2, n), dtype=np.int64)
    for i in range(1, n):
        then = np.empty(2)
        for k in range(2):
            stay, come = total[0] + jump[k, 0, i - 1], total[1] + jump[k, 1, i - 1]
            back[k, i] = 1 if come < stay else 0
            then[k] = min(stay, come) + cost[k, i]
        total = then
    which = np.empty(n, dtype=np.int64)
    which[n - 1] = 1 if total[1] < total[0] else 0
    for i in range(n - 1, 0, -1):
        which[i - 1] = back[which[i], i]
    return which


def choose(master: Minima, slave: Minima, R: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The minima (n,) of both stations that agree best with the slave's rotation R."""
    return (
        _smooth(master, master.excess + _disagreement(master, slave, R)),
        _smooth(slave, slave.excess + _disagreement(slave, master, R.T)),
    )


def hypotheses(master: Minima, slave: Minima) -> list[np.ndarray]:
    """Rotations of the slave that most moments could have, best first; then that of Kabsch."""
    near, same = _nearest(master.paths[0].time_s, slave.paths[0].time_s)
    moments = np.flatnonzero(same)
    moments = moments[:: max(len(moments) // VOTERS, 1)]
    pairs = np.einsum("anij,bnkj->nabik", master.R[:, moments], slave.R[:, near[moments]])
    pairs = pairs.reshape(-1, 4, 3, 3)
    excess = master.excess[:, None, moments] + slave.excess[None, :, near[moments]]
    excess = np.moveaxis(excess, 2, 0).reshape(-1, 4)
    spread = master.spread[:, None, moments] + slave.spread[None, :, near[moments]]
    variance = np.trace(spread, axis1=3, axis2=4).transpose(2, 0, 1).reshape(-1, 4) / 3
    proposed = np.arange(0, len(pairs), max(len(pairs) // PROPOSERS, 1))
    candidates = pairs[proposed].reshape(-1, 3, 3)[excess[proposed].ravel() < IMPOSSIBLE]
    rotations: list[np.ndarray] = []
    if len(candidates):
        angle = _angles(candidates, pairs.reshape(-1, 3, 3)).reshape(-1, *excess.shape)
        cost = np.minimum(angle**2 / (variance + FLOOR_RAD**2), CAP) + np.minimum(excess, CAP)
        of_it, best = cost.argmin(axis=2), cost.min(axis=2)
        total = best.sum(axis=1)
        free = np.ones(len(candidates), dtype=bool)
        while free.any() and len(rotations) < HYPOTHESES:
            k = int(np.flatnonzero(free)[total[free].argmin()])
            voting = best[k] < CAP
            here = pairs[np.arange(len(pairs)), of_it[k]]
            rotations.append(mean(here[voting]) if voting.sum() > 2 else candidates[k])
            free &= _angles(candidates[k : k + 1], candidates)[0] > ALIKE_RAD
    possible = (master.excess[0, moments] < IMPOSSIBLE) & (
        slave.excess[0, near[moments]] < IMPOSSIBLE
    )
    if possible.sum() > 3:
        here, there = master.paths[0].t_m[moments], slave.paths[0].t_m[near[moments]]
        rotations.append(kabsch(there[possible], here[possible])[0])
    return rotations


def _angles(a: Floats, b: Floats) -> Floats:
    trace = a.reshape(len(a), 9) @ b.reshape(len(b), 9).T
    return np.arccos(np.clip((trace - 1) / 2, -1, 1))


@dataclass(frozen=True)
class Agreed:
    """Paths through the minima on which both stations agree, and a slave pose R, t (m) from them;
    none where the stations have no moment in common."""

    paths: tuple[Path, Path]
    pose: Pose | None


def agree(
    master: Minima, slave: Minima, order: int, near: np.ndarray | None = None, roughly: bool = False
) -> Agreed:
    """Board poses of both stations, the mirror decided by both. near: a rotation of the slave that
    is known to some degrees, in place of votes; roughly: where each station distinguishes the
    minima, the slave's pose is not improved by its angles."""
    ways = hypotheses(master, slave) if near is None else [near]
    if master.clear and slave.clear:
        if roughly and ways:
            return _roughly(master, slave, ways[0])
        ways = ways[:1]
    starts = (_pose_from(R, master, slave, order) for R in ways)
    tried = [one for one in starts if one is not None]
    if not tried:
        return Agreed((master.paths[0], slave.paths[0]), None)
    limit = min(np.median(cost) for _, _, cost, _ in tried) * CAP
    means = [float(np.minimum(cost, limit).mean()) for _, _, cost, _ in tried]
    equal = [one for one, mean in zip(tried, means, strict=True) if mean <= EQUAL * min(means)]
    R, t, *_ = min(equal, key=lambda one: one[3])
    before = None
    for _ in range(ROUNDS):
        which = choose(master, slave, R)
        if before is not None and all((a == b).all() for a, b in zip(which, before, strict=True)):
            break
        before = which
        result = _pose_from(R, master, slave, order, which)
        if result is None:
            break
        R, t, *_ = result
    return Agreed((master.chosen(which[0]), slave.chosen(which[1])), (R, t))


def _roughly(master: Minima, slave: Minima, R: np.ndarray) -> Agreed:
    """The minima of lower K_1, R of the slave, and the median of its positions."""
    here, other = master.paths[0], slave.paths[0]
    near, same = _nearest(here.time_s, other.time_s)
    if same.sum() < 3:
        return Agreed((here, other), None)
    t = np.median(here.t_m[same] - other.t_m[near[same]] @ R.T, axis=0)
    return Agreed((here, other), (R, t))


def _pose_from(
    R: np.ndarray,
    master: Minima,
    slave: Minima,
    order: int,
    which: tuple[np.ndarray, np.ndarray] | None = None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, float] | None:
    """Slave pose R, t (m) from a hypothesis of R, the cost of some measurements, and how much the
    minima of both stations exceed the lower ones on average; None where there are too few."""
    which = choose(master, slave, R) if which is None else which
    paths = master.chosen(which[0]), slave.chosen(which[1])
    then, inside = at_times(paths[0], slave.measurements.time_s, order)
    rows = np.arange(0, len(then), max(len(then) // TRIED, 1))
    some = slave.measurements.take(inside).take(rows)
    both = master.rotors, slave.rotors
    known = evidence(then.take(rows), some, master.measurements, master.board, both)
    near, same = _nearest(paths[0].time_s, paths[1].time_s)
    if len(known.path) < 3 or same.sum() < 3:
        return None
    t = np.median(paths[0].t_m[same] - paths[1].t_m[near[same]] @ R.T, axis=0)
    R, t, _ = by_gauss_newton(R, t, known)
    residual = residuals(R, t, known)
    chosen = (
        np.choose(w, minimum.excess) for w, minimum in zip(which, (master, slave), strict=True)
    )
    excess = sum(float(np.minimum(one, CAP).mean()) for one in chosen)
    return R, t, residual.cost[residual.count > 0], excess


def agreed_paths(optics: Optics, board: np.ndarray, order: int, near: np.ndarray | None) -> Agreed:
    """Board poses in the frames of both stations, the mirror decided by both; see `agree`."""
    master, slave = (
        minima(measured, board, rotors)
        for measured, rotors in zip(optics.measurements, optics.rotors, strict=True)
    )
    return agree(master, slave, order, near)
