"""Takes of the bars of a group -> <group>_bar and <group>_statement: all passes together,
as tables and a figure; the uncertainty of a length."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.accuracy.statement import known_of
    from mocap_metrology.common.files import read_json
    from mocap_metrology.recording.bar import write_group, write_statement
    from mocap_metrology.settings import Settings

    inputs, output = snakemake.input, snakemake.output
    read = (inputs.verdicts, inputs.monitors, inputs.points)
    still, monitors, points = (list(map(read_json, paths)) for paths in read)
    settings, group = Settings(**snakemake.params.settings), snakemake.wildcards.group
    bar = write_group(group, inputs.takes, still, settings, Path(output.json), Path(output.svg))
    known = known_of(bar.pair, monitors, points[0] if points else None)
    statement = Path(output.statement_json), Path(output.statement_pdf)
    write_statement(group, bar, known, *statement)
    log.info("%d takes", len(inputs.takes))
