"""Recording -> pulses, stations and sweeps."""

from step import step

with step(snakemake):
    from mocap_metrology.pipeline.calibration import Asked, decoded
    from mocap_metrology.pipeline.calibration_files import write_decoded
    from mocap_metrology.settings import Lighthouse

    asked = Asked(**snakemake.params.row | {"path": snakemake.input.dump})
    settings = Lighthouse(**snakemake.params.lighthouse)
    found = decoded(asked, dict(snakemake.input.items()), settings)
    write_decoded(asked, found, settings, dict(snakemake.output.items()))
