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

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.batch import inertial, problem, recording, solve
from mocap_metrology.lighthouse.batch.bias import bias_equations
from mocap_metrology.lighthouse.batch.kernel import POSE
from mocap_metrology.lighthouse.rotor import GENERATION, X, Z

ROUNDS = 60  # steps at most
SETTLED = 0.8  # of the spread of residuals one step before: from then on noise is estimated
LEAST_GAIN = 0.01  # of the cost, which is a chi squared
SAME_COST = 1.0  # likewise, of the costs of two models
FIRST_DAMPING, LARGEST_DAMPING = 1e-2, 1e6  # of the diagonal
LOCAL = 8  # steps that are damped where they fail before all is
WEAK_DAMPING = 1e-4, 1e-9  # first and least, where errors that are shared leave unknowns weak
SMALL = 0.02  # of its standard deviation: a step that ends the search
SMALL_ENOUGH = 0.1  # likewise, if it is the last that is allowed
SMALL_GAIN = 0.1  # of the cost: the same where poses are known, and only trajectories matter
STALLED = 8  # steps of so small a gain one after the other end a search as well
NEAR_S = 5e-4  # delays so near are linear
LARGEST_BIAS = 5.0  # of its standard deviations, of all unknowns at once
SIZED = ("depth", "place")  # groups whose size the recording shows


@dataclass(frozen=True)
class Joint:
    """An estimate. S: information of the global unknowns without priors; working, believed: prior
    standard deviations that it used, and that the recordings do not contradict; ups: as given;
    misfit: by how much the pieces of the recordings differ, over what noise explains (variances);
    others: what S has from other data than those, as measured lengths; begins: as in
    `batch.begins`, of an estimate that is not `sized`.
    """

    state: problem.State
    recordings: tuple[recording.Recording, ...]
    of: problem.Layout
    S: np.ndarray
    working: np.ndarray
    believed: np.ndarray
    converged: bool
    rounds: int
    ups: np.ndarray | None
    misfit: float = 1.0
    others: Floats | float = 0.0
    begins: Floats | float = 0.0

    def sure(self, what: str) -> Joint:
        """Itself; refused, in the name of `what`, where the search did not converge."""
        if not self.converged:
            raise Refusal(f"{what}: no convergence in {self.rounds} steps")
        return self

    @property
    def covariance(self) -> np.ndarray:
        """Covariance of all unknowns (n, n), in rad, m and units of their own."""
        return solve.covariance_of(self.S, self.working, self.believed, self.pull)

    @property
    def pull(self) -> Floats:
        """Covariance of what the data pull at all unknowns: S, that of the recordings times their
        misfit, which says nothing about a measured length, and that of the begins of turns."""
        return self.S + (self.misfit - 1) * (self.S - self.others) + self.begins

    @property
    def inverse(self) -> tuple[Floats, Floats]:
        """(S + L)^-1 and the diagonal of L, the information of the priors."""
        known = 1 / self.working**2
        return solve.solved(self.S + np.diag(known), np.eye(known.size)), known

    @property
    def sd(self) -> Floats:
        """Prior standard deviations that the recordings do not contradict, 0 of what has none."""
        return np.where(np.isfinite(self.believed), self.believed, 0.0)

    def pose_covariance(self, station: int = 1) -> np.ndarray:
        """Covariance (6, 6) of t and the left rotation vector of a station in m and rad."""
        return self.covariance[np.ix_(*2 * [self.pose(station)])]

    def pose(self, station: int) -> np.ndarray:
        """Rows of a station's pose among the unknowns: 3 of position, 3 of rotation."""
        return int(self.of.columns[station, 0, 0]) + np.arange(6)


@contextmanager
def expect_determined(what: str) -> Iterator[None]:
    """Refuses, in the name of `what`, hits whose normal equations have no solution."""
    try:
        yield
    except np.linalg.LinAlgError as error:
        causes = (
            "a board file of another object or a mirror image of its own, reflections, few hits"
        )
        said = f"{what}: the hits do not determine it ({error}). Possible causes: {causes}"
        raise Refusal(said) from None


