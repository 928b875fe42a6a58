"""Pictures of one simulated calibration."""

from step import step

with step(snakemake):
    from pathlib import Path

    from mocap_metrology.calibration.figures import draw

    draw(Path(snakemake.output[0]).parent, snakemake.wildcards.calibration, snakemake.params.twin)
