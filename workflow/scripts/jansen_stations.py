"""Tables I to III of J with second-generation stations, by their number."""

from step import step

with step(snakemake) as log:
    from mocap_metrology.lighthouse.assess.rows import records_of
    from mocap_metrology.papers.jansen import cells, stations_tables
    from mocap_metrology.present.tables import document, source_sentence, write_with
    from mocap_metrology.present.text import captions

    records = records_of(snakemake.params.rows, snakemake.input.every)
    rows = list(stations_tables(records))
    note = source_sentence({record["calibration"]: record["source"] for record in records})
    head = ["table", "row", "stations", "x mm", "y mm", "z mm", "α °", "β °", "γ °", "n"]
    title = "Jansen et al. 2019, Tables I to III with second-generation stations"
    text = document(title, f"{captions.JANSEN_STATIONS} {note}", [head, *cells(rows)])
    write_with(snakemake.output.csv, rows, text)
    log.info("%d rows", len(rows))
