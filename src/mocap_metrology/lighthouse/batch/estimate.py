"""Joint estimate of station poses, trajectories and what is uncertain besides: estimator `batch`.

Gauss-Newton steps on all unknowns at once, each hit weighed by its residual, the steps damped where
the cost would rise. It begins with a noise that is the spread of the residuals themselves and so
falls with them; then the noise is estimated, then how large the errors of the board and of the
lasers are, and the search goes on to the end with these.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np
from scipy import linalg

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.hampel import MAD_TO_SIGMA
from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.batch.bias import bias_equations
from mocap_metrology.lighthouse.batch.problem import (
    GROUPS,
    Layout,
    Priors,
    State,
    Sweeps,
    by_sweep,
    layout,
    start,
)
from mocap_metrology.lighthouse.batch.solve import (
    Noise,
    Sums,
    View,
    Weights,
    bend_cost,
    covariance_of,
    estimated_noise,
    linearised,
    reduced,
    residuals,
    supported,
    view,
    weights,
)
from mocap_metrology.lighthouse.batch.trajectory import Trajectory
from mocap_metrology.lighthouse.records import Hits
from mocap_metrology.lighthouse.rotor import X, Z

ROUNDS = 60  # steps at most
LEAST_HIT_RAD = 1e-9  # of noise: of simulations without any
SETTLED = 0.8  # of the spread of residuals one step before: from then on noise is estimated
LEAST_GAIN = 0.01  # of the cost, which is a chi squared
SAME_COST = 1.0  # likewise, of the costs of two models
FIRST_DAMPING, LARGEST_DAMPING = 1e-4, 1e6  # of the diagonal
SMALL = 0.02  # of its standard deviation: a step that ends the search
SMALL_GAIN = 0.1  # of the cost: the same where poses are known, and only trajectories matter
LARGEST_BIAS = 5.0  # of its standard deviations, of all unknowns at once
SIZED = ("depth", "place")  # groups whose size the recording shows


@dataclass
class Recording:
    """A recording in the search: its hits, trajectory, noise, and the hits' residuals in rad."""

    sweeps: Sweeps
    trajectory: Trajectory
    seen: View
    noise: Noise
    residual: Floats

    def weights(self) -> Weights:
        """Of the hits, at the present noise."""
        return weights(self.seen, self.residual, self.noise)

    @property
    def alone(self) -> Floats:
        """Residuals without the offset of their sweep, rad."""
        return self.residual - self.weights().offset[self.sweeps.sweep]


@dataclass(frozen=True)
class Joint:
    """An estimate. S: information of the global unknowns without priors; working, believed: prior
    standard deviations that it used, and that the recordings do not contradict."""

    state: State
    recordings: tuple[Recording, ...]
    of: Layout
    S: np.ndarray
    working: np.ndarray
    believed: np.ndarray
    converged: bool
    rounds: int

    def sure(self, what: str) -> Joint:
        """Itself; refused, in the name of `what`, where the search did not converge."""
        if not self.converged:
            raise Refusal(f"{what}: no convergence in {self.rounds} steps")
        return self

    @property
    def covariance(self) -> np.ndarray:
        """Of all global unknowns, in m and rad."""
        return covariance_of(self.S, self.working, self.believed)

    def pose_covariance(self, station: int = 1) -> np.ndarray:
        """Covariance (6, 6) of t and the left rotation vector of a station in m and rad."""
        return self.covariance[np.ix_(*2 * [self.pose(station)])]

    def pose(self, station: int = 1) -> np.ndarray:
        """Rows of a station's pose among the unknowns."""
        return int(self.of.columns[station, 0, 0]) + np.arange(6)


@contextmanager
def determined(what: str) -> Iterator[None]:
    """Refuses, in the name of `what`, hits whose normal equations have no solution."""
    try:
        yield
    except np.linalg.LinAlgError as error:
        raise Refusal(f"{what}: the hits do not determine it ({error})") from None


