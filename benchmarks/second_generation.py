"""Stations of the second generation by `batch`: errors over their bound, coverage, processor time.

    python -m benchmarks.second_generation [runs] [case]

Hits are made by the model (tests/lighthouse/batch/planes_scene.py): a hand-held object of 32 diodes
for 20 s, 20 urad of noise a hit and 15 of a sweep, a tenth of the hits lost. Case `light`: nothing
else is wrong, so that the covariance is the Cramer-Rao bound; `real`: diodes 0.2 mm from their
places, under covers, factory values known; `slow`: 0.15 mm, and besides diodes are seen 0.07 mm
aside by the direction of the light, and 3 % of the hits are reflections; `unknown`: factory values
drawn from the spread of real ones and not known; `drawn`: as `slow`, and scale, cover, places and
time zeros are drawn from what `batch` takes them for beforehand. Ratios are root mean squares of
normalised errors, so 1 is the bound; shares of six-dimensional ellipsoids that hold the true pose.
"""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from benchmarks import arguments
from benchmarks.poses import UNITS, error, held, lengths, mahalanobis, with_zeros
from mocap_metrology.lighthouse.batch.kernel import HELD
from mocap_metrology.lighthouse.batch.problem import COVER_M, COVER_SD_M, Priors
from mocap_metrology.lighthouse.calibrate.batch import joint
from mocap_metrology.lighthouse.calibrate.scene import Scene
from tests.lighthouse.batch.planes_scene import made

KNOWN = {"cover": (-0.75e-3, 1.55e-3), "priors": Priors(phase_mrad=0.0)}
SLOW = KNOWN | {"slow_mm": 0.07, "wrong": 0.03}
CASES = {
    "light": {},
    "real": KNOWN | {"place_mm": 0.2},
    "slow": SLOW | {"place_mm": 0.15},
    "unknown": {"known": False, "priors": Priors(phase_mrad=0.0)},
    "drawn": SLOW | {"place_mm": 0.2},
}


def drawn(rng: np.random.Generator, priors: Priors) -> tuple[float, tuple[float, float]]:
    """Share by which an object is larger than its file, and its cover a, t in m, from priors."""
    held, thickness = np.array([0.0, COVER_M[1]]) + COVER_SD_M * [1, 0.1] * rng.normal(size=2)
    return float(priors.board_scale * rng.normal()), (held - HELD * thickness, thickness)


def zeroed(scene: Scene, rng: np.random.Generator) -> Scene:
    """With a time zero of each station and plane from its prior."""
    sd = scene.used_priors.time_zero_rad
    return replace(scene, hits=with_zeros(scene.hits, rng, sd, len(scene.names)))


def study(n: int, case: str, runs: int, seconds: float) -> None:
    """One row of the table."""
    squares, ratios, millimetres, spent, hits = [], [], [], [], 0
    for seed in range(runs):
        rng, more = np.random.default_rng([17, seed]), {}
        if case == "drawn":
            more = dict(zip(("larger", "cover"), drawn(rng, Priors()), strict=True))
        given = made(n, seed, seconds, **CASES[case] | more)
        scene = zeroed(given.scene, rng) if case == "drawn" else given.scene
        begun = time.process_time()
        found, _ = joint(scene)
        spent.append(time.process_time() - begun)
        hits = len(given.scene.hits)
        for k, (R, t) in enumerate(given.poses[1:], start=1):
            off = error(found.state.R[k], found.state.t_m[k], R, t)
            C = found.pose_covariance(k) * np.outer(UNITS, UNITS)
            squares.append(mahalanobis(off, C))
            ratios.append(off / np.sqrt(np.diag(C)))
            millimetres.append(lengths(off)[0])
    inside = held(squares)
    rms = np.sqrt(np.mean(np.square(ratios)))
    print(
        f"{n:2d} stations, {case:8s} {runs:3d} runs, {hits:6d} hits: RMSE/sigma {rms:.2f},"
        f" 68 %: {inside[0]:.0f}, 95 %: {inside[1]:.0f}, error {np.median(millimetres):.2f} mm,"
        f" CPU {np.median(spent):.1f} s",
        flush=True,
    )


if __name__ == "__main__":
    asked = arguments(__doc__, runs=40, cases=(*CASES,))
    RUNS = asked["runs"]
    for name in asked["cases"]:
        study(2, name, RUNS, 20.0)
        study(4, name, max(RUNS // 2, 2), 20.0)
        study(16, name, max(RUNS // 10, 2), 20.0)
