"""trajectories.parquet, allan.parquet -> noise.csv: coefficients of the noise of every series."""

from step import step

with step(snakemake) as log:
    from zlib import crc32

    from coordinates import read_coordinates

    from mocap_metrology.common.errors import Refusal
    from mocap_metrology.common.files import read_table, versions, write_csv, write_table
    from mocap_metrology.noise.fit import estimates
    from mocap_metrology.noise.fit.estimators import NoiseSettings, estimate_series, masked_curve
    from mocap_metrology.noise.series import (
        ALLAN,
        PERIODOGRAM,
        all_series,
        allan_columns,
        joined,
        periodogram_columns,
    )

    given, recording = snakemake.params, snakemake.wildcards.recording
    _, raw, origin = read_coordinates(snakemake.input.raw)
    allan, _ = read_table(snakemake.input.allan)
    rate = origin["frame_rate_hz"]
    settings = NoiseSettings.of(
        given.settings, rate, origin.get("form", "sampled"), given.subset or None
    )
    table, curves, periodograms, refused = [], [], [], {}

    def shown(series, estimator):
        return masked_curve(series, rate, settings, origin["resolution_mm"], estimator)[1]

    for name, series in all_series(raw, [tuple(pair) for pair in origin["pairs"]]):
        own = (allan["series"] == name) & (allan["estimator"] == "oadev") & (allan["avar_mm2"] > 0)
        cleaned = allan["m"][own], allan["avar_mm2"][own]
        asked = settings.components(name)
        others = [e for e in settings.curves if e != "oadev"]
        curves += [allan_columns(name, shown(series, e), e) for e in others]
        number = crc32(f"{recording} {name}".encode()) + settings.seed
        try:
            found = estimate_series(
                series, cleaned, rate, settings, asked, number, origin["resolution_mm"]
            )
        except Refusal as refusal:
            refused.setdefault(str(refusal), []).append(name)
            table += estimates.refused_rows(name, settings.estimators, str(refusal))
            curves.append(allan_columns(name, shown(series, "oadev")))
            continue
        for estimate in found.estimates:
            table += estimates.rows(name, estimate)
            log.info("%s %s: cost %.6g %s", name, estimate.estimator, estimate.cost, estimate.note)
        for estimator, why in found.refused.items():
            log.warning("%s: %s: %s", name, estimator, why)
            table += estimates.refused_rows(name, (estimator,), why)
        curves.append(allan_columns(name, found.curve))
        periodograms.append(periodogram_columns(name, found.periodogram))
    for why, names in refused.items():
        log.warning("%s: no noise coefficients: %s", ", ".join(names), why)
    origin |= {name: given.settings[name] for name in ("noise", "allan", "seed")}
    origin["versions"] = versions("numpy", "scipy", "numba", "pyarrow")
    write_csv(snakemake.output.noise, table)
    write_table(snakemake.output.allan, joined(curves, ALLAN), origin)
    write_table(snakemake.output.periodogram, joined(periodograms, PERIODOGRAM), origin)
