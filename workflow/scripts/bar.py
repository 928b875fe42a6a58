"""Recording of a bar that is moved -> bar.json, bar.csv, bar_places.csv, its take, a figure."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.accuracy.asked import Asked
    from mocap_metrology.present.accuracy.bar_document import bar_lines
    from mocap_metrology.recording.bar import write_bar
    from mocap_metrology.recording.bar_take import read_bar
    from mocap_metrology.recording.clean import Entry
    from mocap_metrology.recording.results import Table
    from mocap_metrology.settings import Settings

    given, settings = snakemake.params, Settings(**snakemake.params.settings)
    asked, named = Asked(**given.bar), given.named
    raw = Table.read(snakemake.input.trajectories) if named["twin"] else None
    entry = Entry(list(snakemake.input.files), **given.entry)
    reading = read_bar(entry, asked, settings, named, raw)
    document = write_bar(reading, asked, settings, Path(snakemake.output.json).parent)
    log.info("%s", "\n".join(bar_lines(document)))
