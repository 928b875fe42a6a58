"""All results -> pages of tables, recordings, calibrations, groups and papers, and the summary."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.common.files import write_folder, write_text
    from mocap_metrology.present import tables
    from mocap_metrology.present.pages import write
    from mocap_metrology.present.plot.figure import save

    inputs, params, output = snakemake.input, snakemake.params, snakemake.output
    claims = [row for p in inputs.claims for row in tables.read(p).fillna("").to_dict("records")]
    results = write.Results(
        Path(output.details).parent,
        params.recordings,
        params.calibrations,
        dict(zip(params.cameras, inputs.cameras, strict=True)),
        dict(zip(params.compared, inputs.changes, strict=True)),
        claims,
        params.papers,
        params.subjects,
        [Path(path) for path in dict.fromkeys(inputs.results)],
        {Path(path).parent.name: Path(path) for path in inputs.monitors},
    )
    write_folder(output.tables, write.table_pages(map(Path, inputs.tables), params.papers))
    write_folder(output.details, write.detail_pages(results))
    save(write.overview(results), output.png)
    checks, named = map(Path, inputs.checks), map(Path, inputs.tables)
    page, front = write.summaries(results, checks, named, Path(output.png))
    write_text(output.summary, page)
    write_text(output.front, front)
    log.info("%d results", len(results.files))
