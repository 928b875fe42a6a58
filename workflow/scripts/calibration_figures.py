"""Pictures of one calibration: stations, path of the board, disagreement, residuals, diodes; the
tracked board."""

from step import step

with step(snakemake) as log:
    from mocap_metrology.common.files import read_table
    from mocap_metrology.present.calibration.calibration_figure import calibration_figure
    from mocap_metrology.present.calibration.calibration_files import read_calibration
    from mocap_metrology.present.calibration.track_figure import track_figure
    from mocap_metrology.present.plot.figure import save

    given, params = snakemake.input, snakemake.params
    files = {key: given[key] for key in ("pose", "poses", "sweeps", "stations", "board")}
    calibration = read_calibration(files, params.name, params.twin)
    save(calibration_figure(calibration), snakemake.output.png)
    angles = dict(given.items()).get("allan")
    noise = read_table(angles) if angles else ({}, {"rotors": []})
    tracked = track_figure(params.name, params.twin, *read_table(given.track), *noise)
    save(tracked, snakemake.output.track_png)
    log.info("verdict: %s", calibration.pose["verdict"]["word"])
