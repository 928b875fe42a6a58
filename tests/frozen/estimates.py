"""Estimates by `batch` of a second or two of hits, made without the package's simulator."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.batch.problem import Priors
from mocap_metrology.lighthouse.board import flat_board
from mocap_metrology.lighthouse.calibrate.agreement import agreed_paths
from mocap_metrology.lighthouse.calibrate.batch import details_of, joint, solved, usable_hits
from mocap_metrology.lighthouse.calibrate.reconstruction import Optics, reconstruct
from mocap_metrology.lighthouse.calibrate.scene import Scene
from mocap_metrology.lighthouse.fit.board_pose import well_posed
from mocap_metrology.lighthouse.records import Hits
from mocap_metrology.lighthouse.rotor import rotor_parameters
from tests.lighthouse.batch import planes_scene
from tests.lighthouse.calibrate import scenes

from .digest import Flat, flat

NONE = Priors(0, 0, 0, 0, 0)
THIRD = np.eye(3), np.array([0.3, -2.2, -0.4])
FIRST: dict[str, dict[str, Any]] = {
    "quiet": {"noise_rad": 2e-5}, "noisy": {"noise_rad": 2e-4}, "prior": {"priors": Priors()},
    "wrong hits": {"wrong": 0.04}, "gap": {"dark": (0.5, 0.9)}, "still": {"still": True},
    "fast": {"speed": 1.2}, "few diodes": {"board": flat_board(3, 2)},
    "own optics": {"optics": "estimated", "priors": Priors()}, "very brief": {"seconds": 0.3},
    "three stations": {"more": (THIRD,)},
}  # fmt: skip
SECOND: dict[str, dict[str, Any]] = {
    "turns": {},
    "turns with wrong hits": {"wrong": 0.05},
    "turns with a cover": {"cover": (-0.8e-3, 1.5e-3)},
    "turns of ideal planes": {"ideal": True},
}


def disturbed(hits: Hits, wrong: float, dark: tuple[float, float]) -> Hits:
    rng = np.random.default_rng(15)
    off = 5e-3 * rng.standard_normal(len(hits)) * (rng.random(len(hits)) < wrong)
    hits = replace(hits, angle_rad=hits.angle_rad + off)
    return hits.take((hits.time_s < dark[0]) | (hits.time_s > dark[1]))


def first(name: str, folder: Path | None = None) -> Flat:
    how = {"noise_rad": 5e-5, "seconds": 1.2, "board": flat_board(4, 2)} | FIRST[name]
    wrong, dark = how.pop("wrong", 0.0), how.pop("dark", (9.0, 9.0))
    priors, optics = how.pop("priors", NONE), how.pop("optics", "ideal")
    made = scenes.scene(3, **how)
    hits = disturbed(made.hits, wrong, dark)
    n = 2 + len(how.get("more", ()))
    scene = Scene(hits, made.board, optics, [None] * n, None, "crazyflie", priors)
    if n > 2:
        found = joint(scene)[0]
        return dict(flat({"state": found.state._asdict(), "S": found.covariance}))
    return dict(flat({"batch": tried(timeless, scene), "paths": tried(paths, hits, made.board)}))


def timeless(scene: Scene) -> object:
    return replace(solved(scene)[0], seconds=0.0)


def tried(function: Callable[..., object], *given: object) -> object:
    try:
        return function(*given)
    except Refusal as refusal:
        return str(refusal)


def paths(hits: Hits, board: np.ndarray) -> object:
    """By way of single board poses, whose mirror both stations decide."""
    given = tuple(well_posed(reconstruct(hits, k, len(board)), board) for k in (0, 1))
    optics = Optics("ideal", given, (rotor_parameters(), rotor_parameters()), "optical")
    found = agreed_paths(optics, board, 1, None)
    R, t_m = found.pose or (None, None)
    return {"paths": found.paths, "R": R, "t_m": t_m}


def second(name: str, folder: Path | None = None) -> Flat:
    made = planes_scene.made(2, 4, 1.5, **SECOND[name])
    found = joint(made.scene)[0]
    of = details_of(made.scene, found, {"": usable_hits(made.scene, found)})
    return dict(flat({"state": found.state._asdict(), "S": found.covariance, "of": of}))


CASES: dict[str, Callable[..., Flat]] = {
    **{f"estimate, {name}": partial(first, name) for name in FIRST},
    **{f"estimate, {name}": partial(second, name) for name in SECOND},
}
