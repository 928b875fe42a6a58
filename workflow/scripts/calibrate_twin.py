"""Simulate a Lighthouse twin as a dump; decode and calibrate what then lies on the disk."""

from step import step

with step(snakemake) as log:
    from lighthouse_steps import write_decoded, write_poses, write_twin

    row, config = snakemake.params.row, snakemake.params.lighthouse
    (twin,) = snakemake.params.twin.values()
    files = dict(snakemake.output.items())
    log.info("%s", write_twin(twin, snakemake.params.seed, files))
    dump = {"dump": files["dump"], "board": files["twin_board"]}
    write_decoded(row, config, dump, files, log)
    against = dict(snakemake.input.items())
    if "reference" not in against:
        mocap = twin.reference == "mocap"
        against["reference"] = files["reference" if mocap else "truth"]
        against["mount"] = files["mount"] if mocap else None
    made = {name: files[name] for name in ("sweeps", "stations", "board", "truth")}
    write_poses(row, config, made | against, files, log)
