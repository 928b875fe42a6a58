"""Tables of one group of calibrations: the poses to use, how good they are, and why."""

from step import step

with step(snakemake) as log:
    from mocap_metrology.common.files import read_table
    from mocap_metrology.lighthouse.assess import rows as rows_of
    from mocap_metrology.lighthouse.assess.rows import records_of
    from mocap_metrology.present.calibration import pose_text
    from mocap_metrology.present.tables import markdown, source_sentence, write_with
    from mocap_metrology.present.text import captions

    group = snakemake.wildcards.group
    records = records_of(snakemake.params.rows, snakemake.input.poses)
    joined = [
        {"calibration": f"{setup} (joint)", "setup": setup, "source": source}
        for _, setup, source in snakemake.params.setups
    ]
    note = source_sentence({record["calibration"]: record["source"] for record in records})
    rows = rows_of.calibration_rows([*records, *records_of(joined, snakemake.input.setups)])
    text = pose_text.calibration_markdown(rows, f"{group}: calibrations", note=note)
    write_with(snakemake.output[0], rows, text)
    tracked = [
        rows_of.track_row(record, *read_table(path))
        for record, path in zip(records, snakemake.input.tracks, strict=True)
    ]
    caption = f"{captions.TRACK_TABLE} {note}".strip()
    text = markdown(tracked, f"{group}: tracked receivers", caption, "No calibrations.")
    write_with(snakemake.output[2], tracked, text)
    rotors = [
        row
        for named, path in zip(snakemake.params.at_rest, snakemake.input.allan, strict=True)
        for row in rows_of.angle_rows(named, *read_table(path))
    ]
    caption, nothing = f"{captions.ANGLE_TABLE} {note}", "No calibration of a board at rest."
    text = markdown(rotors, f"{group}: noise of angles", caption.strip(), nothing)
    write_with(snakemake.output[4], rotors, text, rows_of.ANGLE_HEAD)
    log.info("%s: %d calibrations", group, len(rows))
