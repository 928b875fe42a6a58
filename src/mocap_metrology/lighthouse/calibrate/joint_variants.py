"""The variant of the rotor model by `batch`: each is fitted to all hits, and `variants` judges.

What a variant leaves of a sweep, with the noise s of a hit and S of a sweep, residuals e, the loss
rho of the estimate and the offset b that the sweep's hits share, is in rad^2

    s^2 (sum rho((e - b) / s) + (b / S)^2),

and the costs of the priors are spread over all sweeps. s and S are those of the best variant for
all, and the priors are the full ones: `batch` would give each the more freedom, the worse it is.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.batch.estimate import Joint, determined, with_rotors
from mocap_metrology.lighthouse.batch.solve import bend_cost
from mocap_metrology.lighthouse.calibrate.batch import Scene, joint, start
from mocap_metrology.lighthouse.calibrate.fits import explored, facing
from mocap_metrology.lighthouse.calibrate.superpose import BLOCKS
from mocap_metrology.lighthouse.calibrate.variants import (
    FALLBACK,
    HIT_RAD,
    NAMES,
    Fit,
    Weighed,
    units_of,
    weigh,
)


def best_joint(scene: Scene) -> tuple[list[Weighed], tuple[Joint, str]]:
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


def weighed_stations(of: Mapping[str, Scene], found: Mapping[str, Joint]) -> list[list[Weighed]]:
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
    """Of each sweep, that of the priors spread over all."""
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
