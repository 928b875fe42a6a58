"""A joint estimate held against itself: parts of its recording, and where residuals arise."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.special import chdtri, fdtrc

from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.batch.estimate import Joint
from mocap_metrology.lighthouse.batch.kernel import POSE
from mocap_metrology.lighthouse.batch.problem import GROUPS, NEARLY_KNOWN, Priors
from mocap_metrology.lighthouse.batch.recording import Recording, pull_of_begins, rough
from mocap_metrology.lighthouse.batch.solve import Sums, by_bends, linearised, reduced, solved
from mocap_metrology.lighthouse.batch.view import Noise, stretch, sweeps_of, weights
from mocap_metrology.lighthouse.records import AXES, Halves, SharedErrors

PIECES = 12  # of a recording, of one duration
SPLITS = (1 / 3, 1 / 2, 2 / 3)  # of the duration; a bump is near one of them
FEWEST_SWEEPS = 20  # of each station in a part
FEWEST_OF_PIECE = 5  # likewise
UNDETERMINED = 0.25  # m^2 or rad^2: the variance of a pose that nothing determines
ANYWHERE, ANCHORED = 100.0, 1.0  # m or rad
WEAK = 1e-9  # of the largest information: a direction of a pose that a piece does not determine
BY_CHANCE = 1e-3  # probability that sound pieces are called a misfit, or a step in time


@dataclass(frozen=True)
class _Part:
    """Step from the estimate of all, gain K = M^-1 L of the priors, covariance of its noise."""

    step: np.ndarray
    gain: np.ndarray
    noise: np.ndarray


class _Step(NamedTuple):
    """Probability by chance that both sides of a recording differ so much, how far they are apart,
    the sides, and whether the pose of the first may be the right one."""

    p: float
    pair: Halves
    parts: tuple[_Part, _Part]
    both: bool


class Piece(NamedTuple):
    """Normal equations S, h of a piece of a recording, its trajectory eliminated, the covariance
    of h, and its sweeps by station; those of several are added."""

    S: Floats
    h: Floats
    pull: Floats
    sweeps: np.ndarray

    @classmethod
    def of(cls, one: Recording, sums: Sums, sweeps: np.ndarray) -> Piece:
        """From the sums over its hits."""
        without = reduced(sums, one.trajectory, one.noise)
        h = without.h + by_bends(without, one.trajectory, one.noise)
        return cls(without.S, h, without.S + pull_of_begins(one, sums, without), sweeps)

    @classmethod
    def total(cls, pieces: Sequence[Piece]) -> Piece:
        """All of them together."""
        return cls(*(np.sum(column, axis=0) for column in zip(*pieces, strict=True)))


def _from(joint: Joint, anchor: int, station: int) -> Floats:
    """Derivative (6, n) of the pose of a station as seen from another by all unknowns, in the axes
    of the first: with r from the anchor, dt - dt_a - w_a x r and w - w_a."""
    rows, held = np.zeros((2, 6, joint.of.size))
    rows[:, joint.pose(station)] = np.eye(6)
    if anchor:
        held[:, joint.pose(anchor)] = np.eye(6)
        rows -= held
        rows[:3] += np.cross(joint.state.t_m[station] - joint.state.t_m[anchor], held[3:], axis=0)
    return rows


def _part(joint: Joint, piece: Piece, station: int, anchor: int = 0) -> _Part | None:
    """One Gauss-Newton step of all unknowns from a part of the hits, at the scale of the whole;
    None where these do not determine the pose of the station as seen from the anchor."""
    scale = joint.of.group == GROUPS.index("scale")
    sd = np.where(scale, NEARLY_KNOWN * joint.of.sd, joint.working)
    poses = np.flatnonzero(joint.of.group == GROUPS.index("pose"))
    sd[np.setdiff1d(poses, joint.pose(station))] = ANYWHERE  # of stations that a part does not see
    if anchor:
        sd[joint.pose(anchor)] = ANCHORED  # where it does not see the reference either
    rows = _from(joint, anchor, station)
    known = 1 / sd**2
    try:
        M = np.linalg.inv(piece.S + np.diag(known))
    except np.linalg.LinAlgError:
        return None
    variances = np.linalg.eigvalsh(rows @ M @ rows.T)
    if not 0 < variances[0] <= variances[-1] < UNDETERMINED:
        return None
    step = -M @ (piece.h + known * np.where(scale, 0.0, joint.state.values))
    return _Part(step, M * known, M @ piece.pull @ M)


def _halves_apart(joint: Joint, a: _Part, b: _Part, single_sd: Floats, rows: Floats) -> Halves:
    """single_sd: standard deviations that each part has for itself; rows: of `_from`."""
    gain = rows @ (a.gain - b.gain) * np.sqrt(np.maximum(joint.sd**2 - single_sd**2, 0.0))
    alone = [rows @ part.gain * single_sd for part in (a, b)]
    noise = rows @ (a.noise + b.noise) @ rows.T
    covariance = noise + sum(one @ one.T for one in (*alone, gain))
    d = rows @ (a.step - b.step)
    return Halves.of(d, float(d @ np.linalg.solve(covariance, d)))


def pieces_of(joint: Joint, one: Recording) -> list[Piece]:
    """`PIECES` of a recording at the values of the estimate. Their noise is at least the spread of
    the residuals, which are larger where a station moved."""
    coarse = rough(one)
    noise = Noise(max(coarse.hit, one.noise.hit), one.noise.sweep)
    weight = weights(one.seen, one.residual, noise, one.share)
    time = one.sweeps.hits.time_s[one.sweeps.first[:-1]]
    share = (time - time.min()) / max(float(np.ptp(time)), 1e-9)
    piece = np.minimum((PIECES * share).astype(np.int64), PIECES - 1)
    stations = one.sweeps.hits.station[one.sweeps.first[:-1]]
    count = np.zeros((PIECES, len(joint.state.R)), int)
    np.add.at(count, (piece, stations), 1)
    pieces = []
    for k in range(PIECES):
        chosen = piece == k
        rows = chosen[one.sweeps.sweep]
        seen, path, sensors = sweeps_of(one.seen, chosen), one.trajectory, None
        if chosen.any():
            low, (seen, path) = seen.who[:, 3].min(), stretch(seen, path)
            sensors = one.sensors and one.sensors.within(seen.sweeps.hits.time_s, low)
        hit, held = weight.hit[rows], weight.held[chosen]
        its = replace(one, seen=seen, trajectory=path, noise=noise, sensors=sensors)
        at = seen, path, joint.state
        sums = linearised(*at, one.residual[rows], hit, joint.of, its.more(joint.of), held)
        pieces.append(Piece.of(its, sums, count[k]))
    return pieces


def _fewest(sweeps: np.ndarray, station: int) -> int:
    """Sweeps of a station, or of all others if these are fewer."""
    return int(min(sweeps[station], sweeps.sum() - sweeps[station]))


def _scatter(
    pieces: Sequence[Piece], joint: Joint, station: int, step: Floats
) -> tuple[float, int]:
    """Squared sum of what the pieces pull at a station's pose after a step, over its variance; and
    how many directions they determine."""
    total, freedom, rows = 0.0, 0, joint.pose(station)
    for piece in pieces:
        if _fewest(piece.sweeps, station) < FEWEST_OF_PIECE:
            continue
        unit = 1 / np.sqrt(np.diag(piece.pull)[rows])
        size, axes = np.linalg.eigh(piece.pull[np.ix_(rows, rows)] * np.outer(unit, unit))
        clear = size > WEAK * size[-1]
        pull = (piece.h + piece.S @ step)[rows] / np.sqrt(np.diag(piece.pull)[rows])
        total += float(np.sum((pull @ axes)[clear] ** 2 / size[clear]))
        freedom += int(clear.sum())
    return total, freedom


def misfit_of(joint: Joint) -> float:
    """Mean square of what pieces pull at the stations' poses, over what noise makes of it: 1 where
    that is within chance.

    Errors that were considered, not estimated, as those of phases, pull as well. So it is what is
    left after a step of all unknowns with the freedom of what is believed.
    """
    n, every = len(joint.state.R), [pieces_of(joint, one) for one in joint.recordings]
    S, h, *_ = Piece.total([piece for of_one in every for piece in of_one])
    known, step = 1 / joint.believed**2, np.zeros(joint.of.size)
    with suppress(np.linalg.LinAlgError):
        step = -solved(S + np.diag(known), h + known * joint.state.values)
    total, freedom = 0.0, -POSE * (n - 1)
    for pieces, station in product(every, range(1, n)):
        scatter = _scatter(pieces, joint, station, step)
        total, freedom = total + scatter[0], freedom + scatter[1]
    if freedom <= 0 or total < chdtri(freedom, BY_CHANCE):
        return 1.0
    return total / freedom


def _step(
    joint: Joint, station: int, one: Sequence[Piece], other: Sequence[Piece], both: bool
) -> _Step | None:
    """The step between two sides of a recording; None where a side does not determine the pose;
    both: whether the pose of either side may be the right one, or that of the other only."""
    sides = one, other
    if not (one and other):
        return None
    whole = [Piece.total(side) for side in sides]
    if min(_fewest(side.sweeps, station) for side in whole) < FEWEST_SWEEPS:
        return None
    a, b = (_part(joint, side, station) for side in whole)
    if a is None or b is None:
        return None
    pair, p = _halves_apart(joint, a, b, np.zeros(joint.of.size), _from(joint, 0, station)), 1.0
    per_side = [
        _scatter(side, joint, station, part.step) for side, part in zip(sides, (a, b), strict=True)
    ]
    rest, freedom = np.sum(per_side, axis=0)
    if freedom > 2 * POSE:
        rest = max(rest / (freedom - 2 * POSE), 1.0)
        p = float(fdtrc(POSE, freedom - 2 * POSE, pair.m2 / POSE / rest))
    return _Step(p, pair, (a, b), both)


def _left(joint: Joint, station: int, pieces: Sequence[Piece], begin: int, end: int) -> float:
    """Mean square of what pieces pull at all stations after a step at the begin and back at the end
    of some of them, over its noise: the least, as it may be within the piece before or after."""
    inner, every, left = set(range(begin, end)), set(range(len(pieces))), joint.misfit
    stations = range(1, len(joint.state.R))
    for out in product(*((at - 1, at) for at in (begin, end) if at)):
        one, other = ([pieces[k] for k in side.difference(out)] for side in (inner, every - inner))
        if (step := _step(joint, station, one, other, both=False)) is not None:
            of = product(zip((one, other), step.parts, strict=True), stations)
            each = [_scatter(side, joint, k, part.step) for (side, part), k in of]
            total, freedom = np.sum(each, axis=0) - [0, 2 * POSE * len(stations)]
            left = min(left, float(total / freedom)) if freedom > 0 else 1.0
    return max(left, 1.0)


def halves(
    joint: Joint, station: int = 1, pieces: Sequence[Piece] | None = None
) -> tuple[Halves | None, float, float]:
    """Pose of a station from the hits before and after each of `SPLITS` of the duration: the two
    that are farthest apart by m2; the misfit by which a step has moved the estimate, and that which
    the likeliest step leaves of all stations.

    Errors of board and optics are the same in both and nearly cancel: with the gains K_i, the
    difference has the covariance of both parts' noise and
    (K_1 - K_2) diag(believed^2) (K_1 - K_2)'. A part counts that has sweeps of the station and of
    others: from the hits of one alone the pose between two is not determined. None where no two
    parts have. pieces: what `pieces_of` returns, where it was called before.

    `stepped`: whether a step at one moment explains the difference, and pieces before and after
    agree among themselves, by an F test of the moment that explains most. Where pieces differ by
    more than noise, steps there and back are tested as well, whose parts are what is between and
    the rest. The misfit then, of the likeliest step: mean square of the distance, over noise, from
    the estimate to the pose of the part that is farther off; of a step there and back to the
    rest's.
    """
    pieces = pieces_of(joint, joint.recordings[0]) if pieces is None else pieces
    steps = dict[tuple[int, int], _Step]()
    for i in range(PIECES - 1 if joint.misfit > 1 else 1):
        for k in range(i + 1, PIECES):
            sides = pieces[i:k], [*pieces[:i], *pieces[k:]]
            if (step := _step(joint, station, *sides, both=not i)) is not None:
                steps[i, k] = step
    at = [steps[0, k].pair for k in (round(PIECES * split) for split in SPLITS) if (0, k) in steps]
    if not at:
        return None, 1.0, joint.misfit
    by_chance = BY_CHANCE / PIECES
    stepped = min(step.p for (i, _), step in steps.items() if not i) < by_chance
    pair = replace(max(at, key=lambda one: one.m2), stepped=stepped)
    when, likely = min(steps.items(), key=lambda one: one[1].p)
    clear = joint.misfit > 1 and likely.p < by_chance / PIECES
    left = _left(joint, station, pieces, *when) if clear or pair.stepped else joint.misfit
    whole = _part(joint, Piece.total(pieces), station) if clear else None
    if whole is None:
        return pair, 1.0, left
    rows = joint.pose(station)
    noise = whole.noise[np.ix_(rows, rows)]
    right = likely.parts if likely.both else likely.parts[1:]
    off = [(part.step - whole.step)[rows] for part in right]
    return pair, max(float(d @ np.linalg.solve(noise, d)) for d in off) / POSE, left


def halves_of_all(joint: Joint) -> tuple[Joint, list[list[Halves | None]], float]:
    """The estimate with the largest misfit by steps; `halves` of each station but the first in each
    recording, None where the board is at rest; and the least misfit that a step leaves."""
    moved = [None if r.trajectory.still else pieces_of(joint, r) for r in joint.recordings]
    none, stations = (None, 1.0, joint.misfit), range(1, len(joint.state.R))
    every = [[halves(joint, k, one) if one else none for one in moved] for k in stations]
    misfits, left = zip(*((misfit, left) for row in every for _, misfit, left in row), strict=True)
    pairs = [[pair for pair, *_ in row] for row in every]
    return replace(joint, misfit=max(joint.misfit, *misfits)), pairs, min(left)


def members_of(joint: Joint) -> list[Piece]:
    """Normal equations of each recording."""
    none = np.zeros(0)
    return [Piece.of(one, one.sums(joint.state, joint.of), none) for one in joint.recordings]


def pull_of_zeros(joint: Joint, priors: Priors, members: Sequence[Piece]) -> Floats | float:
    """Covariance of what time zeros of each recording pull at all unknowns, sum of P_o z^2 P_o';
    0 where recordings show, after a step as in `misfit_of`, that theirs are the same."""
    at = np.flatnonzero(joint.of.group == GROUPS.index("offset"))
    total, known = Piece.total(members), 1 / joint.believed**2
    step = -solved(total.S + np.diag(known), total.h + known * joint.state.values)
    freedom = (len(members) - 1) * at.size - POSE * (len(joint.state.R) - 1)
    pulls = [(one.h + one.S @ step)[at] for one in members]
    own = zip(pulls, members, strict=True)
    square = sum(float(h @ solved(one.S[np.ix_(at, at)], h)) for h, one in own)
    if freedom > 0 and square < chdtri(freedom, BY_CHANCE):
        return 0.0
    return sum(priors.time_zero_rad**2 * one.S[:, at] @ one.S[at] for one in members)


def predicted(joint: Joint, priors: Priors, parts: Sequence[Piece]) -> list[list[Halves | None]]:
    """Pose of each station but the first from each of several recordings against that from all
    others, as seen from the first station from which both determine it, None where there is none:
    first by station, then by recording.

    As `halves`, but recordings have time zeros of their own: flashes reach other diodes.
    """
    state = joint.state
    every = Piece.total(parts)
    zero = _of_one(joint, priors)
    apart: list[list[Halves | None]] = []
    for station in range(1, len(state.R)):
        apart.append([])
        for member in parts:
            rest, pair = Piece(*(a - b for a, b in zip(every, member, strict=True))), None
            for anchor in sorted({*range(len(state.R))} - {station}):
                alone, others = (_part(joint, its, station, anchor) for its in (member, rest))
                if alone is not None and others is not None:
                    rows = _from(joint, anchor, station)
                    pair = _halves_apart(joint, alone, others, zero, rows)
                    break
            apart[-1].append(pair and replace(pair, recordings=True))
    return apart


def _of_one(joint: Joint, priors: Priors) -> Floats:
    """Standard deviations of all unknowns by what differs between recordings."""
    group = np.array(GROUPS)[joint.of.group]
    sd = np.where(group == "offset", min(priors.time_zero_rad, priors.offset_rad), 0.0)
    return np.where(np.isin(group, ("gravity", "inertial")), joint.of.sd, sd)


def shared_errors(
    joint: Joint, priors: Priors, units: np.ndarray, board: str, station: int
) -> tuple[Floats, SharedErrors]:
    """Covariance (6, 6) of a station's pose by what differs between recordings of the same
    hardware, and the errors that do not; with these it is the whole covariance.

    units (6,) of the pose in m and rad; board: digest of its diodes.

    With M = S + L, an error e of what has a prior moves the estimate by -M^-1 L e. Noise makes
    M^-1 S M^-1, to which the time zeros are added: flashes reach other diodes the next time.
    """
    M, known = joint.inverse
    gain, rows = M * known, joint.pose(station)
    group, zero = np.array(GROUPS)[joint.of.group], _of_one(joint, priors)
    sd = np.sqrt(np.maximum(joint.sd**2 - zero**2, 0.0))
    noise = M @ joint.pull @ M + (gain * zero**2) @ gain.T
    relevant = sd > 1e-6 * zero
    effect = (gain * sd)[np.ix_(rows, relevant)].T * units
    of_board = np.isin(group[relevant], ("scale", "place", "cover"))
    by_noise = noise[np.ix_(rows, rows)] * np.outer(units, units)
    by_noise = (by_noise + by_noise.T) / 2  # apart by rounding, which differences leave much of
    return by_noise, SharedErrors(sd[relevant], effect, of_board, board)


def residual_ratios(one: Recording, names: Sequence[str]) -> dict[str, dict[str, float]]:
    """Rms residual beyond the sweep's offset over the noise of a hit: by station, axis, diode."""
    hits, z2 = one.sweeps.hits, (one.alone / one.noise.hit) ** 2
    ratios: dict[str, dict[str, float]] = {}
    for name, labels in {"station": names, "axis": AXES, "diode": ()}.items():
        rms = rms_by(getattr(hits, name), z2)
        seen = np.flatnonzero(np.isfinite(rms)).tolist()
        ratios[name] = {labels[k] if k < len(labels) else str(k): float(rms[k]) for k in seen}
    return ratios


def rms_by(key: np.ndarray, squares: np.ndarray, fewest: int = 1) -> Floats:
    """Root of the mean of squares for each value of a key from 0; NaN of fewer than `fewest`."""
    count = np.bincount(key)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.bincount(key, squares) / count
    return np.sqrt(np.where(count >= fewest, mean, np.nan))
