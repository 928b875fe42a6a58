"""allan_masked.parquet of recordings and their references -> <group>_compare: changes."""

from step import step

with step(snakemake) as log:
    from mocap_metrology.common.files import read_table, write_json
    from mocap_metrology.noise.changes.rows import coarse_steps, compare_rows
    from mocap_metrology.present import changes, tables
    from mocap_metrology.present.changes import Comparison, compare_figure
    from mocap_metrology.present.plot.figure import Texts, save
    from mocap_metrology.present.tables import sources_of
    from mocap_metrology.present.text import captions

    settings, pairs = snakemake.params.compare, snakemake.params.pairs
    files = zip(pairs, snakemake.input.new, snakemake.input.old, strict=True)
    comparisons, rows, origins = [], [], {}
    for pair, *paths in files:
        (new, new_origin), (old, made_old) = map(read_table, paths)
        comparisons.append(Comparison(*pair, new, old))
        origins |= dict(zip(pair, (new_origin, made_old), strict=True))
        coarse = coarse_steps(old, made_old["resolution_mm"])
        coarse |= coarse_steps(new, new_origin["resolution_mm"])
        rows += compare_rows(*pair, new, old, **settings, coarse=coarse)
    source, remarks = sources_of(origins)
    title = f"{snakemake.wildcards.group}: comparison with the reference"
    text = changes.compare_markdown(rows, title, f"{captions.COMPARE_TABLE} {source} {remarks}")
    tables.write_with(snakemake.output.csv, rows, text)
    words = changes.sentences(rows)
    recordings = [recording for recording, _ in pairs]
    of = dict(zip(recordings, words, strict=True))
    write_json(snakemake.output.json, {"words": words, "recordings": of})
    texts = Texts(title, source, remarks)
    picture = compare_figure(comparisons, settings["margin"], settings["confidence"], texts)
    save(picture, snakemake.output.svg)
    for word in words:
        log.info("%s", word)
