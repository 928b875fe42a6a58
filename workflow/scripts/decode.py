"""Recording -> pulses, stations and sweeps, see lighthouse_steps.write_decoded."""

from step import step

with step(snakemake) as log:
    from lighthouse_steps import write_decoded

    given, files = dict(snakemake.input.items()), dict(snakemake.output.items())
    write_decoded(snakemake.params.row, snakemake.params.lighthouse, given, files, log)
