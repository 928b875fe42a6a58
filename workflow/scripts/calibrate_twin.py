"""Simulate a Lighthouse twin as a dump; decode and calibrate what then lies on the disk."""

from step import step

with step(snakemake) as log:
    from mocap_metrology.pipeline.calibration import Asked, decoded
    from mocap_metrology.pipeline.calibration_files import write_decoded, write_poses
    from mocap_metrology.pipeline.calibration_twin import with_sensors, write_twin
    from mocap_metrology.settings import Lighthouse

    asked, settings = Asked(**snakemake.params.row), Lighthouse(**snakemake.params.lighthouse)
    (twin,) = snakemake.params.twin.values()
    files = dict(snakemake.output.items())
    log.info("%s", write_twin(twin, snakemake.params.seed, files))
    found = decoded(asked, {"dump": files["dump"], "board": files["twin_board"]}, settings)
    found = with_sensors(found, twin, snakemake.params.seed)
    write_decoded(asked, found, settings, files)
    against = dict(snakemake.input.items())
    if "reference" not in against:
        mocap = twin.reference == "mocap"
        against["reference"] = files["reference" if mocap else "truth"]
        against["mount"] = files["mount"] if mocap else None
    made = {name: files[name] for name in ("sweeps", "inertial", "stations", "board", "truth")}
    write_poses(asked, settings, made | against, files)
