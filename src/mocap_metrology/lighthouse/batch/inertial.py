"""Gyroscope and accelerometer of a board as residuals of a joint estimate.

J VIII expects more of such sensors than of interpolation. Between the ends a, b of an interval of
the trajectory's knots, m its middle and h half its length,

    e_w = Log(W' M' R_a' R_b M) / 2h,
    e_f = (1 + s) (N' M' R_m' ((q_b - 2 q_m + q_a) / h^2 - g) + c) - f,   q = p + R l,

with R, p the board's pose, M the small rotation of the sensors' axes on the board, N that of the
accelerometer's from the gyroscope's and l their place, g gravity. W is the rotation that the
gyroscope measured, less its bias; f the mean of the accelerometer with the weights of that second
difference, a triangle, each sample turned by the gyroscope to the middle; s and c are its scale and
bias. So both are exact whatever the motion is within an interval; what the spline cannot follow
counts as noise, which is estimated. Sensors filter, so they are late by some ms: that delay is an
unknown, too.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.common.hampel import MAD_TO_SIGMA
from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.batch.kernel import (
    POSE,
    Equations,
    of_turn,
    right_jacobians,
    rotated,
)
from mocap_metrology.lighthouse.batch.problem import GRAVITY_M_S2, INERTIAL_SD, Layout, State
from mocap_metrology.lighthouse.batch.trajectory import Trajectory, cubic
from mocap_metrology.lighthouse.batch.view import LIMIT, selected_inverse
from mocap_metrology.lighthouse.records import Inertial
from mocap_metrology.lighthouse.rotation import cross, exp, log

KNOT_S = 0.025  # a hand's tremor of 10 Hz, which 50 ms hide from angles, is seen by accelerometers
LONGEST_GAP_S = 0.02  # between samples
FEWEST = 10  # intervals
LONGEST_DELAY_S = 0.02
STEP_S = 5e-3  # of the derivative by the delay: in a shorter one there is more noise than motion
NEAR = 4 * POSE  # unknowns of the trajectory in an interval
ENDS = cubic(np.array([0.0, 0.5, 1.0]))  # weights at begin, middle and end of an interval
SECOND = np.array([1.0, -2.0, 1.0])
BIAS_W, BIAS_F, SCALE, TURN, PLACE, DELAY, APART = (
    slice(*ends) for ends in ((0, 3), (3, 6), (6, 7), (7, 10), (10, 13), (13, 14), (14, 17))
)
OWN = INERTIAL_SD.size
UNKNOWNS = {
    **{"rate bias": BIAS_W, "force bias": BIAS_F, "scale": SCALE, "orientation": TURN},
    **{"place": PLACE, "delay": DELAY, "orientation to each other": APART},
}
FARTHEST = 6.0  # standard deviations of an unknown: beyond it they are not as described
NOISIEST = 50.0  # times `LEAST`: likewise
# Of the mean over 25 ms, as data sheets of such sensors: 0.01 deg/s and 300 ug per root of 1 Hz.
# Less is not believed: where few hits are seen, the trajectory can follow the sensors' noise.
LEAST = np.array([8e-4, 1.5e-2])  # rad/s, m/s^2


@dataclass(frozen=True)
class Windows:
    """Intervals in which both sensors were recorded: index of each; begin, middle and end (n, 3)
    in s, and the reference rotations at these."""

    series: Inertial
    interval: np.ndarray
    time_s: np.ndarray
    F: np.ndarray  # (n, 3, 3, 3)
    still: bool

    def take(self, chosen: np.ndarray, low: int) -> Windows:
        """The chosen intervals, by a mask; of a board that moves counted from `low` on."""
        interval = self.interval[chosen] - (0 if self.still else low)
        return replace(self, interval=interval, time_s=self.time_s[chosen], F=self.F[chosen])


def windows(series: Inertial | None, trajectory: Trajectory, hits_s: np.ndarray) -> Windows | None:
    """The intervals of a trajectory that the series covers without gaps; None if they are few.

    hits_s: times of the hits. What was before and after them is not used of a board at rest.
    """
    if series is None or not len(series) or not hits_s.size:
        return None
    time = series.time_s
    if trajectory.still:
        begin = np.arange(hits_s.min(), hits_s.max() - KNOT_S, KNOT_S)
        length, interval = KNOT_S, np.zeros(begin.size, np.int64)
    else:
        length, interval = trajectory.knot_s, np.arange(len(trajectory.control) - 3)
        begin = trajectory.begin_s + length * interval
    at = begin[:, None] + length * np.array([0.0, 0.5, 1.0])
    low = np.searchsorted(time, at[:, 0] - LONGEST_DELAY_S, "right")
    high = np.searchsorted(time, at[:, 2] + LONGEST_DELAY_S, "left")
    gaps = np.r_[0, 0, np.cumsum(np.diff(time) > LONGEST_GAP_S)]  # before each sample
    whole = (low > 0) & (high < time.size)
    whole &= gaps[np.minimum(high, time.size - 1) + 1] == gaps[np.maximum(low - 1, 0) + 1]
    for moment in at.T:
        whole &= trajectory.known(moment)
    if np.count_nonzero(whole) < FEWEST:
        return None
    instants = at[whole]
    F = trajectory.reference(instants.ravel()).reshape(-1, 3, 3, 3)
    return Windows(series, interval[whole], instants, F, trajectory.still)


@dataclass(frozen=True)
class Residuals:
    """e_w in rad/s and e_f in m/s^2, (n, 2, 3), and what their derivatives are made of."""

    e: Floats
    R: Floats  # (n, 3, 3, 3), at begin, middle, end
    by_knots: Floats  # likewise: right Jacobians of the trajectory's rotation vectors
    by_bias: Floats  # (n, 3, 3): of W's rotation vector
    by_turn: Floats  # (2, 3, 3): of M's and N's
    by_delay: Floats  # (n, 2, 3)
    y: Floats  # (n, 3): acceleration less gravity, in axes of the board
    felt: Floats  # (n, 3): in axes of the sensors, with their bias
    gain: float  # 1 + s
    M: Floats
    N: Floats
    place: Floats

    def take(self, chosen: np.ndarray) -> Residuals:
        """Those of the chosen intervals, by a mask."""
        names = "e", "R", "by_knots", "by_bias", "by_delay", "y", "felt"
        return replace(self, **{name: getattr(self, name)[chosen] for name in names})


def residuals(
    seen: Windows, trajectory: Trajectory, state: State, column: int, near_s: float = 0.0
) -> Residuals:
    """At the present values; column: first of the unknowns of the sensors; near_s: a delay near the
    present one, from which that is linear, as samples that enter and leave an interval make the
    cost rough."""
    unknowns = state.values[column : column + OWN]
    M, N, place = exp(unknowns[TURN]), exp(unknowns[APART]), seen.series.place_m + unknowns[PLACE]
    h = (seen.time_s[0, 2] - seen.time_s[0, 0]) / 2
    weights = _weights(seen)
    near = trajectory.control[seen.interval[:, None] + np.arange(4)]
    pose = np.einsum("ji,nia->nja", weights, near)
    v = pose[..., 3:].reshape(-1, 3)
    R = seen.F @ exp(v).reshape(-1, 3, 3, 3)
    q = pose[..., :3] + R @ place
    y = np.einsum("nji,nj->ni", R[:, 1], np.einsum("j,nja->na", SECOND, q) / h**2 - state.gravity)
    felt, gain = y @ M @ N + unknowns[BIAS_F], 1 + float(unknowns[SCALE][0])
    back = M.T @ np.swapaxes(R[:, 0], 1, 2) @ R[:, 2] @ M

    def at(delay_s: float) -> tuple[Floats, Floats]:
        turn, force = sensed(seen, unknowns[BIAS_W], delay_s)
        rate = log(np.swapaxes(turn, 1, 2) @ back) / (2 * h)
        return np.stack([rate, gain * felt - force], axis=1), turn

    e, turn = at(near_s)
    by_delay = (at(near_s + STEP_S)[0] - at(near_s - STEP_S)[0]) / (2 * STEP_S)
    e += (unknowns[DELAY][0] - near_s) * by_delay
    by_knots = right_jacobians(v).reshape(-1, 3, 3, 3)
    by_bias, by_turn = (
        right_jacobians(log(turn)),
        right_jacobians(np.stack([unknowns[TURN], unknowns[APART]])),
    )
    return Residuals(e, R, by_knots, by_bias, by_turn, by_delay, y, felt, gain, M, N, place)


def delay(state: State, column: int) -> float:
    """The present delay in s, within what the intervals have samples for."""
    most = LONGEST_DELAY_S - STEP_S
    return float(np.clip(state.values[column : column + OWN][DELAY][0], -most, most))


def sensed(seen: Windows, bias: Floats, delay_s: float) -> tuple[Floats, Floats]:
    """W (n, 3, 3) and f (n, 3), if the sensors are late by so much."""
    turn, force = np.empty((len(seen.F), 3, 3)), np.empty((len(seen.F), 3))
    series, at = seen.series, seen.time_s + delay_s
    first = np.searchsorted(series.time_s, at[:, 0], "right")
    _measured(series.time_s, series.rate_rad_s - bias, series.force_m_s2, at, first, turn, force)
    return turn, force


def _weights(seen: Windows) -> Floats:
    """Weights of the control points at begin, middle and end, (3, 4)."""
    return np.tile([1.0, 0.0, 0.0, 0.0], (3, 1)) if seen.still else ENDS


def derivatives(seen: Windows, res: Residuals) -> tuple[Floats, Floats]:
    """Derivatives of e_w and e_f by the control points of the interval (n, 6, 24), and by gravity
    and the sensors' unknowns (n, 6, 3 + OWN)."""
    n, M, R = len(res.e), res.M, res.R
    h = (seen.time_s[0, 2] - seen.time_s[0, 0]) / 2
    at = np.zeros((n, 6, 3, POSE))
    back = np.swapaxes(R[:, 2], 1, 2) @ R[:, 0]
    at[:, :3, 0, 3:] = -M.T @ back @ res.by_knots[:, 0] / (2 * h)
    at[:, :3, 2, 3:] = M.T @ res.by_knots[:, 2] / (2 * h)
    MN = M @ res.N
    P = MN.T @ np.swapaxes(R[:, 1], 1, 2)
    for j, factor in enumerate(SECOND / h**2):
        at[:, 3:, j, :3] = factor * P
        at[:, 3:, j, 3:] = -factor * P @ R[:, j] @ cross(res.place) @ res.by_knots[:, j]
    at[:, 3:, 1, 3:] += MN.T @ cross(res.y) @ res.by_knots[:, 1]
    near = np.einsum("ji,nrja->nria", _weights(seen), at).reshape(n, 6, NEAR)
    far = np.zeros((n, 6, 3 + OWN))
    far[:, 3:, :3] = -P
    by_unknowns = far[:, :, 3:]
    by_unknowns[:, :3, BIAS_W], by_unknowns[:, 3:, BIAS_F] = res.by_bias, np.eye(3)
    by_unknowns[:, :3, TURN] = (np.eye(3) - M.T @ back @ M) @ res.by_turn[0] / (2 * h)
    by_unknowns[:, 3:, TURN] = res.N.T @ cross(res.y @ M) @ res.by_turn[0]
    by_unknowns[:, 3:, APART] = cross(res.y @ MN) @ res.by_turn[1]
    by_unknowns[:, 3:, PLACE] = P @ np.einsum("j,njab->nab", SECOND / h**2, R)
    near[:, 3:] *= res.gain
    far[:, 3:] *= res.gain
    by_unknowns[:, 3:, SCALE] = res.felt[..., None]
    by_unknowns[..., DELAY] = res.by_delay.reshape(n, 6, 1)
    return near, far


