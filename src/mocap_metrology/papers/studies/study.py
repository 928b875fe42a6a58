"""The studies of J's claims: which circumstance varies, by which approaches recordings are
calibrated, and the errors of all of them.

    reconstruction  speed of the board, by the three ways of J IV
    pattern         motion pattern
    distance        board to both stations; Kabsch with and without J's weights
    baseline        station to station
    diodes          number of diodes on the same board
    lasers          distance of the lasers from the middle of their station, at several distances
                    of the board: a common centre against the real places
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mocap_metrology.common.types import Row
from mocap_metrology.lighthouse.calibrate.reconstruction import METHODS
from mocap_metrology.papers.studies.cases import Case, draw
from mocap_metrology.papers.studies.errors import WEIGHTED, Approach, errors_of

ALL = ("paper", "paper-lm", "batch")
LASER_BASELINE_M = 1.0  # boards are as near as 1 m
BASE = Case()
COMMON, REAL, ESTIMATED = "common centre", "real places", "depths estimated"


@dataclass(frozen=True)
class Study:
    """field: of `Case`, that varies over the setting `values`; approaches: of each recording."""

    name: str
    field: str
    values: str
    approaches: tuple[Approach, ...]
    base: Case = BASE
    at: str = ""  # setting with distances of the board: the study is made at each

    def cases(self, settings: Mapping[str, Any]) -> Iterator[Case]:
        """The cases of each point of the study."""
        for distance in settings[self.at] if self.at else [self.base.distance_m]:
            base = replace(self.base, distance_m=distance)
            for value in settings[self.values]:
                yield replace(base, **{self.field: value})


STUDIES = {
    study.name: study
    for study in (
        Study(
            "reconstruction",
            "speed_m_s",
            "speeds_m_s",
            (
                *(Approach(("paper", "paper-lm"), way, way, "linear") for way in METHODS),
                Approach(("batch",), "all hits", interpolation="linear"),
            ),
        ),
        Study("pattern", "pattern", "patterns", (Approach(ALL),)),
        Study("distance", "distance_m", "distances_m", (Approach(ALL, WEIGHTED, unweighted=True),)),
        Study("baseline", "baseline_m", "baselines_m", (Approach(ALL),)),
        Study("diodes", "n_diodes", "diodes", (Approach(ALL),)),
        Study(
            "lasers",
            "laser_offset_mm",
            "laser_offsets_mm",
            (
                Approach(("paper", "pnp", "geometric", "batch"), COMMON, interpolation="linear"),
                Approach(("paper",), REAL, interpolation="linear", lasers="real"),
                Approach(("batch",), ESTIMATED, interpolation="linear", lasers="estimated"),
            ),
            Case(baseline_m=LASER_BASELINE_M),
            "laser_distances_m",
        ),
    )
}


def recordings_of(
    name: str, settings: Mapping[str, Any], seed: int, report: Callable[[str], None]
) -> list[Row]:
    """A row for each simulated recording and method of a study.

    settings: lists of values by name, `recordings` at each point, `duration_s`. The random numbers
    of recording k at point j are those of the seed [seed, number of the study, j, k], so that
    recordings are independent.
    """
    study = STUDIES[name]
    number, approaches = list(STUDIES).index(name), [a.available() for a in study.approaches]
    rows: list[Row] = []
    for j, case in enumerate(study.cases(settings)):
        for k in range(settings["recordings"]):
            drawn = draw(case, settings["duration_s"], np.random.default_rng([seed, number, j, k]))
            errors = [error for approach in approaches for error in errors_of(approach, drawn)]
            of = {"value": getattr(case, study.field), "distance_m": case.distance_m}
            rows += [{**of, "recording": k + 1, **vars(error)} for error in errors]
        report(f"{name}: {study.field} {getattr(case, study.field)}, {case.distance_m:g} m")
    return rows
