"""Simulate Lighthouse twins of one setup as dumps; decode and calibrate each."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.calibration.pose import simulate
    from mocap_metrology.calibration.sweeps import Entry
    from mocap_metrology.settings import Allan, Lighthouse

    params, settings = snakemake.params, Lighthouse(**snakemake.params.lighthouse)
    every = Path(snakemake.output[0]).parents[1]
    against = {row["calibration"]: {} for row in params.rows}
    for (name, key), path in zip(params.against, snakemake.input, strict=True):
        against[name][key] = path
    for row in params.rows:
        twin, folder = params.twins[row["twin"]], every / row["calibration"]
        folder.mkdir(parents=True, exist_ok=True)
        allan = Allan(**params.allan) if row["calibration"] in params.at_rest else None
        how = params.seed, against[row["calibration"]], settings, allan, folder
        document = simulate(Entry(**row), twin, *how)
        log.info("%s: %s", row["calibration"], document["verdict"]["word"])