def _robust(e: Floats, noise: Floats) -> tuple[Floats, Floats]:
    """Weights and costs, as those of hits."""
    z = np.abs(e) / noise[:, None]
    far = np.maximum(z / LIMIT, 1.0)
    return 1 / far**2, np.where(far > 1, LIMIT**2 * (1 + 2 * np.log(far)), z**2)


def cost(res: Residuals, noise: Floats) -> float:
    """Sum of the robust costs of all windows."""
    return float(_robust(res.e, noise)[1].sum())


def equations(
    seen: Windows, res: Residuals, noise: Floats, of: Layout, column: int, size: int
) -> Equations:
    """Normal equations; size: unknowns of the trajectory."""
    near, far = derivatives(seen, res)
    weight = (_robust(res.e, noise)[0] / noise[:, None] ** 2).reshape(-1, 6)
    e = res.e.reshape(-1, 6)
    at = np.r_[of.gravity : of.gravity + 3, column : column + OWN]
    band, cross, inner, g, h = total = Equations.zeros(size, of.size)
    rows = POSE * seen.interval[:, None] + np.arange(NEAR)
    w_near = np.swapaxes(near * weight[..., None], 1, 2)
    i, j = np.tril_indices(NEAR)
    np.add.at(band, (i - j, rows[:, j]), (w_near @ near)[:, i, j])
    np.add.at(cross, (rows[:, :, None], at), w_near @ far)
    np.add.at(g, rows, (w_near @ e[..., None])[..., 0])
    w_far = np.swapaxes(far * weight[..., None], 1, 2)
    inner[np.ix_(at, at)] = (w_far @ far).sum(axis=0)
    h[at] = (w_far @ e[..., None]).sum(axis=0)[:, 0]
    return total


