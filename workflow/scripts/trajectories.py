"""Recording -> trajectories.parquet: chosen markers in mm, one row a frame, gaps as NaN.

What an interpolation filled is a gap, too."""

from step import step

with step(snakemake) as log:
    from dataclasses import asdict

    import numpy as np

    from mocap_metrology.common.files import versions, write_table
    from mocap_metrology.io.read import labels_of, read_recording
    from mocap_metrology.noise.diagnosis.export import filled_frames
    from mocap_metrology.noise.series import coordinate_names, pair_numbers

    row = snakemake.params.row
    paths = list(snakemake.input.files)
    markers = row["markers"] or labels_of(paths[0], row["accept_truncated"])
    recording = read_recording(
        paths,
        markers,
        row["frame_rate_hz"],
        second_opinion=False,  # asked by check_recording
        accept_truncated=row["accept_truncated"],
    )
    log.info("%s: %d frames", recording.encoding, recording.position_mm.shape[2])
    filled = filled_frames(recording.position_mm, recording.resolution_mm)
    for label, own, mask in zip(recording.labels, recording.position_mm, filled, strict=True):
        own[:, mask] = np.nan  # no measurement
        if mask.any():
            log.warning("%s: %d frames are gap-filled and left out", label, mask.sum())
    coordinates = recording.position_mm.reshape(-1, recording.position_mm.shape[2])
    names = [f"{name}_mm" for name in coordinate_names(len(markers))]
    columns = {"frame": np.arange(coordinates.shape[1], dtype=np.int32)}
    write_table(
        snakemake.output[0],
        columns | dict(zip(names, coordinates, strict=True)),
        {
            "recording": row["recording"],
            "source": row["source"],
            "twin": row["twin"],
            "unit": "mm",
            "labels": recording.labels,
            "pairs": pair_numbers(recording.labels, row["pairs"]),
            "frame_rate_hz": recording.frame_rate_hz,
            "resolution_mm": recording.resolution_mm,
            "resolution_kind": recording.resolution_kind,
            "file_units": recording.units,
            "file_encoding": recording.encoding,
            "n_gap_frames": recording.n_gap_frames,
            "n_invalid": recording.n_invalid,
            "n_filled_frames": dict(
                zip(recording.labels, filled.sum(axis=1).tolist(), strict=True)
            ),
            "segments": [asdict(segment) for segment in recording.segments],
            "notes": recording.notes,
            "versions": versions("numpy", "pyarrow"),
        }
        # Of twins alone: frames of a camera are points, its exposure is far shorter than a frame
        | ({"form": snakemake.params.form} if snakemake.params.form else {}),
        dictionary=names if recording.resolution_kind == "int16" else (),
    )
