"""bar.parquet of a bar that is moved -> bar.json, bar.csv, bar_places.csv, verdict.json, noise for
filters, a figure."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.common.files import write_json
    from mocap_metrology.present.accuracy.bar import bar_lines
    from mocap_metrology.present.verdict.words import verdict_of_bar
    from mocap_metrology.recording.bar import write_bar
    from mocap_metrology.settings import Settings

    params, path = snakemake.params, Path(snakemake.input.take)
    document = write_bar(path.parent, Settings(**params.settings))
    write_json(snakemake.output.verdict, params.row | verdict_of_bar(document))
    log.info("%s", "\n".join(bar_lines(document)))
