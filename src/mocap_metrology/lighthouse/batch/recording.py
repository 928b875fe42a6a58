"""A recording in a joint estimate: hits, trajectory, sensors of the board, and their noise."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mocap_metrology.common.hampel import MAD_TO_SIGMA
from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.batch import inertial
from mocap_metrology.lighthouse.batch.inertial import Windows, windows
from mocap_metrology.lighthouse.batch.kernel import Equations
from mocap_metrology.lighthouse.batch.length import LengthView, added, equation
from mocap_metrology.lighthouse.batch.problem import Layout, State, Sweeps, by_sweep
from mocap_metrology.lighthouse.batch.share import shares
from mocap_metrology.lighthouse.batch.solve import Reduced, Sums, bend_cost, linearised
from mocap_metrology.lighthouse.batch.trajectory import Trajectory
from mocap_metrology.lighthouse.batch.view import Noise, View, Weights, residuals, view, weights
from mocap_metrology.lighthouse.known_length import KnownLength
from mocap_metrology.lighthouse.records import Clock, Hits, Inertial

LEAST_HIT_RAD = 1e-9  # of noise: of simulations without any


@dataclass(frozen=True)
class Given:
    """Of a recording: hits of all stations, a trajectory near the board's, sensors on it, and
    lengths that were measured meanwhile; clocks: of the stations."""

    hits: Hits
    trajectory: Trajectory
    inertial: Inertial | None = None
    lengths: tuple[KnownLength, ...] = ()
    clocks: tuple[Clock | None, ...] = ()

    def windows(self) -> Windows | None:
        """What is used of its sensors."""
        return windows(self.inertial, self.trajectory, self.hits.time_s)

    def with_knots(self) -> Given:
        """With the knots that its sensors need."""
        own = self.trajectory
        if own.still or own.knot_s <= inertial.KNOT_S or self.windows() is None:
            return self
        return replace(self, trajectory=own.halved())


@dataclass
class Sensed:
    """Gyroscope and accelerometer of a recording in the search: first of their unknowns, residuals,
    standard deviations of both in rad/s and m/s^2, and a delay near theirs."""

    windows: Windows
    column: int
    residual: inertial.Residuals
    noise: Floats
    near_s: float = 0.0


@dataclass
class Recording:
    """A recording in the search: its hits, trajectory, noise, and the hits' residuals in rad; its
    sensors, where it has any; share, tau_rad: as `share.shares`."""

    sweeps: Sweeps
    trajectory: Trajectory
    seen: View
    noise: Noise
    residual: Floats
    sensors: Sensed | None = None
    lengths: tuple[LengthView, ...] = ()
    share: Floats | None = None  # of the hits, where they share errors by direction
    tau_rad: float = 0.0  # standard deviation of these
    clocks: tuple[Clock | None, ...] = ()  # of the stations

    def move(self, step: Floats, state: State) -> None:
        """Add a step to the control points, and take other values of all else."""
        self.trajectory = self.trajectory.moved(step)
        self.renew(state)

    def renew(self, state: State) -> None:
        """Residuals at these values."""
        self.residual = residuals(self.seen, self.trajectory, state)
        if (own := self.sensors) is not None:
            found = inertial.residuals(own.windows, self.trajectory, state, own.column, own.near_s)
            self.sensors = replace(own, residual=found)

    def cost(self) -> float:
        """Robust sum of squares, with that of what is known of the trajectory."""
        total = float(self.weights().cost.sum()) + bend_cost(self.trajectory)
        if (own := self.sensors) is not None:
            total += inertial.cost(own.residual, own.noise)
        return total

    def more(self, of: Layout, column: int | None = None) -> Equations | None:
        """Equations of its sensors; column: first of their unknowns, in another layout."""
        if (own := self.sensors) is None:
            return None
        at, size = own.column if column is None else column, self.trajectory.control.size
        return inertial.equations(own.windows, own.residual, own.noise, of, at, size)

    def sums(self, state: State, of: Layout, column: int | None = None) -> Sums:
        """Normal equations of its hits and sensors."""
        own, more = self.weights(), self.more(of, column)
        at = self.seen, self.trajectory, state, self.residual
        return linearised(*at, own.hit, of, more, own.held)

    def by_lengths(self, state: State, of: Layout, part: Reduced) -> tuple[Floats, Floats]:
        """S and h of its lengths, its trajectory eliminated as in `part`."""
        S, h = np.zeros((of.size, of.size)), np.zeros(of.size)
        for seen in self.lengths:
            own = equation(seen, self.trajectory.control, state, of)
            S_own, h_own, _ = added(own, part, self.noise)
            S, h = S + S_own, h + h_own
        return S, h

    def cost_of_lengths(self, state: State, of: Layout) -> float:
        """Sum of squares of its lengths."""
        own = [equation(seen, self.trajectory.control, state, of) for seen in self.lengths]
        return float(sum(one.residual**2 / one.variance for one in own))

    def weights(self) -> Weights:
        """Of the hits, at the present noise."""
        return weights(self.seen, self.residual, self.noise, self.share)

    def plain(self) -> Weights:
        """Likewise, of hits that count alike."""
        return weights(self.seen, self.residual, self.noise)

    def shared(self, state: State) -> None:
        """Let hits of a diode from one direction share their errors, as the residuals show."""
        own = self.plain()
        alone = self.residual - own.offset[self.sweeps.sweep]
        at = self.seen, self.trajectory, state
        self.share, self.tau_rad, hit = shares(*at, alone, own.hit, self.noise.hit)
        self.noise = replace(self.noise, hit=hit)

    def total_weight(self) -> Floats:
        """Of each hit, with that of its sweep."""
        own = self.plain()
        return own.hit * own.held[self.sweeps.sweep]

    @property
    def alone(self) -> Floats:
        """Residuals without the offset of their sweep, rad."""
        return self.residual - self.plain().offset[self.sweeps.sweep]


def recording(given: Given, state: State) -> Recording:
    """Hits of all stations along a trajectory, not yet weighed."""
    sweeps = by_sweep(given.hits)
    seen = view(sweeps, given.trajectory)
    off = residuals(seen, given.trajectory, state)
    lengths = tuple(LengthView.of(known, given.trajectory) for known in given.lengths)
    none, clocks = Noise(np.inf, np.inf), given.clocks
    own = sweeps, given.trajectory, seen, none, off
    return Recording(*own, lengths=lengths, clocks=clocks)


def _spread(values: np.ndarray) -> float:
    return max(MAD_TO_SIGMA * float(np.median(np.abs(values))), LEAST_HIT_RAD)


def rough(one: Recording) -> Noise:
    """Noise by medians, model errors included, while the fit is coarse."""
    low, n = one.sweeps.first[:-1], np.diff(one.sweeps.first)
    mean = np.add.reduceat(one.residual, low) / n
    many = (n > 1)[one.sweeps.sweep]
    inside = one.residual - mean[one.sweeps.sweep]
    return Noise(_spread(inside[many] if many.any() else one.residual), _spread(mean))
