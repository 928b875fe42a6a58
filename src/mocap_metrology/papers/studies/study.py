"""The studies of J's claims: which circumstance varies, by which approaches recordings are
calibrated, and the errors of all of them.

    reconstruction  speed of the board, by the three ways of J IV
    pattern         motion pattern
    distance        board to both stations; Kabsch with and without J's weights
    baseline        station to station
    diodes          number of diodes on the same board
    lasers          distance of the lasers from the middle of their station, at several distances
                    of the board: a common centre against the real places

A case sets one circumstance; the others are those of the base case: board of 32 diodes, flat, 3 m
from both stations, which are 2 m apart; moved by hand at up to 0.4 m/s. Drawn for each recording,
as J VII varies them: direction of the board, side and orientation of the slave, extent and wobble
of the motion, start and clock.

Noise is that of real sweeps at 2 MHz: 53 urad in common to the hits of a sweep, 49 urad of each hit
(30 of its own and 38 of quantisation). Rotors are ideal but for the places of their lasers.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.types import Floats, Row
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.calibrate.jansen import CalibrationSettings, calibrate
from mocap_metrology.lighthouse.calibrate.pnp import opencv_is_missing
from mocap_metrology.lighthouse.calibrate.reconstruction import METHODS
from mocap_metrology.lighthouse.calibrate.stages import INTERPOLATIONS, PEERS, Calibration
from mocap_metrology.lighthouse.calibrate.superpose import at_times, kabsch
from mocap_metrology.lighthouse.records import Factory, Hits
from mocap_metrology.lighthouse.rotation import from_angles
from mocap_metrology.lighthouse.simulate.recording import simulate
from mocap_metrology.lighthouse.simulate.twin import LighthouseTwin, MotionTwin, StationTwin

COMMON_URAD, HIT_URAD = 53.0, 49.0
DROPOUT = 0.05
SWAY_M = 0.04  # of a line, arc or circle drawn by hand
TREMOR_MM, TREMOR_DEG = 0.05, 0.014


@dataclass(frozen=True)
class Case:
    """Circumstances of a recording. distance_m: of the board from both stations; laser_offset_mm:
    of each laser from the middle of its station, in a direction drawn for each."""

    distance_m: float = 3.0
    baseline_m: float = 2.0
    speed_m_s: float = 0.4
    pattern: str = "hand"
    n_diodes: int = 32
    laser_offset_mm: float = 0.0


@dataclass(frozen=True)
class Drawn:
    """A simulated recording and its truth: R, t between the origins of the optics; lasers_m
    (station, axis, 3) and origins_m (station, 3) of the optics in the housings."""

    hits: Hits
    board: Floats
    R: Floats
    t_optical_m: Floats
    lasers_m: Floats
    origins_m: Floats


def draw(case: Case, duration_s: float, rng: np.random.Generator) -> Drawn:
    """A recording of these circumstances."""
    simulation = simulate(twin_of(case, duration_s, rng))
    truth, stations = simulation.truth, simulation.twin.stations
    assert truth.R is not None and truth.t_optical_m is not None
    hits, board = of_diodes(simulation.hits, truth.board, spread_out(truth.board, case.n_diodes))
    return Drawn(
        hits,
        board,
        truth.R,
        truth.t_optical_m,
        np.array([station.lasers_m for station in stations]),
        np.array([station.optical_origin for station in stations]),
    )


def twin_of(case: Case, duration_s: float, rng: np.random.Generator) -> LighthouseTwin:
    """The recording with all its parameters."""
    centre, place, angles = _scene(case, rng)
    motion = MotionTwin(
        pattern=case.pattern,
        centre_m=_point(centre),
        speed_m_s=case.speed_m_s,
        extent_m=rng.uniform(0.2, 0.5),
        sway_m=SWAY_M,
        wobble_deg=rng.uniform(6, 14),
        tremor_mm=TREMOR_MM,
        tremor_deg=TREMOR_DEG,
    )
    lasers = rng.normal(size=(2, 2, 3))
    lasers *= 1e-3 * case.laser_offset_mm / np.linalg.norm(lasers, axis=2, keepdims=True)
    master, slave = ((_point(first), _point(second)) for first, second in lasers)
    return LighthouseTwin(
        seed=int(rng.integers(2**31)),
        master=StationTwin(id=1, mode="b", lasers_m=master),
        slave=StationTwin(
            id=2, mode="c", position_m=_point(place), rotation_deg=_point(angles), lasers_m=slave
        ),
        motion=motion,
        duration_s=duration_s,
        start_cycle=rng.uniform(0, 4),
        clock_ppm=rng.normal(0, 20),
        common_urad=COMMON_URAD,
        independent_urad=HIT_URAD,
        dropout=DROPOUT,
    )


def _scene(case: Case, rng: np.random.Generator) -> tuple[Floats, Floats, Floats]:
    """Centre of the board, place and angles (deg) of the slave: an isosceles triangle with the
    board at its tip, about level, before the master."""
    azimuth, elevation, level = np.radians(rng.uniform([-15, -10, -20], [15, 10, 20]))
    R = from_angles(level, -elevation, azimuth)
    at_board = 2 * math.asin(case.baseline_m / (2 * case.distance_m))
    side = rng.choice([-1, 1])
    centre = case.distance_m * R[:, 0]
    place = centre - case.distance_m * (
        math.cos(at_board) * R[:, 0] + side * math.sin(at_board) * R[:, 1]
    )
    way = (centre - place) / case.distance_m
    yaw, pitch = np.degrees([math.atan2(way[1], way[0]), -math.asin(way[2])])
    return centre, place, np.array([0, pitch, yaw]) + rng.uniform([-26, -10, -10], [26, 10, 10])


def _point(values: Floats) -> tuple[float, float, float]:
    x, y, z = values.tolist()
    return x, y, z


def spread_out(board: Floats, count: int) -> np.ndarray:
    """`count` diodes of a board (n, 3) by index, from the first on: each the one that is farthest
    from those before it, so that few diodes still span the board."""
    chosen = [0]
    distance = np.linalg.norm(board - board[0], axis=1)
    while len(chosen) < min(count, len(board)):
        chosen.append(int(distance.argmax()))
        distance = np.minimum(distance, np.linalg.norm(board - board[chosen[-1]], axis=1))
    return np.sort(chosen)


def of_diodes(hits: Hits, board: Floats, chosen: np.ndarray) -> tuple[Hits, Floats]:
    """Hits and places of some diodes, numbered anew."""
    number = np.full(len(board), -1, dtype=hits.diode.dtype)
    number[chosen] = np.arange(len(chosen))
    seen = hits.take(number[hits.diode] >= 0)
    seen.diode[:] = number[seen.diode]
    return seen, board[chosen]


# ---- Errors of every method on one recording, between the optical frames of the stations

STAGES = {"batch": ("final",)} | dict.fromkeys(PEERS, ("kabsch",))
BOTH = ("kabsch", "final")
WEIGHTED, UNWEIGHTED = "weighted", "unweighted"


@dataclass(frozen=True)
class Approach:
    """One way to calibrate, by some estimators. variant: its name in tables; lasers: `real`
    places are named, are a `common` centre, or their depths are `estimated` (by batch)."""

    estimators: tuple[str, ...]
    variant: str = ""
    reconstruction: str = "full-interpolation"
    interpolation: str = "cubic"
    lasers: str = "common"
    unweighted: bool = False

    def available(self) -> Approach:
        """Without `pnp` where OpenCV is not installed."""
        missing = ("pnp",) if opencv_is_missing() else ()
        return replace(self, estimators=tuple(e for e in self.estimators if e not in missing))


@dataclass(frozen=True)
class Error:
    """Error of the pose of the slave by a method: mm and deg, infinite where there is no pose, and
    the reason; mirrored: share of board poses in the other minimum (NaN: unknown)."""

    estimator: str
    stage: str
    variant: str
    error_mm: float = math.inf
    error_deg: float = math.inf
    mirrored: float = math.nan
    why: str = ""


def errors_of(approach: Approach, drawn: Drawn) -> list[Error]:
    """Errors of each estimator and stage of an approach."""
    estimated = approach.lasers == "estimated"
    settings = CalibrationSettings(
        estimators=approach.estimators,
        optics=("factory",) if estimated else ("ideal",),
        reconstruction=approach.reconstruction,
        lm_interpolation=approach.interpolation,
        lasers_m=drawn.lasers_m if approach.lasers == "real" else None,
    )
    factories = (Factory(), Factory()) if estimated else (None, None)
    why = ""
    try:
        calibration = calibrate(drawn.hits, drawn.board, factories, settings)
    except Refusal as refusal:
        calibration, why = Calibration(), str(refusal)
    why = why or "; ".join(calibration.why) or "no pose"
    errors = []
    for estimator in approach.estimators:
        for stage in STAGES.get(estimator, BOTH):
            kind = estimator, stage
            pose = next((e for e in calibration.estimates if (e.estimator, e.stage) == kind), None)
            name = *kind, approach.variant
            if pose is None or not np.isfinite(pose.t_m).all():
                errors.append(Error(*name, why=why))
                continue
            size = _sizes(pose.R, pose.t_m, pose.frame, drawn)
            errors.append(Error(*name, *size, mirrored=pose.mirrored_share))
    return errors + (_unweighted(approach, calibration, drawn) if approach.unweighted else [])


def _unweighted(approach: Approach, calibration: Calibration, drawn: Drawn) -> list[Error]:
    """Stage `kabsch` of the same paths with equal weights."""
    errors = []
    for estimator in approach.estimators:
        paths = calibration.paths.get((estimator, "ideal"))
        if estimator == "batch":
            continue
        if paths is None:
            errors.append(Error(estimator, "kabsch", UNWEIGHTED, why="no paths"))
            continue
        master, slave = paths
        order = INTERPOLATIONS[approach.interpolation] if estimator == "paper-lm" else 1
        then, inside = at_times(slave, master.time_s, order)
        R, t_m = kabsch(then.t_m, master.take(inside).t_m)
        errors.append(Error(estimator, "kabsch", UNWEIGHTED, *_sizes(R, t_m, "optical", drawn)))
    return errors


def _sizes(R: Floats, t_m: Floats, frame: str, drawn: Drawn) -> tuple[float, float]:
    """Lengths of the errors of position (mm) and rotation (deg)."""
    if frame == "housing":
        master, slave = drawn.origins_m
        t_m = t_m + R @ slave - master
    turn = np.linalg.norm(rotation.error(R, drawn.R))
    return 1e3 * float(np.linalg.norm(t_m - drawn.t_optical_m)), math.degrees(turn)


# ---- Studies

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
