"""A simulated calibration as files that a lab could have."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from mocap_metrology.calibration.files import write_board
from mocap_metrology.common.files import write_json
from mocap_metrology.io.c3d.write import write_c3d
from mocap_metrology.lighthouse.batch.problem import Priors
from mocap_metrology.lighthouse.calibrate.batch import Scene, Sensors, by_batch
from mocap_metrology.lighthouse.decode.chain import Decoded
from mocap_metrology.lighthouse.simulate.inertial import sensed
from mocap_metrology.lighthouse.simulate.mocap import simulate_mounts, write_mounts
from mocap_metrology.lighthouse.simulate.motion import motion_of
from mocap_metrology.lighthouse.simulate.recording import (
    SENSORS,
    simulate,
    truth_json,
    up_of,
    write_dump,
)
from mocap_metrology.lighthouse.simulate.twin import (
    BoardTwin,
    InertialTwin,
    LighthouseTwin,
    MotionTwin,
    StationTwin,
)


def write_twin(twin: LighthouseTwin, seed: int, files: Mapping[str, str]) -> str:
    """Simulate a Lighthouse twin; write it as a dump, with what a lab would have beside it.

    `files` are named dump, twin_board, truth, reference, mount. Returns what was made, in words.
    """
    seed += twin.seed
    made = simulate(twin, seed)
    seen = simulate_mounts(twin, seed)
    frames = np.moveaxis(seen.positions_mm, 2, 0).astype(np.float32)
    write_c3d(files["reference"], seen.labels, seen.rate_hz, [frames], len(frames))
    write_mounts(files["mount"], seen.mounts)
    write_board(files["twin_board"], made.truth.board)
    write_json(files["truth"], truth_json(made))
    write_dump(files["dump"], made.pulses)
    return f"{made.pulses.start_s.size} pulses in {twin.duration_s:g} s"


def with_sensors(found: Decoded, twin: LighthouseTwin, seed: int) -> Decoded:
    """The decoded dump of a twin with its gyroscope and accelerometer, of which a dump has none."""
    if twin.inertial is None or found.pulses is None:
        return found
    seed += twin.seed
    motion = motion_of(twin.motion, np.array([one.t for one in twin.stations]), seed)
    rng = np.random.default_rng([seed, SENSORS])
    series = sensed(motion, up_of(twin), twin.inertial, twin.duration_s, rng)
    return replace(found, pulses=replace(found.pulses, inertial=series))


def warm_up() -> None:
    """Compile the kernels of `batch` and of the sensors, with what a calibration gives them."""
    stations = StationTwin(id=1, mode="b"), StationTwin(id=2, mode="c", position_m=(0.0, 1.0, 0.0))
    motion = MotionTwin(centre_m=(3.0, 0.5, 0.0))
    twin = LighthouseTwin(
        seed=0,
        master=stations[0],
        slave=stations[1],
        motion=motion,
        inertial=InertialTwin(),
        board=BoardTwin(columns=3, rows=2),
        duration_s=0.6,
        independent_urad=50.0,
    )
    made = simulate(twin)
    rng = np.random.default_rng(0)
    series = sensed(made.truth.motion, up_of(twin), InertialTwin(), twin.duration_s, rng)
    how = "ideal", [None, None], None, "crazyflie", Priors()
    by_batch(Scene(made.hits, made.truth.board, *how, sensors=Sensors(series)))
