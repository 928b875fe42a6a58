"""Recording -> trajectories.parquet: chosen markers in mm, one row a frame, gaps as NaN."""

from step import step

with step(snakemake) as log:
    from mocap_metrology.io.read import labels_of, read_recording
    from mocap_metrology.pipeline.reading import trajectories

    row, paths = snakemake.params.row, list(snakemake.input.files)
    recording = read_recording(
        paths,
        row["markers"] or labels_of(paths[0], row["accept_truncated"], row["column_names"]),
        row["frame_rate_hz"],
        second_opinion=False,  # requested by check_recording
        accept_truncated=row["accept_truncated"],
        unit=row["unit"],
        columns=row["column_names"],
    )
    log.info("%s: %d frames", recording.encoding, recording.position_mm.shape[2])
    named = {key: row[key] for key in ("recording", "source", "twin")}
    named |= {"form": snakemake.params.form} if snakemake.params.form else {}
    trajectories(recording, named, row["pairs"]).write(snakemake.output[0])