def estimate(
    recordings: Sequence[recording.BatchInput],
    R: Sequence[np.ndarray],
    t_m: Sequence[np.ndarray],
    rotors: np.ndarray,
    board: np.ndarray,
    priors: problem.Priors | None = None,
    known_poses: bool = False,
    *,
    sized: bool = False,
    more: problem.SideInformation | None = None,
    near: Joint | None = None,
    rounds: int = ROUNDS,
) -> Joint:
    """Poses R, t of the stations in the master's frame and everything else, from near them; rotors
    (stations, 2, 13); board (n, 3) in m; known_poses: R and t are held; sized: the priors are taken
    as they are, also of `SIZED`, and the bias remains; near: an estimate of the same unknowns, or
    all but the last, where this begins. Raises LinAlgError where the hits do not determine the
    poses."""
    if not all(len(one.hits) for one in recordings):
        raise np.linalg.LinAlgError("none of them fits the board")
    recordings = [one.with_knots() for one in recordings]
    seen = [one.windows() for one in recordings]
    more = more or problem.SideInformation()
    ups, normals = more.ups, more.normals
    by_ups = ups is not None and bool(np.isfinite(ups).all(axis=1).any())
    there = [one is not None for one in seen]
    sized_scale = known_poses or any(one.lengths for one in recordings)
    priors = priors or problem.Priors()
    of = problem.layout(len(R), len(board), priors, known_poses, there, by_ups, sized_scale, more)
    state = problem.start(
        R, t_m, rotors, board, of.size, problem.NO_NORMALS if normals is None else normals
    )
    if near is not None:
        values = np.append(near.state.values, state.values[near.of.size :])
        state = near.state._replace(values=values, normals=state.normals)
    begun = [recording.recording(one, state) for one in recordings]
    for one, its, column in zip(begun, seen, of.inertial, strict=True):
        if its is not None:
            felt = inertial.residuals(its, one.trajectory, state, column)
            one.sensors = recording.Sensed(its, column, felt, inertial.rough_noise(felt))
            if not state.gravity.any():
                state = state._replace(gravity=inertial.first_gravity(its, felt))
                one.renew(state)
    if ups is not None and by_ups and not any(there):
        state = state._replace(gravity=problem.first_gravity(state, ups))
    search = _Search(of, state, begun, sized, ups if by_ups else None)
    joint = search.run(rounds)
    return joint if sized else search.without_bias(joint)


def completed(joint: Joint) -> Joint:
    """The estimate from there with noise and priors as large as the hits show, less its bias."""
    search = _search_from(joint, joint.state, sized=False)
    return search.without_bias(search.run())


def with_rotors(joint: Joint, rotors: np.ndarray, rounds: int = ROUNDS) -> Joint:
    """The estimate for rotors (stations, 2, 13) of another model, from that of `joint` and with its
    noise, so that the costs of several can be compared: to `SAME_COST`, or in so many steps. All
    have the freedom of the full priors, with which one can imitate another."""
    changed = rotors.copy()
    changed[..., X : Z + 1] = joint.state.rotors[..., X : Z + 1]
    search = _search_from(joint, joint.state._replace(rotors=changed), sized=True)
    for one in search.recordings:
        one.renew(search.state)
    search.same_cost = SAME_COST
    return search.run(rounds)


def _search_from(joint: Joint, state: problem.State, sized: bool) -> _Search:
    """A search from there, with the noise of that estimate."""
    search = _Search(joint.of, state, [replace(one) for one in joint.recordings], sized, joint.ups)
    search.refined, search.weighed = True, True
    return search


