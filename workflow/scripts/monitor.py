"""monitor_take.json of the takes of a facility -> its chart, table and state."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.accuracy.monitor_row import Row
    from mocap_metrology.recording.monitor import monitor, read_take
    from mocap_metrology.settings import Settings

    params, folder = snakemake.params, Path(snakemake.output.json).parent
    paths = map(Path, snakemake.input.takes)
    takes = {name: read_take(path.parent) for name, path in zip(params.takes, paths, strict=True)}
    rows = [Row(**row) for row in params.rows]
    document = monitor(
        snakemake.wildcards.monitor, rows, takes, Settings(**params.settings), folder
    )
    log.info("%s", document["line"])
