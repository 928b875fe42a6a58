"""The variant of the rotor model by `batch`: each is fitted to all hits, and `variants` judges.

What a variant leaves of a sweep, with the noise s of a hit and S of a sweep, residuals e, the loss
rho of the estimate and the offset b that the sweep's hits share, is in rad^2

    s^2 (sum rho((e - b) / s) + (b / S)^2),

and the costs of the priors are spread over all sweeps. s and S are those of the best variant for
all, and the priors are the full ones: `batch` would give each the more freedom, the worse it is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations, islice

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.batch.estimate import Joint, determined, with_rotors
from mocap_metrology.lighthouse.batch.solve import bend_cost
from mocap_metrology.lighthouse.calibrate.batch import joint
from mocap_metrology.lighthouse.calibrate.fits import explored, facing, fitted, poses_of
from mocap_metrology.lighthouse.calibrate.network import start
from mocap_metrology.lighthouse.calibrate.scene import Scene
from mocap_metrology.lighthouse.calibrate.superpose import BLOCKS
from mocap_metrology.lighthouse.calibrate.variants import (
    FALLBACK,
    HIT_RAD,
    NAMES,
    Fit,
    VariantFit,
    units_of,
    weigh,
)
from mocap_metrology.lighthouse.records import Station

MOST_PAIRS = 6  # of four stations: each is one more estimate


def best_joint(scene: Scene) -> tuple[list[VariantFit], tuple[Joint, str]]:
    """The ranking of all variants, and the joint estimate by the best of them with its note.

    The variant that is best a step after a first fit, which is by the fallback, is estimated in
    full from there, and all are fitted; then that which is best now, if it is another. The noise is
    that of the first fit, or of the full one by another variant.
    Raises `Refusal` where an estimate does not converge.
    """
    of = {name: replace(scene, variant=name) for name in NAMES}
    with determined(scene.title):
        near = facing(of[FALLBACK], *start(of[FALLBACK]))
        first = explored(of[FALLBACK], *near)
        others = {name: with_rotors(first, of[name].rotors, rounds=1) for name in NAMES[1:]}
    begun = {FALLBACK: first} | others
    best = min(NAMES, key=lambda name: float(_cost(begun[name]).sum()))
    found: dict[str, tuple[Joint, str]] = {}
    while best not in found:
        found[best] = joint(of[best], near=near, first=begun[best])
        known = begun if best == FALLBACK else dict.fromkeys(of, found[best][0])
        weighed = weighed_stations(of, known)[0]
        best = next(one.variant for one in weighed if one.standing == "chosen")
    return weighed, found[best]


def weighed_stations(of: Mapping[str, Scene], found: Mapping[str, Joint]) -> list[list[VariantFit]]:
    """All variants as the pose of each station but the first has them, each from an estimate with
    the noise of the same fit; raises as `best_joint`."""
    fits: list[list[Fit]] = [[] for _ in next(iter(found.values())).state.R[1:]]
    for name, scene in of.items():
        what = f"{scene.title}, variant {name}"
        with determined(what):
            by_it = with_rotors(found[name], scene.rotors)
        for k, own in enumerate(fits, start=1):
            own.append(_fit(name, by_it.sure(what), k))
    return [weigh(own) for own in fits]


def _cost(found: Joint) -> Floats:
    """Cost of each sweep; that of the priors is spread over all."""
    own = np.concatenate([one.plain().cost for one in found.recordings])
    bends = sum(bend_cost(one.trajectory) for one in found.recordings)
    return own + (float(np.sum((found.state.values / found.working) ** 2)) + bends) / own.size


def _fit(name: str, found: Joint, station: int) -> Fit:
    """A unit is a stretch of time of a recording. Noise makes no more than `HIT_RAD` of a hit: a
    larger one is of other errors."""
    angles, unit, hit = [], [], []
    for k, one in enumerate(found.recordings):
        count, time = np.diff(one.sweeps.first), one.sweeps.hits.time_s[one.sweeps.first[:-1]]
        angles.append(count)
        unit.append(units_of(time, time.min(), time.max()) + k * BLOCKS)
        hit.append(np.full(count.size, one.noise.hit))
    n, noise = np.concatenate(angles), np.concatenate(hit)
    loss = noise**2 * _cost(found) / n
    expected = loss * np.minimum(1.0, (HIT_RAD / noise) ** 2)
    state = found.state
    return Fit(name, state.R[station], state.t_m[station], loss, n, np.concatenate(unit), expected)


def exchanged(scene: Scene, found: Joint, stations: Sequence[Station]) -> tuple[str, ...]:
    """Names of two stations whose factory values a file states for the wrong ones, if any.

    A pose from exchanged values is wrong by decimetres at a residual little above noise. Where
    pieces of the recording differ by more than chance, each two stations whose values are not from
    the recording are fitted with them exchanged; the values as stated are wrong where the test of
    `variants` finds them worse than that.
    """
    if scene.optics != "factory" or found.misfit <= 1 or found.recordings[0].trajectory.still:
        return ()
    told = {station.role for station in stations if station.frames_found}
    filed = [k for k, name in enumerate(scene.names) if name not in told]
    for pair in islice(combinations(filed, 2), MOST_PAIRS):
        factories = list(scene.factories)
        factories[pair[0]], factories[pair[1]] = factories[pair[1]], factories[pair[0]]
        other = replace(scene, factories=factories)
        if not np.array_equal(other.rotors, scene.rotors) and _worse(scene, found, other):
            return tuple(scene.names[k] for k in pair)
    return ()


def _worse(scene: Scene, found: Joint, other: Scene) -> bool:
    """Whether a scene, of which `found` is, fits worse than another of the same hits."""
    try:
        of = {"stated": scene, "exchanged": other}
        first = {"stated": found, "exchanged": joint(other)[0]}
        paths = {name: own.recordings[0].trajectory for name, own in first.items()}
        hits = found.recordings[0].sweeps.hits
        for path in paths.values():
            hits = hits.take(path.known(hits.time_s))
        fits = {
            name: fitted(own, hits, paths[name], poses_of(first[name]), sized=True)
            for name, own in of.items()
        }
        parts = [fit.recordings[0] for fit in fits.values()]
        best = min(parts, key=lambda one: one.noise.hit**2 + one.noise.sweep**2)
        for one in parts:
            one.noise, one.share, one.tau_rad = best.noise, best.share, best.tau_rad
        ways = weighed_stations(of, fits)[0]
    except (Refusal, np.linalg.LinAlgError):
        return False
    return any(way.variant == "stated" and way.standing == "worse" for way in ways)
