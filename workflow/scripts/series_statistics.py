"""trajectories.parquet -> clean.parquet: every series, distances included, through Hampel; of these
allan.parquet: Allan deviations of series cleaned as in S, with intervals; psd.parquet: Welch's
power spectral density of every series; gaussian.csv: the simple Gaussian model of every pair
(S Table 4); covariance.csv: the covariance of fast noise between coordinates."""

from step import step

with step(snakemake) as log:
    from mocap_metrology.common.files import read_metadata, read_series, write_csv, write_text
    from mocap_metrology.noise.cameras.covariance import COLUMNS
    from mocap_metrology.pipeline.recording import allan_deviations, write_cleaned
    from mocap_metrology.pipeline.statistics import gaussian_model, spectra
    from mocap_metrology.pipeline.tables import Table
    from mocap_metrology.settings import Allan, Gaussian, Hampel, Spectrum

    given, output = snakemake.params, snakemake.output
    path = output.clean
    report = write_cleaned(Table.open(snakemake.input[0]), Hampel(**given.hampel), path)
    write_csv(output.outliers, report)
    origin = read_metadata(path)
    allan_deviations(read_series(path), origin, Allan(**given.allan)).write(output.allan)
    spectra(read_series(path), origin, Spectrum(**given.psd)).write(output.psd)
    rows, fast = gaussian_model(Table.open(path), Gaussian(**given.gaussian))
    write_csv(output.gaussian, rows)
    log.info("Gaussian model: %d rows", len(rows))
    if fast:
        write_csv(output.covariance, fast)
    else:
        write_text(output.covariance, ",".join(COLUMNS) + "\n")
