"""trajectories.parquet, allan.parquet -> noise.csv: coefficients of the noise of every series."""

from step import step

with step(snakemake) as log:
    from zlib import crc32

    from mocap_metrology.common.errors import Refusal
    from mocap_metrology.common.files import read_table, versions, write_csv, write_table
    from mocap_metrology.noise import estimates, noise_files
    from mocap_metrology.noise.estimators import estimate_series, panel
    from mocap_metrology.noise.series import all_series

    row, seed = snakemake.params.row, snakemake.params.seed
    columns, origin = read_table(snakemake.input.raw)
    allan, _ = read_table(snakemake.input.allan)
    rate = origin["frame_rate_hz"]
    given = snakemake.params
    settings = noise_files.settings(given.noise, given.annealing, given.allan, given.hampel, rate)
    raw = {k.removesuffix("_mm"): v for k, v in columns.items() if k != "frame"}
    table, curves, periodograms, refused = [], [], [], {}
    for name, series in all_series(raw, [tuple(pair) for pair in origin["pairs"]]):
        own = (allan["series"] == name) & (allan["estimator"] == "oadev") & (allan["avar_mm2"] > 0)
        cleaned = allan["m"][own], allan["avar_mm2"][own]
        asked = (
            panel(row["camera_type"], row["n_cameras"], name) if snakemake.params.paper else None
        )
        number = crc32(f"{row['recording']} {name}".encode()) + seed
        try:
            found = estimate_series(
                series, cleaned, 1 / rate, settings, asked, number, origin["resolution_mm"]
            )
        except Refusal as refusal:
            refused.setdefault(str(refusal), []).append(name)
            table += estimates.refused_rows(name, settings.estimators, str(refusal))
            continue
        for estimate in found.estimates:
            table += estimates.rows(name, estimate)
            log.info("%s %s: cost %.6g %s", name, estimate.estimator, estimate.cost, estimate.note)
        for estimator, why in found.refused.items():
            log.warning("%s: %s: %s", name, estimator, why)
            table += estimates.refused_rows(name, (estimator,), why)
        curves.append(noise_files.allan_columns(name, found.curve))
        periodograms.append(noise_files.periodogram_columns(name, found.periodogram))
    for why, names in refused.items():
        log.warning("%s: no noise coefficients: %s", ", ".join(names), why)
    origin |= {"noise": snakemake.params.noise, "seed": seed}
    origin["versions"] = versions("numpy", "scipy", "numba", "pyarrow")
    write_csv(snakemake.output.noise, table)
    write_table(snakemake.output.allan, noise_files.joined(curves, noise_files.ALLAN), origin)
    write_table(
        snakemake.output.periodogram,
        noise_files.joined(periodograms, noise_files.PERIODOGRAM),
        origin,
    )
