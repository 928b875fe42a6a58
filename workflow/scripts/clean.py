"""trajectories.parquet -> clean.parquet: every series, distances included, through Hampel."""

from step import step

with step(snakemake):
    from mocap_metrology.common.files import write_csv
    from mocap_metrology.pipeline.recording import write_cleaned
    from mocap_metrology.pipeline.settings import Hampel
    from mocap_metrology.pipeline.tables import Table

    raw, settings = Table.open(snakemake.input[0]), Hampel(**snakemake.params.hampel)
    report = write_cleaned(raw, settings, snakemake.output.table)
    write_csv(snakemake.output.outliers, report)
