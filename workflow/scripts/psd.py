"""clean.parquet -> psd.parquet: Welch's power spectral density of every series."""

from step import step

with step(snakemake):
    from mocap_metrology.common.files import read_metadata, read_series
    from mocap_metrology.pipeline.settings import Spectrum
    from mocap_metrology.pipeline.statistics import spectra

    path, settings = snakemake.input[0], Spectrum(**snakemake.params.psd)
    spectra(read_series(path), read_metadata(path), settings).write(snakemake.output[0])
