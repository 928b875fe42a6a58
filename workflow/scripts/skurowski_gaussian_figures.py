"""Figures 9-11 of S: densities, means, and how the spread falls with the number of cameras."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.common.files import read_table
    from mocap_metrology.noise.twins.published import published_gaussian
    from mocap_metrology.present import tables
    from mocap_metrology.present.drawing.style import save_figure
    from mocap_metrology.present.skurowski import gather
    from mocap_metrology.present.skurowski.camera_tables import TABLE_4
    from mocap_metrology.present.skurowski.densities import distances_figure, locations_figure
    from mocap_metrology.present.skurowski.scaling import NOTE_11, scaling_figure

    given, files = snakemake.params, snakemake.input
    rows = {row["recording"]: row for row in given.rows}
    twins = given.twins
    lengths = {name: twin.duration_s for name, twin in twins.items()}
    source = " ".join(gather.sources(rows, lengths))
    gaussian = {
        name: gather.gaussian_row(tables.read(path).to_dict("records"), "x")
        for name, path in zip(rows, files.gaussian, strict=True)
    }
    clean = {Path(path).parent.name: read_table(path)[0] for path in files.clean}
    kinds = {name: rows[name]["camera_type"] for name in clean}
    first = gather.of_locations(rows, list(clean))
    x = {f"x{k}": clean[first][f"x{k}_mm"] for k in (1, 2)}
    printed = {k: published_gaussian(k) for k in kinds.values() if k in TABLE_4}
    note_9 = f"{first}. {gather.spread_sentence(twins.get(first))} {source}"
    figures = {
        9: locations_figure(x, printed.get(kinds[first]), note=note_9),
        10: distances_figure(
            {kinds[name]: columns["L_mm"] for name, columns in clean.items()},
            printed,
            gather.means(rows, gaussian, twins),
            note=source,
        ),
        11: scaling_figure(gather.subsets(rows, gaussian, twins), note=f"{NOTE_11} {source}"),
    }
    folder = Path(snakemake.output[0]).parent
    for number, figure in figures.items():
        save_figure(figure, folder / f"skurowski_fig{number:02d}")
        log.info("Figure %d", number)
