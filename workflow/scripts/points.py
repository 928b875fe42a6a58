"""Recordings at reference points -> <group>_points: a rigid fit, what each is off by, a figure."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.common.errors import Refusal
    from mocap_metrology.common.files import write_json
    from mocap_metrology.present import tables
    from mocap_metrology.present.plot.figure import Texts, save, styled, words_picture
    from mocap_metrology.recording.points import first_marker, write_points

    inputs, output, rows = snakemake.input, snakemake.output, snakemake.params.rows
    group, files = snakemake.wildcards.group, iter(inputs.files)
    try:
        if len(inputs.reference) > 1:
            names = ", ".join(Path(path).name for path in inputs.reference)
            raise Refusal(f"{group}: references {names}; expected one file for all rows of a group")
        recorded = [
            first_marker(path, [next(files) for _ in row["paths"]], row)
            for path, row in zip(inputs.clean, rows, strict=True)
        ]
        paths = Path(output.json), Path(output.svg)
        write_points(group, rows, recorded, inputs.reference[0], *paths)
    except Refusal as refusal:
        log.warning("%s", refusal)
        title = f"{group}: reference points"
        write_json(output.json, {"group": group, "refused": str(refusal)})
        tables.write(output.csv, [{"note": str(refusal)}], title, snakemake.params.caption)
        with styled():
            save(words_picture(str(refusal), Texts(title)), output.svg)
    log.info("%d points", len(rows))