class _Search:
    """The present values, and steps from them."""

    def __init__(
        self,
        of: problem.Layout,
        state: problem.State,
        recordings: list[recording.Recording],
        sized: bool,
        ups: np.ndarray | None,
    ):
        self.of, self.state, self.recordings, self.ups = of, state, recordings, ups
        self.working, self.believed = of.working.copy(), of.sd.copy()
        self.refined, self.sized = False, sized
        self.share = bool(state.rotors[0, 0, GENERATION] == 2)  # of hits from one direction
        first, self.least_damping = WEAK_DAMPING if self.share else (0.0, FIRST_DAMPING)
        # Of each control point of the recordings, in the last step.
        self.damping = [np.full(len(one.trajectory.control), first) for one in recordings]
        self.weighed = False  # the sensors' noise remains as it is
        self.parts: list[solve.Reduced] = []  # the recordings, in the last step
        self.others: Floats | float = 0.0  # as in `Joint`, in the last step
        self.last = False  # whether all priors are as large as they will be
        held = (of.group != problem.GROUPS.index("pose")).all()
        self.same_cost = SMALL_GAIN if held else 0.0

    def run(self, most: int = ROUNDS) -> Joint:
        """Steps until they are small, once with the first priors and once with those found."""
        converged, rounds, stalled, final = False, 0, 0, not self.sized
        while not converged and rounds < most:
            rounds += 1
            sums = self._linearise()
            before = self.state.values
            S, h, step, gain = self._step(sums)
            share = self._of_a_stall(gain)
            stalled = stalled + share if share else 0
            small = abs(gain) < self.same_cost if self.same_cost else self._size_of(S, step) < SMALL
            if self.refined and (small or stalled >= STALLED):
                converged, stalled = self.sized, 0
                self.sized = True
                if not converged:
                    self._size(S, h, before, sums)
                    self.last = True
        if not converged and self.last and abs(gain) < SAME_COST:
            converged = self._size_of(S, step) < SMALL_ENOUGH
        begins = (
            sum(map(recording.pull_of_begins, self.recordings, sums, self.parts)) if final else 0.0
        )
        values = self.state, tuple(self.recordings), self.of, S, self.working, self.believed
        how = converged, rounds, self.ups
        return Joint(*values, *how, others=self.others, begins=begins)

    def without_bias(self, joint: Joint) -> Joint:
        """The estimate less its bias; as it is where this is too large for the second order."""
        if not joint.converged:
            return joint
        of, state, recordings = joint.of, joint.state, joint.recordings
        parts = [
            bias_equations(one, state, of, part.factor)
            for one, part in zip(recordings, self.parts, strict=True)
        ]
        M = joint.S + np.diag(1 / joint.working**2)
        y = -solve.solved(M, np.sum([part.h for part in parts], axis=0))
        if y @ M @ y > LARGEST_BIAS**2:
            return joint
        state = state.moved(-y, of)
        for one, part in zip(recordings, parts, strict=True):
            one.move(-part.trajectory_step(y), state)
        return replace(joint, state=state)

    def _linearise(self) -> list[solve.Sums]:
        settled = True
        for one in self.recordings:
            if not self.refined:
                before, one.noise = one.noise, recording.rough(one, few_wrong=self.share)
                settled &= one.noise.hit > SETTLED * before.hit
        self._weigh_sensors()
        sums = [one.sums(self.state, self.of) for one in self.recordings]
        if self.refined or not settled:
            return sums
        self.refined = True
        return self._renoised(sums)

    def _renoised(self, sums: list[solve.Sums]) -> list[solve.Sums]:
        """Estimate the noise, by sums over hits that count alike; sums at it."""
        for one, its_sums in zip(self.recordings, sums, strict=True):
            one.noise = solve.estimated_noise(its_sums, one.trajectory, one.noise)
            if self.share:
                one.shared(self.state)
        return [one.sums(self.state, self.of) for one in self.recordings] if self.share else sums

    def _weigh_sensors(self) -> None:
        """Noise of the sensors: by medians while the fit is coarse, then with its freedom."""
        for k, one in enumerate(self.recordings):
            if (sensors := one.sensors) is None or self.weighed:
                continue
            near = inertial.delay(self.state, sensors.column)
            if abs(near - sensors.near_s) > NEAR_S:
                one.sensors = replace(sensors, near_s=near)
                one.renew(self.state)
                sensors = one.sensors
            if self.refined:
                hit, factor = one.noise.hit, self.parts[k].factor
                noise = inertial.noise_of(
                    sensors.windows, sensors.residual, sensors.noise, factor, hit
                )
            else:
                noise = inertial.rough_noise(sensors.residual)
            one.sensors = replace(sensors, noise=noise)

    def _size_of(self, S: Floats, step: Floats) -> float:
        """Size of a step in standard deviations."""
        information = S + np.diag(1 / self.working**2)
        return float(np.sqrt(step @ information @ step / self.of.size))

    def _of_a_stall(self, gain: float) -> int:
        """The count by which a step of such a gain brings the search nearer to its end, which is at
        `STALLED`: two steps without gain end it, or one that gains little before the last search,
        which begins where this ends."""
        if not self.refined or abs(gain) > (SMALL_GAIN if self.last else SAME_COST):
            return 0
        return 1 if self.last and abs(gain) > LEAST_GAIN else STALLED // 2

    def _cost(self) -> float:
        known = float(np.sum((self.state.values / self.working) ** 2))
        _, _, of_gravity = problem.gravity_equations(self.state, self.of, self.ups)
        lengths = sum(one.cost_of_lengths(self.state, self.of) for one in self.recordings)
        return known + of_gravity + lengths + sum(one.cost() for one in self.recordings)

    def _step(self, sums: list[solve.Sums]) -> tuple[Floats, Floats, Floats, float]:
        """Take a step by which the cost does not rise; S and h before it, the step without damping,
        and by how much the cost falls.

        The step without damping shows whether the search has come to its end: a damped one is small
        anywhere. It can fail even there, where few hits determine an end of a trajectory. So it is
        damped where it fails, and all else, the global unknowns too, where that does not help.
        """
        before, old = self.state, [replace(one) for one in self.recordings]
        down, pull, _ = problem.gravity_equations(self.state, self.of, self.ups)
        cost, known, tries = self._cost(), 1 / self.working**2, 0
        damping = [np.zeros_like(of_one) for of_one in self.damping]
        plain: tuple[Floats, Floats, Floats] | None = None
        while True:
            parts = [
                solve.reduced(of_one, one.trajectory, one.noise, np.repeat(its, POSE))
                for of_one, one, its in zip(sums, old, damping, strict=True)
            ]
            more = [
                one.by_lengths(before, self.of, part) for one, part in zip(old, parts, strict=True)
            ]
            others = down + np.sum([of_one[0] for of_one in more], axis=0)
            S = others + np.sum([part.S for part in parts], axis=0)
            h = pull + np.sum(
                [of_one.h for of_one in parts] + [of_one[1] for of_one in more], axis=0
            )
            M = S + np.diag(known)
            M[np.diag_indices(len(M))] *= 1 + min(its.min() for its in damping)
            step = -solve.solved(M, h + known * before.values)
            if plain is None:
                plain, self.parts, self.others = (S, h, step), parts, others
            self.state = before.moved(step, self.of)
            for one, part, then in zip(self.recordings, parts, old, strict=True):
                one.trajectory = then.trajectory
                one.move(part.trajectory_step(step), self.state)
            after, largest = self._cost(), max(its.max() for its in damping)
            if not self.refined or after <= cost + LEAST_GAIN or largest > LARGEST_DAMPING:
                self.damping = damping
                return *plain, cost - after
            tries += 1
            every = self.share or tries > LOCAL
            least = [np.maximum(of_one / 10, self.least_damping) for of_one in self.damping]
            damping = recording.more_damping(damping, least, old, self.recordings, every)

    def _size(self, S: Floats, h: Floats, values: Floats, sums: list[solve.Sums]) -> None:
        """Noise, and priors of `SIZED` groups, as large as the hits show; S and h at these
        values."""
        self.weighed = True
        if self.share:
            sums = [replace(one, share=None).sums(self.state, self.of) for one in self.recordings]
        self._renoised(sums)
        for one, part in zip(self.recordings, self.parts, strict=True):
            h = h + solve.by_bends(part, one.trajectory, one.noise)
        for name in SIZED:
            members = self.of.group == problem.GROUPS.index(name)
            if members.any():
                best, most = solve.supported(S, h, values, self.working, members)
                if self.share:  # many hits show the size: what remains open is about the best
                    most = float(np.hypot(best, most - best))
                self.working[members] = best * self.of.sd[members]
                self.believed[members] = most * self.of.sd[members]
