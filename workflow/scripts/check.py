"""Read a whole recording; say in check.json whether it can be used, and what to beware of."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.common.errors import Refusal, Truncated
    from mocap_metrology.common.files import empty_folder, sha256, write_json
    from mocap_metrology.io.read import bodies_of, read_recording
    from mocap_metrology.noise.motion.movement import moving_markers
    from mocap_metrology.present.text.movement import movement_words

    row = snakemake.params.row
    check = {"ok": True, "why": "", "warnings": [], "notes": []}
    try:
        for path, expected in zip(row["paths"], row["sha256"], strict=False):
            if sha256(path) != expected:
                raise Refusal(f"{Path(path).name}: SHA-256 is {sha256(path)}; expected {expected}")
        recording = read_recording(
            row["paths"],
            row["markers"],
            row["frame_rate_hz"],
            snakemake.params.second_opinion,
            row["accept_truncated"],
        )
        check["notes"] = list(recording.notes)
        rate, horizon = recording.frame_rate_hz, snakemake.params.horizon_s
        moving = moving_markers(
            dict(zip(recording.labels, recording.position_mm, strict=True)),
            rate,
            snakemake.params.still["range_mm"],
            horizon,
            recording.resolution_mm,
        )
        duration = recording.position_mm.shape[2] / rate
        check["warnings"] = movement_words(moving, min(duration, horizon))
        check["moving"] = bool(moving)
        check["bodies"] = bodies_of(row["paths"][0], row["markers"])
    except Refusal as refusal:
        why = str(refusal)
        if isinstance(refusal, Truncated):
            why += '; to use what is there, write "accept" in column truncated of the sheet'
        check |= {"ok": False, "why": why}
        empty_folder(Path(snakemake.output[0]).parent)  # results of an earlier input
    log.info("%s", check)
    write_json(snakemake.output[0], check)
