"""Recording -> pulses, stations, sweeps; check.json states whether it can be used."""

from step import refusal_of, step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.calibration.sweeps import Entry, refuse, sweeps
    from mocap_metrology.common.files import empty_folder
    from mocap_metrology.settings import Lighthouse

    given, folder = snakemake.params, Path(snakemake.output.check).parent
    entry = Entry(**given.row | {"path": snakemake.input.dump})
    try:
        sweeps(entry, dict(snakemake.input.items()), Lighthouse(**given.lighthouse), folder)
    except Exception as error:
        refusal = refusal_of(error, snakemake.log[0])
        log.info("%s", refusal)
        empty_folder(folder)  # results of an earlier input
        refuse(refusal, folder)