def estimate(
    recordings: Sequence[tuple[Hits, Trajectory]],
    R: Sequence[np.ndarray],
    t_m: Sequence[np.ndarray],
    rotors: np.ndarray,
    board: np.ndarray,
    priors: Priors | None = None,
    known_poses: bool = False,
    *,
    sized: bool = False,
) -> Joint:
    """Poses R, t of the stations in the master's frame and everything else, from near them.

    recordings: hits of all stations, and a trajectory near the board's; rotors (stations, 2, 10);
    board (n, 3) in m; known_poses: R and t are held; sized: the priors are taken as they are, also
    of `SIZED`, and the bias remains. Raises LinAlgError where the hits do not determine the poses.
    """
    of = layout(len(R), len(board), priors or Priors(), known_poses)
    state = start(R, t_m, rotors, board, of.size)
    search = _Search(of, state, [recording(*one, state) for one in recordings], sized)
    found = search.run()
    return found if sized else search.without_bias(found)


def with_rotors(found: Joint, rotors: np.ndarray, rounds: int = ROUNDS) -> Joint:
    """The estimate for rotors (stations, 2, 10) of another model, from that of `found` and with its
    noise, so that the costs of several can be compared: to `SAME_COST`, or in so many steps. All
    have the freedom of the full priors, with which one can imitate another."""
    own = rotors.copy()
    own[..., X : Z + 1] = found.state.rotors[..., X : Z + 1]
    state = replace(found.state, rotors=own)
    parts = [
        replace(one, residual=residuals(one.seen, one.trajectory, state))
        for one in found.recordings
    ]
    search = _Search(found.of, state, parts, sized=True)
    search.refined, search.same_cost = True, SAME_COST
    return search.run(rounds)


def recording(hits: Hits, trajectory: Trajectory, state: State) -> Recording:
    """Hits of all stations along a trajectory, not yet weighed."""
    sweeps = by_sweep(hits)
    seen = view(sweeps, trajectory)
    off = residuals(seen, trajectory, state)
    return Recording(sweeps, trajectory, seen, Noise(np.inf, np.inf), off)


def _spread(values: np.ndarray) -> float:
    return max(MAD_TO_SIGMA * float(np.median(np.abs(values))), LEAST_HIT_RAD)


def rough(one: Recording) -> Noise:
    """Noise by medians, model errors included, while the fit is coarse."""
    low, n = one.sweeps.first[:-1], np.diff(one.sweeps.first)
    mean = np.add.reduceat(one.residual, low) / n
    many = (n > 1)[one.sweeps.sweep]
    inside = one.residual - mean[one.sweeps.sweep]
    return Noise(_spread(inside[many] if many.any() else one.residual), _spread(mean))


