"""Motion capture of the receiver of a calibration -> receiver.json."""

from step import step

with step(snakemake):
    from mocap_metrology.calibration.receiver import receiver
    from mocap_metrology.calibration.sweeps import Entry
    from mocap_metrology.settings import Lighthouse

    params, files = snakemake.params, dict(snakemake.input.items())
    receiver(
        Entry(**params.row),
        files.pop("seen"),
        params.receiver["receiver_labels"],
        files,
        Lighthouse(**params.lighthouse),
        snakemake.output.receiver,
        params.receiver["receiver_unit"],
    )
