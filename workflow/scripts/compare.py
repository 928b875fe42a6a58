"""allan_masked.parquet of recordings and their references -> <group>_compare: what has changed."""

from step import step

with step(snakemake) as log:
    from mocap_metrology.common.files import read_table, write_json
    from mocap_metrology.present import tables
    from mocap_metrology.present.changes import compare
    from mocap_metrology.present.changes.compare_figure import Comparison, compare_figure
    from mocap_metrology.present.drawing.style import save_figure

    settings, pairs = snakemake.params.compare, snakemake.params.pairs
    group, sources = snakemake.wildcards.group, snakemake.params.sources
    files = zip(pairs, snakemake.input.new, snakemake.input.old, strict=True)
    found, rows = [], []
    for pair, *paths in files:
        (new, made), (old, made_old) = map(read_table, paths)
        found.append(Comparison(*pair, new, old))
        coarse = compare.coarse_steps(old, made_old["resolution_mm"])
        coarse |= compare.coarse_steps(new, made["resolution_mm"])
        rows += compare.compare_rows(*pair, new, old, **settings, coarse=coarse)
    sentence = tables.source_sentence(sources, snakemake.config["duration_s"])
    title = f"{group}: what has changed"
    text = compare.compare_markdown(rows, title, f"{compare.CAPTION} {sentence}")
    tables.write_with(snakemake.output.csv, rows, text)
    words = compare.sentences(rows)
    write_json(snakemake.output.json, {"words": words})
    note = f"{compare.FIGURE} {sentence}"
    confidence = settings["confidence"]
    figure = compare_figure(found, settings["margin"], confidence, title, note)
    save_figure(figure, snakemake.output.svg)
    for word in words:
        log.info("%s", word)
