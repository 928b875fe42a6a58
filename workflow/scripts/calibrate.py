"""sweeps.parquet, stations.json -> poses.parquet, pose.json: board poses and pose of the slave."""

from step import step

with step(snakemake) as log:
    import json
    from pathlib import Path

    from lighthouse_steps import calibration_settings, reference_of, truths_of

    from mocap_metrology.common.errors import Refusal
    from mocap_metrology.common.files import read_table, versions, write_json, write_table
    from mocap_metrology.lighthouse import columns
    from mocap_metrology.lighthouse.assess.summary import refused, summary
    from mocap_metrology.lighthouse.board import read_board
    from mocap_metrology.lighthouse.calibrate.jansen import Calibration, calibrate
    from mocap_metrology.lighthouse.decode.factory_file import stations_from_json

    row, config, files = snakemake.params.row, snakemake.params.lighthouse, snakemake.input
    table, origin = read_table(files.sweeps)
    stations = stations_from_json(json.loads(Path(files.stations).read_text(encoding="utf-8")))
    factories = [station.factory for station in stations]
    found, board = Calibration(), read_board(files.board)
    try:
        found = calibrate(
            columns.hits_of(table), board, factories, calibration_settings(config), log.info
        )
        result = summary(
            found,
            stations,
            duration_s=origin["duration_s"],
            resolution_s=origin["resolution_s"],
            notes=origin["notes"],
            reference=reference_of(row, files.get("reference"), files.get("mount")),
            truths=truths_of(files.get("truth")),
            earlier=files.get("earlier"),
        )
    except Refusal as refusal:
        log.warning("%s", refusal)
        result = refused(stations, str(refusal))
    log.info("%s: %s", result["verdict"]["word"], result["verdict"]["reason"])
    kept = ("recording", "source", "twin", "sha256", "duration_s")
    origin = {key: origin[key] for key in kept} | {"lighthouse": config}
    origin["versions"] = versions("numpy", "scipy", "numba")
    write_table(snakemake.output.poses, columns.poses(found.paths), origin)
    write_json(snakemake.output.pose, result | {"origin": origin})
