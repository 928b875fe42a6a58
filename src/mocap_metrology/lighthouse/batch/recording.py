"""A recording in a joint estimate: hits, trajectory, sensors of the board, and their noise.

Steps are damped by control point: one stretch in which hits are few or wrong fails at steps that
all others need, and damped alone it holds up no other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import linalg, ndimage

from mocap_metrology.common.hampel import MAD_TO_SIGMA
from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.batch import inertial
from mocap_metrology.lighthouse.batch.inertial import Windows, windows
from mocap_metrology.lighthouse.batch.kernel import POSE, SPAN, Equations
from mocap_metrology.lighthouse.batch.length import LengthView, equation
from mocap_metrology.lighthouse.batch.problem import Layout, State, Sweeps, by_sweep
from mocap_metrology.lighthouse.batch.solve import Reduced, Sums, bend_cost, linearised
from mocap_metrology.lighthouse.batch.trajectory import Trajectory
from mocap_metrology.lighthouse.batch.view import (
    LEAST_RAD,
    Noise,
    View,
    Weights,
    residuals,
    view,
    weights,
)
from mocap_metrology.lighthouse.decode.wander import TurnClock
from mocap_metrology.lighthouse.known_length import KnownLength
from mocap_metrology.lighthouse.records import Clock, Hits, Inertial
from mocap_metrology.lighthouse.rotation import exp

RISE, SHARE = 0.01, 0.03  # of the cost, which is a chi squared; of the largest rise
REACH = np.ones(SPAN // POSE)  # control points of a sweep
CELL = 0.2  # of the direction, a unit vector in the board's axes: 11 deg
PER_AXIS = 12  # cells; the first remains empty
STRIDES = np.outer((-1, 1), (1, PER_AXIS, PER_AXIS**2)).ravel()  # from a cell to its neighbours
ALIKE = 0.6  # of its hits: so 3.4 cells are one, by the covariances below 3.1
USUAL_RAD, AS_MANY_AS = 25e-6, 2.0  # tau of two boards, 16 and 36 urad; and what that counts for
FEWEST_HITS = 4.0  # of a cell whose mean counts


def shared_by_direction(
    seen: View,
    trajectory: Trajectory,
    state: State,
    alone: Floats,
    weight: Floats,
    hit_rad: float,
) -> tuple[Floats, float, float]:
    """Errors that the hits of a diode share from one direction, in light of the second generation:
    share of each hit; tau, and the noise of a hit with it, in rad.

    What cover, housing and active area of a diode do to an angle depends on the direction of the
    light, not on time: residuals of a moved controller (23 diodes, 2 to 3 m) covary by (34 urad)^2
    within 0.5 deg of direction, (28)^2 at 2 deg, (18)^2 at 8 deg and not at all beyond 16 deg; the
    white noise is 24 urad. Of n hits of a diode, of the white noise s, in a cell of directions of
    which the error has the variance tau^2, the mean has s^2 / n + tau^2: all are worth as much as
        n share,   share = (s^2 + tau^2) / (s^2 + n tau^2)
    independent ones, n with `ALIKE` of those in neighbouring cells. tau is what means of cells of
    one diode, station and plane differ by; a board that shows its diodes from one direction has
    that of other boards.

    alone, weight: residual beyond its sweep's offset in rad, robust weight; hit_rad: noise of a
    hit.
    """
    who = seen.who
    pose = np.einsum("ni,nia->na", seen.basis, trajectory.control[who[:, 3, None] + np.arange(4)])
    far = state.t_m[who[:, 0]] - pose[:, :3]
    turn = seen.turned @ exp(pose[:, 3:])
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
    alike = n.copy()
    for step in STRIDES:
        at = np.minimum(np.searchsorted(number, number + step), number.size - 1)
        alike += ALIKE * n[at] * (number[at] == number + step)
    share = np.asarray((white + tau2) / (white + alike * tau2), np.float64)
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


@dataclass(frozen=True)
class BatchInput:
    """What an estimate begins with: hits of all stations, a trajectory near that of the board,
    sensors on it, lengths measured meanwhile; clocks of the stations."""

    hits: Hits
    trajectory: Trajectory
    inertial: Inertial | None = None
    lengths: tuple[KnownLength, ...] = ()
    clocks: tuple[Clock | None, ...] = ()

    def windows(self) -> Windows | None:
        """Windows of the inertial series between knots; None without one."""
        return windows(self.inertial, self.trajectory, self.hits.time_s)

    def with_knots(self) -> BatchInput:
        """The same with the knots that its inertial sensors need."""
        trajectory = self.trajectory
        if trajectory.still or trajectory.knot_s <= inertial.KNOT_S or self.windows() is None:
            return self
        return replace(self, trajectory=trajectory.halved())


@dataclass
class Sensed:
    """Sensors of a recording in the search: first of their unknowns, standard deviations of both in
    rad/s and m/s^2, a delay near theirs."""

    windows: Windows
    column: int
    residual: inertial.Residuals
    noise: Floats
    near_s: float = 0.0

    def within(self, time_s: np.ndarray, low: int) -> Sensed | None:
        """What they measured between the first and the last of these times, if anything, its
        control points counted from `low` on."""
        at = self.windows.time_s
        inside = (at[:, 0] >= time_s.min()) & (at[:, 2] <= time_s.max())
        if not inside.any():
            return None
        windows, residual = self.windows.take(inside, low), self.residual.take(inside)
        return replace(self, windows=windows, residual=residual)


@dataclass
class Recording:
    """A recording in the search: its hits, trajectory, noise, and the hits' residuals in rad; its
    sensors, where it has any; share, tau_rad: as `shared_by_direction`."""

    trajectory: Trajectory
    seen: View
    noise: Noise
    residual: Floats
    sensors: Sensed | None = None
    lengths: tuple[LengthView, ...] = ()
    share: Floats | None = None  # of the hits, where they share errors by direction
    tau_rad: float = 0.0  # standard deviation of these
    clocks: tuple[Clock | None, ...] = ()  # of the stations

    @property
    def sweeps(self) -> Sweeps:
        """Its hits, by sweeps."""
        return self.seen.sweeps

    def move(self, step: Floats, state: State) -> None:
        """Add a step to the control points, and take other values of all else."""
        self.trajectory = self.trajectory.moved(step)
        self.renew(state)

    def renew(self, state: State) -> None:
        """Residuals at these values."""
        self.residual = residuals(self.seen, self.trajectory, state)
        if (sensors := self.sensors) is not None:
            residual = inertial.residuals(
                sensors.windows, self.trajectory, state, sensors.column, sensors.near_s
            )
            self.sensors = replace(sensors, residual=residual)

    def cost(self) -> float:
        """Robust cost of the hits, of the bends of the path, and of the inertial sensors."""
        total = float(self.weights().cost.sum()) + bend_cost(self.trajectory)
        if (sensors := self.sensors) is not None:
            total += inertial.cost(sensors.residual, sensors.noise)
        return total

    def more(self, of: Layout, column: int | None = None) -> Equations | None:
        """Equations of its sensors; column: first of their unknowns, in another layout."""
        if (sensors := self.sensors) is None:
            return None
        at, size = sensors.column if column is None else column, self.trajectory.control.size
        return inertial.equations(sensors.windows, sensors.residual, sensors.noise, of, at, size)

    def sums(self, state: State, of: Layout, column: int | None = None) -> Sums:
        """Normal equations of its hits and sensors."""
        weighed, more = self.weights(), self.more(of, column)
        at = self.seen, self.trajectory, state, self.residual
        return linearised(*at, weighed.hit, of, more, weighed.held)

    def by_lengths(self, state: State, of: Layout, part: Reduced) -> tuple[Floats, Floats]:
        """S and h of its lengths, its trajectory eliminated as in `part`."""
        S, h = np.zeros((of.size, of.size)), np.zeros(of.size)
        for seen in self.lengths:
            d, e, variance = self.seen_length(seen, state, of, part)
            S, h = S + np.outer(d, d) / variance, h + d * e / variance
        return S, h

    def seen_length(
        self, seen: LengthView, state: State, of: Layout, part: Reduced
    ) -> tuple[Floats, float, float]:
        """Derivative of a length by all unknowns but the trajectory, which is eliminated as in
        `part`, its residual, and its variance, that of the trajectory included."""
        of_length = equation(seen, self.trajectory.control, state, of)
        a = of_length.by_trajectory
        A_a = linalg.cho_solve_banded((part.factor, True), a, check_finite=False)
        variance = of_length.variance + self.noise.hit**2 * float(a @ A_a)
        d = of_length.by_others - part.A_C.T @ a
        return d, of_length.residual - float(a @ part.A_g), variance

    def cost_of_lengths(self, state: State, of: Layout) -> float:
        """Sum of squares of its lengths."""
        equations = [equation(seen, self.trajectory.control, state, of) for seen in self.lengths]
        return float(sum(one.residual**2 / one.variance for one in equations))

    def weights(self) -> Weights:
        return weights(self.seen, self.residual, self.noise, self.share)

    def plain(self) -> Weights:
        """Weights of hits that count alike."""
        return weights(self.seen, self.residual, self.noise)

    def shared(self, state: State) -> None:
        """Let hits of a diode from one direction share their errors, as the residuals show."""
        plain = self.plain()
        alone = self.residual - plain.offset[self.sweeps.sweep]
        at = self.seen, self.trajectory, state
        self.share, self.tau_rad, hit = shared_by_direction(*at, alone, plain.hit, self.noise.hit)
        self.noise = self.noise._replace(hit=hit)

    def at_a_moment(self) -> Recording:
        """With the share of a hit in the board's pose at one moment, which comes from the hits of
        one interval between knots: errors by direction are shared there by these alone."""
        if self.share is None:
            return self
        who = self.seen.who
        key = np.ravel_multi_index(who.T, who.max(axis=0) + 1)
        _, group, n = np.unique(key, return_inverse=True, return_counts=True)
        alone = 1 / (1 + (n - 1) * (self.tau_rad / self.noise.hit) ** 2)
        return replace(self, share=np.maximum(self.share, alone[group]))

    def total_weight(self) -> Floats:
        """Weight of each hit, times that of its sweep."""
        plain = self.plain()
        return plain.hit * plain.held[self.sweeps.sweep]

    @property
    def alone(self) -> Floats:
        """Residuals without the offset of their sweep, rad."""
        return self.residual - self.plain().offset[self.sweeps.sweep]


def recording(inputs: BatchInput, state: State) -> Recording:
    """A recording as the state sees it, without noise that is known yet."""
    seen = view(by_sweep(inputs.hits), inputs.trajectory)
    off = residuals(seen, inputs.trajectory, state)
    lengths = tuple(LengthView.of(known, inputs.trajectory) for known in inputs.lengths)
    none, clocks = Noise(np.inf, np.inf), inputs.clocks
    begun = inputs.trajectory, seen, none, off
    return Recording(*begun, lengths=lengths, clocks=clocks)


def _spread(values: np.ndarray) -> float:
    return max(MAD_TO_SIGMA * float(np.median(np.abs(values))), LEAST_RAD)


def rough(one: Recording, few_wrong: bool = False) -> Noise:
    """Noise by medians, model errors included, while the fit is coarse; few_wrong: single hits of a
    sweep may be off by so much that they move its mean."""
    sweep, low, n = one.sweeps.sweep, one.sweeps.first[:-1], np.diff(one.sweeps.first)
    middle = np.add.reduceat(one.residual, low) / n
    if few_wrong:
        middle = ndimage.median(one.residual, sweep, np.arange(n.size))
    many, inside = (n > 1)[sweep], one.residual - middle[sweep]
    return Noise(_spread(inside[many] if many.any() else one.residual), _spread(middle))


def more_damping(
    damping: Sequence[Floats],
    least: Sequence[Floats],
    before: Sequence[Recording],
    after: Sequence[Recording],
    everywhere: bool,
) -> list[Floats]:
    """Ten times as much, at least so much, for control points of stretches in which a step raised
    the cost of the sweeps most; for all, where no stretch has, or everywhere. damping, least
    (control points,): of each recording, times the diagonal."""
    rises = [
        np.bincount(old.seen.begin, then.weights().cost - old.weights().cost, its.size)
        for old, then, its in zip(before, after, damping, strict=True)
    ]
    much = max(RISE, SHARE * max(float(rise.max()) for rise in rises))
    worse = [np.convolve(rise > much, REACH)[: rise.size] > 0 for rise in rises]
    everywhere |= not any(mask.any() for mask in worse)
    return [
        np.where(mask | everywhere, np.maximum(10 * its, low), its)
        for mask, its, low in zip(worse, damping, least, strict=True)
    ]


def pull_of_begins(one: Recording, sums: Sums, part: Reduced) -> Floats:
    """P' C P of a recording, or a piece of it, by its normal equations, and these without the
    trajectory; 0 for stations that tell no begins.

    A station of the second generation tells by its light when a turn began, with noise;
    `decode.wander` smooths it. What is left moves both planes of neighbouring turns together. It is
    no unknown: an error u of the begins, of the covariance C of `decode.wander`, pulls at the other
    unknowns, trajectory and offsets of sweeps eliminated, by P' u. The noise of sweeps is estimated
    with the variance of u in it, which is taken out again.
    """
    first, noise = one.sweeps.first[:-1], one.noise
    station, turn = one.sweeps.hits.station[first], one.sweeps.hits.cycle[first]
    open_ = 1 / (1 + (noise.sweep / noise.hit) ** 2 / sums.held * sums.weight)
    total, last = np.zeros_like(part.S), len(part.A_C) - 1
    for k, clock in enumerate(one.clocks):
        begins = np.flatnonzero(station == k)
        if not isinstance(clock, TurnClock) or not begins.size:
            continue
        pull, low = sums.of_sweep_inner[begins], POSE * sums.begin[begins]
        for j in range(SPAN):
            row = np.minimum(low + j, last)  # beyond the last, `of_sweep` is 0
            pull = pull - sums.of_sweep[begins, j, None] * part.A_C[row]
        rad_per_s = 2 * np.pi / clock.cycle_s
        pull *= rad_per_s * open_[begins, None] / noise.hit**2
        twice = min(clock.variance, (noise.sweep / rad_per_s) ** 2)
        total += clock.error_of(pull, turn[begins]) - twice * pull.T @ pull
    return total
