"""allan_masked.parquet of recordings of different days -> <group>_trend: does it get worse?"""

from step import step

with step(snakemake) as log:
    from mocap_metrology.common.files import read_table
    from mocap_metrology.present import tables
    from mocap_metrology.present.changes import compare
    from mocap_metrology.present.changes.trend_figure import trend_figure
    from mocap_metrology.present.drawing.style import save_figure

    dates, settings = snakemake.params.dates, snakemake.params.compare
    group, sources = snakemake.wildcards.group, snakemake.params.sources
    tables_of = dict(zip(dates, map(read_table, snakemake.input), strict=True))
    allan = {name: columns for name, (columns, _) in tables_of.items()}
    coarse = {
        name: compare.coarse_steps(columns, made["resolution_mm"])
        for name, (columns, made) in tables_of.items()
    }
    rows, title = [], f"{group}: change over dates"
    sentence = tables.source_sentence(sources)
    for names in snakemake.params.series_over_dates:
        found = compare.trend_rows(
            names,
            [dates[name] for name in names],
            {name: allan[name] for name in names},
            settings["alpha"],
            settings["confidence"],
            {series: step for name in names for series, step in coarse[name].items()},
        )
        if not rows:  # the first cameras of the sheet; others are in the table
            note = f"{compare.TREND_FIGURE} {', '.join(names)}. {sentence}"
            of_names = [dates[name] for name in names], allan, found, title, note
            save_figure(trend_figure(names, *of_names), snakemake.output.svg)
        rows += [{"first": names[0], "last": names[-1], **row} for row in found]
    tables.write(snakemake.output.csv, rows, title, f"{compare.TREND_CAPTION} {sentence}")
    log.info("%d rows", len(rows))