def rough_noise(res: Residuals) -> Floats:
    """Standard deviations of both sensors' residuals by medians."""
    return np.maximum(MAD_TO_SIGMA * np.median(np.abs(res.e), axis=(0, 2)), LEAST)


def noise_of(seen: Windows, res: Residuals, noise: Floats, factor: Floats, hit: float) -> Floats:
    """Standard deviations of both sensors, one step of the estimate of variance components by
    Helmert (Foerstner 1979): with weights w, derivatives J and the covariance C of the trajectory,
    s^2 = sum(w e^2) / sum(w (1 - J C J' / s_before^2)).

    factor: of the trajectory's equations, in units of the variance of a hit.
    """
    near, _ = derivatives(seen, res)
    Z, first = selected_inverse(factor), POSE * seen.interval
    i, j = np.arange(NEAR)[:, None], np.arange(NEAR)
    C = Z[np.abs(i - j), first[:, None, None] + np.minimum(i, j)]
    share = hit**2 * np.einsum("nri,nij,nrj->nr", near, C, near).reshape(-1, 2, 3)
    weight, _ = _robust(res.e, noise)
    free = weight * np.clip(1 - weight * share / noise[:, None] ** 2, 0.0, 1.0)
    square = (weight * res.e**2).sum(axis=(0, 2))
    return np.maximum(np.sqrt(square / np.maximum(free.sum(axis=(0, 2)), 1.0)), LEAST)


