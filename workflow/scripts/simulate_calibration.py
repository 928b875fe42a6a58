"""Simulate a Lighthouse twin; write it as a dump, with what a lab would have beside it."""

from step import step

with step(snakemake) as log:
    import numpy as np

    from mocap_metrology.c3d import write_c3d
    from mocap_metrology.common.files import write_csv, write_json
    from mocap_metrology.lighthouse.simulate.mocap import simulate_mounts, write_mounts
    from mocap_metrology.lighthouse.simulate.recording import simulate, truth_json, write_dump
    from mocap_metrology.lighthouse.simulate.twin import twin_from_mapping

    twin = twin_from_mapping(snakemake.params.twin, snakemake.params.row["twin"])
    seed = twin.seed + snakemake.params.seed
    made = simulate(twin, seed)
    log.info("%s: %d pulses in %g s", twin.name, made.pulses.start_s.size, twin.duration_s)
    seen = simulate_mounts(twin, seed)
    frames = np.moveaxis(seen.positions_mm, 2, 0).astype(np.float32)
    write_c3d(snakemake.output.reference, seen.labels, seen.rate_hz, [frames], len(frames))
    write_mounts(snakemake.output.mount, seen.mounts)
    board = [dict(zip(("x_m", "y_m", "z_m"), row, strict=True)) for row in made.truth.board]
    write_csv(snakemake.output.board, board)
    write_json(snakemake.output.truth, truth_json(made))
    write_dump(snakemake.output.dump, made)
