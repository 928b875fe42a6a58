"""Simulate a twin and write it as a C3D file that a lab could have exported."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    import numpy as np

    from mocap_metrology.common.files import write_json
    from mocap_metrology.io.c3d.write import write_c3d
    from mocap_metrology.noise.twins.simulate import simulate
    from mocap_metrology.noise.twins.take import TakeTwin, simulate_take

    (twin,) = snakemake.params.twin.values()
    seed, folder = snakemake.params.seed + twin.seed, Path(snakemake.output.c3d).parent
    made = (
        simulate_take(twin, seed=seed)
        if isinstance(twin, TakeTwin)
        else simulate(twin, seed=seed, folder=folder)
    )
    n_frames = made.position_mm.shape[2]
    log.info("%s: %d frames at %g Hz", twin.name, n_frames, made.frame_rate_hz)
    chunks = (
        np.moveaxis(made.position_mm[:, :, start : start + 65_536], 2, 0).astype(np.float32)
        for start in range(0, n_frames, 65_536)
    )
    write_c3d(snakemake.output.c3d, twin.labels, made.frame_rate_hz, chunks, n_frames)
    write_json(snakemake.output.truth, made.truth)
