"""Calibration of any number of stations, of either generation, by `batch`.

Stations that no common view connects are islands. That of the reference is calibrated, or the
largest one where the reference is alone. Of the second generation the optics are `factory` where
the values of all connected stations are known; else `estimated`, with the spread of real stations
as the prior of those that are not.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.batch.estimate import Joint
from mocap_metrology.lighthouse.calibrate.batch import all_solved, joint
from mocap_metrology.lighthouse.calibrate.fits import refitted
from mocap_metrology.lighthouse.calibrate.joint_variants import exchanged, weighed_stations
from mocap_metrology.lighthouse.calibrate.network import (
    FEWEST_MOMENTS,
    look,
    network_of,
    shared_moments,
    start,
)
from mocap_metrology.lighthouse.calibrate.scene import NAME, Scene, Sensors, optics_for
from mocap_metrology.lighthouse.calibrate.stages import Calibration, CalibrationSettings
from mocap_metrology.lighthouse.calibrate.static import is_still, median_angles
from mocap_metrology.lighthouse.calibrate.variants import (
    AUTO,
    COVARIANCE_UNITS,
    FALLBACK,
    Weighed,
    all_one,
    steps,
    widened,
)
from mocap_metrology.lighthouse.records import Hits, Station

OF_PLANES = (FALLBACK, "crazyflie")  # variants of the rotor model of the second generation


def calibrate_stations(
    hits: Hits,
    board: np.ndarray,
    stations: Sequence[Station],
    settings: CalibrationSettings,
    report: Callable[[str], None],
    sensors: Sensors | None,
) -> Calibration:
    """Poses of all stations that are connected with the reference, the first of `stations`.

    Raises `Refusal` where no two are connected, or the search does not converge.
    """
    names = [station.role for station in stations]
    factories = [station.factory for station in stations]
    generation = stations[0].generation
    variant = FALLBACK if settings.variant == AUTO else settings.variant
    how = factories, None, variant, settings.priors
    every = Scene(hits, board, "factory", *how, generation=generation, names=names)
    every = replace(every, sensors=sensors or Sensors())
    every = replace(every, optics=optics_for(settings.optics, factories))
    began = time.perf_counter()
    seen = look(every)
    shared = shared_moments(seen)
    own, network = network_of(names, shared)
    if len(own) < 2:
        raise Refusal(
            f"no two of the stations {', '.join(names)} see four diodes at {FEWEST_MOMENTS}"
            " common moments; expected a board that at least two stations see at a time"
        )
    scene = every.of(own)
    scene = replace(scene, optics=optics_for(settings.optics, scene.factories))
    views = [seen[k] for k in own]
    still = None
    if all(view is not None and is_still(view.paths[0]) for view in views):
        still = [median_angles(scene.hits, k, len(board)) for k in range(len(own))]
    near = start(scene, views) if still is None else None
    given = joint(scene, still, near)
    scene, given, ways = _best(scene, given, settings, near is not None)
    poses, found = all_solved(scene, still, given)
    seconds = time.perf_counter() - began
    report(f"{NAME}, {scene.optics}, {len(own)} stations: {seconds:.2f} s")
    open_ways = ways or [[] for _ in poses]
    return Calibration(
        estimates=[widened(pose, way) for pose, way in zip(poses, open_ways, strict=True)],
        paths={(NAME, scene.optics): (poses[0].path,)} if poses[0].path is not None else {},
        still=still is not None,
        n_common=min(network.common[name] for name in network.connected),
        why=list(network.apart.values()),
        variants=ways[0] if ways else [],
        joints={scene.optics: (scene, found)},
        network=replace(network, covariance=covariance_of_all(found, open_ways)),
        exchanged=exchanged(scene, found, stations),
    )


def _best(
    scene: Scene, given: tuple[Joint, str], settings: CalibrationSettings, moved: bool
) -> tuple[Scene, tuple[Joint, str], list[list[Weighed]]]:
    """By the variant of the rotor model that the recording prefers, and all of them a station."""
    auto = scene.optics == "factory" and settings.variant == AUTO and scene.generation == 2
    if not auto or not moved or all_one(scene.factories):
        return scene, given, []
    of = {name: replace(scene, variant=name) for name in OF_PLANES}
    try:
        ways = weighed_stations(of, dict.fromkeys(of, given[0]))
        best = next(way.variant for way in ways[0] if way.standing == "chosen")
        if best != scene.variant:
            given = refitted(of[best], given[0]), given[1]
            ways = weighed_stations(of, dict.fromkeys(of, given[0]))
    except Refusal:  # the other variant fits no better than not at all
        return scene, given, []
    return of[best], given, ways


def covariance_of_all(found: Joint, ways: Sequence[Sequence[Weighed]]) -> np.ndarray:
    """Covariance of all poses in mm and deg, with the variants that are left open."""
    n = len(ways)
    rows = np.concatenate([found.pose(k) for k in range(1, n + 1)])
    units = np.tile(COVARIANCE_UNITS, n)
    own = found.covariance[np.ix_(rows, rows)] * np.outer(units, units)
    off = np.hstack([steps(way) for way in ways])
    return own + off.T @ off / (len(off) + 1)
