"""allan_masked.parquet of recordings of different days -> <group>_trend: does it get worse?"""

from step import step

with step(snakemake) as log:
    from mocap_metrology.common.files import read_table
    from mocap_metrology.noise.changes.rows import Side, coarse_steps, trend_rows
    from mocap_metrology.present import tables
    from mocap_metrology.present.changes import trend_figure
    from mocap_metrology.present.plot.figure import Texts, save
    from mocap_metrology.present.tables import sources_of
    from mocap_metrology.present.text import captions

    dates, settings = snakemake.params.dates, snakemake.params.compare
    sides = {
        name: Side(name, *read_table(path))
        for name, path in zip(dates, snakemake.input, strict=True)
    }
    source, remarks = sources_of({name: side.origin for name, side in sides.items()})
    rows, title = [], f"{snakemake.wildcards.group}: change over dates"
    for names in snakemake.params.series_over_dates:
        allan = {name: sides[name].named_as(sides[names[0]]).columns for name in names}
        steps = [coarse_steps(allan[name], sides[name].origin["resolution_mm"]) for name in names]
        trends = trend_rows(
            names,
            [dates[name] for name in names],
            allan,
            settings["alpha"],
            settings["confidence"],
            {series: step for one in steps for series, step in one.items()},
        )
        if not rows:  # the first cameras of the sheet; others are in the table
            said = f"Recordings of the same cameras: {', '.join(names)}. {remarks}"
            of_names = [dates[name] for name in names], allan, trends, Texts(title, source, said)
            save(trend_figure(names, *of_names), snakemake.output.svg)
        rows += [{"first": names[0], "last": names[-1], **row} for row in trends]
    tables.write(snakemake.output.csv, rows, title, f"{captions.TREND_TABLE} {source} {remarks}")
    log.info("%d rows", len(rows))
