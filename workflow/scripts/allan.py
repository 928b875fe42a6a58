"""clean.parquet -> allan.parquet: Allan deviations of series cleaned as in S, with intervals."""

from step import step

with step(snakemake) as log:
    from mocap_metrology.common.files import read_metadata, read_series, versions, write_table
    from mocap_metrology.common.hampel import taken_at_most
    from mocap_metrology.noise.allan.confidence import allan_curve
    from mocap_metrology.noise.allan.variance import averaging_factors
    from mocap_metrology.noise.series import ALLAN, allan_columns, joined

    path, settings = snakemake.input[0], snakemake.params.allan
    origin = read_metadata(path)
    hampel, parts = origin["hampel"], []
    taken = taken_at_most(hampel["n_sigma"], origin["window_frames"] // 2, hampel["action"])
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
            parts.append(allan_columns(name, curve.with_upper_raised(taken), estimator))
        log.info("%s: %d averaging factors", name, m.size)
    origin |= {"allan": settings, "versions": versions("numpy", "scipy", "numba", "pyarrow")}
    write_table(snakemake.output[0], joined(parts, ALLAN), origin)
