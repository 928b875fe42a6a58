"""Several recordings of a setup in one estimate by `batch`.

The stations keep their places, so all recordings share the slave's pose, the optics and the board,
and each has a trajectory of its own: their normal equations, without the trajectories, are added.
Recordings at different places determine what one cannot, above all the optics of stations that do
not transmit them. What the recordings say of each other is the check: the pose of each is held
against that from all others.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.batch.estimate import Joint, determined, estimate
from mocap_metrology.lighthouse.batch.parts import predicted
from mocap_metrology.lighthouse.batch.recording import Given
from mocap_metrology.lighthouse.calibrate.batch import Scene, joint, pose_of
from mocap_metrology.lighthouse.calibrate.fits import poses_of
from mocap_metrology.lighthouse.calibrate.joint_variants import weighed_by
from mocap_metrology.lighthouse.calibrate.variants import (
    AUTO,
    NAMES,
    Weighed,
    all_one,
    widened,
)
from mocap_metrology.lighthouse.records import Halves, Measurements, PoseEstimate

FEWEST = 2  # recordings


@dataclass(frozen=True)
class Setup:
    """The estimate from all recordings; each held against the others, by name; the variants of the
    rotor model; why recordings were left out."""

    pose: PoseEstimate
    predicted: Mapping[str, Halves]
    variants: list[Weighed]
    why: list[str]


def by_setup(
    scenes: Mapping[str, Scene],
    still: Mapping[str, tuple[Measurements, Measurements]] | None = None,
) -> Setup:
    """One pose of the slave from recordings that differ in their hits only; still: median angles of
    those in which the board keeps its place.

    Raises `Refusal` where fewer than two of them can be used, or all together do not converge.
    """
    begun, why = time.perf_counter(), []
    first = next(iter(scenes.values()))
    auto = first.optics == "factory" and first.variant == AUTO
    names = NAMES if auto and not all_one(first.factories) else (_variant(first),)
    alone: dict[str, Joint] = {}
    for name, scene in scenes.items():
        try:
            alone[name], note = joint(replace(scene, variant=names[0]), (still or {}).get(name))
        except Refusal as refusal:
            why.append(f"{name}: {refusal}")
            continue
        why += [f"{name}: {note}"] if note else []
    if len(alone) < FEWEST:
        raise Refusal(
            f"{len(alone)} recordings of the setup can be used; expected at least {FEWEST}"
            + "".join(f"; {reason}" for reason in why)
        )
    of = {name: replace(first, variant=name) for name in names}
    found: dict[str, Joint] = {}
    ways: list[Weighed] = []
    best = names[0]
    while best not in found:
        found[best] = _together(of[best], alone)
        if len(names) > 1:
            ways = weighed_by(of, found[best])
            best = next(way.variant for way in ways if way.standing == "chosen")
    with determined(of[best].title):
        apart = predicted(found[best], of[best].used_priors)
    by_name = dict(zip(alone, apart, strict=True))
    worst = max(apart, key=lambda pair: pair.m2)
    pose = replace(pose_of(of[best], found[best], "final"), halves=worst)
    pose = replace(widened(pose, ways), seconds=time.perf_counter() - begun)
    return Setup(pose, by_name, ways, why)


def _variant(scene: Scene) -> str:
    return NAMES[0] if scene.variant == AUTO else scene.variant


def _together(scene: Scene, alone: Mapping[str, Joint]) -> Joint:
    """From the estimates of the single recordings, beginning at the most certain pose."""
    sure = min(alone.values(), key=lambda one: float(np.trace(one.pose_covariance()[:3, :3])))
    own = [one.recordings[0] for one in alone.values()]
    series = [None if one.sensors is None else one.sensors.windows.series for one in own]
    given = [
        Given(one.sweeps.hits, one.trajectory, of, tuple(length.known for length in one.lengths))
        for one, of in zip(own, series, strict=True)
    ]
    R, t = zip(*poses_of(sure), strict=True)
    with determined(scene.title):
        how = scene.rotors, scene.board, scene.used_priors
        found = estimate(given, R, t, *how, more=scene.more)
    return found.sure(scene.title)
