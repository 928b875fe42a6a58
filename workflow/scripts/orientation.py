"""trajectories.parquet, or poses -> orientation: rotation vectors, Allan deviations."""

from step import step

with step(snakemake) as log:
    from mocap_metrology.common import files
    from mocap_metrology.common.errors import Refusal
    from mocap_metrology.common.hampel import hampel
    from mocap_metrology.common.large import in_parts
    from mocap_metrology.io.read import bodies_of, orientation_of
    from mocap_metrology.noise.allan.confidence import allan_curve
    from mocap_metrology.noise.allan.variance import averaging_factors
    from mocap_metrology.noise.motion import orientation as motion
    from mocap_metrology.noise.series import ALLAN, allan_columns, joined
    from mocap_metrology.present.plot.figure import save
    from mocap_metrology.present.recording import orientation_figure

    cluster, settings = snakemake.params.cluster, snakemake.params.allan
    columns, origin = files.open_table(snakemake.input.trajectories)
    n_frames = len(columns["frame"])
    refused = ""
    try:
        if cluster:
            markers = [origin["labels"].index(label) + 1 for label in cluster]
            turns = motion.of_cluster(
                [[in_parts(columns, f"{a}{k}_mm") for a in "xyz"] for k in markers]
            )
        else:
            paths = list(snakemake.input.poses)
            names = snakemake.params.names
            body = bodies_of(paths[0], origin["labels"], names)[0]
            told = origin["frame_rate_hz"], snakemake.params.accept_truncated, names
            turns = motion.of_poses(orientation_of(paths, body, *told))
    except Refusal as refusal:
        refused, turns = str(refusal), motion.unknown(n_frames)
        log.warning("%s", refused)
    rate, clean = origin["frame_rate_hz"], snakemake.params.hampel
    half_window = max(round(clean["half_window_s"] * rate), 1)
    parts = []
    m = averaging_factors(n_frames, settings["n_taus"], settings["min_m"], settings["max_fraction"])
    for name, values in zip(motion.AXES, turns.vectors_rad, strict=True):
        masked = hampel(values, half_window, snakemake.params.mask_sigma, "mask", 0.0).values
        curve = allan_curve(
            masked, rate, m, "oadev", settings["confidence"], settings["min_coverage"]
        )
        parts.append(allan_columns(name, curve))

    def series():
        yield "frame", columns["frame"]
        for name, values in zip(motion.AXES, turns.vectors_rad, strict=True):
            how = half_window, clean["n_sigma"], clean["action"], 0.0
            yield f"{name}_rad", hampel(values, *how).values
        if cluster:
            yield "residual_mm", turns.residual_mm

    origin |= {"unit": "rad", "cluster": cluster, "hampel": clean, "allan": settings}
    origin["versions"] = files.versions("numpy", "scipy", "numba", "pyarrow")
    files.write_series(snakemake.output.series, series(), origin)
    allan = motion.in_radians(joined(parts, ALLAN))
    files.write_table(snakemake.output.allan, allan, origin)
    rows = motion.orientation_rows(origin["recording"], origin["source"], allan, turns, refused)
    files.write_csv(snakemake.output.csv, rows)
    figure = orientation_figure(allan, turns, origin, cluster, refused)
    save(figure, snakemake.output.svg)
    log.info("%s", rows)
