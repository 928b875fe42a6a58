"""Figure 7 of S: a shock in the trajectories, and in the Allan deviation of the distance."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.common.files import read_table
    from mocap_metrology.noise.series import all_series
    from mocap_metrology.present import tables
    from mocap_metrology.present.drawing.style import save_figure
    from mocap_metrology.present.skurowski.crump import Shaken, crump_figure
    from mocap_metrology.present.skurowski.families import TITLES

    def coordinates(path):
        columns, origin = read_table(path)
        return {k.removesuffix("_mm"): v for k, v in columns.items() if k != "frame"}, origin

    given, rows = snakemake.input, snakemake.params.rows
    sources = {row["recording"]: tables.source_of(row) for row in rows}
    raw, origin = coordinates(given.raw)
    raw = dict(all_series(raw, [tuple(pair) for pair in origin["pairs"]]))
    (allan, settings), *other = [read_table(path) for path in given.allan]
    shaken = Shaken(
        raw,
        coordinates(given.clean)[0],
        allan,
        origin["frame_rate_hz"],
        settings["allan"]["min_coverage"],
    )
    label = rows[1]["recording"] if other else ""
    quiet = (f"{label}, without a shock", other[0][0]) if other else None
    apart = f"{label} is another draw of noise: far right they differ by chance. " if other else ""
    note = (
        f"Recording {rows[0]['recording']}; S shows one of all its cameras. "
        f"{apart}{tables.source_sentence(sources)}"
    )
    figure = crump_figure(shaken, quiet, TITLES[7], note)
    save_figure(figure, Path(snakemake.output[0]).with_suffix(""))
    log.info("%s: drawn", rows[0]["recording"])
