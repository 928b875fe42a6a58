"""Words of the checks of a calibration over the values that they judge: where each word begins."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from mocap_metrology.lighthouse.assess import fit_checks as checks
from mocap_metrology.lighthouse.records import Halves, PoseEstimate

from .digest import Flat

GRID = 3.3e-11 * 1.15 ** np.arange(270)  # none is a limit itself
BATCH = PoseEstimate("batch", "final", "factory", np.eye(3), np.array([2.0, 0.0, 0.0]))
PAPER = replace(BATCH, estimator="paper-lm")
Judge = Callable[[float], checks.Check]


def detail(name: str, check: Callable[[PoseEstimate], checks.Check]) -> Judge:
    return lambda value: check(replace(BATCH, details={name: value}))


def halves(chosen: PoseEstimate, stepped: bool | None, recordings: bool = False) -> Judge:
    own = replace(chosen, details={"misfit": 4.0})
    return lambda m2: checks.halves(replace(own, halves=Halves(3.0, 0.2, m2, recordings, stepped)))


def sd(chosen: PoseEstimate, mm: float, deg: float, share: float = 0.1) -> Judge:
    own = replace(chosen, details={"scale_share": share})

    def judge(value: float) -> checks.Check:
        axes = np.array([mm, 0.1 * mm, 0, 0.1 * deg, deg, 0]) * value
        return checks.uncertainty(replace(own, covariance=np.diag(axes**2)))

    return judge


def residual(stage: str, gain: float = 1.0, estimator: str = "paper-lm", **beside: Any) -> Judge:
    own = replace(BATCH, estimator=estimator, stage=stage, noise_gain=gain, **beside)
    return lambda value: checks.residual(replace(own, residual_rms_urad=value), 50.0)


JUDGES: dict[str, Judge] = {
    "distance": lambda value: checks.distance(replace(BATCH, t_m=np.array([0.0, value, 0.0]))),
    "residual of batch": residual("final", estimator="batch"),
    **{f"residual, {stage}": residual(stage) for stage in ("static", "kabsch", "final")},
    "residual of a small board": residual("final", 12.0),
    "gain of a board": lambda value: residual("final", value)(400.0),
    "residual beyond the path": lambda value: residual("final", weighted_rms_urad=value)(60.0),
    "weight": detail("weight_lost", checks.weight),
    "priors": detail("prior_p", checks.priors),
    "misfit": detail("misfit", checks.misfit),
    "weighted": lambda value: checks.weighted(replace(BATCH, weighted_rms_urad=value), 50.0),
    "halves": halves(BATCH, None),
    "halves, no step": halves(BATCH, False),
    "halves of paper-lm": halves(PAPER, True),
    "recordings": halves(BATCH, None, True),
    "mirrored": lambda value: checks.mirrored(replace(BATCH, mirrored_share=value)),
    "mirrored for both": lambda value: checks.mirrored(replace(PAPER, mirrored_share=value)),
    "common": lambda value: checks.common_measurements(PAPER, round(value)),
    "common of batch": lambda value: checks.common_measurements(BATCH, round(value)),
    "board poses": lambda value: checks.board_poses(value, 50.0),
    "board poses by places": lambda value: checks.board_poses(value, 50.0, 200.0),
    "path": lambda value: checks.path(replace(PAPER, stage="kabsch"), value),
    "mm": sd(BATCH, 1.0, 0.0),
    "deg": sd(BATCH, 0.0, 1.0),
    "mm of paper-lm": sd(PAPER, 1.0, 0.0),
    "deg of paper-lm": sd(PAPER, 0.0, 1.0),
    "mm of the far": sd(replace(BATCH, t_m=np.array([0.0, 12.0, 0.0])), 1.0, 0.0),
    "share of the scale": lambda value: sd(BATCH, 1.0, 1.0, value)(1.0),
    "duration": checks.duration,
}
ENDS = (7.98, 7.995, 8.3, 8.39, 8.41, 8.6)  # of a usual duration, finer than the grid


def words(folder: Path | None = None) -> Flat:
    found: Flat = {}
    for name, judge in JUDGES.items():
        before = ""
        for value in sorted({*GRID.tolist(), *(ENDS if name == "duration" else ())}):
            check = judge(value)
            now = f"{check.case.value} {check.level} {check.ok}"
            if now != before:
                limit = check.limit if isinstance(check.limit, tuple) else (check.limit,)
                found[f"{name} from {value:.3g}"] = [now, *limit, *check.numbers.values()]
            before = now
    places = [checks.places_urad(1e-4, r, n) for r in (1.0, 4.0) for n in (3, 4, 12)]
    noise = [checks.expected_noise_urad(r) for r in (None, 0.0, 2e-8, 5e-7)]
    return found | {"errors of places": places, "noise expected": noise}


CASES = {"words of a fit": words}
