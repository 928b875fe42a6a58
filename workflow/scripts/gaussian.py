"""clean.parquet -> gaussian.csv, the simple Gaussian model of every pair (S Table 4), and
covariance.csv, the covariance of fast noise between coordinates."""

from step import step

with step(snakemake) as log:
    from coordinates import read_coordinates

    from mocap_metrology.common.files import write_csv, write_text
    from mocap_metrology.noise.cameras.covariance import COLUMNS, covariance_rows
    from mocap_metrology.noise.gaussian.two_markers import gaussian_rows

    _, series, origin = read_coordinates(snakemake.input[0])
    rows = gaussian_rows(
        series,
        origin["labels"],
        [tuple(pair) for pair in origin["pairs"]],
        origin["frame_rate_hz"],
        snakemake.params.gaussian["n_bins"],
    )
    name = {"recording": origin["recording"]}
    write_csv(snakemake.output.gaussian, [name | row for row in rows])
    log.info("%d rows", len(rows))
    fast = covariance_rows(series, len(origin["labels"]), origin["frame_rate_hz"])
    if fast:
        write_csv(snakemake.output.covariance, fast)
    else:
        write_text(snakemake.output.covariance, ",".join(COLUMNS) + "\n")
