"""Figures 3 and 5-8 of J, from one calibration."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.common.files import read_table
    from mocap_metrology.present.calibration.calibration_files import read_calibration
    from mocap_metrology.present.jansen.jansen_figures import jansen_figures
    from mocap_metrology.present.plot.figure import save

    given, (row,) = snakemake.input, snakemake.params.rows
    files = {key: given[key][0] for key in ("pose", "poses", "sweeps", "stations", "board")}
    calibration = read_calibration(files, row["calibration"], row["twin"])
    pulses, _ = read_table(given.pulses[0], ["start_s", "length_us", "diode"])
    for number, figure in jansen_figures(calibration, pulses).items():
        save(figure, Path(snakemake.output[0]).parent / f"jansen_fig{number:02d}")
        log.info("Figure %d", number)
