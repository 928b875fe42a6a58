"""Tables 3 and 4 of S: every published number beside the regenerated one."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    import pandas as pd

    from mocap_metrology.present import tables

    rows = {row["recording"]: row for row in snakemake.params.rows}
    gaussian = {}
    for name, path in zip(rows, snakemake.input.gaussian, strict=True):
        table = pd.read_csv(path, float_precision="round_trip")
        gaussian[name] = table[table["axis"] == "x"].iloc[0].to_dict()
    sentence = tables.source_sentence(
        {name: "twin" if row["twin"] else "measured" for name, row in rows.items()}
    )
    folder = Path(snakemake.output[0]).parent
    for number, made, title, caption in (
        (3, tables.skurowski_table_3(rows), "camera subsets", tables.TABLE_3_CAPTION),
        (4, tables.skurowski_table_4(rows, gaussian), "Gaussian model", tables.TABLE_4_CAPTION),
    ):
        title = f"Skurowski & Pawlyta 2019, Table {number}: {title}"
        tables.write(folder / f"skurowski_table{number}", made, title, f"{caption} {sentence}")
        log.info("Table %d: %d rows", number, len(made))
