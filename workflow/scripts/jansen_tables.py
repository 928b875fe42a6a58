"""Tables I, II and III of Jansen et al. 2019: published beside regenerated."""

from step import step

with step(snakemake) as log:
    from calibration_records import records_of

    from mocap_metrology.present.jansen.jansen_tables import jansen_table, jansen_table_3
    from mocap_metrology.present.jansen.jansen_text import markdown
    from mocap_metrology.present.tables import source_sentence, write_with

    records = records_of(snakemake.params.rows, snakemake.input.poses)
    note = source_sentence({record["calibration"]: record["source"] for record in records})
    for number in (1, 2, 3):
        rows = jansen_table_3(records) if number == 3 else jansen_table(number, records)
        path = snakemake.output[0].replace("table1.csv", f"table{number}")
        write_with(path, rows, markdown(number, rows, records, note))
        log.info("Table %d: %d rows", number, len(rows))
