"""clean.parquet of a take -> monitor_take.json: the numbers by which a facility is monitored."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.recording.monitor import write_take
    from mocap_metrology.recording.results import Results
    from mocap_metrology.settings import Settings

    folder = Path(snakemake.output.json).parent
    document = write_take(Results(folder), Settings(**snakemake.params.settings))
    log.info("%s", document["take"])
