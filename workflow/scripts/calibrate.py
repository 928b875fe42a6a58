"""Sweeps and stations -> board poses and pose of the slave."""

from step import step

with step(snakemake):
    from mocap_metrology.pipeline.calibration import Asked
    from mocap_metrology.pipeline.calibration_files import write_poses
    from mocap_metrology.settings import Lighthouse

    asked, settings = Asked(**snakemake.params.row), Lighthouse(**snakemake.params.lighthouse)
    write_poses(asked, settings, dict(snakemake.input.items()), dict(snakemake.output.items()))
