"""Verdicts of the estimator `batch` on recordings with a fault.

    python benchmarks/calibration_faults.py [--generation 2] [--setups 10] [--only bumped]

A table of how often each word, the median error, and how many `good` ones err by more than five of
their standard deviations. Recordings are those of joint_calibration.py with real noise; of the
second generation those of tests/lighthouse/batch/planes_scene.py: three stations, 10 s, 32 diodes
0.2 mm off, under covers, seen 0.07 mm aside by the direction of the light.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from benchmarks.joint_calibration import UNITS, decoded, lasers_apart, real, rotors
from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.assess.summary import summary
from mocap_metrology.lighthouse.batch.problem import Priors
from mocap_metrology.lighthouse.calibrate.jansen import CalibrationSettings, calibrate
from mocap_metrology.lighthouse.calibrate.scene import Scene
from mocap_metrology.lighthouse.records import Factory, Hits, Station
from mocap_metrology.lighthouse.simulate.recording import SimulatedSweeps
from mocap_metrology.lighthouse.simulate.twin import BoardTwin
from tests.lighthouse.batch.planes_scene import Made as MadeOfTurns
from tests.lighthouse.batch.planes_scene import factory as another
from tests.lighthouse.batch.planes_scene import made as made_of_turns

SETTINGS = CalibrationSettings(estimators=("batch", "paper-lm"))
WORDS = ("good", "usable", "doubtful", "failed")
Stations = list[Station]
# A recording, the board file, and what else its reader believes of the stations.
Faulty = tuple[SimulatedSweeps, np.ndarray, Callable[[Stations], Stations]]
Fault = Callable[[int, int, np.random.Generator], Faulty]
Turned = Callable[[Scene, int, int, np.random.Generator], Scene]
TURNS_S = 10.0  # of a recording of the second generation


def faults(generation: int, setups: int, recordings: int, only: str) -> None:
    """Verdicts by fault: how often each word, and errors above five sigma among the good."""
    judge = judged if generation == 1 else judged_turns
    print("| fault | good / usable / doubtful / failed | median mm | good and > 5 sigma |")
    print("|---" * 4 + "|")
    for name in FAULTS if generation == 1 else OF_TURNS:
        if only not in name:
            continue
        words, errors, missed = [], [], 0
        for setup in range(setups):
            for recording in range(recordings):
                with tempfile.TemporaryDirectory() as folder:
                    word, mm, sigmas = judge(name, setup, recording, Path(folder))
                words.append(word)
                errors.append(mm)
                missed += word == "good" and sigmas > 5
        count = " / ".join(str(words.count(word)) for word in WORDS)
        print(f"| {name} | {count} | {np.nanmedian(errors):.1f} | {missed} |", flush=True)


def judged(name: str, setup: int, recording: int, folder: Path) -> tuple[str, float, float]:
    """Verdict on a recording with a fault, error in mm, and the largest |error| / sigma."""
    rng = np.random.default_rng([14, setup, recording])
    made, board, change = FAULTS[name](setup, recording, rng)
    try:
        recorded = decoded(made, board, folder)
        listed = change(recorded.stations)
        factories = [station.factory for station in listed]
        found = calibrate(recorded.hits, recorded.board, factories, SETTINGS)
    except Refusal:
        return "failed", np.nan, np.nan
    told = summary(
        found, listed, duration_s=recorded.duration_s, resolution_s=5e-7, notes=recorded.notes
    )
    index = told.document["chosen"]
    if index is None:
        return "failed", np.nan, np.nan
    best = found.estimates[index]
    error = np.r_[best.t_m - made.truth.t_optical_m, rotation.error(best.R, made.truth.R)] * UNITS
    sigma = np.sqrt(np.diag(best.covariance))
    return told.verdict.word, float(np.linalg.norm(error[:3])), float(np.abs(error / sigma).max())


def _fault(
    board: Callable[[np.ndarray, np.random.Generator], np.ndarray] = lambda b, _: b,
    stations: Callable[[Stations, np.random.Generator], Stations] = lambda s, _: s,
    **more: object,
) -> Fault:
    def made(setup: int, recording: int, rng: np.random.Generator) -> Faulty:
        own = real(setup, recording, variant="libsurvive", **more)
        return own, board(own.truth.board, rng), lambda found: stations(list(found), rng)

    return made


def _exchanged(board: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    pair = rng.choice(len(board), 2, replace=False)
    board = board.copy()
    board[pair] = board[pair[::-1]]
    return board


def _phase(stations: Stations, rng: np.random.Generator) -> Stations:
    phase = stations[0].factory.phase.copy()
    phase[rng.integers(2)] += 1e-3 * rng.choice([-1, 1])
    return [replace(stations[0], factory=replace(stations[0].factory, phase=phase)), stations[1]]


def _swapped(stations: Stations, _: np.random.Generator) -> Stations:
    master, slave = stations
    return [replace(master, factory=slave.factory), replace(slave, factory=master.factory)]


def _ideal(stations: Stations, _: np.random.Generator) -> Stations:
    return [replace(station, factory=Factory()) for station in stations]


def _bumped(setup: int, recording: int, rng: np.random.Generator) -> Faulty:
    before = real(setup, recording, variant="libsurvive")
    way = rng.normal(size=3)
    place = np.array(before.twin.slave.position_m) + 0.005 * way / np.linalg.norm(way)
    twin = before.twin.slave
    slave = {"position_m": tuple(place), "factory": twin.factory, "rotation_deg": twin.rotation_deg}
    after = real(setup, recording, variant="libsurvive", slave=slave)
    at, parts = rng.uniform(2, 6), []
    for made, own in ((before, before.pulses.start_s < at), (after, after.pulses.start_s >= at)):
        parts.append({n: getattr(made.pulses, n)[own] for n in ("start_s", "length_s", "diode")})
    joined = {n: np.concatenate([part[n] for part in parts]) for n in parts[0]}
    return replace(before, pulses=replace(before.pulses, **joined)), before.truth.board, list


def _depth(setup: int, recording: int, _: np.random.Generator) -> Faulty:
    made = real(setup, recording, variant="libsurvive", **lasers_apart(setup))
    return made, made.truth.board, list


def _mirrored(setup: int, recording: int, _: np.random.Generator) -> Faulty:
    made = real(setup, recording, variant="libsurvive", board=BoardTwin(out_of_plane_m=0.02))
    return made, made.truth.board * np.array([-1.0, 1.0, 1.0]), list


FAULTS: dict[str, Fault] = {
    "none": _fault(),
    "ideal optics on imperfect rotors": _fault(stations=_ideal),
    "one phase off by 1 mrad": _fault(stations=_phase),
    "factory values of the stations swapped": _fault(stations=_swapped),
    "factory values of another station": _fault(
        stations=lambda s, rng: [s[0], replace(s[1], factory=rotors(rng))]
    ),
    "board scaled by 0.3 %": _fault(lambda b, _: 1.003 * b),
    "diodes off by 0.3 mm": _fault(lambda b, rng: b + 3e-4 * rng.normal(size=b.shape)),
    "diodes off by 1 mm": _fault(lambda b, rng: b + 1e-3 * rng.normal(size=b.shape)),
    "two diodes exchanged": _fault(_exchanged),
    "mirrored deep board": _mirrored,
    "station bumped by 5 mm": _bumped,
    "lasers 5 mm off in depth": _depth,
}


def judged_turns(name: str, setup: int, recording: int, _: Path) -> tuple[str, float, float]:
    """As `judged`, of stations of the second generation; the station with the largest error."""
    rng = np.random.default_rng([15, setup, recording])
    more, change = OF_TURNS[name]
    made = of_turns(setup, recording, **more)
    scene = change(made.scene, setup, recording, rng)
    listed = [
        Station(role, id=k, factory=own, frames_found=1, generation=2)
        for k, (role, own) in enumerate(zip(scene.names, scene.factories, strict=True))
    ]
    try:
        how = scene.hits, scene.board, scene.factories, CalibrationSettings()
        found = calibrate(*how, sensors=scene.sensors, stations=listed)
    except Refusal:
        return "failed", np.nan, np.nan
    told = summary(found, listed, duration_s=TURNS_S, resolution_s=None, notes=[])
    off = np.array(
        [
            np.r_[best.t_m - t, rotation.error(best.R, R)] * UNITS
            for best, (R, t) in zip(found.estimates, made.poses[1:], strict=True)
        ]
    )
    sigma = [np.sqrt(np.diag(best.covariance)) for best in found.estimates]
    far = float(np.linalg.norm(off[:, :3], axis=1).max())
    return told.verdict.word, far, float(np.abs(off / sigma).max())


def of_turns(setup: int, recording: int, **more: object) -> MadeOfTurns:
    """A recording of the second generation."""
    usual = {"place_mm": 0.2, "cover": (-0.75e-3, 1.55e-3), "slow_mm": 0.07, "wrong": 0.005}
    return made_of_turns(3, setup, TURNS_S, take=recording, priors=Priors(), **usual | more)


def _with_factories(
    change: Callable[[list[Factory], np.random.Generator], list[Factory]],
) -> Turned:
    return lambda scene, setup, recording, rng: replace(
        scene, factories=change(list(scene.factories), rng)
    )


def _with_board(change: Callable[[np.ndarray, np.random.Generator], np.ndarray]) -> Turned:
    return lambda scene, setup, recording, rng: replace(scene, board=change(scene.board, rng))


def _moved(scene: Scene, setup: int, recording: int, _: np.random.Generator) -> Scene:
    later = of_turns(setup, recording, bump_mm=8.0).scene.hits
    parts = [
        own.take((own.time_s >= TURNS_S / 2) == k) for k, own in enumerate((scene.hits, later))
    ]
    names = Hits.__dataclass_fields__
    return replace(
        scene, hits=Hits(*(np.concatenate([getattr(p, n) for p in parts]) for n in names))
    )


OF_TURNS: dict[str, tuple[dict[str, object], Turned]] = {
    "none": ({}, lambda scene, *_: scene),
    "factory values of another station": (
        {},
        _with_factories(lambda own, rng: [*own[:-1], another(rng)]),
    ),
    "factory values of two stations swapped": ({}, _with_factories(lambda own, _: own[::-1])),
    "board scaled by 1 %": ({}, _with_board(lambda board, _: 1.01 * board)),
    "diodes off by 1 mm": ({}, _with_board(lambda b, rng: b + 1e-3 * rng.normal(size=b.shape))),
    "two diodes exchanged": ({}, _with_board(_exchanged)),
    "5 % reflections": ({"wrong": 0.05}, lambda scene, *_: scene),
    "station bumped by 8 mm": ({}, _moved),
    "one station lost midway": ({"keep": [(0, 1), (0, 1), (0, 0.5)]}, lambda scene, *_: scene),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--generation", type=int, default=1, choices=(1, 2))
    parser.add_argument("--setups", type=int, default=10)
    parser.add_argument("--recordings", type=int, default=1, help="of each setup")
    parser.add_argument("--only", default="", help="faults whose names contain this")
    given = parser.parse_args()
    faults(given.generation, given.setups, given.recordings, given.only)


if __name__ == "__main__":
    main()
