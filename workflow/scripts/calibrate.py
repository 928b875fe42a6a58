"""Sweeps and stations -> board poses and pose of the slave, see lighthouse_steps.write_poses."""

from step import step

with step(snakemake) as log:
    from lighthouse_steps import write_poses

    given, files = dict(snakemake.input.items()), dict(snakemake.output.items())
    write_poses(snakemake.params.row, snakemake.params.lighthouse, given, files, log)
