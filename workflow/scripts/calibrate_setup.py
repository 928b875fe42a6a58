"""Recordings of a setup -> one pose of the slave, and what each recording says of the others."""

from step import step

with step(snakemake):
    from mocap_metrology.calibration.setup import Member, write_setup
    from mocap_metrology.settings import Lighthouse

    inputs, settings = snakemake.input, Lighthouse(**snakemake.params.lighthouse)
    kinds = inputs.sweeps, inputs.stations, inputs.board, inputs.pose, inputs.inertial
    files = zip(*kinds, strict=True)
    members = [
        Member(name, *of_member)
        for name, of_member in zip(snakemake.params.names, files, strict=True)
    ]
    write_setup(snakemake.wildcards.setup, members, settings, snakemake.output[0])
