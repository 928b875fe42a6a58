"""Figures of one recording: Allan deviation, trajectory with replaced samples, spectrum."""

from step import step

with step(snakemake):
    from pathlib import Path

    from mocap_metrology.pipeline.figures import draw_allan, draw_psd, draw_trajectory
    from mocap_metrology.pipeline.tables import Table

    files, folder = snakemake.input, Path(snakemake.output[0]).parent
    draw_allan(Table.read(files.allan), folder / "adev")
    draw_psd(Table.read(files.psd), folder / "psd")
    draw_trajectory(Table.read(files.raw), Table.read(files.clean), folder / "trajectory")
