"""A simulated calibration as files that a lab could have."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mocap_metrology.common.files import write_json
from mocap_metrology.io.c3d.write import write_c3d
from mocap_metrology.lighthouse.simulate.mocap import simulate_mounts, write_mounts
from mocap_metrology.lighthouse.simulate.recording import simulate, truth_json, write_dump
from mocap_metrology.lighthouse.simulate.twin import LighthouseTwin
from mocap_metrology.pipeline.calibration_files import write_board


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
    return f"{twin.name}: {made.pulses.start_s.size} pulses in {twin.duration_s:g} s"
