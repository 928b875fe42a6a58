"""clean.parquet -> gaussian.csv: the simple Gaussian model of every pair (S Table 4)."""

from step import step

with step(snakemake) as log:
    from mocap_metrology.common.files import read_table, write_csv
    from mocap_metrology.noise.describe import gaussian_rows

    columns, origin = read_table(snakemake.input[0])
    series = {name.removesuffix("_mm"): values for name, values in columns.items()}
    rows = gaussian_rows(
        series,
        origin["labels"],
        [tuple(pair) for pair in origin["pairs"]],
        origin["frame_rate_hz"],
        snakemake.params.gaussian["n_bins"],
    )
    write_csv(snakemake.output[0], [{"recording": origin["recording"], **row} for row in rows])
    log.info("%d rows", len(rows))
