"""The studies of J's claims: medians, rank correlations, findings and figures."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.papers.studies.findings import SHOWN, rows_of
    from mocap_metrology.present import tables
    from mocap_metrology.present.claims import studies_markdown, study_figure
    from mocap_metrology.present.plot.figure import save

    settings, seed = snakemake.params.settings, snakemake.params.seed
    by_study = {Path(path).stem: tables.read(path) for path in snakemake.input}
    rows = {shown: rows_of(shown, by_study[shown.data]) for shown in SHOWN}
    every = [row for of_study in rows.values() for row in of_study]
    text = studies_markdown(every, settings["recordings"], settings["duration_s"], seed)
    tables.write_with(snakemake.output.csv, every, text)
    length = f"{settings['duration_s']:g} s"
    source = f"Source: simulated recordings of {length} with the noise of real sweeps."
    for shown, of_study in rows.items():
        path = Path(snakemake.output.figures[0]).with_name(f"jansen_studies_{shown.number}")
        save(study_figure(shown, of_study, source), path)
    log.info("%d studies, %d rows", len(rows), len(every))
