"""Factory values that a file states for the wrong stations.

A pose from exchanged values is wrong by decimetres at a residual little above noise. Where pieces
of the recording differ by more than chance, each two stations whose values are not from the
recording are fitted with them exchanged; the values as stated are wrong where the test of
`variants` finds them worse than that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations, islice

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.batch.estimate import Joint
from mocap_metrology.lighthouse.calibrate.batch import joint
from mocap_metrology.lighthouse.calibrate.fits import fitted, poses_of
from mocap_metrology.lighthouse.calibrate.joint_variants import weighed_stations
from mocap_metrology.lighthouse.calibrate.scene import Scene
from mocap_metrology.lighthouse.records import Station

MOST_PAIRS = 6  # of four stations: each is one more estimate


def exchanged(scene: Scene, found: Joint, stations: Sequence[Station]) -> tuple[str, ...]:
    """Names of two stations whose factory values fit better exchanged, where there are any."""
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
