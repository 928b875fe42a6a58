"""trajectories.parquet, covariance.csv and noise.csv of camera subsets -> <group>_cameras."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    import pandas as pd

    from mocap_metrology.common.files import write_json
    from mocap_metrology.noise.cameras.findings import COLUMNS, LAW_COLUMNS
    from mocap_metrology.noise.cameras.take import Take, levels_of, one_frame, take_rows
    from mocap_metrology.noise.fit.estimates import read_noise
    from mocap_metrology.present import cameras, tables
    from mocap_metrology.present.plot.figure import Texts, save
    from mocap_metrology.present.text import captions

    params, settings, group = snakemake.params, snakemake.params.cameras, snakemake.wildcards.group
    of = {row["recording"]: row for row in params.rows}
    raw, covariance, coefficients = (
        dict(zip(of, snakemake.input[kind], strict=True)) for kind in ("raw", "covariance", "noise")
    )
    rows, laws, sigma, origins = [], [], {}, {}
    for take in params.takes:
        ids = {name: of[name]["camera_ids"] for name in take}
        paths = {name: Path(raw[name]) for name in take}
        files = Take(paths, params.mask_sigma, params.half_window_s)
        origins |= files.origins
        levels = {name: one_frame(pd.read_csv(covariance[name])) for name in take}
        noise = {name: read_noise(coefficients[name]) for name in take}
        kind = of[take[0]]["camera_type"]
        rows_of_take = take_rows(kind, ids, files, levels, noise, settings["rise"], log)
        rows, laws = rows + rows_of_take[0], laws + rows_of_take[1]
        sigma.setdefault(kind, {}).update(levels_of(ids, levels))
    source, remarks = tables.sources_of(origins)
    title = f"{group}: noise with each camera added"
    caption, nothing = f"{captions.CAMERA_TABLE} {source} {remarks}", "No addition of cameras."
    text = tables.markdown(rows, title, caption, nothing)
    tables.write_with(snakemake.output.csv, rows, text, COLUMNS)
    law_title = f"{group}: noise against the number of cameras"
    caption = f"{captions.LAW_TABLE} {source} {remarks}"
    text = tables.markdown(laws, law_title, caption) if laws else law_title
    tables.write_with(snakemake.output.law, laws, text, LAW_COLUMNS)
    summary = cameras.summary(rows, laws, settings)
    write_json(snakemake.output.json, summary)
    texts = Texts(title, source, remarks)
    save(cameras.camera_figure(rows, sigma, settings, texts), snakemake.output.svg)
    for word in summary["words"]:
        log.info("%s", word)
