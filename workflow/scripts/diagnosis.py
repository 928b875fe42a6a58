"""What is wrong with a recording: diagnosis.json, its tables, and the figure that proves it."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.pipeline.figures import draw_diagnosis
    from mocap_metrology.pipeline.judging import diagnosed, diagnosis_settings
    from mocap_metrology.pipeline.settings import Diagnosis, Still
    from mocap_metrology.pipeline.tables import Table
    from mocap_metrology.present.tables import read_noise

    given, name = snakemake.params, snakemake.wildcards.recording
    settings = diagnosis_settings(
        Diagnosis(**given.diagnosis), Still(**given.still), given.horizon_s
    )
    raw, psd = Table.open(snakemake.input.raw), Table.read(snakemake.input.psd)
    found = diagnosed(raw, psd, read_noise(snakemake.input.noise), settings)
    for one in found.sentences:
        log.info("%s: %s: %s", one.severity, one.kind, one.words)
    folder = Path(snakemake.output.json).parent
    found.write(folder, name, raw.origin["source"])
    draw_diagnosis(found, raw.origin, settings.false_alarm, folder / "diagnosis")
