"""Tables I, II and III of J, published beside regenerated, and Figures 3 and 5-8, from one
calibration."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.common.files import read_table
    from mocap_metrology.lighthouse.assess.calibration_files import read_calibration
    from mocap_metrology.lighthouse.assess.rows import records_of
    from mocap_metrology.papers.jansen import jansen_table, jansen_table_3
    from mocap_metrology.present.jansen.jansen_text import markdown
    from mocap_metrology.present.jansen.paths import jansen_figures
    from mocap_metrology.present.plot.figure import save
    from mocap_metrology.present.tables import source_sentence, write_with

    inputs, results = snakemake.input, Path(snakemake.output[0]).parents[1]
    records = records_of(snakemake.params.rows, inputs.every)
    note = source_sentence({record["calibration"]: record["source"] for record in records})
    for number in (1, 2, 3):
        rows = jansen_table_3(records) if number == 3 else jansen_table(number, records)
        text = markdown(number, rows, records, note)
        write_with(results / f"tables/jansen_table{number}", rows, text)
        log.info("Table %d: %d rows", number, len(rows))
    (row,) = snakemake.params.example
    files = {key: inputs[key][0] for key in ("pose", "poses", "sweeps", "stations", "board")}
    calibration = read_calibration(files, row["calibration"], row["twin"])
    pulses, _ = read_table(inputs.pulses[0], ["start_s", "length_us", "diode"])
    for number, figure in jansen_figures(calibration, pulses).items():
        save(figure, results / f"figures/jansen_fig{number:02d}")
        log.info("Figure %d", number)
