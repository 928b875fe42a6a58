"""Tables 3 and 4 of S: every published number beside the regenerated one."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.present import tables
    from mocap_metrology.present.skurowski import camera_tables, gaussian_table

    given, paper = snakemake.params, "Skurowski & Pawlyta 2019"
    rows = {row["recording"]: row for row in given.rows}
    gaussian = {}
    for name, path in zip(rows, snakemake.input.gaussian, strict=True):
        table = tables.read(path)
        gaussian[name] = table[table["axis"] == "x"].iloc[0].to_dict()
    length = snakemake.config["duration_s"]  # of twins
    sources = {name: tables.source_of(row) for name, row in rows.items()}
    sentence = tables.source_sentence(sources, length)
    folder = Path(snakemake.output[0]).parent
    third = camera_tables.table_3(rows)
    title = f"{paper}, Table 3: camera subsets"
    caption = f"{camera_tables.TABLE_3_CAPTION} {sentence}"
    tables.write(folder / "skurowski_table3", third, title, caption)
    fourth = gaussian_table.with_chance(
        camera_tables.table_4(rows, gaussian), given.twins, gaussian_table.cleaning_of(given.hampel)
    )
    short = [{column: row[column] for column in gaussian_table.SHOWN} for row in fourth]
    caption = f"{gaussian_table.CAPTION} {camera_tables.TABLE_4_CAPTION} {sentence}"
    text = tables.markdown(short, f"{paper}, Table 4: Gaussian model", caption)
    tables.write_with(folder / "skurowski_table4", fourth, text)
    log.info("Table 3: %d rows, Table 4: %d rows", len(third), len(fourth))
    log.info(gaussian_table.summary(fourth))
