"""clean.parquet -> psd.parquet: Welch's power spectral density of every series."""

from step import step

with step(snakemake) as log:
    import numpy as np

    from mocap_metrology.common.errors import Refusal
    from mocap_metrology.common.files import read_metadata, read_series, versions, write_table
    from mocap_metrology.noise.fit.spectral.welch import welch

    path, settings = snakemake.input[0], snakemake.params.psd
    origin = read_metadata(path)
    names, parts = [], []
    for name, series in read_series(path):
        try:
            found = welch(series, origin["frame_rate_hz"], **settings)
        except Refusal as refusal:  # the other series are whole enough
            log.warning("%s: %s", name, refusal)
            continue
        names += [name] * found.f_hz.size
        parts.append(
            (
                found.f_hz,
                found.psd,
                np.full(found.f_hz.size, found.n_segments),
                np.full(found.f_hz.size, found.n_bridged),
            )
        )
        log.info("%s: %d segments of %d frames", name, found.n_segments, found.segment)
    empty = [np.array([])] * 4
    f_hz, density, n_segments, n_bridged = (
        np.concatenate(c) for c in (zip(*parts, strict=True) if parts else zip(empty, strict=True))
    )
    write_table(
        snakemake.output[0],
        {
            "series": np.array(names, dtype=object),
            "f_hz": f_hz,
            "psd_mm2_hz": density,
            "n_segments": n_segments.astype(np.int64),
            "n_bridged": n_bridged.astype(np.int64),
        },
        origin | {"psd": settings, "versions": versions("numpy", "scipy", "pyarrow")},
    )