def contradiction(values: np.ndarray, column: int, noise: Floats) -> str:
    """Why the sensors cannot be those of the board as described; empty where they can."""
    off = values[column : column + OWN] / INERTIAL_SD
    for name, rows in UNKNOWNS.items():
        if (far := np.linalg.norm(off[rows])) > FARTHEST:
            return f"their {name} would be {far:.0f} standard deviations off"
    if (noise > NOISIEST * LEAST).any():
        rate, force = noise
        return f"they differ from the light by {rate:.2g} rad/s and {force:.2g} m/s^2 (rms)"
    return ""


def first_gravity(seen: Windows, res: Residuals) -> Floats:
    """Gravity (3,) in m/s^2 as the accelerometer has it on average, in the master's frame."""
    force = res.gain * res.felt - res.e[:, 1]
    up = np.einsum("nij,nj->i", res.R[:, 1], force)
    return -GRAVITY_M_S2 * up / np.linalg.norm(up)


@njit
def _measured(
    time: np.ndarray,
    rate: np.ndarray,
    force: np.ndarray,
    windows_s: np.ndarray,
    first: np.ndarray,
    turn: np.ndarray,
    mean: np.ndarray,
) -> None:
    """W and f of all intervals, into turn (n, 3, 3) and mean (n, 3); between samples the sensors
    change linearly. first: first sample after the begin."""
    w, x = np.empty(3), np.empty(3)
    for m in range(first.size):
        a, middle, b = windows_s[m]
        h, k, s = (b - a) / 2, first[m], a
        R, half = np.eye(3), np.eye(3)
        total = np.zeros(3)
        while s < b:
            while time[k] <= s:
                k += 1
            e = min(time[k], b)
            if s < middle:
                e = min(e, middle)
            u = ((s + e) / 2 - time[k - 1]) / (time[k] - time[k - 1])
            for i in range(3):
                w[i] = (rate[k - 1, i] + u * (rate[k, i] - rate[k - 1, i])) * (e - s) / 2
                x[i] = force[k - 1, i] + u * (force[k, i] - force[k - 1, i])
            _turn(R, w)
            weight = (h - abs((s + e) / 2 - middle)) * (e - s) / (h * h)
            for i in range(3):
                total[i] += weight * (R[i, 0] * x[0] + R[i, 1] * x[1] + R[i, 2] * x[2])
            _turn(R, w)
            s = e
            if s == middle:
                half[:] = R
        turn[m] = R
        for i in range(3):
            mean[m, i] = half[0, i] * total[0] + half[1, i] * total[1] + half[2, i] * total[2]


@njit
def _turn(R: np.ndarray, v: np.ndarray) -> None:
    """R Exp(v), whose rows are Exp(-v) of those of R."""
    x, y, z = v
    s, c, _ = of_turn(x * x + y * y + z * z)
    for i in range(3):
        R[i, 0], R[i, 1], R[i, 2] = rotated(-x, -y, -z, s, c, R[i, 0], R[i, 1], R[i, 2])
