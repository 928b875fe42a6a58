"""Tables A1-A3 of S and what their length supports: published beside regenerated."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.noise.fit.estimates import read_noise
    from mocap_metrology.present import tables
    from mocap_metrology.present.skurowski import appendix, appendix_text
    from mocap_metrology.present.skurowski.appendix_text import table_a_markdown

    rows = {row["recording"]: row for row in snakemake.params.rows}
    noise = dict(zip(rows, map(read_noise, snakemake.input.noise), strict=True))
    expected = {Path(path).parent.name: read_noise(path) for path in snakemake.input.expected}
    length = snakemake.config["duration_s"]  # of twins
    sources = {name: tables.source_of(row) for name, row in rows.items()}
    sentence = tables.source_sentence(sources, length)
    sentence = f"{sentence} {appendix.FORM_WORDS[snakemake.config['twin_form']]}"
    folder = Path(snakemake.output[0]).parent
    made = appendix.tables_a(rows, noise, expected)
    for number, of_type in made.items():
        kind = of_type[0]["camera_type"]
        title = f"Skurowski & Pawlyta 2019, Table {number}: noise of {kind} cameras"
        text = table_a_markdown(of_type, title, f"{appendix.CAPTION} {sentence}", length)
        tables.write_with(folder / f"skurowski_table{number}", of_type, text)
        log.info("Table %s: %d rows", number, len(of_type))
    every = [row for of_type in made.values() for row in of_type]
    levels = appendix_text.white_levels(every)
    tables.write(
        folder / "skurowski_white_levels",
        levels,
        "Skurowski & Pawlyta 2019, Tables A1-A3: white noise given back",
        f"{appendix_text.summary(levels)} {appendix_text.CAPTION} {sentence}",
    )
    log.info(appendix_text.summary(levels))
    tables.write(
        folder / "skurowski_support",
        appendix.support_counts(every),
        "Skurowski & Pawlyta 2019, Tables A1-A3: limits from the length",
        f"{appendix.SUPPORT} {sentence}",
    )
