"""All results -> pages of tables, recordings, calibrations, groups and papers, and the summary."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.common.files import write_folder, write_text
    from mocap_metrology.present.pages import write
    from mocap_metrology.present.plot.figure import save

    inputs, params, output = snakemake.input, snakemake.params, snakemake.output
    files = [Path(path) for path in dict.fromkeys(inputs.results)]
    rows, subjects = (params.recordings, params.calibrations), (params.papers, params.subjects)
    results = write.Results(Path(output.details).parent, *rows, *subjects, files)
    write_folder(output.tables, write.table_pages(results))
    write_folder(output.details, write.detail_pages(results))
    save(write.overview(results), output.png)
    page, front = write.summaries(results, map(Path, inputs.checks), Path(output.png))
    write_text(output.summary, page)
    write_text(output.front, front)
    log.info("%d results", len(results.files))
