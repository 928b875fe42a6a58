"""allan_masked.parquet and diagnosis.json of recordings and their references -> <group>_compare:
changes."""

from step import step

INPUTS = ("new", "old", "new_diagnosis", "old_diagnosis")

with step(snakemake) as log:
    from mocap_metrology.common.files import read_json, read_table, write_json
    from mocap_metrology.noise.changes.rows import Side, coarse_in_either, compare_rows, conditions
    from mocap_metrology.present import changes, tables
    from mocap_metrology.present.changes import Comparison, compare_figure
    from mocap_metrology.present.plot.figure import Texts, save
    from mocap_metrology.present.tables import sources_of
    from mocap_metrology.present.text import captions

    settings, pairs = snakemake.params.compare, snakemake.params.pairs
    files = zip(pairs, *(snakemake.input[name] for name in INPUTS), strict=True)
    comparisons, rows, origins, known = [], [], {}, {}
    for names, new, old, *diagnoses in files:
        findings = (read_json(path)["findings"] for path in diagnoses)
        sides = zip(names, map(read_table, (new, old)), findings, strict=True)
        now, before = (Side(name, *table, of) for name, table, of in sides)
        before = before.named_as(now)
        comparisons.append(Comparison(*names, now.columns, before.columns))
        origins |= {side.name: side.origin for side in (now, before)}
        steps = now.origin["resolution_mm"], before.origin["resolution_mm"]
        coarse = coarse_in_either(now.columns, before.columns, steps, settings["margin"])
        of = compare_rows(*names, now.columns, before.columns, **settings, coarse=coarse)
        known[now.name] = conditions(now, before, of)
        rows += of
    source, remarks = sources_of(origins)
    title = f"{snakemake.wildcards.group}: comparison with the reference"
    text = changes.compare_markdown(
        rows, title, f"{captions.COMPARE_TABLE} {source} {remarks}", known
    )
    tables.write_with(snakemake.output.csv, rows, text)
    words = changes.sentences(rows, known)
    recordings = [recording for recording, _ in pairs]
    of = dict(zip(recordings, words, strict=True))
    found = changes.outcomes(rows, known)
    write_json(snakemake.output.json, {"words": words, "recordings": of, "outcomes": found})
    texts = Texts(title, source, remarks)
    picture = compare_figure(comparisons, settings["margin"], settings["confidence"], texts)
    save(picture, snakemake.output.svg)
    for word in words:
        log.info("%s", word)
