"""Spread of a group's recordings over the number of cameras, with the law of S Eq. 3."""

from step import step

with step(snakemake) as log:
    from mocap_metrology.present import tables
    from mocap_metrology.present.drawing.style import save_figure
    from mocap_metrology.present.skurowski import gather
    from mocap_metrology.present.skurowski.scaling import NOTE_GROUP, scaling_figure

    group = snakemake.wildcards.group
    rows = {row["recording"]: row for row in snakemake.params.rows}
    source = tables.source_sentence({name: tables.source_of(row) for name, row in rows.items()})
    gaussian = {
        name: gather.gaussian_row(tables.read(path).to_dict("records"), "pair")
        for name, path in zip(rows, snakemake.input.gaussian, strict=True)
    }
    found = gather.subsets_of_group(rows, gaussian)
    title = f"{group}: spread over the number of cameras"
    figure = scaling_figure(found, title, f"{NOTE_GROUP} {source}")
    save_figure(figure, snakemake.output[0])
    log.info("%s: %d subsets", group, len(found))
