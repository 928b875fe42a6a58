"""trajectories.parquet, allan.parquet -> noise.csv: coefficients of the noise of every series."""

from step import step

with step(snakemake):
    from mocap_metrology.common.files import read_table, write_csv
    from mocap_metrology.pipeline.recording import noise_coefficients
    from mocap_metrology.pipeline.tables import Table
    from mocap_metrology.settings import Settings

    given = snakemake.params
    allan, _ = read_table(snakemake.input.allan)
    raw = Table.open(snakemake.input.raw)
    found = noise_coefficients(raw, allan, Settings(**given.settings), given.subset or None)
    write_csv(snakemake.output.noise, found.rows)
    found.allan.write(snakemake.output.allan)
    found.periodogram.write(snakemake.output.periodogram)
