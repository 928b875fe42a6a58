"""Figures 9-11 of S: densities, means, and how the spread falls with the number of cameras."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.common.files import read_table
    from mocap_metrology.noise.twins.published import published_gaussian
    from mocap_metrology.present import tables
    from mocap_metrology.present.plot.figure import save
    from mocap_metrology.present.skurowski import gather
    from mocap_metrology.present.skurowski.camera_tables import TABLE_4
    from mocap_metrology.present.skurowski.densities import distances_figure, locations_figure
    from mocap_metrology.present.skurowski.scaling import TITLE_11, scaling_figure
    from mocap_metrology.present.text import captions

    given, files = snakemake.params, snakemake.input
    rows = {row["recording"]: row for row in given.rows}
    twins = given.twins
    lengths = {name: twin.duration_s for name, twin in twins.items()}
    source, remarks = gather.sources(rows, lengths)
    gaussian = {
        name: gather.gaussian_row(tables.read(path).to_dict("records"), "x")
        for name, path in zip(rows, files.gaussian, strict=True)
    }
    clean = {Path(path).parent.name: read_table(path)[0] for path in files.clean}
    kinds = {name: rows[name]["camera_type"] for name in clean}
    first = gather.of_locations(rows, list(clean))
    x = {f"x{k}": clean[first][f"x{k}_mm"] for k in (1, 2)}
    printed = {k: published_gaussian(k) for k in kinds.values() if k in TABLE_4}
    source_9, made = gather.sources({first: rows[first]}, lengths)
    remarks_9 = f"Recording {first}. {gather.spread_sentence(twins.get(first))} {made}"
    texts_11 = TITLE_11, source, f"{captions.SKUROWSKI[11]} {remarks}"
    figures = {
        9: locations_figure(x, printed.get(kinds[first]), source_9, remarks_9),
        10: distances_figure(
            {kinds[name]: columns["L_mm"] for name, columns in clean.items()},
            printed,
            gather.means(rows, gaussian, twins),
            source,
            remarks,
        ),
        11: scaling_figure(gather.subsets(rows, gaussian, twins), texts_11, variances=True),
    }
    folder = Path(snakemake.output[0]).parent
    for number, figure in figures.items():
        save(figure, folder / f"skurowski_fig{number:02d}")
        log.info("Figure %d", number)
