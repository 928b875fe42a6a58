"""The studies of J's claims: medians, rank correlations, findings and figures."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.papers.studies.findings import SHOWN, rows_of
    from mocap_metrology.present import tables
    from mocap_metrology.present.claims import studies_markdown, study_figure
    from mocap_metrology.present.plot.figure import save

    given, seed = snakemake.params.settings, snakemake.params.seed
    found = {Path(path).stem: tables.read(path) for path in snakemake.input}
    rows = {shown: rows_of(shown, found[shown.data]) for shown in SHOWN}
    every = [row for own in rows.values() for row in own]
    text = studies_markdown(every, given["recordings"], given["duration_s"], seed)
    tables.write_with(snakemake.output.csv, every, text)
    source = (
        f"Source: simulated recordings of {given['duration_s']:g} s with the noise of real sweeps."
    )
    for shown, own in rows.items():
        path = Path(snakemake.output.figures[0]).with_name(f"jansen_studies_{shown.number}")
        save(study_figure(shown, own, source), path)
    log.info("%d studies, %d rows", len(rows), len(every))
