"""clean.parquet -> allan.parquet: Allan deviations of series cleaned as in S, with intervals."""

from step import step

with step(snakemake):
    from mocap_metrology.common.files import read_metadata, read_series
    from mocap_metrology.pipeline.recording import allan_deviations
    from mocap_metrology.pipeline.settings import Allan

    path, settings = snakemake.input[0], Allan(**snakemake.params.allan)
    found = allan_deviations(read_series(path), read_metadata(path), settings)
    found.write(snakemake.output[0])
