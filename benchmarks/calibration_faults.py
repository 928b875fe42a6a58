"""Verdicts of the estimator `batch` on recordings with a fault.

    python -m benchmarks.calibration_faults [setups]

A table of how often each word, the median error, and how many `good` ones err by more than five of
their standard deviations. Recordings are those of joint_calibration.py with real noise.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from benchmarks import arguments, head, line
from benchmarks.joint_calibration import lasers_apart, real, rotors
from benchmarks.poses import decoded, lengths, off
from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.assess.summary import summary
from mocap_metrology.lighthouse.calibrate.jansen import CalibrationSettings, calibrate
from mocap_metrology.lighthouse.records import Factory, Station
from mocap_metrology.lighthouse.simulate.recording import SimulatedSweeps
from mocap_metrology.lighthouse.simulate.twin import BoardTwin

SETTINGS = CalibrationSettings(estimators=("batch", "paper-lm"))
WORDS = ("good", "usable", "doubtful", "failed")
Stations = list[Station]
# A recording, the board file, and what else its reader believes of the stations.
Faulty = tuple[SimulatedSweeps, np.ndarray, Callable[[Stations], Stations]]
Fault = Callable[[int, np.random.Generator], Faulty]


def main(setups: int = 10) -> None:
    """Verdicts by fault: how often each word, and errors above five sigma among the good."""
    head("fault", "good / usable / doubtful / failed", "median mm", "good and > 5 sigma")
    for name in FAULTS:
        words, errors, sigmas = zip(*(judged(name, k) for k in range(setups)), strict=True)
        missed = sum(w == "good" and sigma > 5 for w, sigma in zip(words, sigmas, strict=True))
        count = " / ".join(str(words.count(word)) for word in WORDS)
        line(name, count, f"{np.nanmedian(errors):.1f}", missed)


def judged(name: str, setup: int) -> tuple[str, float, float]:
    """Verdict on a recording with a fault, error in mm, and the largest |error| / sigma."""
    made, board, change = FAULTS[name](setup, np.random.default_rng([14, setup, 0]))
    try:
        with tempfile.TemporaryDirectory() as folder:
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
    error = off(made, best)
    sigmas = np.abs(error) / np.sqrt(np.diag(best.covariance))
    return told.verdict.word, lengths(error)[0], float(sigmas.max())


def _fault(
    board: Callable[[np.ndarray, np.random.Generator], np.ndarray] = lambda b, _: b,
    stations: Callable[[Stations, np.random.Generator], Stations] = lambda s, _: s,
    drawn: Callable[[int], dict[str, object]] = lambda _: {},
) -> Fault:
    """Changes of the board file and of what is believed of the stations; keys of the twin."""

    def made(setup: int, rng: np.random.Generator) -> Faulty:
        one = real(setup, 0, variant="libsurvive", **drawn(setup))
        return one, board(one.truth.board, rng), lambda found: stations(list(found), rng)

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


def _bumped(setup: int, rng: np.random.Generator) -> Faulty:
    before = real(setup, 0, variant="libsurvive")
    way = rng.normal(size=3)
    place = np.array(before.twin.slave.position_m) + 0.005 * way / np.linalg.norm(way)
    twin = before.twin.slave
    slave = {"position_m": tuple(place), "factory": twin.factory, "rotation_deg": twin.rotation_deg}
    after = real(setup, 0, variant="libsurvive", slave=slave)
    at, parts = rng.uniform(2, 6), []
    for made, own in ((before, before.pulses.start_s < at), (after, after.pulses.start_s >= at)):
        parts.append({n: getattr(made.pulses, n)[own] for n in ("start_s", "length_s", "diode")})
    joined = {n: np.concatenate([part[n] for part in parts]) for n in parts[0]}
    return replace(before, pulses=replace(before.pulses, **joined)), before.truth.board, list


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
    "mirrored deep board": _fault(
        lambda b, _: b * [-1.0, 1.0, 1.0], drawn=lambda _: {"board": BoardTwin(out_of_plane_m=0.02)}
    ),
    "station bumped by 5 mm": _bumped,
    "lasers 5 mm off in depth": _fault(drawn=lasers_apart),
}


if __name__ == "__main__":
    main(**arguments(__doc__, setups=10))
