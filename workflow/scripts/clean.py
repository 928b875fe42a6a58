"""trajectories.parquet -> clean.parquet: every series, distances included, through Hampel."""

from step import step

with step(snakemake):
    from mocap_metrology.common.files import write_csv
    from mocap_metrology.pipeline.recording import cleaned
    from mocap_metrology.pipeline.settings import Hampel
    from mocap_metrology.pipeline.tables import Table

    found = cleaned(Table.read(snakemake.input[0]), Hampel(**snakemake.params.hampel))
    found.table.write(snakemake.output.table)
    write_csv(snakemake.output.outliers, found.report)
