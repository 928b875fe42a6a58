"""allan_masked.parquet and gaussian.csv of several places -> <group>_places: noise by place."""

from step import step

with step(snakemake) as log:
    import numpy as np

    from mocap_metrology.common.errors import Refusal
    from mocap_metrology.common.files import read_series, read_table
    from mocap_metrology.noise.changes.rows import places_rows
    from mocap_metrology.present import tables
    from mocap_metrology.present.text import captions

    rows = snakemake.params.rows
    names, group = [row["recording"] for row in rows], snakemake.wildcards.group
    allan = {n: read_table(p)[0] for n, p in zip(names, snakemake.input.allan, strict=True)}
    means = {
        name: {
            f"{k}_mm": float(np.nanmean(v)) for k, v in read_series(path) if k in {"x1", "y1", "z1"}
        }
        for name, path in zip(names, snakemake.input.clean, strict=True)
    }
    try:
        of_places = places_rows(rows, allan, means)
    except Refusal as refusal:
        log.warning("%s", refusal)
        of_places = [{"note": str(refusal)}]
    caption = f"{captions.PLACES_TABLE} {tables.source_sentence(snakemake.params.sources)}"
    if len({tuple(row["markers"]) for row in rows}) > 1:
        caption += " Markers differ from place to place, so their own noise may, too."
    tables.write(snakemake.output.csv, of_places, f"{group}: noise by place", caption)
    log.info("%d rows", len(of_places))
