"""Fits of the noise model to every series of one recording."""

from step import step

with step(snakemake):
    from pathlib import Path

    from mocap_metrology.recording import figures
    from mocap_metrology.recording.results import Results

    figures.draw_fits(Results(Path(snakemake.input.noise).parent), snakemake.output[0], None)
