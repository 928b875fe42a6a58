"""clean.parquet -> allan.parquet: Allan deviations of every series, with intervals."""

from step import step

with step(snakemake) as log:
    import numpy as np

    from mocap_metrology.common.files import read_metadata, read_series, versions, write_table
    from mocap_metrology.noise.allan import averaging_factors
    from mocap_metrology.noise.confidence import allan_curve

    path, settings = snakemake.input[0], snakemake.params.allan
    origin = read_metadata(path)
    parts = []
    for name, series in read_series(path):
        m = averaging_factors(
            series.size, settings["n_taus"], settings["min_m"], settings["max_fraction"]
        )
        for estimator in settings["estimators"]:
            curve = allan_curve(
                series,
                origin["frame_rate_hz"],
                m,
                estimator,
                settings["confidence"],
                settings["min_coverage"],
            )
            k = curve.m.size
            parts.append(
                {
                    "series": np.full(k, name, dtype=object),
                    "estimator": np.full(k, estimator, dtype=object),
                    "m": curve.m,
                    "tau_s": curve.tau_s,
                    "avar_mm2": curve.variance,
                    "adev_mm": curve.deviation,
                    "n_terms": curve.n_terms,
                    "alpha": curve.alpha,
                    "edf": curve.edf,
                    "adev_lower_mm": curve.lower,
                    "adev_upper_mm": curve.upper,
                }
            )
        log.info("%s: %d averaging factors", name, m.size)
    origin |= {"allan": settings, "versions": versions("numpy", "scipy", "numba", "pyarrow")}
    columns = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    write_table(snakemake.output[0], columns, origin)
