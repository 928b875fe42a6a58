"""A simulated recording as a C3D file that a lab could have exported."""

from __future__ import annotations

import logging
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from mocap_metrology.common.files import write_json
from mocap_metrology.io.c3d.write import write_c3d
from mocap_metrology.noise.twins.simulate import simulate
from mocap_metrology.noise.twins.take import TakeTwin, simulate_take
from mocap_metrology.noise.twins.twin import Twin

log = logging.getLogger(__name__)
CHUNK = 65_536  # frames


@contextmanager
def simulated(twin: Twin | TakeTwin, seed: int, folder: Path) -> Iterator[Path]:
    """Path of the C3D file of a twin, which is removed in the end; truth.json in `folder`."""
    with tempfile.TemporaryDirectory(dir=folder, prefix=".part-") as part:
        path = Path(part) / "twin.c3d"
        if isinstance(twin, TakeTwin):
            made = simulate_take(twin, seed=seed + twin.seed)
        else:
            made = simulate(twin, seed=seed + twin.seed, folder=folder)
        n_frames, rate = made.position_mm.shape[2], made.frame_rate_hz
        log.info("%s: %d frames at %g Hz", twin.name, n_frames, rate)
        chunks = (
            np.moveaxis(made.position_mm[:, :, start : start + CHUNK], 2, 0).astype(np.float32)
            for start in range(0, n_frames, CHUNK)
        )
        write_c3d(path, twin.labels, rate, chunks, n_frames)
        write_json(folder / "truth.json", made.truth)
        del made, chunks
        yield path
