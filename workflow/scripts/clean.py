"""trajectories.parquet -> clean.parquet: every series, distances included, through Hampel."""

from step import step

with step(snakemake) as log:
    from coordinates import read_coordinates

    from mocap_metrology.common.files import versions, write_csv, write_table
    from mocap_metrology.common.hampel import SHORT_WINDOW, hampel, white_level_kept
    from mocap_metrology.noise.series import all_series

    frame, raw, origin = read_coordinates(snakemake.input[0])
    settings = snakemake.params.hampel
    half_window = max(round(settings["half_window_s"] * origin["frame_rate_hz"]), 1)
    share_of_noise, kept = white_level_kept(settings["n_sigma"], half_window, settings["action"])
    if half_window < SHORT_WINDOW and settings["action"] != "off":
        log.warning(
            "the window holds %d frames, so the filter takes many good samples too; "
            "raise hampel.half_window_s to %g or more",
            2 * half_window + 1,
            SHORT_WINDOW / origin["frame_rate_hz"],
        )
    cleaned, report = {"frame": frame}, []
    for name, series in all_series(raw, [tuple(pair) for pair in origin["pairs"]]):
        result = hampel(
            series, half_window, settings["n_sigma"], settings["action"], origin["resolution_mm"]
        )
        cleaned[f"{name}_mm"] = result.values.astype(raw[name].dtype if name in raw else float)
        report.append(
            {
                "series": name,
                "action": settings["action"],
                "n_sigma": settings["n_sigma"],
                "window_frames": 2 * half_window + 1,
                "n_frames": series.size,
                "n_valid": result.n_valid,
                "n_outliers": int(result.outlier.sum()),
                "share": result.share,
                "share_of_clean_gaussian_noise": share_of_noise,
                "white_level_kept": kept,
                "resolution_mm": origin["resolution_mm"],
                "resolution_kind": origin["resolution_kind"],
            }
        )
        log.info("%s: %.3f %% outliers", name, 100 * result.share)
    origin |= {"hampel": settings, "window_frames": 2 * half_window + 1}
    origin["versions"] = versions("numpy", "numba", "pyarrow")
    write_table(snakemake.output.table, cleaned, origin)
    write_csv(snakemake.output.outliers, report)
