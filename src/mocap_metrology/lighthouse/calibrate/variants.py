"""Which variant of the rotor model the recording itself prefers, and what is left open.

Open-source drivers differ in what factory values mean (`rotor.Variant`), and the choice moves a
pose by millimetres. Each variant is fitted; l_i is what unit i of the recording leaves of it, in
rad^2: K_1 of the master's board poses and the weighted K_2 of the slave's angles together. A unit
is a stretch of time, as the hits of a sweep and of neighbouring sweeps err together; of a board at
rest it is a diode of a station. Variant b is worse than the best variant a beyond chance if

    mean(l_b - l_a) > t_0.995(n - 1) sd(l_b - l_a) / sqrt(n)

(the test of Vuong 1989 for models that are not nested), and if the gap in all is larger than what
even the best one leaves beyond `Fit.noise`: other errors of that size (lasers, diodes, the board)
could imitate it, and being alike in all units they escape the test. Of hits that share errors by
direction (`batch.recording`), as of a board that stops at a few places, the likelihoods, their
costs times the shares, must differ by the same odds as well. Variants that are not ruled out
stay open: with k of them, and d_j the step from the pose taken to theirs, (sum d_j d_j^T) / (k + 1)
joins the covariance: the second moment of a pose that is any of them with equal probability.

By `batch` each is fitted to all hits. What a variant leaves of a sweep, with the noise s of a hit
and S of a sweep, residuals e, the loss rho of the estimate and the offset b that the sweep's hits
share, is in rad^2

    s^2 (sum rho((e - b) / s) + (b / S)^2),

and the costs of the priors are spread over all sweeps. s and S are those of the best variant for
all, and the priors are the full ones: `batch` would give each the more freedom, the worse it is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, islice

import numpy as np
from scipy.special import stdtrit

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.batch.estimate import Joint, expect_determined, with_rotors
from mocap_metrology.lighthouse.batch.solve import bend_cost
from mocap_metrology.lighthouse.calibrate.agreement import Agreed, agreed_paths
from mocap_metrology.lighthouse.calibrate.batch import joint
from mocap_metrology.lighthouse.calibrate.fits import (
    explored,
    fitted,
    poses_of,
    without_hidden_hits,
)
from mocap_metrology.lighthouse.calibrate.network import start
from mocap_metrology.lighthouse.calibrate.reconstruction import Optics
from mocap_metrology.lighthouse.calibrate.scene import Scene
from mocap_metrology.lighthouse.calibrate.static import is_still, residuals_by_diode, static_pose
from mocap_metrology.lighthouse.calibrate.superpose import BLOCKS, blocks_of
from mocap_metrology.lighthouse.calibrate.weighted_station import (
    last_step,
    residuals,
    seen_on_path,
)
from mocap_metrology.lighthouse.records import (
    COVARIANCE_UNITS,
    MASTER,
    Factory,
    Measurements,
    PoseEstimate,
    Station,
)
from mocap_metrology.lighthouse.rotation import error
from mocap_metrology.lighthouse.rotor import VARIANTS, rotor_parameters

AUTO = "auto"
FALLBACK = "libsurvive"  # where nothing can be fitted: 14 of 16 real recordings prefer it
NAMES = (FALLBACK, *(name for name in VARIANTS if name != FALLBACK))
NOISE_RAD = 75e-6  # of an angle: jitter, and a clock of 2 MHz
# What a sweep's diodes have in common is in the board's pose, so single poses show the rest only.
HIT_RAD = 49e-6  # of an angle beyond its sweep, at most: 30 urad of a hit, 38 of a clock of 2 MHz
# Of the 53 urad of a sweep an uncertain path takes about half the square: sound recordings of decks
# and boards leave 30 to 38.
SWEEP_RAD = 53e-6 / np.sqrt(2)
RULED_OUT = 0.995  # quantile of the t distribution: by chance one variant in 200
ODDS = -2 * math.log(1 - RULED_OUT)  # of a likelihood ratio, by chance as rarely
OUTLIER = 25.0  # times the median loss an angle
FEWEST_MOMENTS = 20  # of both stations
MOST_PAIRS = 6  # of four stations: each is one more estimate


@dataclass(frozen=True)
class Fit:
    """A variant fitted: slave pose R, t (m), and what parts of the recording leave of it.

    loss (n,) in rad^2 an angle, angles (n,), unit (n,): which unit a part belongs to; noise (n,):
    the loss that noise makes, rad^2 an angle; variance: of an angle in rad^2, where the losses are
    a likelihood, else 0.
    """

    variant: str
    R: np.ndarray
    t_m: np.ndarray
    loss: np.ndarray
    angles: np.ndarray
    unit: np.ndarray
    noise: np.ndarray
    variance: float = 0.0


@dataclass(frozen=True)
class VariantFit:
    """A variant as the recording judges it: `standing` is chosen, open or worse; residual in urad
    of both stations; t: statistic of its being worse than the chosen one (0 for that itself)."""

    variant: str
    standing: str
    residual_rms_urad: float
    t: float
    R: np.ndarray
    t_m: np.ndarray

    def as_dict(self) -> dict[str, object]:
        values = {"variant": self.variant, "chosen": self.standing == "chosen"}
        values |= {name: getattr(self, name) for name in ("standing", "residual_rms_urad", "t")}
        pose = {"translation_mm": (1e3 * self.t_m).tolist(), "rotation_matrix": self.R.tolist()}
        return values | pose


def weigh(fits: Sequence[Fit]) -> list[VariantFit]:
    """The fits in their order, the best of them chosen; they are of the same parts."""
    limit = OUTLIER * min(float(np.median(fit.loss)) for fit in fits)
    typical = np.all([fit.loss <= limit for fit in fits], axis=0)
    if not typical.any():
        typical[:] = True
    units, row = np.unique(fits[0].unit[typical], return_inverse=True)
    angles = fits[0].angles[typical]
    sums = np.array([np.bincount(row, (fit.loss[typical] * angles)) for fit in fits])
    total = sums.sum(axis=1)
    best = int(total.argmin())
    beyond_noise = max(total[best] - float(angles @ fits[best].noise[typical]), 0.0)
    least = max(beyond_noise, ODDS * fits[best].variance)
    weighed = []
    for k, fit in enumerate(fits):
        gap, value, sure = sums[k] - sums[best], 0.0, False
        if units.size > 2:
            value = float(gap.mean() / max(gap.std(ddof=1) / np.sqrt(units.size), 1e-30))
            sure = value > stdtrit(units.size - 1, RULED_OUT) and gap.sum() > least
        standing = "chosen" if k == best else "worse" if sure else "open"
        rms = 1e6 * float(np.sqrt(total[k] / angles.sum()))
        weighed.append(VariantFit(fit.variant, standing, rms, value, fit.R, fit.t_m))
    return weighed


def steps(weighed: Sequence[VariantFit]) -> np.ndarray:
    """From the chosen pose to those left open: (k, 6) in mm and deg, as a covariance counts."""
    taken = next((way for way in weighed if way.standing == "chosen"), None)
    rows = [
        np.r_[way.t_m - taken.t_m, error(way.R, taken.R)]
        for way in weighed
        if taken is not None and way.standing == "open"
    ]
    return np.reshape(rows, (-1, 6)) * COVARIANCE_UNITS


def widened(estimate: PoseEstimate, weighed: Sequence[VariantFit]) -> PoseEstimate:
    """The estimate with the open variants in its covariance."""
    off = steps(weighed)
    if estimate.covariance is None or not len(off):
        return estimate
    return replace(estimate, covariance=estimate.covariance + off.T @ off / (len(off) + 1))


def all_one(factories: Sequence[Factory | None]) -> bool:
    """Whether the variants are the same for these values, as for those of ideal rotors."""
    models = [[rotor_parameters(f, None, VARIANTS[name]) for f in factories] for name in NAMES]
    return all(np.array_equal(models[0], model) for model in models)


def best_variant(
    scene: Scene,
    measured: Sequence[Measurements],
    middle: Sequence[Measurements],
    order: int,
) -> list[VariantFit]:
    """The ranking of all variants by `paper-lm`.

    measured: of master and slave; middle: the median angles of each diode, which count where the
    board keeps its place. Empty where none can be fitted.
    """
    fits, near = [], None
    for name in NAMES:
        variant = replace(scene, variant=name)
        optics, board = variant.seen(measured), scene.board
        agreed = agreed_paths(optics, board, order, near)
        near = agreed.pose and agreed.pose[0]
        if all(is_still(path) for path in agreed.paths):
            fit = _at_rest(name, variant.seen(middle), board)
        else:
            fit = _moving(name, optics, agreed, board, order)
        if fit is None:
            return []
        fits.append(fit)
    if len({fit.loss.size for fit in fits}) > 1:  # still by one variant, moving by another
        return []
    return weigh(fits)


def _moving(name: str, optics: Optics, agreed: Agreed, board: np.ndarray, order: int) -> Fit | None:
    """K_1 of the master's board poses and the weighted K_2 of the slave's angles, by stretches."""
    evidence = seen_on_path(agreed.paths, optics, board, order)
    if agreed.pose is None or len(evidence.path) < FEWEST_MOMENTS:
        return None
    R, t, _ = last_step([agreed.pose], evidence)
    left, master = residuals(R, t, evidence), agreed.paths[MASTER]
    time = np.concatenate([master.time_s, evidence.path.time_s])
    angles = np.concatenate([master.n_angles, left.count])
    loss = np.concatenate([master.epsilon / np.maximum(master.n_angles, 1), left.cost])
    # K_1 / (angles - 6) in all is the variance of an angle beyond its sweep, up to `HIT_RAD`.
    free = np.maximum(master.n_angles - 6, 0)
    hit = min(float(master.epsilon.sum() / max(free.sum(), 1)), HIT_RAD**2)
    of_slave = np.full(len(left.count), hit + SWEEP_RAD**2)
    noise = np.r_[hit * free / np.maximum(master.n_angles, 1), of_slave]
    return Fit(name, R, t, loss, angles, blocks_of(time), noise)


def _at_rest(name: str, optics: Optics, board: np.ndarray) -> Fit | None:
    """K_1 of both stations by diode."""
    pose = static_pose(list(optics.measurements), board, list(optics.rotors))
    if pose is None:
        return None
    loss = residuals_by_diode(list(optics.measurements), board, list(optics.rotors))
    noise = np.full(loss.size, NOISE_RAD**2)
    return Fit(name, pose.R, pose.t_m, loss, np.full(loss.size, 2), np.arange(loss.size), noise)


def best_joint(scene: Scene) -> tuple[list[VariantFit], tuple[Joint, str]]:
    """The ranking of all variants, and the joint estimate by the best of them with its note.

    The variant that is best a step after a first fit, which is by the fallback, is estimated in
    full from there. Raises `Refusal` where an estimate does not converge.
    """
    of = {name: replace(scene, variant=name) for name in NAMES}
    with expect_determined(scene.title):
        near = without_hidden_hits(of[FALLBACK], *start(of[FALLBACK]))
        first = explored(of[FALLBACK], *near)
        others = {name: with_rotors(first, of[name].rotors, rounds=1) for name in NAMES[1:]}
    begun = {FALLBACK: first} | others
    best = min(NAMES, key=lambda name: float(_cost(begun[name]).sum()))
    _, solution, (ways, *_) = preferred(
        of, best, lambda name: joint(of[name], near=near, first=begun[name])
    )
    return ways, solution


def preferred(
    of: Mapping[str, Scene], name: str, estimate_of: Callable[[str], tuple[Joint, str]]
) -> tuple[str, tuple[Joint, str], list[list[VariantFit]]]:
    """The variant that fits best from its own estimate, begun with `name`; that estimate with its
    note; and all variants as the pose of each station but the first has them."""
    solutions: dict[str, tuple[Joint, str]] = {}
    while name not in solutions:
        solutions[name] = estimate_of(name)
        ways = weighed_stations(of, dict.fromkeys(of, solutions[name][0]))
        name = next(way.variant for way in ways[0] if way.standing == "chosen")
    return name, solutions[name], ways


def weighed_stations(
    of: Mapping[str, Scene], joints: Mapping[str, Joint]
) -> list[list[VariantFit]]:
    """All variants as the pose of each station but the first has them, each from an estimate with
    the noise of the same fit; raises as `best_joint`."""
    fits: list[list[Fit]] = [[] for _ in next(iter(joints.values())).state.R[1:]]
    for name, scene in of.items():
        what = f"{scene.title}, variant {name}"
        with expect_determined(what):
            by_it = with_rotors(joints[name], scene.rotors)
        for k, of_station in enumerate(fits, start=1):
            of_station.append(_fit(name, by_it.sure(what), k))
    return [weigh(of_station) for of_station in fits]


def _cost(solution: Joint) -> Floats:
    """Cost of each sweep; that of the priors is spread over all."""
    costs = np.concatenate([one.weights().cost for one in solution.recordings])
    bends = sum(bend_cost(one.trajectory) for one in solution.recordings)
    return (
        costs
        + (float(np.sum((solution.state.values / solution.working) ** 2)) + bends) / costs.size
    )


def _fit(name: str, solution: Joint, station: int) -> Fit:
    """A unit is a stretch of time of a recording, or all of one at rest. Noise makes no more than
    `HIT_RAD` of a hit: a larger one is of other errors."""
    angles, unit, hit = [], [], []
    for k, one in enumerate(solution.recordings):
        first, share = one.sweeps.first[:-1], one.share
        time = one.sweeps.hits.time_s[first]
        count = np.diff(one.sweeps.first) if share is None else np.add.reduceat(share, first)
        angles.append(count)
        still = one.trajectory.still
        within = np.zeros(time.size) if still else blocks_of(time)
        unit.append(within + k * BLOCKS)
        hit.append(np.full(count.size, one.noise.hit))
    n, noise = np.concatenate(angles), np.concatenate(hit)
    loss = noise**2 * _cost(solution) / n
    expected = loss * np.minimum(1.0, (HIT_RAD / noise) ** 2)
    state, of_hits = solution.state, float(np.mean(noise**2))
    pose = state.R[station], state.t_m[station]
    return Fit(name, *pose, loss, n, np.concatenate(unit), expected, of_hits)


def exchanged(scene: Scene, solution: Joint, stations: Sequence[Station]) -> tuple[str, ...]:
    """Names of two stations whose factory values a file states for the wrong ones, if any.

    A pose from exchanged values is wrong by decimetres at a residual little above noise. Where
    pieces of the recording differ by more than chance, each two stations whose values are not from
    the recording are fitted with them exchanged; the values as stated are wrong where the test of
    `variants` finds them worse than that.
    """
    if scene.optics != "factory" or solution.misfit <= 1 or solution.recordings[0].trajectory.still:
        return ()
    told = {station.role for station in stations if station.frames_found}
    filed = [k for k, name in enumerate(scene.names) if name not in told]
    for pair in islice(combinations(filed, 2), MOST_PAIRS):
        factories = list(scene.factories)
        factories[pair[0]], factories[pair[1]] = factories[pair[1]], factories[pair[0]]
        other = replace(scene, factories=factories)
        if not np.array_equal(other.rotors, scene.rotors) and _fits_worse(scene, solution, other):
            return tuple(scene.names[k] for k in pair)
    return ()


def _fits_worse(scene: Scene, solution: Joint, other: Scene) -> bool:
    """Whether a scene, of which `solution` is, fits worse than another of the same hits."""
    try:
        of = {"stated": scene, "exchanged": other}
        first = {"stated": solution, "exchanged": joint(other)[0]}
        paths = {name: one.recordings[0].trajectory for name, one in first.items()}
        hits = solution.recordings[0].sweeps.hits
        for path in paths.values():
            hits = hits.take(path.known(hits.time_s))
        fits = {
            name: fitted(one, hits, paths[name], poses_of(first[name]), sized=True)
            for name, one in of.items()
        }
        parts = [fit.recordings[0] for fit in fits.values()]
        best = min(parts, key=lambda one: one.noise.hit**2 + one.noise.sweep**2)
        for one in parts:
            one.noise, one.share, one.tau_rad = best.noise, best.share, best.tau_rad
        ways = weighed_stations(of, fits)[0]
    except (Refusal, np.linalg.LinAlgError):
        return False
    return any(way.variant == "stated" and way.standing == "worse" for way in ways)
