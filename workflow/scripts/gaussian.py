"""clean.parquet -> gaussian.csv, the simple Gaussian model of every pair (S Table 4), and
covariance.csv, the covariance of fast noise between coordinates."""

from step import step

with step(snakemake) as log:
    from mocap_metrology.common.files import write_csv, write_text
    from mocap_metrology.noise.cameras.covariance import COLUMNS
    from mocap_metrology.pipeline.settings import Gaussian
    from mocap_metrology.pipeline.statistics import gaussian_model
    from mocap_metrology.pipeline.tables import Table

    settings = Gaussian(**snakemake.params.gaussian)
    rows, fast = gaussian_model(Table.open(snakemake.input[0]), settings)
    write_csv(snakemake.output.gaussian, rows)
    log.info("%d rows", len(rows))
    if fast:
        write_csv(snakemake.output.covariance, fast)
    else:
        write_text(snakemake.output.covariance, ",".join(COLUMNS) + "\n")
