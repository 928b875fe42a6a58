"""Spread of a group's recordings over the number of cameras, with the law of S Eq. 3."""

from step import step

with step(snakemake) as log:
    from mocap_metrology.papers.subsets import spreads
    from mocap_metrology.present import tables
    from mocap_metrology.present.plot.figure import save
    from mocap_metrology.present.skurowski import gather
    from mocap_metrology.present.skurowski.gaussian_figures import scaling_figure
    from mocap_metrology.present.text import captions

    group = snakemake.wildcards.group
    rows = {row["recording"]: row for row in snakemake.params.rows}
    gaussian = {
        name: gather.gaussian_row(tables.read(path).to_dict("records"), "pair")
        for name, path in zip(rows, snakemake.input.gaussian, strict=True)
    }
    found = spreads(rows, gaussian)
    source, remarks = gather.sources(rows, {}, paper=False)
    title = f"{group}: spread over the number of cameras"
    picture = scaling_figure(found, (title, source, f"{captions.SCALING} {remarks}"))
    save(picture, snakemake.output[0])
    log.info("%s: %d numbers", group, len(found))