class _Search:
    """The present values, and steps from them."""

    def __init__(self, of: Layout, state: State, recordings: list[Recording], sized: bool):
        self.of, self.state, self.recordings = of, state, recordings
        self.working, self.believed = of.working.copy(), of.sd.copy()
        self.damping, self.refined, self.sized = 0.0, False, sized
        self.factors: list[np.ndarray] = []  # of the recordings' trajectories, in the last step
        held = (of.group != GROUPS.index("pose")).all()
        self.same_cost = SMALL_GAIN if held else 0.0

    def run(self, most: int = ROUNDS) -> Joint:
        """Steps until they are small, once with the first priors and once with those found."""
        converged, rounds = False, 0
        while not converged and rounds < most:
            rounds += 1
            sums = self._linearise()
            before = self.state.values
            S, h, step, gain = self._step(sums)
            if self.refined and self._small(S, step, gain):
                converged = self.sized
                self.sized = True
                if not converged:
                    self._size(S, h, before, sums)
        return Joint(
            self.state,
            tuple(self.recordings),
            self.of,
            S,
            self.working,
            self.believed,
            converged,
            rounds,
        )

    def without_bias(self, found: Joint) -> Joint:
        """The estimate less its bias (`batch.bias`); as it is where this is so large that the
        second order does not suffice."""
        if not found.converged:
            return found
        of, state, own = found.of, found.state, found.recordings
        parts = [
            bias_equations(
                one.seen,
                one.trajectory,
                state,
                one.residual,
                one.weights().hit,
                one.noise,
                of,
                factor,
            )
            for one, factor in zip(own, self.factors, strict=True)
        ]
        M = found.S + np.diag(1 / found.working**2)
        y = -linalg.solve(M, np.sum([part.h for part in parts], axis=0), assume_a="pos")
        if y @ M @ y > LARGEST_BIAS**2:
            return found
        state = state.moved(-y, of)
        for one, part in zip(own, parts, strict=True):
            one.trajectory = one.trajectory.moved(-part.trajectory_step(y))
            one.residual = residuals(one.seen, one.trajectory, state)
        return replace(found, state=state)

    def _linearise(self) -> list[Sums]:
        settled = True
        for one in self.recordings:
            if not self.refined:
                before, one.noise = one.noise, rough(one)
                settled &= one.noise.hit > SETTLED * before.hit
        sums = [self._sums(one) for one in self.recordings]
        if self.refined or not settled:
            return sums
        self.refined = True
        for one, own in zip(self.recordings, sums, strict=True):
            one.noise = estimated_noise(own, one.trajectory, one.noise)
        return sums

    def _sums(self, one: Recording) -> Sums:
        hit = one.weights().hit
        return linearised(one.seen, one.trajectory, self.state, one.residual, hit, self.of)

    def _small(self, S: Floats, step: Floats, gain: float) -> bool:
        """Whether a step, by which the cost fell by `gain`, is the last."""
        if self.same_cost:
            return abs(gain) < self.same_cost
        information = S + np.diag(1 / self.working**2)
        return float(np.sqrt(step @ information @ step / self.of.size)) < SMALL

    def _cost(self) -> float:
        """Robust sum of squares, with those of the priors."""
        known = float(np.sum((self.state.values / self.working) ** 2))
        return known + sum(
            float(one.weights().cost.sum()) + bend_cost(one.trajectory) for one in self.recordings
        )

    def _step(self, sums: list[Sums]) -> tuple[Floats, Floats, Floats, float]:
        """Take a step by which the cost does not rise; S and h before it, the step, and by how much
        the cost falls."""
        before = self.state, [(one.trajectory, one.residual) for one in self.recordings]
        cost, known = self._cost(), 1 / self.working**2
        while True:
            parts = [
                reduced(own, trajectory, one.noise, self.damping)
                for own, one, (trajectory, _) in zip(sums, self.recordings, before[1], strict=True)
            ]
            self.factors = [part.factor for part in parts]
            S = np.sum([part.S for part in parts], axis=0)
            h = np.sum([part.h for part in parts], axis=0)
            M = S + np.diag(known)
            M[np.diag_indices(len(M))] *= 1 + self.damping
            step = -linalg.solve(M, h + known * before[0].values, assume_a="pos")
            self.state = before[0].moved(step, self.of)
            for one, part, (trajectory, _) in zip(self.recordings, parts, before[1], strict=True):
                one.trajectory = trajectory.moved(part.trajectory_step(step))
                one.residual = residuals(one.seen, one.trajectory, self.state)
            after = self._cost()
            if not self.refined or after <= cost + LEAST_GAIN or self.damping > LARGEST_DAMPING:
                self.damping = self.damping / 10 if self.damping > FIRST_DAMPING / 100 else 0.0
                return S, h, step, cost - after
            self.damping = max(10 * self.damping, FIRST_DAMPING)

    def _size(self, S: Floats, h: Floats, values: Floats, sums: list[Sums]) -> None:
        """Noise, and priors of `SIZED` groups, as large as the recordings show; S and h at these
        values."""
        for one, of_one in zip(self.recordings, sums, strict=True):
            one.noise = estimated_noise(of_one, one.trajectory, one.noise)
        for name in SIZED:
            own = self.of.group == GROUPS.index(name)
            if own.any():
                best, most = supported(S, h, values, self.working, own)
                self.working[own] = best * self.of.sd[own]
                self.believed[own] = most * self.of.sd[own]
