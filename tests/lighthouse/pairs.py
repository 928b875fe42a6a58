"""Recordings of a board before a master and a slave, with the noise of real ones, and what is
compared of them."""

from typing import Any

import numpy as np

from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.batch.problem import Priors
from mocap_metrology.lighthouse.calibrate.scene import Scene
from mocap_metrology.lighthouse.records import Hits
from mocap_metrology.lighthouse.simulate.recording import SimulatedSweeps, simulate
from mocap_metrology.lighthouse.simulate.twin import LighthouseTwin, MotionTwin, StationTwin

EXACT = Priors(0, 0, 0, 0, 0)
UNITS = np.r_[np.full(3, 1e3), np.full(3, 180 / np.pi)]  # mm and deg of m and rad
MOTION = {"centre_m": (3.0, 0.8, 0.2), "tremor_mm": 0.05, "tremor_deg": 0.014}


def twin(
    seed: int, *, master: dict | None = None, slave: dict | None = None, **more: Any
) -> LighthouseTwin:
    """Five seconds by hand; keys of the stations, of the motion and of the twin that differ."""
    place = {"id": 2, "mode": "c", "position_m": (0.5, 2.5, 0.3), "rotation_deg": (5, 4, -40)}
    given = {"duration_s": 5.0, "common_urad": 53.0, "independent_urad": 49.0, "dropout": 0.1}
    return LighthouseTwin(
        seed=seed,
        master=StationTwin(**{"id": 1, "mode": "b"} | (master or {})),
        slave=StationTwin(**place | (slave or {})),
        motion=MotionTwin(**MOTION | more.pop("motion", {})),
        **given | more,
    )


def scene(made: SimulatedSweeps, hits: Hits | None = None, priors: Priors = EXACT) -> Scene:
    hits = made.hits if hits is None else hits
    return Scene(hits, made.truth.board, "ideal", [None] * 2, None, "crazyflie", priors)


def bumped(seed: int) -> tuple[SimulatedSweeps, Hits]:
    """A recording, and its hits if the slave moved by 5 mm at 2.6 s."""
    sound = simulate(twin(seed))
    moved = simulate(twin(seed, slave={"position_m": (0.503, 2.504, 0.3)}))
    parts = sound.hits.take(sound.hits.time_s < 2.6), moved.hits.take(moved.hits.time_s >= 2.6)
    columns = {k: np.concatenate([getattr(p, k) for p in parts]) for k in Hits.__dataclass_fields__}
    return sound, Hits(**columns)


def error(R: np.ndarray, t_m: np.ndarray, R_true: np.ndarray, t_true_m: np.ndarray) -> np.ndarray:
    """Translation and left rotation vector (6,), in m and rad."""
    return np.r_[t_m - t_true_m, rotation.error(R, R_true)]


def squared(off: np.ndarray, covariance: np.ndarray) -> float:
    return float(off @ np.linalg.solve(covariance, off))
