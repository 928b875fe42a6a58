"""Recordings of a setup -> one pose of the slave, and what each recording says of the others."""

from step import step

with step(snakemake):
    from mocap_metrology.calibration.setup import Member, write_setup
    from mocap_metrology.settings import Lighthouse

    given, settings = snakemake.input, Lighthouse(**snakemake.params.lighthouse)
    kinds = given.sweeps, given.stations, given.board, given.pose, given.inertial
    files = zip(*kinds, strict=True)
    members = [Member(name, *own) for name, own in zip(snakemake.params.names, files, strict=True)]
    write_setup(snakemake.wildcards.setup, members, settings, snakemake.output[0])
