"""trajectories.parquet, covariance.csv and noise.csv of camera subsets -> <group>_cameras."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    import pandas as pd

    from mocap_metrology.common.files import write_json
    from mocap_metrology.present import tables
    from mocap_metrology.present.cameras import camera_tables as cameras
    from mocap_metrology.present.cameras.camera_figure import camera_figure
    from mocap_metrology.present.cameras.take import Take, levels_of, of_take, one_frame
    from mocap_metrology.present.drawing.style import save_figure
    from mocap_metrology.present.tables import read_noise

    given, settings, group = snakemake.params, snakemake.params.cameras, snakemake.wildcards.group
    of = {row["recording"]: row for row in given.rows}
    raw, covariance, coefficients = (
        dict(zip(of, snakemake.input[kind], strict=True)) for kind in ("raw", "covariance", "noise")
    )
    rows, laws, sigma = [], [], {}
    for take in given.takes:
        ids = {name: of[name]["camera_ids"] for name in take}
        paths = {name: Path(raw[name]) for name in take}
        files = Take(paths, given.mask_sigma, given.half_window_s)
        levels = {name: one_frame(pd.read_csv(covariance[name])) for name in take}
        noise = {name: read_noise(coefficients[name]) for name in take}
        kind = of[take[0]]["camera_type"]
        found = of_take(kind, ids, files, levels, noise, settings["rise"], log)
        rows, laws = rows + found[0], laws + found[1]
        sigma.setdefault(kind, {}).update(levels_of(ids, levels))
    sources = tables.source_sentence(given.sources)
    title = f"{group}: noise with each camera added"
    caption = f"{cameras.CAPTION} {sources}"
    text = tables.markdown(rows, title, caption) if rows else f"# {title}\n\nNothing to tell.\n"
    tables.write_with(snakemake.output.csv, rows, text, cameras.COLUMNS)
    law_title = f"{group}: noise against the number of cameras"
    tables.write_with(
        snakemake.output.law,
        laws,
        tables.markdown(laws, law_title, f"{cameras.LAW_CAPTION} {sources}") if laws else law_title,
        cameras.LAW_COLUMNS,
    )
    summary = cameras.summary(rows, laws, settings)
    write_json(snakemake.output.json, summary)
    figure = camera_figure(rows, sigma, settings, title, sources)
    save_figure(figure, snakemake.output.svg)
    for word in summary["words"]:
        log.info("%s", word)
