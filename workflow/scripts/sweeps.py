"""Recording -> pulses, stations, sweeps; check.json states whether it can be used."""

from step import refusal_of, step

with step(snakemake):
    from pathlib import Path

    from mocap_metrology.calibration.sweeps import Entry, refuse, sweeps
    from mocap_metrology.settings import Lighthouse

    params, folder = snakemake.params, Path(snakemake.output.check).parent
    entry = Entry(**params.row | {"path": snakemake.input.dump})
    try:
        sweeps(entry, dict(snakemake.input.items()), Lighthouse(**params.lighthouse), folder)
    except Exception as error:
        refuse(refusal_of(error, snakemake, folder), folder)
