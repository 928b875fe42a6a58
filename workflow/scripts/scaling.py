"""Spread of a group's recordings over the number of cameras, with the law of S Eq. 3."""

from step import step

with step(snakemake) as log:
    from mocap_metrology.papers.subsets import spreads
    from mocap_metrology.present.plot.figure import save
    from mocap_metrology.present.skurowski.gaussian_figures import scaling_figure
    from mocap_metrology.present.skurowski.results import gaussian_row
    from mocap_metrology.present.tables import sources
    from mocap_metrology.present.text.captions import SCALING, Texts

    group = snakemake.wildcards.group
    rows = {row["recording"]: row for row in snakemake.params.rows}
    gaussian = {
        name: gaussian_row(path, "pair")
        for name, path in zip(rows, snakemake.input.gaussian, strict=True)
    }
    numbers = spreads(rows, gaussian)
    source, remarks = sources(rows, {}, paper=False)
    title = f"{group}: spread over the number of cameras"
    picture = scaling_figure(numbers, Texts(title, source, f"{SCALING} {remarks}"))
    save(picture, snakemake.output[0])
    log.info("%s: %d numbers", group, len(numbers))
