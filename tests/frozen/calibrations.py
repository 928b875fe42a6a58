"""Calibrations of both generations, of every format, estimator and fault."""

import csv
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from mocap_workflow.calibration_twins import calibration_twin

from mocap_metrology.calibration.pose import pose, simulate
from mocap_metrology.calibration.sweeps import Entry, sweeps
from mocap_metrology.common.entries import load_twins
from mocap_metrology.lighthouse.simulate import recording, turns
from mocap_metrology.lighthouse.simulate.twin import LighthouseTwin
from mocap_metrology.settings import Allan, Lighthouse

from .digest import Flat, of_folder

ROOT = Path(__file__).resolve().parents[2]
LIGHT = Lighthouse(estimators=("batch", "paper-lm"))


def twin(name: str, **changes: Any) -> LighthouseTwin:
    made = calibration_twin(load_twins(str(ROOT / "config/twins.yaml")), name)
    return made.model_copy(update=changes)


def first_generation(
    name: str,
    folder: Path,
    settings: Lighthouse = LIGHT,
    seed: int = 7,
    allan: Allan | None = None,
    entry: Entry | None = None,
    **changes: Any,
) -> Flat:
    made = twin(name, **changes)
    row = entry or Entry(name, f"simulate:{name}", twin=name)
    simulate(row, made, seed, {}, settings, allan, folder)
    return of_folder(folder)


def still(folder: Path) -> Flat:
    """At rest, with the noise of the angles and the static estimators."""
    motion = twin("real-2-1").motion.model_copy(update={"pattern": "static"})
    settings = Lighthouse(estimators=("batch", "paper-lm", "geometric"))
    own = {"motion": motion, "duration_s": 4.0}
    return first_generation("real-2-1", folder, settings, allan=Allan(), **own)


def as_angles(folder: Path) -> Flat:
    """What a user's own decoder writes, without factory values, with a known length."""
    made = recording.simulate(twin("sim-3-1", duration_s=3.0), seed=5)
    names = ("station", "axis", "cycle", "diode", "time_s", "angle_rad")
    columns = [getattr(made.hits, name).tolist() for name in names]
    table(folder / "angles.csv", names, zip(*columns, strict=True))
    table(folder / "board.csv", ("x_m", "y_m", "z_m"), made.truth.board.tolist())
    entry = Entry("angles", str(folder / "angles.csv"), "angles-csv")
    length = float(np.linalg.norm(made.truth.t_m))
    entry = replace(entry, known_length=f"stations {length:.4f} 0.005")
    given = {"dump": str(folder / "angles.csv"), "board": str(folder / "board.csv")}
    return both(entry, given, LIGHT, folder / "results")


def table(path: Path, header: Any, rows: Any) -> None:
    with path.open("w", newline="", encoding="utf-8") as stream:
        csv.writer(stream).writerows([header, *rows])


def both(entry: Entry, given: dict[str, str], settings: Lighthouse, folder: Path) -> Flat:
    """Both steps."""
    folder.mkdir(exist_ok=True)
    check = sweeps(entry, given, settings, folder)
    assert check["ok"], check
    pose(entry, given, settings, None, folder)
    return of_folder(folder)


def second_generation(n: int, folder: Path, seconds: float = 3.0, **faults: Any) -> Flat:
    rng = np.random.default_rng([n, 3])
    R, t, middle, up = turns.stations_around(n, rng)
    how = {"centre_m": tuple(middle), "speed_m_s": 0.5, "extent_m": 0.4}
    motion = twin("sim-1-1").motion.model_copy(update=how)
    channels = tuple(range(0, 3 * n, 3))
    board, normals = turns.ball_board(24)
    own = {"board": board, "normals": normals, "up": up, "duration_s": seconds} | faults
    made = turns.simulate_turns(turns.TurnsTwin(11, R, t, channels, motion, **own))
    path = folder / "turns.rec.gz"
    turns.write_rec(path, made)
    entry = Entry("turns", str(path), "libsurvive-rec", "T20")
    return both(entry, {"dump": str(path)}, LIGHT, folder / "results")


EVERY = Lighthouse(
    estimators=("batch", "paper", "paper-tight", "paper-lm", "geometric"),
    optics=("ideal", "factory"),
)
CASES = {
    "every estimator": partial(first_generation, "sim-1-1", settings=EVERY, duration_s=1.5),
    "pairs of sweeps": partial(first_generation, "sim-2-1",
                               settings=Lighthouse(reconstruction="pairs",
                                                   lm_interpolation="linear", lm_weights="none"),
                               duration_s=2.0),
    "factory values": partial(first_generation, "real-3-1", duration_s=4.0),
    "inertial": partial(first_generation, "real-4-1",
                        settings=Lighthouse(estimators=("batch", "paper-lm"), inertial=True),
                        duration_s=3.0),
    "still": still,
    "angles": as_angles,
    "disturbed": partial(first_generation, "real-6-2", duration_s=4.0, reflections=0.03,
                         missed_flashes=0.05, false_flashes_per_s=3.0, blocked=((1, 1.0, 1.4),),
                         sync_jitter_us=0.5),
    "whole frames": partial(second_generation, 2, seconds=10.0),
    "two stations": partial(second_generation, 2),
    "four stations": partial(second_generation, 4, cover_mm=(-0.8, 1.5), reflections=0.02),
}  # fmt: skip
