"""clean.parquet, trajectories.parquet -> psd, Allan deviations, Gaussian model, covariance of fast
noise, coefficients of the noise of every series."""

from step import step

with step(snakemake):
    from pathlib import Path

    from mocap_metrology.recording.noise import noise
    from mocap_metrology.recording.results import Results
    from mocap_metrology.settings import Settings

    results = Results(Path(snakemake.output.noise).parent)
    noise(results, Settings(**snakemake.params.settings), snakemake.params.subset or None)
