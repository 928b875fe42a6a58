"""Results of one recording -> diagnosis.json with its tables, verdict.json, both in words in the
log; figures of both, of the Allan deviations, of the trajectory, and of some fits."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.present.verdict.words import verdict_lines
    from mocap_metrology.recording import figures
    from mocap_metrology.recording.results import Results
    from mocap_metrology.recording.verdict import diagnose, verdict
    from mocap_metrology.settings import Settings

    params = snakemake.params
    results = Results(Path(snakemake.output.json).parent, params.png)
    settings = Settings(**params.settings)
    diagnosis = diagnose(results, settings)
    for one in diagnosis.sentences:
        log.info("%s: %s: %s", one.severity, one.kind, one.words)
    figures.draw_diagnosis(diagnosis, results, settings)
    del diagnosis
    document = verdict(results, params.row, settings)
    log.info("%s", "\n".join(verdict_lines(document)))
    figures.draw_verdict(document, results)
    figures.draw_allan(results)
    figures.draw_trajectory(results)
    chosen = figures.decisive(document) if params.fits is None else params.fits
    figures.draw_fits(results, snakemake.output.fits, chosen)
