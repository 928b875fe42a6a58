"""Errors of Lighthouse poses, in mm and degrees, and how often ellipsoids hold."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import chi2

from mocap_metrology.calibration.sweeps import write_board
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.batch.estimate import Joint
from mocap_metrology.lighthouse.calibrate.jansen import CalibrationSettings, calibrate
from mocap_metrology.lighthouse.decode.chain import Decoded, decode
from mocap_metrology.lighthouse.decode.clean import clean_hits
from mocap_metrology.lighthouse.records import Factory, Hits
from mocap_metrology.lighthouse.simulate.recording import SimulatedSweeps, write_dump

UNITS = np.r_[np.full(3, 1e3), np.full(3, 180 / np.pi)]  # of metres and radians


def error(R: np.ndarray, t_m: np.ndarray, true_R: np.ndarray, true_t_m: np.ndarray) -> np.ndarray:
    """(6,) mm, then deg."""
    return np.r_[t_m - true_t_m, rotation.error(R, true_R)] * UNITS


def off(made: SimulatedSweeps, estimate: Any) -> np.ndarray:
    """(6,) error of a pose of the slave."""
    return error(estimate.R, estimate.t_m, made.truth.R, made.truth.t_optical_m)


def off_joint(made: SimulatedSweeps, found: Joint) -> np.ndarray:
    """(6,) of a joint estimate."""
    return error(found.state.R[1], found.state.t_m[1], made.truth.R, made.truth.t_optical_m)


def lengths(errors: np.ndarray) -> tuple[float, float]:
    """mm and deg."""
    return float(np.linalg.norm(errors[:3])), float(np.linalg.norm(errors[3:]))


def mahalanobis(errors: np.ndarray, covariance: np.ndarray) -> float:
    """Squared error over its covariance, six degrees of freedom."""
    return float(errors @ np.linalg.solve(covariance, errors))


def held(squares: object) -> list[float]:
    """% of squared errors over their covariance inside of the ellipsoids of 68 and 95 %."""
    return [100 * float(np.mean(np.array(squares) < chi2.ppf(p, 6))) for p in (0.68, 0.95)]


def with_zeros(hits: Hits, rng: np.random.Generator, sd_rad: float, stations: int = 2) -> Hits:
    """With a time zero of each station and axis from its prior."""
    zeros = sd_rad * rng.normal(size=(stations, 2))
    return replace(hits, angle_rad=hits.angle_rad + zeros[hits.station, hits.axis])


def factories(made: SimulatedSweeps) -> list[Factory]:
    return [station.factory for station in made.truth.stations]


def calibrated(made: SimulatedSweeps, board: np.ndarray | None = None, **settings: Any) -> Any:
    """With factory values, by cleaned hits."""
    board = made.truth.board if board is None else board
    asked = CalibrationSettings(optics=("factory",), **settings)
    return calibrate(clean_hits(made.hits, board)[0], board, factories(made), asked)


def decoded(made: SimulatedSweeps, board: np.ndarray, folder: Path | str) -> Decoded:
    """The recording by way of a dump."""
    dump, file = Path(folder) / "dump", Path(folder) / "board.csv"
    write_dump(dump, made.pulses)
    write_board(file, board)
    return decode(dump, "gpio-dump", file)
