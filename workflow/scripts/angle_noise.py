"""sweeps.parquet, pose.json -> allan.parquet: noise of the angles of a board at rest."""

from step import step

with step(snakemake):
    from mocap_metrology.pipeline.angle_noise import of_calibration
    from mocap_metrology.settings import Allan

    given, settings = snakemake.input, Allan(**snakemake.params.allan)
    of_calibration(snakemake.output[0], given.sweeps, given.pose, settings)
